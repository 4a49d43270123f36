"""What is opened in a grown maze: second ways out of dead ends, and open rooms."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import STEPS
from worldgen.families.parts.mazes.board import CORNER, EAST, NORTH, ROCK, Links, Mask, open_sides
from worldgen.random_streams import RandomStream

__all__ = ["braid_ends", "carve_rooms"]

LEAST_PLOT = 3  # chambers a side: a room of 2 x 2, and one beside it that parts it from the next


def braid_ends(rng: RandomStream, links: Links, share: float) -> None:
    """Opens one more side of dead ends, in place, until ``share`` of them is gone.

    One opening can end two dead ends, so one more than asked may go.
    """
    if share == 0.0:
        return
    columns = links.shape[1]
    sides = open_sides(links)
    within = _sides_within((links & ROCK) == 0)
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
        links[min(row, row + dy), min(column, column + dx)] |= NORTH if dy else EAST


def _sides_within(mask: Mask) -> npt.NDArray[np.bool_]:
    """(rows, columns, 4): which sides of a chamber have another behind them."""
    links = np.zeros(mask.shape, dtype=np.int8)
    links[:, :-1] = (mask[:, :-1] & mask[:, 1:]) * EAST
    links[:-1] |= (mask[:-1] & mask[1:]) * np.int8(NORTH)
    return open_sides(links)


def carve_rooms(rng: RandomStream, links: Links, mask: Mask, count: int) -> None:
    """Takes the walls out of rectangles of chambers, in place; no two touch.

    The chambers are cut into square plots, as large as lets ``count`` of them lie in the maze; as
    many plots are drawn, and in each a rectangle of two chambers a side or more.

    Raises:
        InvalidParameter: If so many do not fit.
    """
    if count == 0:
        return
    side = min(mask.shape) // (
        math.isqrt(count - 1) + 1
    )  # with larger ones there are fewer even in a full square
    plots = _plots(mask, side) if side >= LEAST_PLOT else []
    while side > LEAST_PLOT and len(plots) < count:
        side -= 1
        plots = _plots(mask, side)
    if len(plots) < count:
        most = len(_plots(mask, LEAST_PLOT))
        raise InvalidParameter(
            "no-room",
            "rooms={rooms} do not fit in this maze",
            "give at most {most}, or a larger size",
            rooms=count,
            most=most,
        )
    rng.shuffle(plots)
    for row, column in plots[:count]:
        width = rng.between(2, side - 1)
        height = rng.between(2, side - 1)
        x = column + rng.below(side - width)
        y = row + rng.below(side - height)
        links[y : y + height, x : x + width - 1] |= EAST
        links[y : y + height - 1, x : x + width] |= NORTH
        links[y : y + height - 1, x : x + width - 1] |= CORNER


def _plots(mask: Mask, side: int) -> list[tuple[int, int]]:
    """Row and column of the lower left chamber of each plot that lies in the maze."""
    rows, columns = (length // side for length in mask.shape)
    whole = (
        mask[: rows * side, : columns * side].reshape(rows, side, columns, side).all(axis=(1, 3))
    )
    return [(row * side, column * side) for row, column in np.argwhere(whole).tolist()]
