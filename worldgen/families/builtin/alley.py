"""Alleys: a passage for one robot with bays on its sides, and robots that come from both ends."""

from __future__ import annotations

from typing import Annotated

from worldgen.errors import InvalidParameter
from worldgen.families.parts.fleets import Robots, fleet_world
from worldgen.families.parts.layout import (
    CHOSEN,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Size,
    Width,
    spread_unevenly,
)
from worldgen.family import Bounds, family
from worldgen.random_streams import RandomStream
from worldgen.world import World

MOST_BAYS = 200
# Bays that are drawn if the user gives no number.
MOST_DRAWN = 3


@family("alley", version=2)
def alley(
    rng: RandomStream,
    *,
    size: Size = 30,
    robots: Robots = 2,
    bays: Annotated[int, Bounds(1, MOST_BAYS, chosen=CHOSEN)] = CHOSEN,
    width: Width = CHOSEN,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build a passage that is too narrow for two robots to pass, with bays in which one can wait.

    The robots come from both ends. One of them has to be in a bay when they meet.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        robots: Number of robots; they start at the two ends in turn, each with its target at the
            other end.
        bays: Bays along the passage, on either side; if omitted, drawn.
        width: Width of the passage, and width and depth of a bay, cells; if omitted, the narrowest
            that lets a robot through.
        cell_size: Side of a cell, m.
        robot_radius: Radius of a robot, m.
        robot_speed: Top speed of a robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or there is no room for the bays or robots.

    Source: passing places of a single-track road.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    width = arena.passage("width", width)

    # Make a hall at each end, as wide as two robots if there is room, and the passage between them.
    hall = max(arena.narrowest, min(2 * arena.narrowest, arena.inside // 4))
    length = arena.inside - 2 * hall
    room = (length - 1) // (width + 1)
    if room < 1 or arena.inside < 3 * width + 2 or bays > room:
        raise InvalidParameter(
            "no-room",
            "size={size} cells have no room for bays={bays} of width={width} along the passage",
            "use a larger size, or fewer or narrower bays",
            size=size,
            bays=1 if bays == CHOSEN else bays,
            width=width,
        )
    plan = rng.child("plan")
    bays = plan.between(1, min(room, MOST_DRAWN)) if bays == CHOSEN else bays
    walls = arena.solid()
    walls[1:-1, 1 : 1 + hall] = False
    walls[1:-1, -1 - hall : -1] = False
    y = plan.between(1 + width, size - 1 - 2 * width)
    walls[y : y + width, 1:-1] = False

    # Place bays with at least one cell of rock before, between and after them.
    gaps = spread_unevenly(plan.child("gaps"), length - bays * width - (bays + 1), bays + 1)
    x = 1 + hall
    for gap in gaps[:-1]:
        x += gap + 1
        side = y + width if plan.below(2) else y - width
        walls[side : side + width, x : x + width] = False
        x += width

    ends = ((1, 1, hall, size - 2), (size - 1 - hall, 1, size - 2, size - 2))
    boxes = [(ends[number % 2], ends[1 - number % 2]) for number in range(robots)]
    return fleet_world(arena, walls, rng, boxes, "alley")
