"""Open walls of a grown maze: second exits of dead ends, and rooms."""

from __future__ import annotations

import math

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import STEPS
from worldgen.families.parts.mazes.board import CORNER, EAST, NORTH, ROCK, Links, open_sides
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools

# Chambers per side of a plot: a room of 2 x 2, and one more that separates it from the next room.
LEAST_PLOT = 3


def braid_ends(rng: RandomStream, links: Links, share: float) -> None:
    """Open one more side of dead ends, in place, until only ``1 - share`` of them remain.

    One opening can remove two dead ends, so the result may exceed the share by one.
    """
    if share == 0.0:
        return
    columns = links.shape[1]
    sides = open_sides(links)
    within = _sides_within((links & ROCK) == 0)
    ends = np.flatnonzero(sides.sum(axis=2) == 1)
    remove = round(share * len(ends))

    # Visit the dead ends in random order until enough of them are open.
    for end in ends[np.argsort(rng.bits(len(ends)), kind="stable")].tolist():
        if remove <= 0:
            return
        row, column = divmod(end, columns)
        # An earlier opening may have reached this dead end from its neighbour.
        if sides[row, column].sum() > 1:
            continue
        way = rng.choice(np.flatnonzero(within[row, column] & ~sides[row, column]).tolist())
        dx, dy = STEPS[way]
        beyond = sides[row + dy, column + dx]
        remove -= 2 if beyond.sum() == 1 else 1
        sides[row, column, way] = beyond[(way + 2) % 4] = True
        links[min(row, row + dy), min(column, column + dx)] |= NORTH if dy else EAST


def _sides_within(mask: Bools) -> Bools:
    """Return which sides of each chamber have a neighbour: (rows, columns, 4) bool."""
    links = np.zeros(mask.shape, dtype=np.int8)
    links[:, :-1] = (mask[:, :-1] & mask[:, 1:]) * EAST
    links[:-1] |= (mask[:-1] & mask[1:]) * np.int8(NORTH)
    return open_sides(links)


def carve_rooms(rng: RandomStream, links: Links, mask: Bools, count: int) -> None:
    """Remove the walls inside rectangles of chambers, in place; no two rectangles touch.

    The chambers are divided into square plots, as large as possible if ``count`` of them must be
    inside the maze. That many plots are drawn, and each gets one rectangle with sides of at least
    two chambers.

    Raises:
        InvalidParameter: If that many rooms do not fit.
    """
    if count == 0:
        return
    # Larger plots than this would be too few even in a full square. Shrink them until enough fit.
    side = min(mask.shape) // (math.isqrt(count - 1) + 1)
    plots = _plots(mask, side) if side >= LEAST_PLOT else []
    while side > LEAST_PLOT and len(plots) < count:
        side -= 1
        plots = _plots(mask, side)
    if len(plots) < count:
        most = len(_plots(mask, LEAST_PLOT))
        raise InvalidParameter(
            "no-room",
            "rooms={rooms} do not fit in this maze",
            "use at most {most}, or a larger size",
            rooms=count,
            most=most,
        )

    # Draw the plots, and a rectangle in each.
    rng.shuffle(plots)
    for row, column in plots[:count]:
        width = rng.between(2, side - 1)
        height = rng.between(2, side - 1)
        x = column + rng.below(side - width)
        y = row + rng.below(side - height)
        links[y : y + height, x : x + width - 1] |= EAST
        links[y : y + height - 1, x : x + width] |= NORTH
        links[y : y + height - 1, x : x + width - 1] |= CORNER


def _plots(mask: Bools, side: int) -> list[tuple[int, int]]:
    """Return the row and column of the lower left chamber of each plot inside the maze."""
    rows, columns = (length // side for length in mask.shape)
    whole = (
        mask[: rows * side, : columns * side].reshape(rows, side, columns, side).all(axis=(1, 3))
    )
    return [(row * side, column * side) for row, column in np.argwhere(whole).tolist()]
