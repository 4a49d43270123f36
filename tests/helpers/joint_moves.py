"""Single joint moves of the core, with displacements that a test chooses."""

import math

import numpy as np

from sim._core import ffi, lib
from sim.controllers import CONTROLLERS
from sim.fleet import FleetRun
from sim.fleet.core_calls import CoreFleet
from sim.options.run import options_of
from tests.helpers.fleets import crowd


class JointMoves:
    """Robots of a world, moved in the core step by step."""

    def __init__(self, world, motion="swept", **settings):
        options = options_of(world, {"motion": motion, "steps": 10, **settings})
        count = len(world.robots)
        run = FleetRun(world, [CONTROLLERS.get("naive")] * count, [options] * count)
        self.world = world
        self.settings = [one.settings for one in run.runs]
        self.cells = np.array(world.walls, np.uint8)
        drivers = [one.driver() for one in run.runs]
        self.fleet = CoreFleet(run.runs, drivers, 10, lib.WG_NO_LOOP)
        self.clear_sq = {
            (one, other): int(
                self.fleet.c.settings.clear_sq[
                    self.fleet.c.settings.kind[one] * self.fleet.c.settings.kinds
                    + self.fleet.c.settings.kind[other]
                ]
            )
            for other in range(count)
            for one in range(other)
        }

    def places(self):
        """Return where the robots are, lattice units."""
        states = [member.state for member in self.fleet.members]
        return [(int(state.x), int(state.y)) for state in states]

    def collision(self):
        """Return the robots that drove through each other in the last move; ``None`` if none."""
        report = self.fleet.report
        return (int(report.robot), int(report.other)) if report.ending == lib.WG_COLLISION else None

    def move(self, displacements):
        """Move all robots; return each one's path, as (x, y, time) after its start, and its
        contact.
        """
        for member, (dx, dy) in zip(self.fleet.members, displacements, strict=True):
            # The core looks as far ahead as the wheels drive.
            member.state.speed = math.ceil(math.hypot(dx, dy)) * lib.WG_SPEED_UNIT
            member.report.ending = lib.WG_LIMIT  # a robot at its target keeps driving
            member.c.robot.corners = 0
            member.c.robot.contact = (0.0, 0.0)
        self.fleet.report.ending = lib.WG_LIMIT
        by = ffi.new("WgVector[]", [tuple(one) for one in displacements])
        lib.wg_fleet_move(self.fleet.c, by)
        robots = [member.c.robot for member in self.fleet.members]
        return [
            (
                [
                    (int(robot.chain[k].x), int(robot.chain[k].y), int(robot.chain[k].time))
                    for k in range(int(robot.corners))
                ],
                (float(robot.contact.x), float(robot.contact.y)),
            )
            for robot in robots
        ]


def draw_displacements(rng, count):
    """Return displacements, lattice units: short, long, some in the same direction, some zero."""
    lengths = rng.choice([0, 1, 40, 300, 900, 3000], count)
    angles = rng.uniform(0.0, 2.0 * math.pi, count)
    if rng.random() < 0.3:
        angles[:] = rng.choice([0.0, 0.5, 1.0, 1.5]) * math.pi
    return [
        (round(length * math.cos(angle)), round(length * math.sin(angle)))
        for length, angle in zip(lengths, angles, strict=True)
    ]


def crowds(seeds, **settings):
    """Yield a crowd for each seed, with its random generator."""
    for seed in seeds:
        rng = np.random.default_rng(seed)
        yield rng, JointMoves(crowd(rng), **settings)
