"""A user's folder or file called ``sim`` or ``fuzz``:

the program works next to it, and a test run reports it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from sim.controllers import CONTROLLERS
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter

ROOT = Path(__file__).parents[2]
SCRIPT = "from worldgen.cli.main import main; main()"
# `pip install -e` looks for our modules after Python has looked in the folders of its path.
EDITABLE = f"""
import sys
from importlib.machinery import PathFinder

class Editable:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] in ("worldgen", "worldgen_plugins", "sim", "fuzz"):
            return PathFinder.find_spec(name, ["/".join([{str(ROOT)!r}, *name.split(".")[:-1]])])

sys.path.remove({str(ROOT)!r}) if {str(ROOT)!r} in sys.path else None
sys.meta_path.insert(sys.meta_path.index(PathFinder) + 1, Editable)
{SCRIPT}
"""
ROBOT_TEST = """
import pytest

@pytest.mark.worldgen(family="maze", controller="wall-left", count=1, size=12)
def test_robot(worldgen_episode):
    assert worldgen_episode.steps > 0
"""


def run_in(folder, *command, **environment):
    return subprocess.run(
        [sys.executable, *command],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def project(tmp_path, request):
    file = tmp_path / request.param
    file.parent.mkdir(exist_ok=True)
    file.write_text("raise SystemExit('run')\n")
    return tmp_path


@pytest.mark.gate
@pytest.mark.parametrize(
    ("project", "by_path"),
    [
        ("sim/__init__.py", False),
        ("sim.py", True),
        pytest.param("sim/planner.py", False, marks=pytest.mark.nightly),
        pytest.param("fuzz.py", False, marks=pytest.mark.nightly),
    ],
    indirect=["project"],
)
def test_the_program_works_next_to_a_folder_of_the_same_name(project, by_path):
    program = ["-P", "-c", SCRIPT] if by_path else ["-m", "worldgen"]
    found = {"PYTHONPATH": str(project)} if by_path else {}
    run_in(project, *program, "maze", "--seed", "3", "--size", "12", "--out", "w.grid", **found)
    result = run_in(project, *program, "run", "w.grid", "--controller", "wall-left", **found)
    assert result.returncode in {0, 1}, result.stderr
    assert ", trace " in result.stdout


@pytest.mark.gate
@pytest.mark.parametrize("project", ["worldgen/README"], indirect=True)
def test_an_editable_installation_works_next_to_a_folder_named_worldgen(project):
    grid = ("maze", "--seed", "3", "--size", "12", "--out", "w.grid")
    for words in (grid, ("run", "w.grid", "--controller", "wall-left")):
        result = run_in(project, "-c", EDITABLE, *words)
        assert result.returncode in {0, 1}, result.stderr
    assert ", trace " in result.stdout


@pytest.mark.gate
@pytest.mark.parametrize("project", ["sim/__init__.py"], indirect=True)
def test_worker_processes_work_next_to_a_folder_of_the_same_name(project):
    words = ["--controller", "wall-left", "--units", "2", "--seed", "1", "--workers", "2"]
    result = run_in(project, "-m", "worldgen", "fuzz", *words, "--out", "found")
    assert result.returncode in {0, 1}, result.stderr


@pytest.mark.gate
@pytest.mark.parametrize("project", ["sim/__init__.py"], indirect=True)
def test_a_controller_next_to_a_folder_of_the_same_name_is_still_found(project):
    (project / "mine.py").write_text(
        "from sim.controllers import CONTROLLERS\nRobot = CONTROLLERS.get('wall-left')\n"
    )
    run_in(project, "-m", "worldgen", "maze", "--seed", "3", "--size", "12", "--out", "w.grid")
    result = run_in(project, "-m", "worldgen", "run", "w.grid", "--controller", "mine:Robot")
    assert result.returncode in {0, 1}, result.stderr


@pytest.mark.gate
@pytest.mark.parametrize(
    "project", ["sim.py", pytest.param("fuzz.py", marks=pytest.mark.nightly)], indirect=True
)
def test_a_test_run_says_what_hides_a_package(project):
    (project / "test_robot.py").write_text(ROBOT_TEST)
    result = run_in(project, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_robot.py")
    assert result.returncode == 1
    assert "hides the package" in result.stdout and "--import-mode=importlib" in result.stdout
    assert "Traceback" not in result.stdout and "ModuleNotFoundError" not in result.stdout


def test_a_module_that_our_package_hides_is_named_by_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "sim" / "robot.py"
    file.parent.mkdir()
    file.write_text("act = None\n")
    with raises(InvalidParameter, "hidden-module", file="sim/robot.py", attribute="act"):
        CONTROLLERS.get("sim.robot:act")


def test_an_import_that_our_package_hides_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "sim" / "motors.py"
    file.parent.mkdir()
    file.write_text("")
    (tmp_path / "mine.py").write_text("import sim.motors\n")
    with raises(InvalidParameter, "hidden-module", module="sim.motors", folder="sim"):
        CONTROLLERS.get("./mine.py:Robot")
    # A module that does not exist is the user's own mistake.
    (tmp_path / "other.py").write_text("import sim.wheels\n")
    with raises(InvalidParameter, "code-failed"):
        CONTROLLERS.get("./other.py:Robot")
