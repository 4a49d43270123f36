"""Obstacles with slanted walls: convex polygons, turned by any angle, with a passage around."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

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
from worldgen.reach.still.grid_search import free_windows
from worldgen.support.arrays import Bools, Ints


@dataclass(frozen=True)
class TrapShape:
    """Describe an obstacle whose mouth opens to +x and whose first corner is (0, 0).

    Lengths are in cells. Ranges are half open.

    Args:
        pieces: The walls.
        width: Extent in x.
        height: Extent in y.
        opening: Rows of the mouth.
        backing: Rows behind the obstacle that no straight line from before the mouth reaches.
        flank: Columns in which no straight line leads from above the obstacle to below it.
        flank_rows: Rows of the walls in these columns.
        hollows: Convex polygons that trap a robot.
        flipped: True if the shape was mirrored, so that above and below are swapped.
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
        """Return an upper bound on the columns and rows of the turned obstacle.

        They grow with each of its lengths, so a search for the largest obstacle can use halving.
        """
        return extents([turned(piece, degrees) for piece in self.pieces])

    def mirrored(self) -> TrapShape:
        """Return the obstacle flipped in y."""
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
    """Return a V: two straight arms from a point to both sides of the mouth."""
    height = mouth + 2 * thickness
    apex = (FINE * thickness, FINE * height // 2)
    dx = FINE * depth
    dy = FINE * mouth // 2
    length = math.isqrt(dx * dx + dy * dy)
    # Offset from an arm's inner side to its outer side: towards -x, and up or down.
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
    # Stop short of the tips, past which a straight line could lead to the other side.
    flank = (thickness + depth // 4, width - 1)
    return TrapShape(
        pieces, width, height, opening, opening, flank, opening, ((apex, lower, upper),)
    )


def comb(depth: int, mouth: int, thickness: int, teeth: int) -> TrapShape:
    """Return a back wall with teeth.

    The hollows between two teeth trap a robot. The first and the last hollow are open at the side;
    with a single tooth, the one above it counts as the trap.
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
    """Return U shapes inside each other, all open to +x and ``mouth`` cells apart."""
    step = thickness + mouth
    pieces: list[Polygon] = []
    for level in range(levels):
        # Number of U shapes outside this one.
        around = levels - 1 - level
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
    """Return a U with another one behind it, offset sideways by half its height.

    The path around the first U leads past the second.
    """
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
    """Return why a turned figure with a passage around it does not fit, or ``None`` if it does."""
    for length in figure.extents(degrees):
        if length + 2 * arena.narrowest > arena.inside:
            return (
                f"{length} cells and a passage of {arena.narrowest} on both sides are more than "
                f"the {arena.inside} cells inside"
            )
    return None


def draw_up_to(rng: RandomStream, values: range, fits: Callable[[int], bool]) -> int:
    """Draw one of the values up to the largest that fits; the first value must fit."""
    low = values[0]
    high = values[-1]
    # A larger value takes more room, so the limit can be found by halving.
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if fits(middle) else (low, middle - 1)
    return rng.between(values[0], low)


@dataclass(frozen=True)
class TurnedLayout:
    """Hold walls, start and target in half cells, and the heading in quarter turns."""

    walls: Bools
    start: tuple[int, int]
    target: tuple[int, int]
    quarter: int


def place_turned(
    rng: RandomStream, arena: Arena, figure: TrapShape, degrees: int, faces: str, *, inside: bool
) -> TurnedLayout:
    """Place the figure in the arena, with start and target on opposite sides of it.

    Args:
        rng: The only source of randomness.
        arena: The square and the robot.
        figure: The obstacle.
        degrees: Angle to turn it by, counter-clockwise.
        faces: The end that the mouth faces: ``start``, ``target``, or ``side`` for neither.
        inside: If True, the start is in one of the obstacle's hollows instead.

    Raises:
        InvalidParameter: If the robot does not fit into the hollow.
        GenerationFailed: If there is no place for start or target. This has never been observed.
    """
    # Rasterise the figure, and place it so that the robot can pass on all sides.
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

    # Convert all places of the robot to the figure's frame, and sort them into zones around it.
    side = arena.narrowest
    origin = (corner[0] - x0, corner[1] - y0)  # origin of the figure's frame, in cells
    free_rows, free_columns = np.nonzero(free_windows(walls, side, side))
    middles = np.stack([2 * free_columns + side, 2 * free_rows + side])  # half cells
    u, v = _seen(middles, origin, degrees)
    zones, wider = (_zones(figure, u, v, side, spare) for spare in (0, FINE))
    first, last = {
        "start": ("front", "back"),
        "target": ("back", "front"),
        "side": ("above", "below"),
    }[faces]

    # Draw a place for start and target, the start inside a hollow if requested.
    spots = (
        []
        if not inside
        else [_spot_inside(rng, arena, walls, rng.choice(figure.hollows), origin, degrees)]
    )
    for zone in (first, last)[len(spots) :]:
        found = np.flatnonzero(zones[zone])
        # A narrow zone with slanted borders may contain no half cell; then widen it a little.
        if not len(found):
            found = np.flatnonzero(wider[zone])
        if not len(found):
            raise GenerationFailed(
                "no-room",
                "trap: no place for the robot on the side called {zone}",
                "use a larger size",
                zone=zone,
            )
        spot = found[rng.below(len(found))]
        spots.append((int(middles[0, spot]), int(middles[1, spot])))

    # Face the obstacle, to the nearest quarter turn.
    looks = {"start": 2, "target": 0, "side": 1 if figure.flipped else 3}[faces] + (
        degrees + 45
    ) // 90
    return TurnedLayout(walls, spots[0], spots[1], looks % 4)


def _seen(points: Ints, origin: tuple[int, int], degrees: int) -> tuple[Ints, Ints]:
    """Convert (2, n) points in half cells to the figure's frame, in units."""
    return to_frame(
        (points[0] - 2 * origin[0]) * (FINE // 2),
        (points[1] - 2 * origin[1]) * (FINE // 2),
        degrees,
    )


def _spot_inside(
    rng: RandomStream,
    arena: Arena,
    walls: Bools,
    hollow: Polygon,
    origin: tuple[int, int],
    degrees: int,
) -> tuple[int, int]:
    """Draw a place in a hollow, in half cells, at which the robot's disc is clear of all walls.

    The test is exact.

    Raises:
        InvalidParameter: If there is no such place.
    """
    # List the half cells in the hollow.
    x0, y0, x1, y1 = bounds([turned(hollow, degrees)])
    grid = np.meshgrid(
        np.arange(2 * (x0 + origin[0]), 2 * (x1 + origin[0]) + 1),
        np.arange(2 * (y0 + origin[1]), 2 * (y1 + origin[1]) + 1),
    )
    points = np.stack([axis.ravel() for axis in grid])
    points = points[:, _within(hollow, *_seen(points, origin, degrees))]

    # For each cell that the disc could touch, drop the points where it is solid and too near.
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
            "no-room", "inside: the hollow has no room for the robot", "use a larger depth or mouth"
        )
    spot = rng.below(points.shape[1])
    return int(points[0, spot]), int(points[1, spot])


def _zones(figure: TrapShape, u: Ints, v: Ints, side: int, wider: int) -> dict[str, Bools]:
    """Return which points are before the figure's mouth, behind it, above it and below it.

    Args:
        figure: The obstacle.
        u: (n,) first coordinates in the figure's frame, units.
        v: (n,) second coordinates, units.
        side: Cells per side of the robot's window.
        wider: Units by which to widen the zones.
    """
    # Distance to the figure's hull: half the robot, less what rounding to half cells takes away.
    apart = FINE * (side - 1) // 2

    def between(values: Ints, limits: tuple[int, int]) -> Bools:
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


def _within(polygon: Polygon, u: Ints, v: Ints) -> Bools:
    inside = np.ones(u.shape, dtype=np.bool_)
    for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        inside &= (bx - ax) * (v - ay) - (by - ay) * (u - ax) >= 0
    return inside
