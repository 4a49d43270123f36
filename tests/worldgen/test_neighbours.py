"""A user's file can import the files next to it, and only those."""

from __future__ import annotations

import pickle
import subprocess
import sys

import pytest

from sim.controllers import CONTROLLERS
from sim.controllers.hidden_state import hidden_state
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter

MINE = """
{imports}

class Mine:
    speed = {speed}

    def reset(self):
        return ()

    def act(self, observation, memory):
        {in_act}
        return (self.speed, 0.0), memory
"""


def mine(folder, imports, speed="helper_of_mine.SPEED", in_act="pass"):
    folder.mkdir(exist_ok=True)
    (folder / "mine.py").write_text(MINE.format(imports=imports, speed=speed, in_act=in_act))
    return CONTROLLERS.get(f"{folder / 'mine.py'}:Mine")


@pytest.mark.parametrize(
    ("imports", "speed"),
    [
        ("import helper_of_mine", "helper_of_mine.SPEED"),
        ("from helper_of_mine import SPEED", "SPEED"),
        ("import parts_of_mine.wheel", "parts_of_mine.wheel.SPEED"),
        ("from parts_of_mine import wheel as w", "w.SPEED"),
    ],
    ids=["module", "name", "package", "submodule"],
)
def test_a_file_imports_its_neighbours(imports, speed, tmp_path):
    (tmp_path / "helper_of_mine.py").write_text("SPEED = 0.5\n")
    (tmp_path / "parts_of_mine").mkdir()
    (tmp_path / "parts_of_mine" / "__init__.py").write_text("from . import wheel\n")
    (tmp_path / "parts_of_mine" / "wheel.py").write_text(
        "import helper_of_mine\nSPEED = helper_of_mine.SPEED\n"
    )
    assert mine(tmp_path, imports, speed).speed == 0.5


def test_a_file_imports_a_neighbour_by_its_name_as_text(tmp_path):
    (tmp_path / "named_of_mine.py").write_text("SPEED = 0.5\n")
    assert mine(
        tmp_path,
        "import importlib\nhelper = importlib.import_module('named_of_mine')",
        "helper.SPEED",
    ).speed


def test_an_import_in_act_finds_a_neighbour(tmp_path):
    (tmp_path / "late_of_mine.py").write_text("SPEED = 0.25\n")
    robot = mine(tmp_path, "", "0", in_act="import late_of_mine; self.speed = late_of_mine.SPEED")
    assert robot.act(None, ()) == ((0.25, 0.0), ())


def test_neighbours_of_the_same_name_in_two_folders_stay_apart(tmp_path):
    speeds = []
    for name, speed in (("one", 1.0), ("two", 2.0)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "twin_of_mine.py").write_text(f"SPEED = {speed}\n")
        speeds.append(mine(tmp_path / name, "import twin_of_mine", "twin_of_mine.SPEED").speed)
    assert speeds == [1.0, 2.0]


def test_a_name_as_text_that_two_folders_have_is_refused(tmp_path):
    by_name = "import importlib\nhelper = importlib.import_module('either_of_mine')"
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "either_of_mine.py").write_text("")
    mine(tmp_path / "one", by_name, "0")
    with raises(InvalidParameter, "code-failed"):
        mine(tmp_path / "two", by_name, "0")


def test_an_error_names_a_neighbour_as_the_user_does(tmp_path):
    (tmp_path / "helper_of_mine.py").write_text("")
    with raises(InvalidParameter, "code-failed") as found:
        mine(tmp_path, "from helper_of_mine import SPEED", "SPEED")
    assert "import name 'SPEED' from 'helper_of_mine'" in found.value.facts["reason"]


def test_a_neighbour_s_class_can_be_pickled(tmp_path):
    (tmp_path / "net_of_mine.py").write_text("class Net:\n    pass\n")
    robot = mine(tmp_path, "import net_of_mine", "net_of_mine.Net()")
    assert type(pickle.loads(pickle.dumps(robot.speed))) is type(robot.speed)


def test_a_neighbour_hides_nothing_from_others(tmp_path):
    (tmp_path / "colorsys.py").write_text("MARK = 1\n")
    assert mine(tmp_path, "import colorsys", "colorsys.MARK").speed == 1
    import colorsys

    assert not hasattr(colorsys, "MARK")


def test_a_folder_next_to_the_file_does_not_hide_our_packages(tmp_path):
    (tmp_path / "sim").mkdir()
    (tmp_path / "sim" / "__init__.py").write_text("")
    assert mine(tmp_path, "from sim import Command", "Command(0.5).speed").speed == 0.5


def test_a_neighbour_that_was_edited_is_loaded_again_with_its_file(tmp_path):
    (tmp_path / "edited_of_mine.py").write_text("SPEED = 0.5\n")
    assert mine(tmp_path, "import edited_of_mine", "edited_of_mine.SPEED").speed == 0.5
    (tmp_path / "edited_of_mine.py").write_text("SPEED = 0.75 # and longer\n")
    CONTROLLERS.forget(str(tmp_path / "mine.py"))
    assert mine(tmp_path, "import edited_of_mine", "edited_of_mine.SPEED").speed == 0.75


def test_state_in_a_neighbour_is_noticed(tmp_path):
    (tmp_path / "count_of_mine.py").write_text("steps = 0\n")
    robot = mine(tmp_path, "import count_of_mine", "0.0", in_act="count_of_mine.steps += 1")
    before = hidden_state(robot)
    robot.act(None, ())
    assert before is not None and hidden_state(robot) != before


@pytest.mark.gate
def test_plain_pytest_finds_the_neighbours_of_a_controller(tmp_path):
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "beside_mine.py").write_text("SPEED = 1.0\n")
    code = MINE.format(imports="import beside_mine", speed="beside_mine.SPEED", in_act="pass")
    (tmp_path / "robots" / "mine.py").write_text(code)
    (tmp_path / "test_it.py").write_text(
        "from sim.controllers import CONTROLLERS\n\n\n"
        "def test_it():\n    assert CONTROLLERS.get('robots/mine.py:Mine').speed == 1.0\n"
    )
    command = [
        sys.executable,
        "-P",
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "--import-mode=importlib",
    ]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
