"""Compose worlds from pieces: rectangles of cells that are mirrored, rotated, cut and placed.

Contents:
    Piece: cells with a start, a target and changes, and the operations on them.
    of_family, of_world, of_cells: create a piece.

``docs/howto/compose.md`` has examples, and shows how to make a family of a composition.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.domain import MAX_SIDE
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.family import FAMILIES, Family, check_choice
from worldgen.generation import generate
from worldgen.interop.place import place
from worldgen.lattice import TURN, exact, heading_from_lattice, heading_to_lattice, in_cells
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.robot_overrides import describe_body
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.support.frozen import HoldsFrozen, frozen
from worldgen.timeline import Timeline
from worldgen.world import DEFAULT_CELL_SIZE, Pose, Robot, Target, Value, Witness, World

__all__ = ["Piece", "of_cells", "of_family", "of_world"]

# Limit per piece, 4000 x 4000 cells.
_MOST_CELLS = 16_000_000
_HALF = Fraction(1, 2)
_USUAL_ROBOT = Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 1.0))

_Corner: TypeAlias = tuple[int, int]


@dataclass(frozen=True)
class _Mark:
    """A place of a piece, in exact fractions of a cell from its lower left corner.

    Args:
        x: Cells from the piece's left side.
        y: Cells from its lower side.
        heading: In 1/65536 turns, counter-clockwise from +x; ``None`` if any will do.
        radius: Radius of the target's disc, cells.
    """

    x: Fraction
    y: Fraction
    heading: int | None = None
    radius: Fraction = _HALF


@dataclass(frozen=True, eq=False)
class Piece(HoldsFrozen):
    """A rectangle of cells with a start, a target and changes.

    A piece is immutable: every operation returns a new one. Coordinates are in cells, x to the
    right and y up, from the piece's lower left corner.

    Args:
        solid: (height, width) bool, True is solid; row 0 is the lowest y.
        start: Where the robot starts, if that is inside.
        target: Where it is to go, if that is inside.
        timeline: Changes of the piece's cells.
        cell_size: Side of a cell, m; ``None`` if the piece fits any size.
        robot: The robot that the piece was made for; its places are those of ``start`` and
            ``target``, and it has no waypoints.

    Raises:
        InvalidParameter: If there are no cells or too many, or an event is outside.
    """

    solid: Bools
    start: _Mark | None = None
    target: _Mark | None = None
    timeline: Timeline = field(default_factory=Timeline)
    cell_size: float | None = None
    robot: Robot | None = None

    def __post_init__(self) -> None:
        solid = _solid_cells(self.solid)
        _check_size(solid.shape)
        object.__setattr__(self, "solid", frozen(solid, np.bool_))
        if not self.timeline.is_within(self.width, self.height):
            raise InvalidParameter(
                "outside-grid",
                "a piece's timeline has a cell outside the piece",
                "cut the timeline, or the world",
            )

    @property
    def width(self) -> int:
        """Return the number of cells in x."""
        return int(self.solid.shape[1])

    @property
    def height(self) -> int:
        """Return the number of cells in y."""
        return int(self.solid.shape[0])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Piece):
            return NotImplemented
        rest = ("start", "target", "timeline", "cell_size", "robot")
        return np.array_equal(self.solid, other.solid) and all(
            getattr(self, name) == getattr(other, name) for name in rest
        )

    __hash__ = None  # type: ignore[assignment]  # equal by content, and the content is an array

    def mirror(self, axis: str) -> Piece:
        """Swap left and right (``x``), or top and bottom (``y``).

        Raises:
            InvalidParameter: If ``axis`` is neither.
        """
        check_choice("mirror", axis, ("x", "y"))
        width, height = self.width, self.height
        if axis == "x":
            return self._moved(
                self.solid[:, ::-1], lambda x, y: (width - x, y), lambda h: TURN // 2 - h
            )
        return self._moved(self.solid[::-1], lambda x, y: (x, height - y), lambda h: -h)

    def rotate(self, quarters: int) -> Piece:
        """Turn the piece counter-clockwise by quarter turns, without loss."""
        piece = self
        for _ in range(_whole("rotate", quarters, -1_000_000, 1_000_000) % 4):
            piece = piece._quarter()
        return piece

    def _quarter(self) -> Piece:
        height = self.height
        return self._moved(
            self.solid.T[:, ::-1], lambda x, y: (height - y, x), lambda h: h + TURN // 4
        )

    def crop(self, x: int, y: int, width: int, height: int) -> Piece:
        """Cut out a box of cells.

        Args:
            x: First column.
            y: First row.
            width: Number of columns.
            height: Number of rows.

        Raises:
            InvalidParameter: If the box is not entirely inside the piece.
        """
        low_x, low_y = (
            _whole(f"crop {name}", low, 0, MAX_SIDE) for name, low in (("x", x), ("y", y))
        )
        sides = (("width", width), ("height", height))
        wide, high = (_whole(f"crop {name}", side, 1, MAX_SIDE) for name, side in sides)
        if low_x + wide > self.width or low_y + high > self.height:
            raise InvalidParameter(
                "outside-grid",
                f"a crop of {wide} x {high} cells from ({low_x}, {low_y}) reaches beyond the piece "
                f"of {self.width} x {self.height} cells",
                "use a box inside",
            )
        return self._moved(
            self.solid[low_y : low_y + high, low_x : low_x + wide],
            lambda x, y: (x - low_x, y - low_y),
        )

    def border(self, cells: int = 1) -> Piece:
        """Add a solid border around the piece."""
        cells = _whole("border", cells, 0, MAX_SIDE)
        _check_size((self.height + 2 * cells, self.width + 2 * cells))
        return self._moved(
            np.pad(self.solid, cells, constant_values=True), lambda x, y: (x + cells, y + cells)
        )

    def _moved(
        self,
        solid: Bools,
        move: Callable[[Fraction, Fraction], tuple[Fraction, Fraction]],
        turn: Callable[[int], int] = lambda heading: heading,
    ) -> Piece:
        """Return a piece of these cells, with this one's start, target and changes.

        What ends up outside is dropped.

        Args:
            solid: Cells of the new piece.
            move: Maps a place of this piece to the new one.
            turn: Maps a heading, in 1/65536 turns.
        """
        height, width = solid.shape

        def moved(mark: _Mark | None) -> _Mark | None:
            if mark is None:
                return None
            x, y = move(mark.x, mark.y)
            heading = None if mark.heading is None else turn(mark.heading) % TURN
            is_inside = 0 <= x <= width and 0 <= y <= height
            return replace(mark, x=x, y=y, heading=heading) if is_inside else None

        # The centre of a cell moves like any place; twice its coordinates are whole numbers.
        line = self.timeline
        x, y = move(line.ix + 0.5, line.iy + 0.5)  # type: ignore[arg-type]  # arrays, all at once
        timeline = _timeline(line.times, _cells(x), _cells(y), line.states, solid.shape)
        return replace(
            self, solid=solid, start=moved(self.start), target=moved(self.target), timeline=timeline
        )

    def with_start(self, x: float, y: float, *, degrees: float | None = None) -> Piece:
        """Set the start, in cells: (3.5, 2.5) is the centre of cell (3, 2)."""
        angle = None if degrees is None else _number("degrees", degrees)
        heading = None if angle is None else math.floor(angle / 360 * TURN + _HALF) % TURN
        return replace(self, start=replace(self._mark("start", x, y), heading=heading))

    def with_target(self, x: float, y: float, *, radius: float = 0.5) -> Piece:
        """Set the target; its place and radius are in cells."""
        disc = _number("radius", radius)
        if disc <= 0:
            raise InvalidParameter(
                "not-positive",
                f"radius={radius!r} must be above 0 cells",
                "use 0.5 for half a cell",
            )
        return replace(self, target=replace(self._mark("target", x, y), radius=disc))

    def _mark(self, name: str, x: float, y: float) -> _Mark:
        mark = _Mark(_number("x", x), _number("y", y))
        if not (0 <= mark.x <= self.width and 0 <= mark.y <= self.height):
            raise InvalidParameter(
                "outside-grid",
                f"{name} at ({x:g}, {y:g}) is outside the piece of {self.width} x {self.height} cells",
                "use a place in cells, from its lower left corner",
            )
        return mark

    def place(
        self, piece: Piece, *, at: tuple[int, int] | str, seed: int | RandomStream | None = None
    ) -> Piece:
        """Place another piece on this one, the host, and replace the cells below it.

        Start, target and robot are the host's if it has them.

        Args:
            piece: The piece to place.
            at: Host cell of the piece's lower left cell; or ``centre``; or ``way``, which draws a
                place on the path from the host's start to its target, and avoids both.
            seed: Seed of a drawn place.

        Raises:
            InvalidParameter: If the piece fits nowhere, or the cell sizes differ.
            InvalidWorld: If ``at`` is ``way`` and the host has no room for the robot.
        """
        x, y = self._corner(piece, at, seed)
        if not (0 <= x <= self.width - piece.width and 0 <= y <= self.height - piece.height):
            raise InvalidParameter(
                "outside-grid",
                f"a piece of {piece.width} x {piece.height} cells at ({x}, {y}) sticks out of "
                f"{self.width} x {self.height} cells",
                "put it elsewhere, or crop it",
            )
        if None not in (self.cell_size, piece.cell_size) and self.cell_size != piece.cell_size:
            raise InvalidParameter(
                "cell-sizes-differ",
                f"the host has cells of {self.cell_size:g} m, but the piece has cells of "
                f"{piece.cell_size:g} m",
                "make one with the other's cell_size",
            )
        solid = self.solid.copy()
        solid[y : y + piece.height, x : x + piece.width] = piece.solid
        placed = piece._moved(solid, lambda px, py: (px + x, py + y))
        # The host's changes below the piece end with its cells.
        own, new = self.timeline, placed.timeline
        stays = (own.ix < x) | (own.ix >= x + piece.width) | (own.iy < y)
        stays |= own.iy >= y + piece.height
        timeline = _timeline(
            np.concatenate((own.times[stays], new.times)),
            np.concatenate((own.ix[stays], new.ix)),
            np.concatenate((own.iy[stays], new.iy)),
            np.concatenate((own.states[stays], new.states)),
            solid.shape,
        )
        return replace(
            placed,
            start=self.start or placed.start,
            target=self.target or placed.target,
            timeline=timeline,
            cell_size=piece.cell_size if self.cell_size is None else self.cell_size,
            robot=self.robot or piece.robot,
        )

    def _corner(
        self, piece: Piece, at: tuple[int, int] | str, seed: int | RandomStream | None
    ) -> _Corner:
        """Return the host cell where the lower left cell of a piece goes."""
        if not isinstance(at, str):
            if not isinstance(at, tuple | list) or len(at) != 2:
                raise InvalidParameter(
                    "wrong-form", "at={at!r} is not a cell", "use (x, y), centre or way", at=at
                )
            x, y = at
            return _whole("at x", x, -MAX_SIDE, MAX_SIDE), _whole("at y", y, -MAX_SIDE, MAX_SIDE)
        check_choice("at", at, ("centre", "way"))
        if at == "centre":
            return (self.width - piece.width) // 2, (self.height - piece.height) // 2
        if seed is None:
            raise InvalidParameter("needs-seed", "at='way' is drawn", "give it a seed")
        rng = seed if isinstance(seed, RandomStream) else RandomStream(seed).child("place", at)

        # Search the path through the host as it is at time 0.
        world = self.layout()
        decision = decide(replace(world, timeline=Timeline()))
        way = decision.certificate
        if not isinstance(way, Witness):
            raise InvalidWorld(
                "not-reachable",
                "at='way', but the host has no path from start to target: {reason}",
                "put the piece elsewhere",
                reason=decision.reason,
            )
        points = np.stack([way.x, way.y], axis=1) / world.cell_size
        ends = of_world(world)
        radius = in_cells(world.robot_radius, world.cell_size)
        return _drawn_corner(
            rng, self, piece, points, [(ends.start, radius), (ends.target, radius)]
        )

    def layout(self, *, seed: int = 0) -> World:
        """Return the world without proving it.

        A missing start or target is placed far from the other one, as ``worldgen import`` does.

        Args:
            seed: Seed of the search for places that are far apart.

        Raises:
            InvalidWorld: If there is no room for the robot.
        """
        side = DEFAULT_CELL_SIZE if self.cell_size is None else self.cell_size
        robot = self.robot or _USUAL_ROBOT
        start, target = self.start, self.target
        if start is None or target is None:
            metres = [
                None if mark is None else (float(mark.x * exact(side)), float(mark.y * exact(side)))
                for mark in (start, target)
            ]
            body = "" if robot.is_disc else f"around the {describe_body(robot)}"
            placed = place(
                self.solid, side, robot.radius, seed, start=metres[0], target=metres[1], body=body
            )
            start, target = (
                mark or _Mark(in_cells(x, side), in_cells(y, side))
                for mark, (x, y) in ((start, placed.start), (target, placed.target))
            )
        robot = replace(
            robot,
            start=_pose(start, target, side),
            target=replace(
                robot.target,
                x=float(target.x * exact(side)),
                y=float(target.y * exact(side)),
                radius=float(target.radius * exact(side)),
                heading=None if target.heading is None else heading_from_lattice(target.heading),
            ),
        )
        return World(self.solid, cell_size=side, timeline=self.timeline, robots=[robot])

    def world(self, *, seed: int = 0, margin: float = 0.0) -> World:
        """Return the world with a witness, proved like every generated world.

        Apart from the proof this is :meth:`layout`.

        Args:
            seed: Seed of the search for places that are far apart.
            margin: Seconds by which the robot may start late on its witness in a changing world.

        Raises:
            InvalidWorld: If there is no room for the robot.
            GenerationFailed: If the target cannot be reached, or no proof was found; the error
                carries the reason.
        """
        world = self.layout(seed=seed)
        decision = decide(world, margin=margin)
        if decision.result != REACHABLE:
            raise GenerationFailed(
                "not-reachable",
                "the composed world is {result}: {reason}",
                "move a piece, start or target, or make the robot smaller",
                result=decision.result,
                reason=decision.reason,
            )
        return replace(world, certificate=decision.certificate)


def of_world(world: World) -> Piece:
    """Create a piece from a world's cells, start, target, changes and first robot."""
    robot = world.robots[0]
    side = world.cell_size
    start, target = (
        _Mark(
            in_cells(place.x, side),
            in_cells(place.y, side),
            None if place.heading is None else heading_to_lattice(place.heading),
            in_cells(radius, side),
        )
        for place, radius in ((robot.start, side / 2), (robot.target, robot.target.radius))
    )
    return Piece(
        world.walls,
        replace(start, radius=_HALF),
        target,
        world.timeline,
        side,
        replace(robot, start=_USUAL_ROBOT.start, waypoints=()),
    )


def of_cells(solid: npt.ArrayLike, *, cell_size: float | None = None) -> Piece:
    """Create a piece from an array of cells.

    Args:
        solid: (height, width) bool, True is solid; row 0 is the lowest y.
        cell_size: Side of a cell, m; a piece without one fits any.

    Raises:
        InvalidParameter: If the array has another shape, or too many cells.
    """
    return Piece(_solid_cells(solid), cell_size=cell_size)


def of_family(name: str | Family, seed: int | RandomStream = 0, **params: Value) -> Piece:
    """Create a piece from a family's world.

    Args:
        name: A family, or its name.
        seed: A seed gives the same world as ``generate``. A stream gives a layout that
            is drawn from the stream, without a proof.
        **params: Parameters of the family.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, or a value is out of range.
        GenerationFailed: If the family finds no solvable world for this seed.
    """
    if isinstance(seed, RandomStream):
        made_by = name if isinstance(name, Family) else FAMILIES.get(name)
        # A piece has one start and one target; the world as a whole has the robots.
        return of_world(made_by.build(seed, **made_by.complete({**params, "robots": 1})))
    return of_world(generate(name, seed, **params))


def _pose(start: _Mark, target: _Mark, side: float) -> Pose:
    """Convert a start to a pose; without a heading it faces the target, to a quarter turn."""
    heading = start.heading
    if heading is None:
        dx, dy = target.x - start.x, target.y - start.y
        quarters = (0 if dx >= 0 else 2) if abs(dx) >= abs(dy) else (1 if dy > 0 else 3)
        heading = quarters * TURN // 4
    return Pose(
        float(start.x * exact(side)), float(start.y * exact(side)), heading_from_lattice(heading)
    )


def _timeline(
    times: Floats, ix: Ints, iy: Ints, states: npt.NDArray[np.uint8], shape: tuple[int, ...]
) -> Timeline:
    """Return the changes inside a grid, sorted by time, then by cell."""
    order = np.lexsort((ix, iy, times))
    inside = (ix >= 0) & (iy >= 0) & (ix < shape[1]) & (iy < shape[0])
    order = order[inside[order]]
    return Timeline(times[order], ix[order], iy[order], states[order])


def _cells(centres: object) -> Ints:
    return np.floor(np.asarray(centres, np.float64)).astype(np.int64)


def _drawn_corner(
    rng: RandomStream,
    host: Piece,
    piece: Piece,
    way: Floats,
    keep_free: list[tuple[_Mark | None, Fraction]],
) -> _Corner:
    """Draw the first cell of a piece on a path so that it avoids some discs.

    Args:
        rng: The only source of randomness.
        host: The piece to place on.
        piece: The piece to place, a cell or more inside the host's sides.
        way: (n, 2) points of the path, in cells. Near a side the piece cannot be centred on it, but
            still covers it.
        keep_free: Discs that the piece must not touch: their centres, and radii in cells.
    """
    most = np.array([host.width - piece.width - 1, host.height - piece.height - 1])
    corners = np.zeros((0, 2), np.int64)
    if most.min() >= 1:
        centred: list[Floats] = []
        for begin, end in pairwise(way):
            # Two samples per cell, so that no cell along the path is skipped.
            steps = max(1, int(np.ceil(2 * np.abs(end - begin).max())))
            middles = (begin + (end - begin) * (k / steps) for k in range(steps + 1))
            size = np.array([piece.width, piece.height])
            centred += (np.floor(middle - size / 2 + 0.5) for middle in middles)
        along = np.array(centred).astype(np.int64).clip(1, most)
        corners = np.array(list(dict.fromkeys(map(tuple, along.tolist()))), np.int64)
    for mark, radius in keep_free:
        if mark is not None:
            corners = corners[~_touches(corners, piece, mark, radius)]
    if not len(corners):
        raise InvalidParameter(
            "no-room",
            f"a piece of {piece.width} x {piece.height} cells fits nowhere on the path from start to "
            f"target in {host.width} x {host.height} cells without covering one of them or the border",
            "use a smaller piece, or a larger host",
        )
    x, y = corners[rng.below(len(corners))].tolist()
    return x, y


def _touches(corners: Ints, piece: Piece, mark: _Mark, radius: Fraction) -> Bools:
    """Return for each corner whether the piece's box is nearer to the mark than the radius."""
    apart = []
    for axis, (at, size) in enumerate(((mark.x, piece.width), (mark.y, piece.height))):
        low = corners[:, axis]
        apart.append(np.maximum(np.maximum(low - float(at), float(at) - low - size), 0.0))
    return np.asarray(apart[0] ** 2 + apart[1] ** 2 < float(radius) ** 2 + 1e-9)


def _solid_cells(solid: npt.ArrayLike) -> Bools:
    """Return an array whose elements are true or false.

    Raises:
        InvalidParameter: If the rows differ in length, or hold anything but numbers.
    """
    try:
        cells = np.asarray(solid)
    except ValueError:
        cells = np.asarray(None)
    if cells.dtype.kind not in "biuf":
        raise InvalidParameter(
            "wrong-shape",
            "a piece's cells are not rows of equal length of True and False",
            "use a (height, width) array of bool, True is solid",
        )
    return cells.astype(np.bool_)


def _whole(name: str, value: object, low: int, high: int) -> int:
    """Check that a value is a whole number in a range, and return it as an int."""
    is_number = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (is_number and low <= value <= high):  # type: ignore[operator]
        raise InvalidParameter(
            "not-a-number",
            f"{name}={{value!r}} is not a whole number from {low} to {high}",
            "use one",
            value=value,
        )
    return int(value)  # type: ignore[call-overload, no-any-return]


def _number(name: str, value: object) -> Fraction:
    """Check that a value is a number, and return its shortest decimal: 0.1 is exactly 1/10."""
    value = value.item() if isinstance(value, np.number) else value
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
        raise InvalidParameter(
            "not-a-number",
            f"{name}={{value!r}} is not a number of cells or degrees below 1e9",
            "use one",
            value=value,
        )
    return exact(value)


def _check_size(shape: tuple[int, ...]) -> None:
    is_grid = len(shape) == 2 and all(1 <= side <= MAX_SIDE for side in shape)
    if not is_grid or math.prod(shape) > _MOST_CELLS:
        raise InvalidParameter(
            "wrong-shape",
            f"a piece's cells have shape {shape}; it is (height, width), each from 1 to {MAX_SIDE}, "
            f"and at most {_MOST_CELLS} cells",
            "take a smaller one",
        )
