"""Pieces: rectangles of cells that can be mirrored, turned, cut, repeated and put on each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from worldgen.compose._cells import HOW, Bools, Events, How, settled, taken, timeline_of
from worldgen.compose._marks import HALF, START, TARGET, Mark, Marks, frozen, mark_at, moved
from worldgen.compose._placing import corner_of, overlaid, put_down
from worldgen.compose._sizes import check_size, whole
from worldgen.compose._world import proved, usual, world_of
from worldgen.domain import CELL_SIZES, MAX_SIDE
from worldgen.errors import InvalidParameter
from worldgen.family import check_between, check_choice
from worldgen.lattice import TURN
from worldgen.random_streams import RandomStream
from worldgen.support.angles import SCALE, direction
from worldgen.timeline import Timeline
from worldgen.world import (
    DEFAULT_CELL_SIZE,
    DEFAULT_ROBOT_RADIUS,
    DEFAULT_ROBOT_SPEED,
    World,
)

__all__ = ["Piece"]

_FINE = 64  # units a cell, where a piece is turned by any angle
_THICKER = (
    14  # units, more than (sqrt(2) - 1) / 2 cells: a slanted wall of one cell then has no hole
)


@dataclass(frozen=True, eq=False)
class Piece:
    """A rectangle of cells with marks; immutable: every operation gives a new piece.

    Coordinates are in cells, x right, y up, from the piece's lower left corner.

    Args:
        solid: (height, width) bool, True is solid; row 0 is the lowest y.
        mask: (height, width) bool, the cells of which the piece says anything.
        marks: Named places; ``start`` and ``target`` become those of the world.
        timeline: Changes of its cells.
        cell_size: Side of a cell, m; ``None`` where the piece fits any.
        robot_radius: Of the robot that the piece was made for, m; ``None`` for any.
        robot_speed: Its top speed, m/s; ``None`` for any.

    Raises:
        InvalidParameter: If sizes do not fit, or there are too many cells.
    """

    solid: Bools
    mask: Bools
    marks: Mapping[str, Mark] = field(default_factory=lambda: MappingProxyType({}))
    timeline: Timeline = field(default_factory=Timeline)
    cell_size: float | None = None
    robot_radius: float | None = None
    robot_speed: float | None = None

    def __post_init__(self) -> None:
        solid = np.array(self.solid, dtype=np.bool_)
        mask = np.array(self.mask, dtype=np.bool_)
        if solid.ndim != 2 or mask.shape != solid.shape:
            raise InvalidParameter(
                "wrong-shape",
                "a piece's cells have shape {shape}, its mask {mask_shape}; both are (height, "
                "width), the same",
                shape=solid.shape,
                mask_shape=mask.shape,
            )
        check_size("a piece", solid.shape[1], solid.shape[0])
        solid &= mask
        for name, array in (("solid", solid), ("mask", mask)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "marks", frozen(self.marks))
        line = self.timeline
        if len(line):
            if not line.is_within(self.width, self.height):
                raise InvalidParameter(
                    "outside-grid",
                    "a piece's timeline has a cell outside of it",
                    "cut the timeline, or the world",
                )
            events = settled(Events.of(line, self.width), solid)
            events = events.only(mask.ravel()[events.cells])
            object.__setattr__(self, "timeline", timeline_of(events, self.width))

    @property
    def width(self) -> int:
        """Cells in x."""
        return int(self.solid.shape[1])

    @property
    def height(self) -> int:
        """Cells in y."""
        return int(self.solid.shape[0])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Piece):
            return NotImplemented
        arrays = all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in ("solid", "mask")
        )
        rest = ("marks", "timeline", "cell_size", "robot_radius", "robot_speed")
        return arrays and all(getattr(self, name) == getattr(other, name) for name in rest)

    __hash__ = None  # type: ignore[assignment]  # equal by content, and the content is an array

    # Moving and cutting: each new cell is taken from an old one.

    def _taken(self, source: npt.NDArray[np.int64], marks: Marks) -> Piece:
        """A piece each of whose cells is one of this one's.

        (height, width) flat cells, -1 for none.
        """
        flat = source.ravel()
        mask = np.asarray((source >= 0) & self.mask.ravel()[source])
        solid = np.asarray(mask & self.solid.ravel()[source])
        events = taken(Events.of(self.timeline, self.width), flat, self.solid.size)
        line = timeline_of(events.only(np.argsort(events.times, kind="stable")), source.shape[1])
        return replace(self, solid=solid, mask=mask, marks=marks, timeline=line)

    def _numbers(self) -> npt.NDArray[np.int64]:
        return np.arange(self.solid.size, dtype=np.int64).reshape(self.solid.shape)

    def mirror(self, axis: str) -> Piece:
        """Left and right (``x``), or up and down (``y``), change places.

        Raises:
            InvalidParameter: If the axis is neither.
        """
        width = self.width
        height = self.height
        if axis == "x":
            marks = moved(self.marks, lambda x, y: (width - x, y), width, height, TURN // 2, -1)
            return self._taken(self._numbers()[:, ::-1], marks)
        if axis == "y":
            marks = moved(self.marks, lambda x, y: (x, height - y), width, height, 0, -1)
            return self._taken(self._numbers()[::-1], marks)
        raise InvalidParameter(
            "unknown-name",
            "mirror={axis!r} is neither 'x' (left and right) nor 'y' (up and down)",
            "give one",
            axis=axis,
        )

    def rotate(self, quarters: int) -> Piece:
        """Turned counter-clockwise by quarter turns, exactly."""
        piece = self
        for _ in range(whole("rotate", quarters, -1_000_000, 1_000_000) % 4):
            piece = piece._quarter()
        return piece

    def _quarter(self) -> Piece:
        height = self.height
        marks = moved(self.marks, lambda x, y: (height - y, x), height, self.width, TURN // 4)
        return self._taken(self._numbers().T[:, ::-1], marks)  # (x, y) goes to (height - y, x)

    def turn(self, degrees: int) -> Piece:
        """Turned counter-clockwise by whole degrees; quarter turns are exact.

        At any other angle walls are rastered and made a little thicker, so that they have no holes:
            passages
        get up to two cells narrower, and of two walls a cell apart one may touch the other. What
        lies between the turned sides and the new rectangle says nothing. Marks go to the nearest
        half cell.
        """
        whole("turn", degrees, -1_000_000, 1_000_000)
        if degrees % 90 == 0:
            return self.rotate(degrees // 90 % 4)
        cos, sin = direction(degrees)
        width, height = (
            -(-(self.width * abs(across) + self.height * abs(along)) // SCALE) + 1
            for across, along in ((cos, sin), (sin, cos))
        )
        check_size(f"turn={degrees}", width, height)
        x, y = (
            2 * np.arange(n, dtype=np.int64) + 1 - n for n in (width, height)
        )  # half cells from the middle
        x = x[np.newaxis, :] * (_FINE // 2)
        y = y[:, np.newaxis] * (_FINE // 2)
        u = (x * cos + y * sin) // SCALE + self.width * _FINE // 2
        v = (y * cos - x * sin) // SCALE + self.height * _FINE // 2
        half_turn = (TURN * (degrees % 360) + 180) // 360

        def place(at_x: Fraction, at_y: Fraction) -> tuple[Fraction, Fraction]:
            du = at_x - Fraction(self.width, 2)
            dv = at_y - Fraction(self.height, 2)
            to = (du * cos - dv * sin) / SCALE, (du * sin + dv * cos) / SCALE
            return Fraction(round(2 * to[0] + width), 2), Fraction(round(2 * to[1] + height), 2)

        marks = moved(self.marks, place, width, height, half_turn)
        turned = self._taken(self._cell_at(u, v), marks)
        walls = self.walls()
        for du in (-_THICKER, _THICKER):
            for dv in (-_THICKER, _THICKER):
                near = walls._taken(walls._cell_at(u + du, v + dv), frozen({}))
                turned = overlaid(turned, near, 0, 0, "union")
        return turned

    def _cell_at(self, u: npt.NDArray[np.int64], v: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Flat cells that hold points, in fine units; -1 outside."""
        ix = u // _FINE
        iy = v // _FINE
        inside = (ix >= 0) & (ix < self.width) & (iy >= 0) & (iy < self.height)
        return np.where(inside, iy * self.width + ix, -1)

    def crop(self, x: int, y: int, width: int, height: int) -> Piece:
        """The cells of a box that lies inside.

        Raises:
            InvalidParameter: If it does not.
        """
        numbers = [
            whole(f"crop {name}", value, 0, MAX_SIDE) for name, value in (("x", x), ("y", y))
        ]
        sides = [
            whole(f"crop {name}", value, 1, MAX_SIDE)
            for name, value in (("width", width), ("height", height))
        ]
        if numbers[0] + sides[0] > self.width or numbers[1] + sides[1] > self.height:
            raise InvalidParameter(
                "outside-grid",
                "crop of {width} x {height} cells from ({x}, {y}) on reaches beyond the "
                "piece of {piece_width} x {piece_height} cells",
                "give a box inside",
                width=width,
                height=height,
                x=x,
                y=y,
                piece_width=self.width,
                piece_height=self.height,
            )
        marks = moved(self.marks, lambda mark_x, mark_y: (mark_x - x, mark_y - y), width, height)
        return self._taken(self._numbers()[y : y + height, x : x + width], marks)

    def inside(self, rim: int = 1) -> Piece:
        """Without the outermost cells: a family's world without its solid border."""
        rim = whole("inside", rim, 0, MAX_SIDE)
        return self.crop(rim, rim, self.width - 2 * rim, self.height - 2 * rim)

    def trim(self) -> Piece:
        """The smallest box that holds all of which the piece says anything."""
        rows, columns = (np.flatnonzero(self.mask.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            return self
        x = int(columns[0])
        y = int(rows[0])
        return self.crop(x, y, int(columns[-1]) - x + 1, int(rows[-1]) - y + 1)

    def pad(self, left: int, right: int, bottom: int, top: int, *, fill: str = "nothing") -> Piece:
        """With more cells round it: ``solid``, ``free``, or ``nothing``, of which it says nothing.

        Raises:
            InvalidParameter: If a number is below 0, or the filling is none of the three.
        """
        for name, value in (("left", left), ("right", right), ("bottom", bottom), ("top", top)):
            whole(f"pad {name}", value, 0, MAX_SIDE)
        if fill not in ("solid", "free", "nothing"):
            raise InvalidParameter(
                "unknown-name",
                "fill={fill!r} is none of solid, free, nothing",
                "give one of these",
                fill=fill,
            )
        width = self.width + left + right
        height = self.height + bottom + top
        check_size("pad", width, height)
        numbers = np.full((height, width), -1, np.int64)
        numbers[bottom : bottom + self.height, left : left + self.width] = self._numbers()
        padded = self._taken(
            numbers, moved(self.marks, lambda x, y: (x + left, y + bottom), width, height)
        )
        if fill == "nothing":
            return padded
        ring = numbers < 0
        return replace(
            padded, solid=padded.solid | (ring & (fill == "solid")), mask=padded.mask | ring
        )

    def border(self, cells: int = 1) -> Piece:
        """With a solid border round it."""
        return self.pad(cells, cells, cells, cells, fill="solid")

    def tile(self, columns: int, rows: int) -> Piece:
        """Repeated, side by side; marks stay in the lower left one."""
        columns, rows = (
            whole(f"tile {n}", v, 1, MAX_SIDE) for n, v in (("columns", columns), ("rows", rows))
        )
        check_size("tile", self.width * columns, self.height * rows)
        return self._taken(np.tile(self._numbers(), (rows, columns)), self.marks)

    def scale(self, factor: int) -> Piece:
        """Each cell becomes ``factor`` x ``factor`` of them; the size of a cell, in m, stays."""
        factor = whole("scale", factor, 1, MAX_SIDE)
        check_size("scale", self.width * factor, self.height * factor)
        numbers = self._numbers().repeat(factor, axis=0).repeat(factor, axis=1)
        width = self.width * factor
        height = self.height * factor
        return self._taken(
            numbers, moved(self.marks, lambda x, y: (x * factor, y * factor), width, height)
        )

    # What the piece speaks of.

    def masked(self, mask: Bools | Piece) -> Piece:
        """Says nothing any more outside a mask.

        (height, width) bool, or a piece, whose solid cells count.

        Raises:
            InvalidParameter: If it has another size.
        """
        kept = mask.solid if isinstance(mask, Piece) else np.asarray(mask, dtype=np.bool_)
        if kept.shape != self.solid.shape:
            raise InvalidParameter(
                "wrong-shape",
                "a mask of shape {shape} does not fit a piece of {width} x {height} cells",
                "crop or pad one of them",
                shape=kept.shape,
                width=self.width,
                height=self.height,
            )
        return replace(self, mask=self.mask & kept)

    def walls(self) -> Piece:
        """Its walls alone: it says nothing of cells that are free and stay so."""
        return self.masked(self.solid | self.timeline.cells_that_become(shape=self.solid.shape))

    def floor(self) -> Piece:
        """Its floor alone: it says nothing of cells that are solid and stay so."""
        return self.masked(~self.solid | self.timeline.cells_that_become(shape=self.solid.shape))

    def filled(self, fill: str) -> Piece:
        """What it said nothing of is ``solid`` or ``free``."""
        if fill not in ("solid", "free"):
            raise InvalidParameter(
                "unknown-name",
                "fill={fill!r} is neither solid nor free",
                "give one of these",
                fill=fill,
            )
        return replace(
            self, solid=self.solid | (~self.mask & (fill == "solid")), mask=np.ones_like(self.mask)
        )

    def dig(
        self, begin: str | tuple[float, float], end: str | tuple[float, float], *, width: int = 2
    ) -> Piece:
        """With a passage, first along x, then along y, whatever was there; it stays free for ever.

        Args:
            begin: A mark, or a place in cells.
            end: Likewise.
            width: Cells.

        Raises:
            InvalidParameter: If a mark is unknown, or a place lies outside.
        """
        width = whole("dig width", width, 1, MAX_SIDE)
        (x0, y0), (x1, y1) = (self._brush(point, width) for point in (begin, end))
        along = (min(x0, x1), y0, max(x0, x1), y0)
        across = (x1, min(y0, y1), x1, max(y0, y1))
        dug = np.zeros_like(self.solid)
        for low_x, low_y, high_x, high_y in (along, across):
            dug[max(low_y, 0) : high_y + width, max(low_x, 0) : high_x + width] = True
        return overlaid(self, Piece(np.zeros_like(dug), dug), 0, 0, "over")

    def _brush(self, point: str | tuple[float, float], width: int) -> tuple[int, int]:
        """First cell of a square round a point."""
        if isinstance(point, str):
            if point not in self.marks:
                raise InvalidParameter(
                    "unknown-name",
                    "no mark is called {name!r}; the piece has {known!l:none}",
                    "give [x, y]",
                    name=point,
                    known=list(self.marks),
                )
            mark = self.marks[point]
        else:
            mark = mark_at(*point)
            self._check_inside("dig", mark)
        x, y = (math.floor(at - Fraction(width, 2) + HALF) for at in (mark.x, mark.y))
        return x, y

    # Marks and robot.

    def with_mark(self, name: str, x: float, y: float, *, degrees: float | None = None) -> Piece:
        """With a named place, in cells.

        ``degrees`` is where the robot looks, from +x counter-clockwise.

        Raises:
            InvalidParameter: If the place lies outside.
        """
        return self._marked(name, mark_at(x, y, degrees))

    def with_start(self, x: float, y: float, *, degrees: float | None = None) -> Piece:
        """With a start, in cells: (3.5, 2.5) is the middle of cell (3, 2)."""
        return self._marked(START, mark_at(x, y, degrees))

    def with_target(self, x: float, y: float, *, radius: float = 0.5) -> Piece:
        """With a target, all in cells."""
        return self._marked(TARGET, mark_at(x, y, radius=radius))

    def _marked(self, name: str, mark: Mark) -> Piece:
        self._check_inside(name, mark)
        return replace(self, marks={**self.marks, name: mark})

    def _check_inside(self, name: str, mark: Mark) -> None:
        if not (0 <= mark.x <= self.width and 0 <= mark.y <= self.height):
            raise InvalidParameter(
                "outside-grid",
                "{name} at ({x:g}, {y:g}) lies outside the piece of {width} x {height} cells",
                "give cells from its lower left corner",
                name=name,
                x=float(mark.x),
                y=float(mark.y),
                width=self.width,
                height=self.height,
            )

    def without_marks(self, *names: str) -> Piece:
        """Without some marks; without all, if none is named."""
        return replace(
            self,
            marks={name: mark for name, mark in self.marks.items() if names and name not in names},
        )

    def for_robot(
        self,
        *,
        radius: float | None = None,
        speed: float | None = None,
        cell_size: float | None = None,
    ) -> Piece:
        """For another robot, or cells of another size, in m and m/s; what is left out stays.

        Raises:
            InvalidParameter: If a number is out of range.
        """
        for name, value, unit in (("robot_radius", radius, "m"), ("robot_speed", speed, "m/s")):
            if value is not None:
                check_between(name, value, 1e-6, 1e6, unit)
        if cell_size is not None:
            check_between("cell_size", cell_size, *CELL_SIZES, "m")
        return replace(
            self,
            robot_radius=self.robot_radius if radius is None else radius,
            robot_speed=self.robot_speed if speed is None else speed,
            cell_size=self.cell_size if cell_size is None else cell_size,
        )

    # Two pieces.

    def place(
        self,
        piece: Piece,
        *,
        at: tuple[float, float] | str = (0, 0),
        anchor: str | None = None,
        how: How = "over",
        outside: str = "refuse",
        start: str = "host",
        target: str = "host",
        margin: int = 1,
        seed: int | RandomStream | None = None,
    ) -> Piece:
        """This piece, the host, with another on it.

        Args:
            piece: What to put down. Its marks come along where the host has none of their names.
            at: Where its lower left cell goes, in cells; or a word: ``centre``, a side (``left``,
                ``top``, ...) or a corner (``lower-left``, ...) inside the host; or a mark of the
                host, on which the piece's middle goes; or drawn: ``way``, its middle on the way
                from the host's start to its target, or ``anywhere``, both clear of start and
                target.
            anchor: What of the piece goes to the place or mark instead: its ``centre``, a side, a
                corner, or a mark of its own; to the nearest whole cell.
            how: ``over``: what the piece says replaces what was there. ``union``: walls of both.
                ``intersection``: walls where both have them, so that the piece's floor is dug out.
                    ``carve``: the piece's walls are
                cut out. Where the host says nothing, the piece alone counts; nothing is carved
                there.
            outside: What becomes of what sticks out of the host: ``refuse`` it, ``clip`` it off, or
                ``grow`` the host, which says nothing of the new cells.
            start: Whose start counts, ``host`` or ``piece``, where both have one.
            target: Likewise.
            margin: Cells between the piece and the host's sides, where ``at`` is a word; 1 keeps a
                border.
            seed: Of the place, where that is drawn.

        Raises:
            InvalidParameter: If a word is unknown, the piece fits nowhere, or the cells have
                different sizes.
            InvalidWorld: If it is to go on the way, and the host has no place for the robot.
        """
        check_choice("how", how, tuple(HOW))
        check_choice("outside", outside, ("refuse", "clip", "grow"))
        corner = corner_of(self, piece, at, anchor, margin, seed)
        return put_down(self, piece, corner, how, outside, {START: start, TARGET: target})

    def union(self, other: Piece) -> Piece:
        """Walls of either; the lower left corners lie on each other, and the larger sides count."""
        return self.place(other, how="union", outside="grow")

    def intersect(self, other: Piece) -> Piece:
        """Walls of both, where both speak; the lower left corners lie on each other."""
        return self.place(other, how="intersection", outside="grow")

    def subtract(self, other: Piece) -> Piece:
        """Without the other's walls; the lower left corners lie on each other."""
        return self.place(other, how="carve", outside="clip")

    # The world.

    def layout(self, *, seed: int = 0) -> World:
        """The world, without proof; what no piece spoke of is solid.

        A start or a target that is missing is placed far from the other, as ``worldgen import``
        does.

        Args:
            seed: Where the search for far places begins.

        Raises:
            InvalidWorld: If there is no room for the robot.
        """
        cell_size = usual(self.cell_size, DEFAULT_CELL_SIZE)
        radius = usual(self.robot_radius, DEFAULT_ROBOT_RADIUS)
        speed = usual(self.robot_speed, DEFAULT_ROBOT_SPEED)
        walls = np.asarray(self.solid | ~self.mask)
        return world_of(walls, self.marks, self.timeline, (cell_size, radius, speed), seed)

    def world(self, *, seed: int = 0, margin: float = 0.0) -> World:
        """The world with a witness, proved like every generated world; like :meth:`layout` else.

        Args:
            seed: Where the search for far places begins.
            margin: Seconds by which the robot may begin the witness later, where something changes.

        Raises:
            InvalidWorld: If there is no room for the robot.
            GenerationFailed: If the target cannot be reached, or was not proved to be; it says why.
        """
        return proved(self.layout(seed=seed), margin)
