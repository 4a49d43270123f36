"""Mazes of rooms and walls that fill the square."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen.families._layout import CHOSEN, STEPS, Arena, spread_evenly
from worldgen.families._spanning_tree import open_sides, spanning_tree
from worldgen.family import check_at_least, check_between, family
from worldgen.random_streams import RandomStream
from worldgen.world import World

__all__ = ["maze"]


@family("maze", version=1)
def maze(
    rng: RandomStream,
    *,
    size: int = 30,
    algorithm: Literal["wilson", "backtracker"] = "wilson",
    braid: float = 0.0,
    passage: int = CHOSEN,
    wall: int = 1,
    cell_size: float = 0.1,
    robot_radius: float = 0.07,
    robot_speed: float = 2.0,
) -> World:
    """A maze from one corner of the square to the opposite one.

    Dead ends and long ways round defeat a robot that only turns away from what it bumps into. Every room
    is reachable by construction; cells left over by the division into rooms widen some passages.

    Args:
        rng: The only source of chance; equal state, equal world.
        size: Cells a side, the solid border included; 10 to 2000.
        algorithm: wilson: every maze equally likely, many short dead ends; backtracker: long winding ways.
        braid: Share of the dead ends that get a second way out, 0 to 1; 1 leaves none.
        passage: Width of the passages, cells; -1: the narrowest that lets the robot through.
        wall: Thickness of the walls, cells.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or fewer than 2 x 2 rooms fit.

    Source: Wilson, "Generating random spanning trees more quickly than the cover time", STOC 1996; the
    backtracker is depth-first search with a random choice of neighbour, made without recursion.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    passage = arena.passage("passage", passage)
    check_at_least("wall", wall, 1, "cells")
    check_between("braid", braid, 0.0, 1.0)
    rooms = (arena.inside + wall) // (passage + wall)
    if rooms < 2:
        raise InvalidParameter(
            f"passage={passage} and wall={wall} leave no 2 x 2 rooms in size={size} cells; "
            f"give a size of at least {2 * passage + wall + 2}, or narrower passages and walls"
        )

    sides = open_sides(spanning_tree(rng.child("tree"), rooms, rooms, algorithm))
    _braid(rng.child("braid"), sides, braid)
    spare = arena.inside - rooms * passage - (rooms - 1) * wall
    widths = [passage + extra for extra in spread_evenly(rng, spare, rooms)]
    heights = [passage + extra for extra in spread_evenly(rng, spare, rooms)]
    start = (rng.below(2) * (rooms - 1), rng.below(2) * (rooms - 1))
    target = (rooms - 1 - start[0], rooms - 1 - start[1])
    quarter = rng.choice([int(way) for way in np.flatnonzero(sides[start[1], start[0]])])

    return arena.world(
        _walls(sides, widths, heights, wall),
        start=(_room_centre(widths, start[0], wall), _room_centre(heights, start[1], wall)),
        target=(_room_centre(widths, target[0], wall), _room_centre(heights, target[1], wall)),
        quarter=quarter,
    )


def _walls(sides: npt.NDArray[np.bool_], widths: list[int], heights: list[int], wall: int) -> npt.NDArray[np.bool_]:
    """Rooms and their open sides as cells, the border one cell thick."""
    plan = np.ones((2 * len(heights) + 1, 2 * len(widths) + 1), dtype=np.bool_)
    plan[1::2, 1::2] = False
    plan[1::2, 2:-1:2] = ~sides[:, :-1, 0]
    plan[2:-1:2, 1::2] = ~sides[:-1, :, 1]
    return plan.repeat(_strips(heights, wall), axis=0).repeat(_strips(widths, wall), axis=1)


def _strips(widths: list[int], wall: int) -> list[int]:
    strips = [wall] * (2 * len(widths) + 1)
    strips[1::2] = widths
    strips[0] = strips[-1] = 1
    return strips


def _room_centre(widths: list[int], room: int, wall: int) -> int:
    """The middle of a room, in half cells."""
    return 2 * (1 + sum(widths[:room]) + room * wall) + widths[room]


def _braid(rng: RandomStream, sides: npt.NDArray[np.bool_], share: float) -> None:
    """Opens one more side of dead ends, in place, until ``share`` of them is gone.

    One opening can end two dead ends, so one more than asked may go.
    """
    columns = sides.shape[1]
    within = _sides_within(sides.shape[0], columns)
    ends = np.flatnonzero(sides.sum(axis=2) == 1)
    remove = round(share * len(ends))
    for end in ends[np.argsort(rng.bits(len(ends)), kind="stable")].tolist():
        if remove <= 0:
            return
        row, column = divmod(end, columns)
        if sides[row, column].sum() > 1:  # a neighbour was opened to it
            continue
        way = rng.choice(np.flatnonzero(within[row, column] & ~sides[row, column]).tolist())
        dx, dy = STEPS[way]
        beyond = sides[row + dy, column + dx]
        remove -= 2 if beyond.sum() == 1 else 1
        sides[row, column, way] = beyond[(way + 2) % 4] = True


def _sides_within(rows: int, columns: int) -> npt.NDArray[np.bool_]:
    """(rows, columns, 4) bool: which sides of a room have another room behind them."""
    within = np.ones((rows, columns, 4), dtype=np.bool_)
    within[:, -1, 0] = within[-1, :, 1] = within[:, 0, 2] = within[0, :, 3] = False
    return within
