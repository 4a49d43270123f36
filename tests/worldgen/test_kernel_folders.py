"""Compiled kernels are pickles: none that others can have written is read, a damaged one is compiled again."""

import hashlib
import importlib.util
import os
import pickle

import pytest

from worldgen import jit, progress

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners are checked on POSIX")


@pytest.fixture(autouse=True)
def at_home(tmp_path, monkeypatch):
    """A user with a home and a temporary folder of their own, of whom nothing is known yet."""
    for name in ("home", "tmp"):
        (tmp_path / name).mkdir(mode=0o700)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("WORLDGEN_CACHE_DIR", raising=False)
    monkeypatch.setattr(jit.tempfile, "gettempdir", lambda: str(tmp_path / "tmp"))
    monkeypatch.setattr(progress, "_said", set())
    jit._checked_root.cache_clear()
    jit.cache_folder.cache_clear()
    yield
    jit._checked_root.cache_clear()
    jit.cache_folder.cache_clear()


def no_home(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))


def private(tmp_path):
    return tmp_path / "tmp" / f"worldgen-{os.geteuid()}"


def test_the_users_own_cache_is_private(tmp_path):
    root = jit.cache_root()
    assert root == tmp_path / "home/.cache/worldgen"
    assert root.stat().st_mode & 0o777 == 0o700


def test_a_named_folder_is_taken(tmp_path, monkeypatch):
    monkeypatch.setenv("WORLDGEN_CACHE_DIR", str(tmp_path / "mine"))
    assert jit.cache_root() == tmp_path / "mine"


def test_a_named_folder_that_others_can_write_is_refused_aloud(tmp_path, monkeypatch, caplog):
    (tmp_path / "ours").mkdir()
    (tmp_path / "ours").chmod(0o777)
    monkeypatch.setenv("WORLDGEN_CACHE_DIR", str(tmp_path / "ours"))
    assert jit.cache_root() == tmp_path / "home/.cache/worldgen"
    assert "can be written by other users" in caplog.text


def test_a_named_folder_of_another_user_is_refused(tmp_path, monkeypatch):
    (tmp_path / "theirs").mkdir()
    monkeypatch.setenv("WORLDGEN_CACHE_DIR", str(tmp_path / "theirs"))
    stranger = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: stranger)
    assert jit.cache_root() is None


def test_a_lax_umask_of_an_earlier_run_is_mended():
    root = jit.cache_root()
    root.chmod(0o775)
    jit._checked_root.cache_clear()
    assert jit.cache_root() == root
    assert root.stat().st_mode & 0o777 == 0o755


def test_without_a_home_the_folder_under_the_temporary_one_is_private(tmp_path, monkeypatch):
    no_home(tmp_path, monkeypatch)
    assert jit.cache_root() == private(tmp_path)
    assert private(tmp_path).stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o755, 0o770, 0o777])
def test_a_folder_under_the_temporary_one_that_is_not_private_is_refused(tmp_path, monkeypatch, mode):
    no_home(tmp_path, monkeypatch)
    private(tmp_path).mkdir()
    private(tmp_path).chmod(mode)
    assert jit.cache_root() is None


def test_a_symlink_under_the_temporary_folder_is_refused(tmp_path, monkeypatch):
    no_home(tmp_path, monkeypatch)
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    private(tmp_path).symlink_to(tmp_path / "elsewhere")
    assert jit.cache_root() is None


def test_a_folder_under_the_temporary_one_that_another_user_made_is_refused(tmp_path, monkeypatch):
    no_home(tmp_path, monkeypatch)
    private(tmp_path).mkdir(mode=0o700)
    owner = os.geteuid()
    private(tmp_path).rename(tmp_path / "tmp" / f"worldgen-{owner + 1}")
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    assert jit.cache_root() is None


def test_where_no_folder_is_safe_it_is_said_once(tmp_path, monkeypatch, caplog):
    no_home(tmp_path, monkeypatch)
    private(tmp_path).touch()
    for _ in range(2):
        jit._checked_root.cache_clear()
        assert jit.cache_root() is None
    assert caplog.text.count("compiled in every run") == 1


def test_a_folder_of_kernels_that_others_can_write_is_not_used(tmp_path, caplog):
    folder = jit.cache_folder(tmp_path)
    folder.chmod(0o777)
    jit.cache_folder.cache_clear()
    assert jit.cache_folder(tmp_path) is None
    assert "remove it" in caplog.text


def twice(folder):
    """A kernel of a file of its own, as a new process would make it, and how often it had to be compiled."""
    source = folder / "source.py"
    if not source.exists():
        folder.mkdir(exist_ok=True)
        source.write_text("def twice(x):\n    return 2 * x\n")
    spec = importlib.util.spec_from_file_location("source", source)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    made = jit.kernel(module.twice)
    assert made(21) == 42
    return sum(made.stats.cache_misses.values())


def test_a_kernel_is_compiled_once(tmp_path):
    assert [twice(tmp_path), twice(tmp_path)] == [1, 0]


def test_two_installations_share_what_is_compiled(tmp_path):
    assert [twice(tmp_path / "one"), twice(tmp_path / "other")] == [1, 0]


def kernel_files(tmp_path, kind="nb?"):
    files = sorted((tmp_path / "home/.cache/worldgen").rglob(f"*.{kind}"))
    assert files
    return files


def signed(content):
    """A file as the cache writes it, with its digest before it."""
    return hashlib.sha256(content).digest() + content


@pytest.mark.parametrize("package", ["numba", "llvmlite"])
def test_another_version_of_the_compiler_has_a_folder_of_its_own(tmp_path, monkeypatch, package):
    before, installed = jit.cache_folder(tmp_path), jit.version
    monkeypatch.setattr(jit, "version", lambda name: "999" if name == package else installed(name))
    jit.cache_folder.cache_clear()
    assert jit.cache_folder(tmp_path) != before


@pytest.mark.gate
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda data: bytes(len(data)), id="zeros"),
        pytest.param(lambda data: b"", id="empty"),
        pytest.param(lambda data: data[: len(data) // 2], id="cut"),
        pytest.param(lambda data: data[:-100] + bytes(100), id="zeros-at-the-end"),
        pytest.param(lambda data: pickle.dumps("something else"), id="another-pickle"),
        pytest.param(lambda data: signed(b"cno_such_module\nSignature\n."), id="of-another-numba"),
    ],
)
def test_a_damaged_kernel_is_compiled_again(tmp_path, kind, damage):
    twice(tmp_path)
    for file in kernel_files(tmp_path, kind):
        file.write_bytes(damage(file.read_bytes()))
    assert [twice(tmp_path), twice(tmp_path)] == [1, 0]


def test_a_kernel_that_others_could_have_written_is_not_read(tmp_path):
    twice(tmp_path)
    for file in kernel_files(tmp_path):
        file.chmod(0o666)
    assert [twice(tmp_path), twice(tmp_path)] == [1, 0]


def test_a_kernel_behind_a_symlink_is_not_read(tmp_path):
    twice(tmp_path)
    for file in kernel_files(tmp_path):
        moved = file.rename(tmp_path / file.name)
        file.symlink_to(moved)
    assert [twice(tmp_path), twice(tmp_path)] == [1, 0]


def test_without_a_folder_kernels_are_compiled_in_every_run(tmp_path, monkeypatch):
    no_home(tmp_path, monkeypatch)
    private(tmp_path).touch()
    assert [twice(tmp_path), twice(tmp_path)] == [1, 1]


def test_without_a_folder_compiling_says_so(tmp_path, monkeypatch, capsys):
    no_home(tmp_path, monkeypatch)
    private(tmp_path).touch()
    monkeypatch.setattr(progress, "_display", progress.Display(verbosity=1))
    twice(tmp_path)
    assert "in this run: no folder can keep it: done in" in capsys.readouterr().err
