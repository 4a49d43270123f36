"""Doorways: two rooms, one narrow door, and robots that need to pass it from both sides."""

from __future__ import annotations

from worldgen.families.parts.fleets import Robots, fleet_world
from worldgen.families.parts.layout import (
    CHOSEN,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Size,
    Wall,
    Width,
)
from worldgen.family import check_between, family
from worldgen.random_streams import RandomStream
from worldgen.world import World


@family("doorway", version=2)
def doorway(
    rng: RandomStream,
    *,
    size: Size = 30,
    robots: Robots = 2,
    door: Width = CHOSEN,
    wall: Wall = 1,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build two rooms joined by a door that robots need to pass from both sides.

    Robots that meet in the door block each other, unless one of them makes way. Each room is wide
    enough for that.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        robots: Number of robots; they start in the two rooms in turn, each with its target in the
            other room.
        door: Width of the door, cells; if omitted, the narrowest that lets a robot through.
        wall: Thickness of the wall between the rooms, cells.
        cell_size: Side of a cell, m.
        robot_radius: Radius of a robot, m.
        robot_speed: Top speed of a robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or there is no room for the rooms or robots.

    Source: the standard bottleneck of crowd simulation; Helbing et al., "Simulating dynamical
        features of escape panic", Nature 2000.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    door = arena.passage("door", door)
    check_between("door", door, 1, arena.inside, "cells")
    check_between("wall", wall, 1, max(1, arena.inside - 2 * arena.narrowest), "cells")

    # The wall is somewhere in the middle half, and the door anywhere along it.
    plan = rng.child("plan")
    spare = arena.inside - wall
    least = max(arena.narrowest, spare // 4)
    left = plan.between(min(least, spare // 2), max(spare - least, spare // 2))
    low = 1 + plan.between(0, arena.inside - door)
    walls = arena.solid()
    walls[1:-1, 1:-1] = False
    walls[1:-1, 1 + left : 1 + left + wall] = True
    walls[low : low + door, 1 + left : 1 + left + wall] = False

    rooms = ((1, 1, left, size - 2), (1 + left + wall, 1, size - 2, size - 2))
    boxes = [(rooms[number % 2], rooms[1 - number % 2]) for number in range(robots)]
    return fleet_world(arena, walls, rng, boxes, "doorway")
