"""Draw office plans: rooms along corridors or next to each other, joined by doors."""

from __future__ import annotations

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.doors import hang_doors, shut_doors
from worldgen.families.parts.floor_plan import Sizes, Style, divide, fit_sizes, joined
from worldgen.families.parts.layout import (
    CHOSEN,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Share,
    Size,
    Wall,
    Width,
    without_effect,
)
from worldgen.families.parts.open_ground import far_poses
from worldgen.family import family
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import free_windows
from worldgen.world import World


@family("rooms", version=1)
def rooms(
    rng: RandomStream,
    *,
    size: Size = 30,
    plan: Style = "wings",
    room: Width = CHOSEN,
    corridor: Width = CHOSEN,
    door: Width = CHOSEN,
    wall: Wall = 1,
    shared: Share = 0.15,
    closed: Share = 0.0,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build one floor of an office: rooms, corridors and doors, with start and target far apart.

    A robot that heads straight for the target ends up behind the wall of the room next door, and
    must find a door, possibly by moving away from the target. Every room can be reached by
    construction, unless doors are shut.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        plan: wings: corridors branch off corridors; spine: one corridor across; suite: no corridor,
            rooms lead to rooms.
        room: Minimum inner side of a room, cells; if omitted, drawn.
        corridor: Width of the corridors, cells; if omitted, the narrowest that fits both the robot
            and a door.
        door: Width of the doors, cells; if omitted, the narrowest that lets the robot through.
        wall: Thickness of the walls, cells.
        shared: Fraction of the walls that get a door without needing one: between two rooms, or as
            a second entrance to the corridor.
        closed: Fraction of the doors that are shut; never those on one path to the target.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or two rooms and their corridor do not fit.

    Source: the square is cut in two again and again, as in binary space partitioning; doors are
        Kruskal's
    spanning tree in random order, corridors before rooms.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    door = arena.passage("door", door)
    corridor = _corridor_width(arena, plan, corridor, door)
    sizes = fit_sizes(rng.child("sizes"), arena, plan, Sizes(room, corridor, door, wall))

    floor = divide(rng.child("floor"), arena, plan, sizes)
    joints = joined(floor, sizes)
    doors = hang_doors(rng.child("doors"), floor, joints, sizes, shared)
    # These windows are entirely inside a room, so that start and target are never in a doorway.
    in_rooms = free_windows(floor.owner < floor.corridors, arena.narrowest, arena.narrowest)
    begin = int(np.flatnonzero(in_rooms)[0])
    poses = far_poses(
        rng.child("poses"),
        doors.walls,
        arena.narrowest,
        begin,
        start_in=in_rooms,
        target_in=in_rooms,
    )
    ends = tuple(int(floor.owner[y // 2, x // 2]) for x, y in (poses.start, poses.target))
    shut_doors(rng.child("shut"), floor, joints, doors, closed, (ends[0], ends[1]))

    return arena.world(doors.walls, poses.start, poses.target, poses.quarter)


def _corridor_width(arena: Arena, plan: Style, corridor: int, door: int) -> int:
    if plan == "suite":
        return without_effect("corridor", corridor, "plan=suite")
    if corridor == CHOSEN:
        return max(arena.narrowest, door)
    if corridor < door:
        raise InvalidParameter(
            "below-minimum",
            "corridor={corridor} is narrower than the doors, {door} cells",
            "use at least {door}, or omit it",
            corridor=corridor,
            door=door,
        )
    return corridor
