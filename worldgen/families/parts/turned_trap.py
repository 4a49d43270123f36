"""Obstacles of slanted walls: shapes as convex polygons, turned by any angle, placed with a way all round."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.families.parts.layout import Arena
from worldgen.families.parts.raster import (
    FINE,
    Polygon,
    bounds,
    box,
    extents,
    fill,
    to_frame,
    turned,
)
from worldgen.random_streams import RandomStream
from worldgen.support.grid_search import free_windows

__all__ = [
    "TrapShape",
    "TurnedLayout",
    "chevron",
    "comb",
    "draw_up_to",
    "nested",
    "pair",
    "place_turned",
    "room_for",
]


@dataclass(frozen=True)
class TrapShape:
    """An obstacle, first corner (0, 0), with its mouth to +x; lengths in cells.

    Args:
        pieces: Its walls.
        width: In x.
        height: In y.
        opening: Rows [low, high) of the mouth.
        backing: Rows [low, high) behind which no line from before the mouth leads straight.
        flank: Columns [low, high) above and below which no line leads straight to the other side.
        flank_rows: Rows [low, high) of the walls there.
        hollows: Convex polygons in which a robot is caught.
        flipped: Whether above is below, because it was mirrored.
    """

    pieces: tuple[Polygon, ...]
    width: int
    height: int
    opening: tuple[int, int]
    backing: tuple[int, int]
    flank: tuple[int, int]
    flank_rows: tuple[int, int]
    hollows: tuple[Polygon, ...]
    flipped: bool = False

    def extents(self, degrees: int) -> tuple[int, int]:
        """Columns and rows that its cells never exceed when it is turned.

        They grow with its lengths.
        """
        return extents([turned(piece, degrees) for piece in self.pieces])

    def mirrored(self) -> TrapShape:
        """The obstacle with y upside down."""
        top = FINE * self.height
        pieces, hollows = (
            tuple(tuple((x, top - y) for x, y in polygon[::-1]) for polygon in polygons)
            for polygons in (self.pieces, self.hollows)
        )
        opening, backing, flank_rows = (
            (self.height - high, self.height - low)
            for low, high in (self.opening, self.backing, self.flank_rows)
        )
        return TrapShape(
            pieces,
            self.width,
            self.height,
            opening,
            backing,
            self.flank,
            flank_rows,
            hollows,
            not self.flipped,
        )


def _u(x: int, y: int, depth: int, mouth: int, thickness: int) -> list[Polygon]:
    width = thickness + depth
    height = mouth + 2 * thickness
    back = box(x, y, x + thickness, y + height)
    arms = [box(x, at, x + width, at + thickness) for at in (y, y + thickness + mouth)]
    return [back, *arms]


def chevron(depth: int, mouth: int, thickness: int) -> TrapShape:
    """A V: two straight arms from a point to both sides of the mouth."""
    height = mouth + 2 * thickness
    apex = (FINE * thickness, FINE * height // 2)
    dx = FINE * depth
    dy = FINE * mouth // 2
    length = math.isqrt(dx * dx + dy * dy)
    # outwards: to -x, and up or down
    nx = FINE * thickness * dy // length
    ny = FINE * thickness * dx // length
    upper = (apex[0] + dx, apex[1] + dy)
    lower = (apex[0] + dx, apex[1] - dy)
    over = (apex[0] - nx, apex[1] + ny)
    under = (apex[0] - nx, apex[1] - ny)
    pieces = (
        (apex, upper, (upper[0] - nx, upper[1] + ny), over),
        (apex, under, (lower[0] - nx, lower[1] - ny), lower),
        (apex, over, (0, apex[1]), under),
    )
    opening = (thickness, thickness + mouth)
    width = thickness + depth
    flank = (thickness + depth // 4, width - 1)  # not past the tips
    return TrapShape(
        pieces, width, height, opening, opening, flank, opening, ((apex, lower, upper),)
    )


def comb(depth: int, mouth: int, thickness: int, teeth: int) -> TrapShape:
    """A back wall with teeth.

    The hollows between two of them are closed, the first and last open aside. Where there is one
    tooth, a robot is caught above it.
    """
    height = teeth * thickness + (teeth + 1) * mouth
    width = thickness + depth
    starts = [mouth + k * (thickness + mouth) for k in range(teeth)]
    pieces = [box(0, 0, thickness, height), *(box(0, y, width, y + thickness) for y in starts)]
    closed = [box(thickness, y + thickness, width, y + thickness + mouth) for y in starts[:-1]]
    end = box(thickness, height - mouth, width, height)
    rows = (0, height)
    return TrapShape(
        tuple(pieces), width, height, rows, rows, (0, width), rows, tuple(closed or [end])
    )


def nested(depth: int, mouth: int, thickness: int, levels: int) -> TrapShape:
    """U's in each other's hollows, all open to +x, ``mouth`` between one and the next."""
    step = thickness + mouth
    pieces: list[Polygon] = []
    for level in range(levels):
        around = levels - 1 - level  # the U's that lie outside of this one
        pieces += _u(
            around * step, around * step, depth + level * step, mouth + 2 * level * step, thickness
        )
    outside = (levels - 1) * step
    low = outside + thickness
    width = outside + thickness + depth
    height = mouth + 2 * thickness + 2 * outside
    rows = (low, low + mouth)
    hollow = box(low, low, width, low + mouth)
    return TrapShape(tuple(pieces), width, height, rows, rows, (0, width), (0, height), (hollow,))


def pair(depth: int, mouth: int, thickness: int) -> TrapShape:
    """A U, and behind it another, set off aside by half of one: the way round the first leads past the second."""
    width = thickness + depth
    height = mouth + 2 * thickness
    offset = height // 2
    front = width + mouth
    pieces = [*_u(front, 0, depth, mouth, thickness), *_u(0, offset, depth, mouth, thickness)]
    hollows = [
        box(front + thickness, thickness, front + width, thickness + mouth),
        box(thickness, offset + thickness, width, offset + thickness + mouth),
    ]
    opening = (thickness, thickness + mouth)
    backing = (offset + thickness, offset + thickness + mouth)
    flank = (0, width)
    flank_rows = (offset, offset + height)
    return TrapShape(
        tuple(pieces),
        front + width,
        height + offset,
        opening,
        backing,
        flank,
        flank_rows,
        tuple(hollows),
    )


def room_for(arena: Arena, figure: TrapShape, degrees: int) -> str | None:
    """Why a turned figure with a passage all round it finds no room, or ``None``."""
    for length in figure.extents(degrees):
        if length + 2 * arena.narrowest > arena.inside:
            return (
                f"{length} cells and a passage of {arena.narrowest} on both sides are more than "
                f"the {arena.inside} inside"
            )
    return None


def draw_up_to(rng: RandomStream, values: range, fits: Callable[[int], bool]) -> int:
    """One of the values up to the largest that fits; the first is known to."""
    low = values[0]
    high = values[-1]
    while low < high:  # what is larger takes more room, so halving finds the limit
        middle = (low + high + 1) // 2
        low, high = (middle, high) if fits(middle) else (low, middle - 1)
    return rng.between(values[0], low)


@dataclass(frozen=True)
class TurnedLayout:
    """Walls and, in half cells, start and target; the heading in quarter turns."""

    walls: npt.NDArray[np.bool_]
    start: tuple[int, int]
    target: tuple[int, int]
    quarter: int


def place_turned(
    rng: RandomStream, arena: Arena, figure: TrapShape, degrees: int, faces: str, *, inside: bool
) -> TurnedLayout:
    """The figure in the arena, and start and target on either side of it, or the start in its hollow.

    Raises:
        InvalidParameter: If the start is to be in a hollow that the robot does not fit into.
        GenerationFailed: If start or target finds no place; none was seen to.
    """
    cells = fill([turned(piece, degrees) for piece in figure.pieces])
    x0, y0, _, _ = bounds([turned(piece, degrees) for piece in figure.pieces])
    rows, columns = cells.shape
    corner = [
        1 + arena.narrowest + rng.below(arena.inside - n - 2 * arena.narrowest + 1)
        for n in (columns, rows)
    ]
    walls = arena.solid()
    walls[1:-1, 1:-1] = False
    walls[corner[1] : corner[1] + rows, corner[0] : corner[0] + columns] = cells
    side = arena.narrowest
    origin = (corner[0] - x0, corner[1] - y0)  # of the figure's frame, in cells
    free_rows, free_columns = np.nonzero(free_windows(walls, side, side))
    middles = np.stack([2 * free_columns + side, 2 * free_rows + side])  # half cells
    u, v = _seen(middles, origin, degrees)
    zones, wider = (_zones(figure, u, v, side, spare) for spare in (0, FINE))
    first, last = {
        "start": ("front", "back"),
        "target": ("back", "front"),
        "side": ("above", "below"),
    }[faces]
    spots = (
        []
        if not inside
        else [_spot_inside(rng, arena, walls, rng.choice(figure.hollows), origin, degrees)]
    )
    for zone in (first, last)[len(spots) :]:
        found = np.flatnonzero(zones[zone])
        if not len(found):  # between slanted borders of a narrow zone there may be no half cell
            found = np.flatnonzero(wider[zone])
        if not len(found):
            raise GenerationFailed(
                "no-room",
                "trap: no place for the robot on the side called {zone}",
                "give a larger size",
                zone=zone,
            )
        spot = found[rng.below(len(found))]
        spots.append((int(middles[0, spot]), int(middles[1, spot])))
    looks = {"start": 2, "target": 0, "side": 1 if figure.flipped else 3}[faces] + (
        degrees + 45
    ) // 90
    return TurnedLayout(walls, spots[0], spots[1], looks % 4)


def _seen(
    points: npt.NDArray[np.int64], origin: tuple[int, int], degrees: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Points in half cells, (2, n), as the figure's frame has them, in units."""
    return to_frame(
        (points[0] - 2 * origin[0]) * (FINE // 2),
        (points[1] - 2 * origin[1]) * (FINE // 2),
        degrees,
    )


def _spot_inside(
    rng: RandomStream,
    arena: Arena,
    walls: npt.NDArray[np.bool_],
    hollow: Polygon,
    origin: tuple[int, int],
    degrees: int,
) -> tuple[int, int]:
    """A place in a hollow, in half cells, at which the disc is clear of every wall; exact.

    Raises:
        InvalidParameter: If there is none.
    """
    x0, y0, x1, y1 = bounds([turned(hollow, degrees)])
    grid = np.meshgrid(
        np.arange(2 * (x0 + origin[0]), 2 * (x1 + origin[0]) + 1),
        np.arange(2 * (y0 + origin[1]), 2 * (y1 + origin[1]) + 1),
    )
    points = np.stack([axis.ravel() for axis in grid])
    points = points[:, _within(hollow, *_seen(points, origin, degrees))]
    reach = math.ceil(arena.radius)
    for dy in range(-reach - 1, reach + 1):
        for dx in range(-reach - 1, reach + 1):
            cells = [points[axis] // 2 + offset for axis, offset in enumerate((dx, dy))]
            apart = [
                np.maximum(2 * cell - at, at - 2 * cell - 2).clip(0)
                for cell, at in zip(cells, points, strict=True)
            ]
            near = apart[0] ** 2 + apart[1] ** 2 < math.ceil(4 * arena.radius**2)
            column, row = (cell.clip(0, arena.size - 1) for cell in cells)
            points = points[:, ~(walls[row, column] & near)]
    if not points.size:
        raise InvalidParameter(
            "no-room",
            "inside: the hollow has no room for the robot",
            "give a larger depth or mouth",
        )
    spot = rng.below(points.shape[1])
    return int(points[0, spot]), int(points[1, spot])


def _zones(
    figure: TrapShape, u: npt.NDArray[np.int64], v: npt.NDArray[np.int64], side: int, wider: int
) -> dict[str, npt.NDArray[np.bool_]]:
    """Which points, in the figure's frame, lie before its mouth, behind it, above and below."""
    apart = (
        FINE * (side - 1) // 2
    )  # from its hull: half the robot, less what rounding to half cells takes

    def between(values: npt.NDArray[np.int64], limits: tuple[int, int]) -> npt.NDArray[np.bool_]:
        return np.asarray(
            (FINE * limits[0] - wider <= values) & (values <= FINE * limits[1] + wider)
        )

    beside = between(u, figure.flank)
    sides = [
        beside & (v > FINE * figure.flank_rows[1] + apart),
        beside & (v < FINE * figure.flank_rows[0] - apart),
    ]
    above, below = sides[::-1] if figure.flipped else sides
    return {
        "front": between(v, figure.opening) & (u > FINE * figure.width + apart),
        "back": between(v, figure.backing) & (u < -apart),
        "above": above,
        "below": below,
    }


def _within(
    polygon: Polygon, u: npt.NDArray[np.int64], v: npt.NDArray[np.int64]
) -> npt.NDArray[np.bool_]:
    inside = np.ones(u.shape, dtype=np.bool_)
    for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        inside &= (bx - ax) * (v - ay) - (by - ay) * (u - ax) >= 0
    return inside
