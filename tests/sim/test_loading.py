"""Whatever a user's file does while it is loaded, the answer is a sentence."""

import subprocess
import sys

import pytest

from sim.controllers import CONTROLLERS
from worldgen import InvalidParameter, generate, write_world
from worldgen.family import FAMILIES

EXITS_IN_INIT = "import sys\nclass Mine:\n    def __init__(self):\n        sys.exit(0)\n"
STANDS = "class Mine:\n    def reset(self): return ()\n    def act(self, o, m): return o, m\n"
HIDES = "def __getattr__(name):\n    raise OSError('not today')\n"
PROPERTY = "class Mine:\n    @property\n    def senses(self):\n        raise OSError('not today')\n"


@pytest.mark.parametrize("registry", [CONTROLLERS, FAMILIES])
@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import sys\nsys.exit(0)\n", r"loading .* ends Python \(SystemExit: 0\); take that exit out"),
        ("raise GeneratorExit('no')\n", r"loading .* failed: GeneratorExit: no"),
        ("import asyncio\nraise asyncio.CancelledError\n", r"loading .* failed: CancelledError"),
        (HIDES, r"loading .* failed: OSError: not today"),
    ],
)
def test_a_file_that_raises_anything_at_import_is_refused(registry, code, message, tmp_path):
    (tmp_path / "mine.py").write_text(code)
    with pytest.raises(InvalidParameter, match=message):
        registry.get(f"{tmp_path / 'mine.py'}:Mine")


@pytest.mark.parametrize(
    ("code", "message"),
    [
        (EXITS_IN_INIT, r"making it without arguments ends Python \(SystemExit: 0\)"),
        (EXITS_IN_INIT.replace("sys.exit(0)", "raise GeneratorExit('no')"), "without arguments failed: GeneratorExit"),
        (PROPERTY, "looking at its attributes failed: OSError: not today"),
    ],
)
def test_a_class_that_raises_anything_when_made_is_refused(code, message, tmp_path):
    (tmp_path / "mine.py").write_text(code)
    with pytest.raises(InvalidParameter, match=message):
        CONTROLLERS.get(f"{tmp_path / 'mine.py'}:Mine")


def test_ctrl_c_while_a_file_is_loaded_is_let_through(tmp_path):
    (tmp_path / "mine.py").write_text("raise KeyboardInterrupt\n")
    with pytest.raises(KeyboardInterrupt):
        CONTROLLERS.get(f"{tmp_path / 'mine.py'}:Mine")


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
