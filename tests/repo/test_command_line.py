"""The command line as a whole: light to start, one line per error, one table of commands."""

import subprocess
import sys
from importlib.metadata import entry_points

import pytest

from tests.helpers.command_line import worldgen
from worldgen.cli.main import _SUMMARY

HEAVY = ("numpy", "scipy", "numba", "shapely", "trimesh", "hypothesis", "PIL", "sim", "fuzz")


def modules_after(*args):
    """Top-level modules that are loaded once a command has run, in a process of its own."""
    code = (
        "import sys\nfrom worldgen.cli.main import main\n"
        f"sys.argv = ['worldgen', *{list(map(str, args))!r}]\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print('MODULES', *{name.partition('.')[0] for name in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.rpartition("MODULES ")[2].split())


@pytest.mark.gate
@pytest.mark.parametrize("args", [["--help"], ["--version"], ["fuzz", "--help"], ["run", "--help"]])
def test_help_imports_nothing_heavy(args):
    allowed = {"sim", "fuzz"} if len(args) > 1 else set()
    assert not modules_after(*args) & (set(HEAVY) - allowed)


@pytest.mark.gate
def test_a_small_maze_imports_neither_numba_nor_scipy_nor_shapely(tmp_path):
    assert not modules_after("maze", "--size", 60, "--seed", 1, "--out", tmp_path / "w.grid") & {
        "numba", "scipy", "shapely", "trimesh", "hypothesis", "sim", "fuzz",
    }  # fmt: skip


def test_the_table_of_commands_says_what_each_command_says_of_itself():
    own = {point.name: point.load() for point in entry_points(group="worldgen.commands")}
    assert set(own) == set(_SUMMARY)
    for name, command in own.items():
        assert command.help.split("\n\n")[0].replace("\n", " ").strip() == _SUMMARY[name]


def test_a_misspelt_command_is_suggested():
    result = worldgen("mazw")
    assert result.code == 2 and "did you mean 'maze'?" in result.err


def test_a_fault_of_our_own_is_code_3_without_traceback(monkeypatch, tmp_path):
    def broken(path):
        raise RuntimeError("a bug")

    monkeypatch.setattr("worldgen.files.grid.read_world", broken)
    result = worldgen("show", tmp_path / "w.grid")
    assert result.code == 3 and "a fault of our own" in result.err and "Traceback" not in result.err


def test_a_full_disk_is_code_2_and_says_so():
    result = worldgen("maze", "--size", 20, "--seed", 1, "--out", "/dev/full", "--force")
    assert result.code == 2 and "No space left" in result.err


def test_a_folder_without_permission_is_code_2(tmp_path):
    result = worldgen("maze", "--size", 20, "--seed", 1, "--out", tmp_path / "absent" / "w.grid")
    assert result.code == 2 and "does not exist; make it first" in result.err


def test_python_runs_the_program_as_a_module(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "worldgen", "maze", "--size", "1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (
        done.returncode == 2
        and done.stderr.count("\n") <= 2
        and "outside 10 to 20000 cells" in done.stderr
    )
