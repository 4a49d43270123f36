"""Choose a start and a target on a map that has none: far apart, clear, and connected."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.interop.clear_points import ClearPoints, Region
from worldgen.interop.largest_disc import Point, largest_disc
from worldgen.lattice import (
    UNIT,
    exact,
    heading_from_lattice,
    heading_to_lattice,
    in_cells,
    lattice_to_metres,
    metres_to_lattice,
)
from worldgen.random_streams import RandomStream
from worldgen.reach.still.walls import Walls, point_box_sq
from worldgen.support.arrays import Bools

# Share of the clear places below which the largest region deserves a warning.
_SCATTERED = 0.5


class Placement(NamedTuple):
    """The chosen start and target, m, with remarks.

    Args:
        start: x and y.
        target: x and y.
        warnings: Sentences about likely mistakes.
        why: How the places that were not given were chosen; empty if both were given.
    """

    start: Point
    target: Point
    warnings: tuple[str, ...] = ()
    why: str = ""


def place(
    walls: Bools,
    cell_size: float,
    radius: float,
    seed: int,
    *,
    start: Point | None = None,
    target: Point | None = None,
    origin: Point | None = None,
    near: Point | None = None,
    clearance: float = 0.0,
    body: str = "",
) -> Placement:
    """Choose a start and a target with the longest path that two sweeps find; keep given ones.

    If neither is given, both are in the largest region that the disc can drive through. On a
    picture that shows its surroundings too, such as a race track's, they are rather in the region
    with the map's origin, or, if the largest reaches the picture's border, in the largest one that
    does not. Otherwise the missing one is as far as possible from the given one, in its region. A chosen place has room
    to turn if the map has such places far enough away: a disc of twice the radius is clear there,
    or one of 1.5 or 1.25 radii.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
        radius: Radius of the robot's disc, m.
        seed: Selects where in the region the sweeps begin.
        start: x and y, m; moved to the nearest point of the pose lattice.
        target: x and y, m; need not be clear itself.
        origin: For a picture, x and y, m, of the point (0, 0) of the map's own coordinates.
        near: x and y, m, to which the start is placed as near as possible, or the target if the
            start is given.
        clearance: Least distance, m, of a chosen place to the nearest wall.
        body: Where the disc is, for messages, if it stands for a footprint: ``in the body of
            1 x 0.5 m``.

    Raises:
        InvalidParameter: If ``near`` has nothing to place.
        InvalidWorld: If a given point is outside, the start is not clear (the message names the
            wall, its distance, and the nearest clear place), or there is no room for the disc (it
            names the largest that has room).
    """
    # Check what is given.
    for name, point in (("start", start), ("target", target), ("near", near)):
        if point is not None:
            _check_inside(name, point, walls, cell_size)
    if start is not None:
        start = _on_lattice(start, cell_size)
        _check_start(walls, cell_size, radius, start, body)
    warnings = [
        f"the {name} as given is closer to a wall than the clearance of {clearance:g} m: "
        f"{_clearance(walls, cell_size, point):.3g} m"
        for name, point in (("start", start), ("target", target))
        if point is not None and _clearance(walls, cell_size, point) < clearance
    ]
    if start is not None and target is not None:
        if near is not None:
            raise InvalidParameter(
                "conflict",
                "start and target are both given, so near has nothing to place",
                "omit one of the three",
            )
        return Placement(start, target, tuple(warnings))
    places = ClearPoints(walls, cell_size, radius, clearance, body)
    # Place one end near a point, or the only missing one as far as possible from the given one.
    given = start if start is not None else target
    source = None if given is None else places.near(given)
    if near is not None:
        node = places.nearest_reached(near, source)
        found = places.metres(node)
        missing = "start" if start is None else "target"
        why = (
            f"{missing} at the nearest place with enough room to the one asked for, "
            f"{math.dist(found, near):.3g} m away"
        )
        if given is None:
            target = places.metres(places.farthest(node))
            why += "; target at the farthest place from it by path"
        start, target = (found, target) if start is None else (start, found)
    elif source is not None:
        node = places.farthest(source)
        found = places.metres(node)
        end, other = ("target", "start") if start is not None else ("start", "target")
        why = f"{end} at the farthest place from the {other} by path"
        start, target = (start, found) if start is not None else (found, target)
    else:
        start, target, region = _farthest_apart(places, seed, origin)
        warnings += _doubts(region, radius, places, start == target)
        why = (
            f"start and target at the ends of a longest path in {region.name} "
            f"({100 * region.share:.0f} % of the free space)"
        )
    assert start is not None and target is not None
    walls_at = [_clearance(walls, cell_size, point) for point in (start, target)]
    why += f"; {walls_at[0]:.3g} and {walls_at[1]:.3g} m from the nearest walls"
    return Placement(start, target, tuple(warnings), why)


def _farthest_apart(
    places: ClearPoints, seed: int, origin: Point | None
) -> tuple[Point, Point, Region]:
    """Return both ends of a long path in one region, found by two sweeps."""
    region = places.largest_region() if origin is None else places.region_of_picture(origin)
    first = places.farthest(places.any_of(region, RandomStream(seed).child("import")))
    return places.metres(first), places.metres(places.farthest(first)), region


def _doubts(region: Region, radius: float, places: ClearPoints, coincide: bool) -> list[str]:
    """Return warnings about the region in which both ends were placed."""
    warnings = []
    if coincide:
        warnings.append("the largest region is a single place; start and target coincide")
    if region.share < _SCATTERED:
        warnings.append(
            f"for a disc of radius {radius:g} m{places.body} there are {region.regions} separate "
            f"regions; start and target are in {region.name}, which has {100 * region.share:.0f} % of the "
            f"free space; {places.smaller} may join them"
        )
    if region.warning:
        warnings.append(region.warning)
    return warnings


def _clearance(walls: Bools, cell_size: float, point: Point) -> float:
    """Return the distance, m, from a point to the nearest wall."""
    x, y = (metres_to_lattice(value, cell_size) for value in point)
    square = _nearest_wall(Walls(walls, Fraction(0)), (x, y))[0]
    return math.sqrt(square) / UNIT * cell_size


def _check_inside(name: str, point: Point, walls: Bools, cell_size: float) -> None:
    height, width = (side * cell_size for side in walls.shape)
    if not (0.0 <= point[0] <= width and 0.0 <= point[1] <= height):
        raise InvalidWorld(
            "outside-grid",
            "{name} ({x:g}, {y:g}) m is outside the map of {width:g} x {height:g} m",
            "use metres from its lower-left corner, x right, y up; --frame map uses the file's own "
            "coordinates",
            at_terminal=True,
            name=name,
            x=point[0],
            y=point[1],
            width=width,
            height=height,
        )


def _on_lattice(point: Point, cell_size: float) -> Point:
    x, y = (lattice_to_metres(metres_to_lattice(value, cell_size), cell_size) for value in point)
    return x, y


def is_clear(walls: Bools, cell_size: float, radius: float, point: Point) -> bool:
    """Return True if a disc of ``radius`` m is clear at the lattice point nearest to a point."""
    solid = Walls(walls, in_cells(radius, cell_size))
    x, y = (metres_to_lattice(value, cell_size) for value in point)
    return _is_clear_of(solid, _nearest_wall(solid, (x, y))[0])


def _is_clear_of(solid: Walls, distance_sq: Fraction) -> bool:
    return distance_sq >= max(Fraction(1), solid.radius_sq)


def _check_start(walls: Bools, cell_size: float, radius: float, start: Point, body: str) -> None:
    """Reject a start at which the disc overlaps a wall."""
    solid = Walls(walls, in_cells(radius, cell_size))
    x, y = (metres_to_lattice(value, cell_size) for value in start)
    distance_sq, cell = _nearest_wall(solid, (x, y))
    if _is_clear_of(solid, distance_sq):
        return
    height, width = walls.shape
    inside = 0 <= cell[0] < width and 0 <= cell[1] < height
    distance = math.sqrt(distance_sq) / UNIT * cell_size
    clear = ClearPoints(walls, cell_size, radius).nearest_to(start)
    fit = largest_disc(walls, cell_size) if clear is None else None
    nowhere = "it does not fit anywhere in the map" + (
        "" if fit is None else "; a radius of up to {fits:g} m does"
    )
    raise InvalidWorld(
        "not-clear",
        "start ({x:g}, {y:g}) m is "
        + ("in " if distance == 0 else "{distance:.3g} m from ")
        + ("the solid cell {cell}" if inside else "the map's edge")
        + ("; the disc {body} has a radius of" if body else "; the robot's radius is")
        + " {radius:g} m",
        nowhere if clear is None else "the nearest clear place is {clear[0]!r},{clear[1]!r}",
        x=start[0],
        y=start[1],
        distance=distance,
        cell=cell,
        radius=radius,
        clear=clear,
        **({"body": body} if body else {}),
        **({} if fit is None else {"fits": fit.radius}),
    )


def _nearest_wall(solid: Walls, point: tuple[int, int]) -> tuple[Fraction, tuple[int, int]]:
    """Return the squared distance in lattice units to the nearest solid cell, and the cell."""
    reach = UNIT
    # The outside is solid, so this loop ends.
    while True:
        near = [
            (Fraction(point_box_sq(point, cell)), cell) for cell in solid.near(point, point, reach)
        ]
        if near and min(near)[0] <= reach * reach:
            return min(near)
        reach *= 2


def heading_towards(start: Point, target: Point) -> float:
    """Return the heading from start to target, on the heading lattice; 0 if they coincide."""
    angle = math.atan2(
        float(exact(target[1]) - exact(start[1])), float(exact(target[0]) - exact(start[0]))
    )
    return heading_from_lattice(heading_to_lattice(angle))
