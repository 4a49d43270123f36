"""Whatever a user's file does while it is loaded, the result is an error message."""

import signal
import subprocess
import sys
import time

import pytest

from sim.controllers import CONTROLLERS
from sim.controllers.behaviours.catalogue import BEHAVIOURS
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate, write_world
from worldgen.family import FAMILIES
from worldgen.interop.format import FORMATS

EXITS_IN_INIT = "import sys\nclass Mine:\n    def __init__(self):\n        sys.exit(0)\n"
STANDS = (
    "class Mine:\n    def reset(self): return ()\n    def act(self, o, m): return (0.0, 0.0), m\n"
)
HIDES = "def __getattr__(name):\n    raise OSError('not today')\n"
PROPERTY = "class Mine:\n    @property\n    def senses(self):\n        raise OSError('not today')\n"


@pytest.mark.parametrize("registry", [CONTROLLERS, FAMILIES])
@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("import sys\nsys.exit(0)\n", {"code": "code-failed"}),
        ("raise GeneratorExit('no')\n", {"code": "code-failed", "kind": "GeneratorExit"}),
        (
            "import asyncio\nraise asyncio.CancelledError\n",
            {"code": "code-failed", "kind": "CancelledError"},
        ),
        (HIDES, {"code": "code-failed", "kind": "OSError"}),
    ],
)
def test_a_file_that_raises_anything_at_import_is_refused(registry, code, expected, tmp_path):
    (tmp_path / "mine.py").write_text(code)
    with raises(InvalidParameter, **expected):
        registry.get(f"{tmp_path / 'mine.py'}:Mine")


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        (EXITS_IN_INIT, {"code": "code-failed"}),
        (
            EXITS_IN_INIT.replace("sys.exit(0)", "raise GeneratorExit('no')"),
            {"code": "code-failed", "kind": "GeneratorExit"},
        ),
        (PROPERTY, {"code": "code-failed", "kind": "OSError"}),
    ],
)
def test_a_class_that_raises_anything_when_made_is_refused(code, expected, tmp_path):
    (tmp_path / "mine.py").write_text(code)
    with raises(InvalidParameter, **expected):
        CONTROLLERS.get(f"{tmp_path / 'mine.py'}:Mine")


def test_a_misspelt_class_is_told_from_what_the_file_defines_and_imports(tmp_path):
    (tmp_path / "mine.py").write_text(f"from sim import Command\n{STANDS}")
    with raises(InvalidParameter, "unknown-name", attribute="Mien", near="Mine"):
        CONTROLLERS.get(f"{tmp_path / 'mine.py'}:Mien")


@pytest.mark.parametrize("registry", [CONTROLLERS, BEHAVIOURS, FAMILIES, FORMATS])
@pytest.mark.parametrize("place", ["recipe", "recipe.part", "json.part", ".json", "a-b", ""])
def test_a_module_that_does_not_exist_is_named_with_what_to_write(registry, place):
    with raises(InvalidParameter, "no-such-module", place=place) as caught:
        registry.get(f"{place}:x")
    assert str(caught.value).endswith("for your own, use package.module:name or ./file.py:name")


@pytest.mark.parametrize("name", ["./absent.py:Robot", f"{'long' * 99}.py:Robot"])
def test_a_file_that_does_not_exist_is_told_as_it_was_written(name):
    with raises(InvalidParameter, "no-such-file", name=name):
        CONTROLLERS.get(name)


def test_a_module_is_found_whatever_its_name(tmp_path, monkeypatch):
    (tmp_path / "my-robot.py").write_text(STANDS)
    monkeypatch.syspath_prepend(tmp_path)
    assert CONTROLLERS.get("my-robot:Mine") is not None


def test_a_module_that_the_users_module_lacks_is_a_fault_of_its_code(tmp_path, monkeypatch):
    (tmp_path / "lacking.py").write_text("import recipe\n")
    monkeypatch.syspath_prepend(tmp_path)
    with raises(InvalidParameter, "code-failed", kind="ModuleNotFoundError"):
        CONTROLLERS.get("lacking:Mine")


def test_ctrl_c_while_a_file_is_loaded_is_let_through(tmp_path):
    (tmp_path / "mine.py").write_text("raise KeyboardInterrupt\n")
    with pytest.raises(KeyboardInterrupt):
        CONTROLLERS.get(f"{tmp_path / 'mine.py'}:Mine")


@pytest.mark.nightly
@pytest.mark.parametrize(
    "command",
    [
        "run w.grid",
        "fuzz --units 1 --seed 1 --out f --workers 1",
        "fuzz --units 1 --seed 1 --out f --workers 2",
    ],
)
@pytest.mark.parametrize("waits", ["pass", "__import__('time').sleep(1)"])
def test_ctrl_c_ends_a_file_that_is_never_done_loading(command, waits, tmp_path):
    text = f"open('loading', 'w').close()\nwhile True: {waits}\n"
    (tmp_path / "mine.py").write_text(text)
    write_world(generate("trap", 4, size=20), tmp_path / "w.grid")
    words = [sys.executable, "-m", "worldgen", *command.split(), "--controller", "./mine.py:Mine"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        end = time.monotonic() + 60
        while not (tmp_path / "loading").exists():
            assert time.monotonic() < end
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert said.split("\n")[-2] == "interrupted" and "Traceback" not in said


@pytest.mark.gate
def test_a_command_does_not_end_well_because_a_controller_exits(tmp_path):
    (tmp_path / "mine.py").write_text("raise SystemExit(0)\n")
    write_world(generate("trap", 4, size=20), tmp_path / "w.grid")
    command = [sys.executable, "-m", "worldgen", "run", "w.grid", "--controller", "./mine.py:Mine"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "ends Python (SystemExit: 0)" in done.stderr


def test_one_relative_name_in_two_folders_is_two_controllers(tmp_path, monkeypatch):
    found = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        (folder / "mine.py").write_text(
            "class Mine:\n    def reset(self): return ()\n    def act(self, o, m): return o, m\n"
        )
        monkeypatch.chdir(folder)
        found.append(CONTROLLERS.get("./mine.py:Mine"))
    assert found[0] is not found[1] and CONTROLLERS.get("./mine.py:Mine") is found[1]
