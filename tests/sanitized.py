"""Use every part of the product whose C keeps addresses, for a build with sanitizers.

``python -m tests.sanitized`` generates a world of every family, proves and drives fleets of more
robots than are planned together, and runs short campaigns of controllers in C. ``.ci/sanitized``
runs it with the C under AddressSanitizer, which ends the process at the first fault.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import math
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from benchmarks.referee import random_body, referee_bodies
from fuzz.campaign.unit import run_unit
from fuzz.unit.config import CampaignConfig
from sim import RobotOptions, RunOptions, simulate, simulate_many
from sim.scenario import Scenario
from worldgen import check_certificate, decide, generate, read_world, write_world
from worldgen.errors import InvalidWorld
from worldgen.family import FAMILIES
from worldgen.random_streams import RandomStream
from worldgen.reach.body.core_calls import Body, BodyPose
from worldgen.robot import Drive, Pose, Robot, Target
from worldgen.world import World

_CONTROLLERS = ("turn-right", "turn-random", "bug2", "vfh", "gestalt", "mapper", "q-learner")
_SHOVED = RobotOptions(
    pushes=(0.3, 0.1, 0.05, 1.0, 0.6, -0.2, 0.1, -2.0), drift=0.05, slip=0.1, odometry_noise=0.1
)
_FLEETS = (("rooms", 12), ("fire", 12), ("corridor", 11))


def main() -> None:
    """Run everything, and say what comes next."""
    parser = argparse.ArgumentParser(prog="python -m tests.sanitized", description=__doc__)
    parser.add_argument("--thorough", action="store_true", help="more seeds, controllers, units")
    thorough = parser.parse_args().thorough
    _generate(range(5) if thorough else range(1))
    _fleets(range(5) if thorough else range(1))
    _prove_bodies(100_000, 200 if thorough else 40)
    _controllers(_CONTROLLERS)
    _drive_bodies(100_000 if thorough else 10_000)
    _campaigns(_CONTROLLERS if thorough else _CONTROLLERS[:2], 10 if thorough else 2)
    print("no fault found")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _generate(seeds: range) -> None:
    """Generate, prove, write and read worlds of every family."""
    with tempfile.TemporaryDirectory() as folder:
        for name in FAMILIES.names():
            _say(f"family {name}")
            for seed in seeds:
                world = generate(name, seed)
                file = Path(folder) / f"{name}-{seed}.grid"
                write_world(world, file)
                decide(read_world(file))
                check_certificate(world)
            gc.collect()


def _fleets(seeds: range) -> None:
    """Place more robots than are planned together, and drive them."""
    for name, robots in _FLEETS:
        _say(f"fleet {name} of {robots}")
        for seed in seeds:
            world = generate(name, seed, robots=robots)
            gc.collect()
            check_certificate(world)
            simulate(world, "orca", steps=300)
            simulate(world, "turn-right", steps=2_000)


def _prove_bodies(poses: int, worlds: int) -> None:
    """Test random bodies at random poses, and decide where some of them get."""
    _say(f"{poses} poses of bodies")
    rng = np.random.default_rng(1)
    for number in range(worlds):
        walls = rng.random(rng.integers(4, 24, 2)) < rng.choice([0.0, 0.03, 0.1])
        height, width = walls.shape
        points = rng.uniform(-1, 1, (int(rng.integers(3, 40)), 2)) * rng.choice([0.05, 0.3, 3.0])
        points += rng.uniform(-0.3, 0.3, 2)
        hull = shapely.convex_hull(shapely.multipoints(points))
        footprint = shapely.get_coordinates(hull)[:-1][:16].tolist()
        try:
            robot = Robot(Pose(0.1 * width / 2, 0.1 * height / 2), Target(0.1, 0.1, 0.1))
            robot = replace(robot, footprint=tuple(map(tuple, footprint)))
            body = Body(walls, robot.footprint, 0.1)
        except InvalidWorld:
            continue
        for _ in range(poses // worlds):
            x, to_x = rng.integers(-2048, (width + 2) * 1024, 2).tolist()
            y, to_y = rng.integers(-2048, (height + 2) * 1024, 2).tolist()
            heading, turn = rng.integers(0, 32_768, 2).tolist()
            pose = BodyPose(x, y, 2 * heading)
            if body.is_clear(pose) and body.may_move(pose, to_x, to_y):
                body.may_turn(pose, turn)
                body.clearance([pose, BodyPose(to_x, to_y, 2 * heading)])
        world = World(walls, robots=[robot])
        decision = decide(world)
        if number % 4 == 0 and decision.certificate is not None:
            check_certificate(world, decision.certificate)


def _controllers(names: tuple[str, ...]) -> None:
    """Run controllers alone, recorded, and many at once."""
    world = generate("maze", 3, size=20)
    for name in names:
        _say(f"controller {name}")
        simulate(world, name, steps=3_000, record=True)
        simulate_many([world], [name], seeds=range(4), options=RunOptions(steps=1_000))
        gc.collect()


def _drive_bodies(moves: int) -> None:
    """Move and turn random bodies, and run some of them, and cars, with pushes, fire and beams."""
    _say(f"{moves:,} moves of bodies")
    referee_bodies(moves, 5)
    _say("runs of bodies and cars")
    stream = RandomStream(7)
    for seed in range(moves // 1_000):
        world = generate(("fire", "trap", "corridor")[seed % 3], seed)
        corners = random_body(stream)
        # About as large as the world's own robot, so that many are clear at the start.
        scale = 1.2 * world.robot_radius / max(math.hypot(*corner) for corner in corners)
        footprint = tuple((x * scale, y * scale) for x, y in corners)
        drive = (
            Drive(3.0 * world.robot_radius, seed % 2 == 0, 2.0 * (seed % 3))
            if seed % 4
            else Drive()
        )
        robot = replace(world.robots[0], footprint=footprint, drive=drive)
        for motion in ("swept", "endpoint"):
            with contextlib.suppress(InvalidWorld):
                simulate(
                    replace(world, robots=(robot,), certificate=None),
                    "vfh" if seed % 5 == 0 else "turn-random",
                    RunOptions(motion, 600, robot=_SHOVED),
                    record=True,
                )


def _campaigns(names: tuple[str, ...], examples: int) -> None:
    """Run a unit of every search strategy for one robot, and one for a fleet."""
    for name in names:
        _say(f"campaign of {name}")
        run_unit(CampaignConfig(scenario=Scenario(name), examples=examples), 0)
    _say("campaign of a fleet")
    run_unit(CampaignConfig(scenario=Scenario("turn-right"), examples=examples, robots=2), 0)


if __name__ == "__main__":
    main()
