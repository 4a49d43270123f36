"""Measure steps per second of the simulator and of other engines that drive a disc through a maze.

``python -m benchmarks.simulator`` prints a table; ``--json`` prints one object. It has each case's
rate and its ratio to each peer, all from one run. Peers that are not installed are skipped and
named: pymunk and mujoco come with pip.

The maze has 60 x 60 cells, the disc a radius of 0.7 cells, and a step is 0.3 cells long. The
controller is a simple reactive one: straight ahead, and after a bump on the spot for 5 to 24 steps.
Rates are steps per second of processor time, but per second of wall time with several
threads or processes; the best of all rounds counts. Cases and peers take turns in every
round, so that other work on the machine affects all alike.

Two peers are our own C (``peers/plain_disc.c``): a disc that drives through the maze without a
lattice, a verdict or a search for loops. ``plain C`` is always moving, which is the usual way to
measure a simulator; ``plain C, bouncer`` turns on the spot like the cases do.
"""

from __future__ import annotations

import argparse
import ctypes
import functools
import importlib
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import shapely

from build_tools.cores import compiler
from sim import (
    Command,
    Commands,
    CompiledController,
    ProcessController,
    RobotOptions,
    RunOptions,
    simulate_many,
)
from sim.controllers import CONTROLLERS, Controller
from sim.episode import prepare
from sim.kernels import layout
from sim.runners.core_calls import MOST_CORNERS, STATE_WORDS, ffi
from worldgen import generate
from worldgen.random_streams import RandomStream
from worldgen.robot import Drive
from worldgen.world import Pose, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--rounds", "1")

# Seconds.
STEP = 0.015
# Turn rate, rad/s.
RATE = 12.0
# Steps, seconds.
Rate = tuple[float, float]


def _act(observation: Any, memory: Any, command: Any) -> None:
    if observation[layout.OBS_BUMP] != 0.0:
        memory[0] = 5.0 + math.floor(observation[layout.OBS_RANDOM] * 20.0)
        command[layout.CMD_DRAW] = 1.0
    if memory[0] > 0.0:
        memory[0] -= 1.0
        command[layout.CMD_TURN_RATE] = RATE
    else:
        command[layout.CMD_SPEED] = 2.0


BOUNCER = CompiledController(
    "bouncer", _act, (0.0,), 2.0, randomised=True, senses=("bump", "random")
)
"""The bouncer as a function that numba compiles."""


@functools.cache
def _built() -> tempfile.TemporaryDirectory[str]:
    """Return a folder with the benchmark's C, compiled; it is deleted with the process."""
    here = Path(__file__).parent
    folder = tempfile.TemporaryDirectory()
    for source in (here / "bouncer.c", here / "peers" / "plain_disc.c"):
        made = Path(folder.name, source.stem).with_suffix(".so")
        flags = ["-std=c17", "-O3", "-fPIC", "-shared", f"-I{here.parent / 'sim' / 'include'}"]
        subprocess.run([*compiler(), *flags, str(source), "-o", str(made), "-lm"], check=True)
    return folder


def in_c(name: str = "bouncer") -> Controller:
    """Return the bouncer in C, or ``eyes``, which has range beams too."""
    return CONTROLLERS.get(f"lib:{_built().name}/bouncer.so:{name}")


@dataclass(frozen=True)
class Bouncer:
    """The same controller as a Python class."""

    senses = ("bump", "random")

    def reset(self) -> tuple[float, ...]:
        """Start without a turn."""
        return (0.0,)

    def act(self, observation: Any, memory: tuple[float, ...]) -> tuple[Command, tuple[float, ...]]:
        """Drive ahead, or continue the turn."""
        rest = 5.0 + math.floor(observation.random * 20.0) if observation.bump else memory[0]
        if rest > 0.0:
            return Command(0.0, RATE, observation.bump), (rest - 1.0,)
        return Command(2.0, 0.0, observation.bump), (0.0,)


@dataclass(frozen=True)
class BouncerOfMany:
    """The same controller for many robots at once."""

    senses = ("bump", "random")

    def reset(self) -> tuple[float, ...]:
        """Start without a turn."""
        return (0.0,)

    def act_many(self, observation: Any, memory: Any) -> tuple[Commands, Any]:
        """Drive ahead, or continue the turn."""
        rest = np.where(observation.bump, 5.0 + np.floor(observation.random * 20.0), memory[:, 0])
        turns = rest > 0.0
        command = Commands(np.where(turns, 0.0, 2.0), np.where(turns, RATE, 0.0), observation.bump)
        return command, np.maximum(rest - 1.0, 0.0)[:, np.newaxis]


def maze(size: int = 60) -> World:
    """Return the maze, with its target out of reach."""
    world = generate("maze", seed=3, size=size)
    return replace(world, target=replace(world.target, radius=1e-6), certificate=None)


def hall(side: int) -> World:
    """Return a large hall with scattered pillars."""
    cells = np.zeros((side, side), bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    cells[5:-5:10, 5:-5:10] = True
    middle = side * 0.05
    return World(cells, Pose(middle + 0.05, middle + 0.05, 0.3), Target(0.3, 0.3, 1e-6))


def _run(world: World, controller: Any, steps: int, **switches: Any) -> Callable[[], Rate]:
    motion = switches.pop("motion", "swept")
    options = RunOptions(motion, steps, STEP, 5, **switches)
    run = prepare(world, controller, options)

    def once() -> Rate:
        begin = time.process_time()
        outcome = run.run(steps, find_loop=True, record=False, digest=False)
        return outcome.steps, time.process_time() - begin

    run.run(10, find_loop=True, record=False, digest=False)
    return once


def _many(workers: int) -> Callable[[], Rate]:
    world = maze()

    def once() -> Rate:
        begin = time.perf_counter()
        runs = simulate_many(world, in_c(), seeds=512, steps=5_000, workers=workers)
        return int(runs.steps.sum()), time.perf_counter() - begin

    simulate_many(world, in_c(), seeds=1, steps=10)
    return once


def _program() -> Callable[[], Rate]:
    """Return a program: the Python class, served by another process, whose time counts too."""
    program = ProcessController([sys.executable, "-m", "sim.host", "benchmarks.simulator:Bouncer"])
    run = prepare(maze(), program, RunOptions("swept", 20_000, STEP, 5))

    def once() -> Rate:
        begin = time.perf_counter()
        outcome = run.run(20_000, find_loop=False, record=False, digest=False)
        return outcome.steps, time.perf_counter() - begin

    return once


def _lockstep() -> Rate:
    begin = time.process_time()
    runs = simulate_many(maze(), BouncerOfMany(), seeds=1024, steps=1_000)
    return int(runs.steps.sum()), time.process_time() - begin


def _beams() -> Callable[[], Rate]:
    return _run(maze(), in_c("eyes"), 200_000, robot=RobotOptions(beams=36, beam_range=2.0))


def _of_another(world: World, **parts: Any) -> World:
    """Return a world whose robot has another body or drive."""
    return replace(world, robots=(replace(world.robots[0], **parts),))


def _box(length: float, width: float) -> tuple[tuple[float, float], ...]:
    x, y = length / 2, width / 2
    return ((x, y), (-x, y), (-x, -y), (x, -y))


CASES: dict[str, Callable[[], Callable[[], Rate]]] = {
    "swept, compiled controller": lambda: _run(maze(), in_c(), 2_000_000),
    "the same compiled by numba": lambda: _run(maze(), BOUNCER, 2_000_000),
    "the same in a 2000 x 2000 world": lambda: _run(hall(2000), in_c(), 1_000_000),
    "the same with 36 beams": _beams,
    "endpoint, compiled controller": lambda: _run(maze(), in_c(), 2_000_000, motion="endpoint"),
    "a rectangle, compiled by numba": lambda: _run(
        _of_another(maze(), footprint=_box(0.12, 0.08)), BOUNCER, 1_000_000
    ),
    "a rectangle of 6 x 9 cells": lambda: _run(
        _of_another(hall(300), footprint=_box(0.62, 0.9)), BOUNCER, 1_000_000
    ),
    "a car, compiled by numba": lambda: _run(
        _of_another(maze(), drive=Drive(0.2, reverse=True)), BOUNCER, 1_000_000
    ),
    "stepped, the thesis's robot": lambda: _run(maze(), "turn-random", 500_000, motion="stepped"),
    "swept, Python class": lambda: _run(maze(), Bouncer(), 20_000),
    "swept, vector class, 1024 robots": lambda: _lockstep,
    "swept, program in Python (wall)": _program,
    "simulate_many, 1 thread (wall)": lambda: _many(1),
    "simulate_many, 2 threads (wall)": lambda: _many(2),
}


def _turns(stream: RandomStream) -> Iterator[tuple[float, bool]]:
    """Yield the heading and whether to drive: the peers' controller, told of collisions."""
    heading = 0.0
    rest = 0
    bumped = yield heading, True
    while True:
        if bumped:
            rest = stream.between(5, 24)
        if rest > 0:
            rest = rest - 1
            heading = heading + RATE * STEP
        bumped = yield heading, rest == 0


def _boxes(world: World) -> list[tuple[float, float, float, float]]:
    """Return walls as boxes, runs of cells in a row merged, m."""
    side = world.cell_size
    found = []
    for iy in range(world.height):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], world.walls[iy].astype(np.int8), [0]])))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            found.append((first * side, iy * side, last * side, (iy + 1) * side))
    return found


def _plain(name: str) -> Callable[[], Rate]:
    """Return a function that runs the plain disc in the maze of the cases; lengths are cells."""
    # Describe the maze and the robot to the C function.
    world = maze()
    steps = 2_000_000
    side = world.cell_size
    cells = np.ascontiguousarray(world.walls, np.uint8)
    function = ctypes.CDLL(f"{_built().name}/plain_disc.so")[name]
    function.restype = ctypes.c_double
    pose = (world.start.x / side, world.start.y / side, world.robot_radius / side, 0.03 / side)
    grid = (
        ctypes.c_void_p(cells.ctypes.data),
        ctypes.c_int64(world.width),
        ctypes.c_int64(world.height),
    )
    before = (*grid, *map(ctypes.c_double, pose))
    after = (ctypes.c_uint64(5), ctypes.c_int64(steps))
    # Places to head for: free cells whose four neighbours are free, so that the disc fits.
    walls = np.pad(world.walls, 1, constant_values=True)
    shut = (
        walls[1:-1, 1:-1] | walls[:-2, 1:-1] | walls[2:, 1:-1] | walls[1:-1, :-2] | walls[1:-1, 2:]
    )
    marks = np.ascontiguousarray(np.argwhere(~shut)[::7, ::-1] + 0.5)

    def once() -> Rate:
        begin = time.process_time()
        if name == "bounce":
            function(*before, ctypes.c_double(RATE * STEP), *after)
        else:
            function(
                *before, ctypes.c_void_p(marks.ctypes.data), ctypes.c_int64(len(marks)), *after
            )
        return steps, time.process_time() - begin

    return once


def _shapely() -> Callable[[], Rate]:
    world = maze()
    steps = 2_000
    # A tree of boxes is the fastest query that shapely offers.
    tree = shapely.STRtree([shapely.box(*box) for box in _boxes(world)])

    def once() -> Rate:
        drive = _turns(RandomStream(5))
        x = world.start.x
        y = world.start.y
        heading, ahead = next(drive)
        begin = time.process_time()
        for _ in range(steps):
            bumped = False
            if ahead:
                to = x + 0.03 * math.cos(heading), y + 0.03 * math.sin(heading)
                bumped = (
                    len(tree.query(shapely.LineString([(x, y), to]), "dwithin", world.robot_radius))
                    > 0
                )
                x, y = (x, y) if bumped else to
            heading, ahead = drive.send(bumped)  # type: ignore[attr-defined]
        return steps, time.process_time() - begin

    return once


def _pymunk() -> Callable[[], Rate]:
    # Build the maze of static boxes, and the disc.
    pymunk = importlib.import_module("pymunk")

    world = maze()
    steps = 20_000
    space = pymunk.Space()
    for left, low, right, high in _boxes(world):
        corners = [(left, low), (right, low), (right, high), (left, high)]
        space.add(pymunk.Poly(space.static_body, corners))
    body = pymunk.Body(1.0, math.inf)
    space.add(body, pymunk.Circle(body, world.robot_radius))

    # Let the engine take the steps; the controller turns at bumps.
    def once() -> Rate:
        body.position = world.start.x, world.start.y
        drive = _turns(RandomStream(5))
        heading, ahead = next(drive)
        begin = time.process_time()
        for _ in range(steps):
            speed = 2.0 if ahead else 0.0
            body.velocity = speed * math.cos(heading), speed * math.sin(heading)
            before = body.position
            space.step(STEP)
            bumped = ahead and (body.position - before).length < 0.8 * speed * STEP
            heading, ahead = drive.send(bumped)  # type: ignore[attr-defined]
        return steps, time.process_time() - begin

    return once


def _mujoco() -> Callable[[], Rate]:
    mujoco = importlib.import_module("mujoco")

    world = maze()
    steps = 5_000
    # One geom per rectangle of walls, because MuJoCo's time grows with their number.
    geoms = "".join(
        f'<geom type="box" pos="{(a + c) / 2} {(b + d) / 2} 0" size="{(c - a) / 2} {(d - b) / 2} '
        f'0.1"/>'
        for a, b, c, d in _boxes(world)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" gravity="0 0 0"/><worldbody>{geoms}'
        f'<body pos="{world.start.x} {world.start.y} 0"><joint type="slide" axis="1 0 0"/>'
        f'<joint type="slide" axis="0 1 0"/><geom type="cylinder" size="{world.robot_radius} 0.1"/>'
        "</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)

    def once() -> Rate:
        mujoco.mj_resetData(model, data)
        drive = _turns(RandomStream(5))
        heading, ahead = next(drive)
        begin = time.process_time()
        for _ in range(steps):
            speed = 2.0 if ahead else 0.0
            # MuJoCo has no bump sensor: the robot has bumped if it moved far less than commanded.
            data.qvel[:] = speed * math.cos(heading), speed * math.sin(heading)
            before = data.qpos.copy()
            mujoco.mj_step(model, data)
            bumped = ahead and float(np.hypot(*(data.qpos - before))) < 0.8 * speed * STEP
            heading, ahead = drive.send(bumped)  # type: ignore[attr-defined]
        return steps, time.process_time() - begin

    return once


PEERS: dict[str, Callable[[], Callable[[], Rate]]] = {
    "plain C": lambda: _plain("wander"),
    "plain C, bouncer": lambda: _plain("bounce"),
    "pymunk": _pymunk,
    "mujoco": _mujoco,
    "shapely": _shapely,
}


def measure(rounds: int) -> tuple[dict[str, float], list[str]]:
    """Return the best rate of each case and peer, steps per second, and the peers not installed."""
    ready = {name: make() for name, make in CASES.items()}
    absent = []
    for name, make in PEERS.items():
        try:
            ready[name] = make()
        except ImportError:
            absent.append(name)
    best = dict.fromkeys(ready, 0.0)
    for _ in range(rounds):
        for name, once in ready.items():
            steps, seconds = once()
            best[name] = max(best[name], steps / seconds)
    return best, absent


def _first_call() -> float:
    """Return seconds until a new process has simulated its first step."""
    code = (
        "from sim import simulate; from worldgen import generate;"
        "simulate(generate('maze', seed=3, size=60), 'turn-right', steps=1)"
    )
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return time.perf_counter() - begin


def _bytes_per_robot() -> int:
    """Return the bytes of an episode of the bouncer, without the log of the loop search."""
    state = 8 * (STATE_WORDS + len(BOUNCER.memory))
    corners = MOST_CORNERS * int(ffi.sizeof("WgCorner"))
    return int(ffi.sizeof("WgEpisode")) + 2 * state + corners + 8 * layout.OBS_SIZE


def main() -> None:
    """Run all and print the table."""
    # Parse the options and measure.
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--rounds", type=int, default=5, help="rounds; the best counts (default 5)")
    arguments = parser.parse_args()
    rates, absent = measure(arguments.rounds)
    first = _first_call()
    # Relate each case to the peers.
    peers = [name for name in PEERS if name in rates]
    cases = {
        name: {
            "steps_per_second": rates[name],
            "ratios": {peer: rates[name] / rates[peer] for peer in peers},
        }
        for name in CASES
    }
    result = {
        "cases": cases,
        "peers": {peer: {"steps_per_second": rates[peer]} for peer in peers},
        "absent_peers": absent,
        "first_call_seconds": first,
        "bytes_per_robot": _bytes_per_robot(),
    }
    # Print one object or the table.
    if arguments.json:
        click.echo(json.dumps(result))
        return
    click.echo("".join([f"{'':36}{'steps/s':>12}", *(f"{'x ' + peer:>20}" for peer in peers)]))
    for name, case in cases.items():
        ratios = "".join(f"{case['ratios'][peer]:20.2f}" for peer in peers)
        click.echo(f"{name:36}{case['steps_per_second']:12,.0f}{ratios}")
    for peer in peers:
        click.echo(f"{peer:36}{rates[peer]:12,.0f}")
    click.echo(f"first step of a new process: {first:.2f} s")
    click.echo(
        f"memory per robot: {result['bytes_per_robot']} bytes, and a byte of each cell for where "
        f"it has been"
    )
    if absent:
        click.echo(f"not installed: {', '.join(absent)}")


if __name__ == "__main__":
    main()
