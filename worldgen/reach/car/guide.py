"""A path for a body that turns on the spot, for a car that may reverse to follow."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from worldgen.lattice import (
    TURN,
    UNIT,
    heading_to_lattice,
    in_cells,
    lattice_units,
    metres_to_lattice,
)
from worldgen.reach.body.prove import decide_body
from worldgen.reach.single import prove
from worldgen.reach.still.walls import Walls
from worldgen.robot import Drive
from worldgen.support.arrays import Ints
from worldgen.world import Witness, World

# Shares of the room around the start by which the disc is made larger at first: a path that keeps
# away from walls takes fewer manoeuvres.
_SHARES = (0.9, 0.6, 0.3, 0.1, 0.0)
# Shares by which a footprint is made larger at first, for the same reason.
_LARGER = (0.2, 0.1, 0.05, 0.02, 0.0)


def guides(world: World) -> Iterator[Ints]:
    """Yield paths for the world's body, those with more room first: (n, 3) int64.

    Each row has x and y, lu, and the heading, 1/65536 turn. Between two rows, the body keeps its
    heading, or turns on the spot; a disc moves straight ahead or straight back.
    """
    robot = world.robots[0]
    if not robot.is_disc:
        yield from _for_footprint(world)
        return
    walls = Walls(world.walls, in_cells(robot.radius, world.cell_size))
    x, y = (lattice_units(value, world.cell_size) for value in (robot.start.x, robot.start.y))
    room = math.sqrt(walls.nearest((x, y))[1]) / UNIT * world.cell_size
    before: Witness | None = None
    for share in _SHARES:
        radius = robot.radius + share * max(0.0, room - robot.radius)
        witness = prove.decide(world, radius=radius, cut=False).certificate
        if isinstance(witness, Witness) and witness != before:
            before = witness
            yield _with_headings(world, witness)


def _for_footprint(world: World) -> Iterator[Ints]:
    """Yield paths of a footprint, first of one that is larger."""
    robot = world.robots[0]
    size = world.cell_size
    for share in _LARGER:
        larger = tuple((x * (1.0 + share), y * (1.0 + share)) for x, y in robot.footprint)
        wide = replace(robot, footprint=larger, drive=Drive())
        witness = decide_body(replace(world, robots=(wide,)), cut=False).certificate
        if isinstance(witness, Witness) and witness.headings is not None:
            columns = (witness.x.tolist(), witness.y.tolist(), witness.headings.tolist())
            yield np.array(
                [
                    (metres_to_lattice(x, size), metres_to_lattice(y, size), heading_to_lattice(h))
                    for x, y, h in zip(*columns, strict=True)
                ],
                np.int64,
            )


def _with_headings(world: World, witness: Witness) -> Ints:
    """Return the poses along a disc's path that turn least in all; some legs go backwards."""
    size = world.cell_size
    points = [
        (metres_to_lattice(x, size), metres_to_lattice(y, size))
        for x, y in zip(witness.x.tolist(), witness.y.tolist(), strict=True)
    ]
    ahead = [
        heading_to_lattice(math.atan2(by - ay, bx - ax))
        for (ax, ay), (bx, by) in itertools.pairwise(points)
    ]
    target = world.target.heading
    ends = [] if target is None else [heading_to_lattice(target)]
    # Least turn in all up to each leg, driven forwards or backwards, and how the leg before it was.
    first = heading_to_lattice(world.start.heading)
    turned = [float(abs(_turn(first, ahead[0] + gear))) for gear in _GEARS] if ahead else []
    came: list[list[int]] = []
    for before, after in itertools.pairwise([*ahead, *ends]):
        costs = [
            [
                total + abs(_turn(before + gear, after + next_gear))
                for total, gear in zip(turned, _GEARS, strict=True)
            ]
            for next_gear in _GEARS
        ]
        came.append([int(np.argmin(row)) for row in costs])
        turned = [min(row) for row in costs]
    # Only one heading is right at the end.
    choice = 0 if ends else int(np.argmin(turned)) if turned else 0
    choices = [choice]
    for row in reversed(came):
        choices.append(row[choices[-1]])
    headings = [
        (heading + _GEARS[choice]) % TURN
        for heading, choice in zip([*ahead, *ends], reversed(choices), strict=False)
    ]
    rows = [(*points[0], first)]
    for leg, heading in enumerate(headings):
        rows.append((*points[leg], heading))
        if leg < len(ahead):
            rows.append((*points[leg + 1], heading))
    return np.array(rows, np.int64)


# What is added to a leg's direction if the car drives it forwards, or backwards.
_GEARS = (0, TURN // 2)


def _turn(before: int, after: int) -> int:
    """Return the shorter turn between two headings, 1/65536 turn."""
    return (after - before + TURN // 2) % TURN - TURN // 2
