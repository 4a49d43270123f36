"""Ctrl-C ends a command while C code works: code 130, one sentence, no traceback."""

import random
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from worldgen import Event, Pose, Robot, Target, Timeline, World, write_world
from worldgen.timeline import CellState

SIZE = 0.1  # m, side of a cell
# Ends only a run that does not hear Ctrl-C, s.
LIMIT = 180

# The command line, and a thread that sends Ctrl-C once the main thread is inside a named function
# of a named file. That is a sign of work on any machine, however fast.
MAIN = """
import os, signal, sys, threading
from worldgen.cli.main import main

file, function = sys.argv[1].split("::")
sys.argv = ["worldgen", *sys.argv[2:]]
worker = threading.get_ident()

def is_at_work():
    frame = sys._current_frames().get(worker)
    while frame is not None:
        if frame.f_code.co_name == function and frame.f_code.co_filename.endswith(file):
            return True
        frame = frame.f_back
    return False

def press():
    while not is_at_work():
        pause.wait(0.001)
    print("pressed", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGINT)

pause = threading.Event()
threading.Thread(target=press, daemon=True).start()
main()
"""


def pose(x, y):
    return Pose((x + 0.5) * SIZE, (y + 0.5) * SIZE, 0.0)


def target(x, y):
    return Target((x + 0.5) * SIZE, (y + 0.5) * SIZE, 0.05)


def hall(side, **fields):
    """An empty square with start and target in opposite corners."""
    given = {
        "walls": np.zeros((side, side), np.bool_),
        "cell_size": SIZE,
        "robot_radius": 0.03,
        "start": pose(1, 1),
        "target": target(side - 2, side - 2),
    }
    return World(**(given | fields))


def rubble(side):
    """A large world of single cells, in which no search is short."""
    walls = np.random.default_rng(1).random((side, side)) < 0.3
    walls[:3, :3] = False
    walls[-3:, -3:] = False
    return hall(side, walls=walls)


def flicker(side, events):
    """A world in which cells change all the time."""
    generator = random.Random(1)
    state = [CellState.SOLID, CellState.FREE]
    return hall(
        side,
        timeline=Timeline.of(
            Event(
                n * 0.01,
                generator.randrange(5, side - 5),
                generator.randrange(5, side - 5),
                state[n % 2],
            )
            for n in range(events)
        ),
    )


def crowd(side, count):
    """So many robots that hardly any of them can move."""
    generator = random.Random(3)
    cells = [(x, y) for x in range(side) for y in range(side)]
    starts, ends = generator.sample(cells, count), generator.sample(cells, count)
    robots = [
        Robot(pose(*start), Target(pose(*end).x, pose(*end).y, 0.02), 0.049, 1.0)
        for start, end in zip(starts, ends, strict=True)
    ]
    return replace(hall(side), robots=robots)


def walled_off(robots=1):
    """A world whose target nobody can reach."""
    walls = np.zeros((20, 20), np.bool_)
    walls[:, 14] = True
    others = [Robot(pose(1, 2 * n + 1), target(18, 2 * n + 1), 0.03, 1.0) for n in range(1, robots)]
    world = hall(20, walls=walls)
    return replace(world, robots=(*world.robots, *others))


LONG = ("--steps", "100000000", "--seed", "1")

# For each, the function that it is in when Ctrl-C comes, the world, and the command.
COMMANDS = {
    "looking for a path": (
        "lattice_graph.py::find_path",
        lambda: rubble(1500),
        ("verify", "WORLD"),
    ),
    "looking for a cut": (
        "still/cut.py::find_chain",
        lambda: rubble(1500),
        ("verify", "WORLD", "--radius", "0.06"),
    ),
    "looking for a path among very many changes": (
        "timed/earliest.py::_search",
        lambda: flicker(400, 100_000),
        ("verify", "WORLD"),
    ),
    "planning robots one after another": (
        "joint/plan.py::add",
        lambda: crowd(8, 60),
        ("verify", "WORLD"),
    ),
    "planning all robots at once": (
        "joint/plan.py::_joint",
        lambda: crowd(8, 60),
        ("verify", "WORLD"),
    ),
    "running a robot": (
        "runners/core_calls.py::run",
        walled_off,
        ("run", "WORLD", "--controller", "random-walk", *LONG),
    ),
    "running a fleet": (
        "fleet/core_calls.py::run",
        lambda: walled_off(robots=3),
        ("run", "WORLD", "--controller", "random-walk", *LONG),
    ),
    "running the thesis's robot": (
        "thesis/run.py::_go_on",
        walled_off,
        ("run", "WORLD", "--controller", "thesis-3+slip=0.1", "--motion", "stepped", *LONG),
    ),
}


def interrupted(*command):
    """Start a command that gets Ctrl-C once it is at work; return what it wrote to stderr."""
    try:
        ended = subprocess.run(
            [sys.executable, "-c", MAIN, *map(str, command)],
            check=False, capture_output=True, text=True, timeout=LIMIT,
        )  # fmt: skip
    except subprocess.TimeoutExpired as over:
        pytest.fail(f"it did not hear Ctrl-C: {over.stderr}")
    assert ended.returncode == 130, ended.stderr
    assert "pressed" in ended.stderr and "Traceback" not in ended.stderr
    return ended.stderr.split("pressed", 1)[1].strip()


@pytest.mark.gate
@pytest.mark.parametrize("work", COMMANDS)
def test_ctrl_c_ends_long_work_in_c_with_one_sentence(work, tmp_path):
    where, made, command = COMMANDS[work]
    path = tmp_path / "w.grid"
    write_world(made(), path)
    assert (
        interrupted(where, *(path if one == "WORLD" else one for one in command)) == "interrupted"
    )


@pytest.mark.gate
def test_ctrl_c_ends_a_campaign_in_its_native_search_and_says_how_to_continue(tmp_path):
    fuzz = ("fuzz", "--controller", "bug2", "--family", "native", "--budget", "10m", "--seed", "1")
    where = "screening/evaluation.py::evaluate"
    said = interrupted(where, *fuzz, "--workers", "1", "--out", tmp_path / "out")
    assert "fuzz --resume" in said
