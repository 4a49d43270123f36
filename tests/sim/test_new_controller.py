"""``worldgen new-controller`` writes controllers that run immediately, and all drive alike."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sim import ProcessController, RunOptions, simulate
from sim.commands.new_controller import new_controller
from sim.controllers import CONTROLLERS
from sim.controllers.shared.object_file import include_folder
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, OutputError, Pose, Target, World, generate

BUILT = ("c", "cpp")
KINDS = (*BUILT, "compiled", "python", "vector", "process")


def make(*arguments):
    """Run the command; raise its errors."""
    return (
        CliRunner().invoke(new_controller, list(map(str, arguments)), catch_exceptions=False).stdout
    )


def made(folder, kind, name="my-robot"):
    told = json.loads(make(name, "--kind", kind, "--out", folder, "--json"))
    if kind in BUILT:
        build(told["build"])
    return told


def build(line):
    """Run a line that builds a shared library, as a shell would."""
    words = shlex.split(line.replace('-I"$(worldgen --include)"', f"-I{include_folder()}"))
    subprocess.run(words, check=True)


def room():
    cells = np.zeros((12, 12), bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    return World(cells, Pose(0.35, 0.35, 0.0), Target(0.85, 0.85, 0.05))


@pytest.mark.gate
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_arrives_in_an_empty_room(kind, tmp_path):
    assert simulate(room(), made(tmp_path, kind)["controller"]).verdict == "reached"


@pytest.mark.gate
def test_all_kinds_drive_the_same_way(tmp_path):
    world, options = generate("maze", 7, size=20), RunOptions(steps=500)
    ways = [
        simulate(
            world, made(tmp_path, kind, f"robot-{kind}")["controller"], options, record=True
        ).trace
        for kind in KINDS
    ]
    shortest = min(len(way.x) for way in ways)
    assert shortest > 100 and len({way.states[:shortest, :4].tobytes() for way in ways}) == 1


@pytest.mark.gate
@pytest.mark.parametrize("kind", KINDS)
def test_the_lines_that_are_printed_work_as_they_are(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    printed = make("mine", "--kind", kind).splitlines()
    if kind in BUILT:
        build(printed.pop(0))
    lines = [shlex.split(line) for line in printed]
    assert [line[:2] for line in lines] == [
        ["worldgen", command] for command in ("trap", "run", "fuzz")
    ]
    assert worldgen(*lines[0][1:]).code == 0 and worldgen(*lines[1][1:]).code == 0
    assert (tmp_path / "run.png").exists()


def test_the_name_is_spelt_as_python_has_it(tmp_path):
    assert made(tmp_path, "python")["controller"] == f"{tmp_path}/my_robot.py:MyRobot"
    assert made(tmp_path, "compiled", "Fast2")["controller"] == f"{tmp_path}/Fast2.py:Fast2"
    assert (
        "xample" not in (tmp_path / "my_robot.py").read_text() + (tmp_path / "Fast2.py").read_text()
    )


def test_a_program_may_be_given_any_file_name_blanks_included(tmp_path):
    result = json.loads(make("mine", "--kind", "process", "--out", tmp_path / "my robot", "--json"))
    assert (
        result["controller"] == f"cmd:'{tmp_path}/my robot'"
        and (tmp_path / "my robot").stat().st_mode & 0o111
    )
    assert simulate(room(), result["controller"]).verdict == "reached"


@pytest.mark.parametrize("name", ["", "2fast", "a b", "class", "match", "../x", "ü", 65 * "x"])
def test_a_name_that_python_would_not_take_is_refused(name, tmp_path):
    with raises(InvalidParameter, "not-a-controller-name"):
        make(name, "--out", tmp_path)


def test_a_file_that_is_there_is_left_alone_without_force(tmp_path):
    (tmp_path / "mine.py").write_text("precious")
    with raises(OutputError, "file-exists"):
        make("mine", "--out", tmp_path)
    make("mine", "--out", tmp_path, "--force")
    assert "class Mine" in (tmp_path / "mine.py").read_text()


def test_a_place_that_is_no_folder_and_no_python_file_is_refused(tmp_path):
    with raises(OutputError, "no-place-for-file", suffix=".py"):
        make("mine", "--kind", "compiled", "--out", tmp_path / "robots")


HANGS = """
from sim import Command

class Hangs:
    def reset(self): return (0.0,)
    def act(self, observation, memory):
        print("step", memory[0])
        while memory[0] == 4.0: pass
        return Command(0.1, 0.2), (memory[0] + 1.0,)
"""


def hosted(*arguments):
    return [sys.executable, "-m", "sim.host", *map(str, arguments)]


@pytest.mark.gate
def test_a_hosted_class_drives_as_it_does_here(tmp_path):
    name, world = made(tmp_path, "python")["controller"], generate("maze", 7, size=20)
    with ProcessController(hosted(name)) as there:
        found = simulate(world, there, RunOptions(steps=300), record=True).trace
    here = simulate(world, CONTROLLERS.get(name), RunOptions(steps=300), record=True).trace
    shortest = min(len(here.x), len(found.x))
    assert shortest > 100 and np.array_equal(
        here.states[:shortest, :4], found.states[:shortest, :4]
    )


@pytest.mark.gate
def test_a_hosted_class_that_hangs_has_a_verdict_and_its_prints_are_no_commands(tmp_path):
    (tmp_path / "mine.py").write_text(HANGS)
    with ProcessController(hosted(tmp_path / "mine.py:Hangs"), deadline=0.5) as controller:
        episode = simulate(room(), controller, RunOptions(steps=50))
    assert (episode.verdict, episode.steps, episode.evidence.stderr[-1]) == ("hang", 5, "step 4.0")


@pytest.mark.gate
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "takes one controller"),
        (("turn-left",), "turn-left is not a Python class"),
        (("./absent.py:Robot",), "no such file"),
        ((f"{Path(__file__).with_name('test_episode.py')}:Follower",), "plans with the world"),
    ],
)
def test_what_cannot_be_hosted_is_one_line(arguments, message):
    result = subprocess.run(hosted(*arguments), capture_output=True, text=True, check=False)
    assert result.returncode == 1 and message in result.stderr and "Traceback" not in result.stderr
