"""Failing tests fail, and debuggers, profilers and coverage end: nothing hangs, nothing changes.

Each test runs a program as a user would, in a process of its own; its limit only ends a run that
hangs. The slower half runs everything that relies on Python's runtime: imports next to a user's
file, the simulator's calls from C, a step that is interrupted when the budget is spent, counted
lines, and a family that is checked in another process.
"""

import subprocess
import sys

import pytest

LIMIT = 300
FILES = {
    "steering.py": "TURN = 1.5\n",
    "robot.py": """
import random
import time
from time import monotonic

import steering


class Circles:
    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        bumps = memory[0] + 1.0 if observation.bump else memory[0]
        return (1.0, steering.TURN), (bumps % 4.0,)


class Jittery:
    def __init__(self):
        self.random = random.Random()

    def reset(self):
        return ()

    def act(self, observation, memory):
        turn = steering.TURN + self.random.random() + random.random()
        return (1.0, turn + time.time() % 0.5 + monotonic() % 0.3), ()


class Endless:
    def reset(self):
        return ()

    def act(self, observation, memory):
        while True:
            pass
""",
    "halls.py": '''
import numpy as np

from worldgen.family import check_between, family
from worldgen.world import Pose, Target, World


@family("hall", version=1)
def hall(rng, *, size: int = 12) -> World:
    """Build an empty hall.

    Args:
        size: Cells per side.
    """
    check_between("size", size, 12, 12)
    x, y = (0.2 + rng.below(1000) / 10_000 for _ in range(2))
    start = Pose(x, y)
    return World(np.zeros((12, 12), bool), start, Target(1.0, 1.0, 0.05))
''',
    "test_property.py": """
from hypothesis import given

from fuzz.strategies import worlds
from sim import simulate


@given(worlds("trap"))
def test_arrives(world):
    assert simulate(world, "./robot.py:Circles").verdict == "reached"
""",
    "test_example.py": """
from sim import simulate
from worldgen import generate


def test_arrives():
    assert simulate(generate("trap", 4, size=20), "./robot.py:Circles").verdict == "reached"
""",
    "run.py": """
from sim import simulate
from worldgen import generate

trap = generate("trap", 4, size=20)
episode = simulate(trap, "./robot.py:Circles")
print("RESULT", episode.verdict, episode.steps)
episode = simulate(trap, "./robot.py:Jittery", frozen_time=True, steps=1000)
print("RESULT", episode.steps, episode.trace_digest)
""",
    "commands.py": """
import glob
import sys

import hypothesis  # the plug-in now waits for worldgen to be imported

from worldgen.cli.main import cli

SEARCH = "--examples 1 --seed 1 --workers 1 --no-shrink --strategy trap --force"


def run(line):
    words = [(sorted(glob.glob(word)) or [word])[0] for word in line.split()]
    try:
        code = cli.main(words, standalone_mode=False)
    except SystemExit as stop:
        code = stop.code
    except Exception as error:
        code = error
    print("RESULT", words[0], code)


if __name__ == "__main__":
    run("trap --size 20 --seed 4 --out w.grid --force")
    run(f"fuzz --controller ./robot.py:Circles --units 1 {SEARCH} --out found")
    run(f"fuzz --controller ./robot.py:Endless --budget 1s {SEARCH} --out none")
    run("explain found/*.grid")
    run("check-family ./halls.py:hall")
    if "with chance" in sys.argv:
        run(f"fuzz --controller ./robot.py:Jittery+frozen_time --units 1 {SEARCH} --out jitter")
""",
    "under.py": """
import runpy
import sys
import threading


def trace(frame, event, argument):
    return trace


tool, program = sys.argv[1:]
if tool == "settrace":
    threading.settrace(trace)
    sys.settrace(trace)
elif tool == "setprofile":
    threading.setprofile(trace)
    sys.setprofile(trace)
elif tool == "monitoring":
    events = sys.monitoring.events
    watched = (events.PY_START, events.LINE, events.CALL, events.RAISE)
    sys.monitoring.use_tool_id(4, "red suite")
    for event in watched:
        sys.monitoring.register_callback(4, event, lambda *_: None)
    sys.monitoring.set_events(4, sum(watched))
runpy.run_path(program, run_name="__main__")
# Whatever was interrupted in the meantime, the tool still works.
assert tool != "settrace" or sys.gettrace() is trace
assert tool != "setprofile" or sys.getprofile() is trace
""",
}
MONITORING = pytest.mark.skipif(sys.version_info < (3, 12), reason="Python 3.12 brought it")
DEBUGGERS = [
    pytest.param(["under.py", "settrace"], id="settrace"),
    pytest.param(["-m", "pdb"], id="pdb"),
]
PROFILERS = [
    pytest.param(["under.py", "setprofile"], id="setprofile"),
    pytest.param(["under.py", "monitoring"], id="monitoring", marks=MONITORING),
    pytest.param(["-m", "cProfile", "-o", "profile"], id="cProfile"),
    pytest.param(["-m", "coverage", "run"], id="coverage"),
]
TOOLS = [*DEBUGGERS, *PROFILERS]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("red")
    for name, text in FILES.items():
        (folder / name).write_text(text.removeprefix("\n"))
    return folder


def python(folder, *words, stdin=""):
    return subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        input=stdin,
        capture_output=True,
        text=True,
        timeout=LIMIT,
        check=False,
    )


def results(done):
    """Return the lines that a program prints about its results."""
    found = [line.partition("RESULT ")[2] for line in done.stdout.splitlines() if "RESULT" in line]
    assert found, done
    return found


@pytest.mark.parametrize(
    "words", [["test_property.py"], ["--cov=robot", "test_example.py"]], ids=["property", "cov"]
)
def test_a_failing_test_fails(words, project):
    done = python(project, "-m", "pytest", "-p", "no:cacheprovider", *words)
    assert done.returncode == 1 and "1 failed" in done.stdout
    assert "Explanation" in done.stdout or "robot.py" in done.stdout


def test_a_profile_of_the_command_line_ends(project):
    words = ["-m", "cProfile", "-m", "worldgen", "maze", "--size", "20", "--seed", "1"]
    done = python(project, *words, "--out", "m.grid")
    assert done.returncode == 0 and (project / "m.grid").exists()


@pytest.fixture(scope="module")
def plain_runs(project):
    return results(python(project, "run.py"))


@pytest.mark.parametrize("tool", TOOLS)
def test_a_run_is_the_same_under_a_tool(tool, project, plain_runs):
    done = python(project, *tool, "run.py", stdin="continue\nquit\n")
    assert results(done) == plain_runs
    assert plain_runs[0] == "stalled 4000"
    assert done.returncode == 0, done


@pytest.fixture(scope="module")
def plain_commands(project):
    return results(python(project, "commands.py"))


@pytest.mark.gate
@pytest.mark.parametrize("tool", DEBUGGERS)
def test_commands_are_the_same_under_a_debugger(tool, project, plain_commands):
    _expect_the_same(tool, project, plain_commands)


@pytest.mark.nightly
@pytest.mark.parametrize("tool", PROFILERS)
def test_commands_are_the_same_under_a_profiler(tool, project, plain_commands):
    _expect_the_same(tool, project, plain_commands)


def _expect_the_same(tool, project, plain_commands):
    codes = [line.partition(" ")[2][:4] for line in plain_commands]
    assert codes == ["None", "1", "./ro", "None", "None"]
    done = python(project, *tool, "commands.py", stdin="continue\nquit\n")
    assert results(done) == plain_commands
    assert done.returncode == 0, done


@pytest.mark.nightly
@pytest.mark.parametrize("tool", TOOLS)
def test_a_campaign_of_a_robot_with_chance_is_the_same_under_a_tool(tool, project):
    plain = results(python(project, "commands.py", "with chance"))
    assert plain[-1] == "fuzz 1"
    done = python(project, *tool, "commands.py", "with chance", stdin="continue\nquit\n")
    assert results(done) == plain
    assert done.returncode == 0, done
