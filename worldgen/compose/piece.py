"""Pieces: rectangles of cells to mirror, turn, cut, repeat and place on each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import MappingProxyType

import numpy as np

from worldgen.compose.cells import HOW, Events, How, settled, taken, timeline_of
from worldgen.compose.marks import HALF, START, TARGET, Mark, Marks, frozen, mark_at, moved
from worldgen.compose.placing import corner_of, overlaid, put_down
from worldgen.compose.sizes import check_size, whole
from worldgen.compose.world import proved, usual, world_of
from worldgen.domain import CELL_SIZES, MAX_SIDE
from worldgen.errors import InvalidParameter
from worldgen.family import check_between, check_choice
from worldgen.lattice import TURN
from worldgen.random_streams import RandomStream
from worldgen.support.angles import SCALE, direction
from worldgen.support.arrays import Bools, Ints
from worldgen.timeline import Timeline
from worldgen.world import DEFAULT_CELL_SIZE, DEFAULT_ROBOT_RADIUS, DEFAULT_ROBOT_SPEED, World

# Units per cell when a piece is turned by an arbitrary angle.
_FINE = 64
# Units by which turned walls are thickened. It exceeds (sqrt(2) - 1) / 2 cells, so a slanted wall
# of one cell has no holes.
_THICKER = 14


@dataclass(frozen=True, eq=False)
class Piece:
    """Hold a rectangle of cells with marks and a timeline.

    A piece is immutable: every operation returns a new one. Coordinates are in cells, x to the
    right and y up, from the piece's lower left corner.

    Args:
        solid: (height, width) bool, True is solid; row 0 is the lowest y.
        mask: (height, width) bool, True where the piece defines a cell. Other cells are left
            undefined, and whatever the piece is placed on shows through.
        marks: Named places; ``start`` and ``target`` become the world's.
        timeline: Changes of the piece's cells.
        cell_size: Side of a cell, m; ``None`` if the piece fits any size.
        robot_radius: Radius of the robot that the piece was made for, m; ``None`` for any.
        robot_speed: Top speed of that robot, m/s; ``None`` for any.

    Raises:
        InvalidParameter: If the shapes differ, there are too many cells, or an event is outside.
    """

    solid: Bools
    mask: Bools
    marks: Mapping[str, Mark] = field(default_factory=lambda: MappingProxyType({}))
    timeline: Timeline = field(default_factory=Timeline)
    cell_size: float | None = None
    robot_radius: float | None = None
    robot_speed: float | None = None

    def __post_init__(self) -> None:
        # Copy the arrays before making them read-only, because the caller may still use its own.
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
        # Equal pieces must have equal arrays, so cells outside the mask are always free.
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
                    "a piece's timeline has a cell outside the piece",
                    "cut the timeline, or the world",
                )
            events = settled(Events.of(line, self.width), solid)
            events = events.only(mask.ravel()[events.cells])
            object.__setattr__(self, "timeline", timeline_of(events, self.width))

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
        arrays = all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in ("solid", "mask")
        )
        rest = ("marks", "timeline", "cell_size", "robot_radius", "robot_speed")
        return arrays and all(getattr(self, name) == getattr(other, name) for name in rest)

    __hash__ = None  # type: ignore[assignment]  # equal by content, and the content is an array

    # Move and cut: each new cell is copied from an old one.

    def _taken(self, source: Ints, marks: Marks) -> Piece:
        """Return a piece whose cells are copied from this one's.

        Args:
            source: (height, width) int64, the flat cell that each new cell is copied from; -1
                leaves the new cell undefined.
            marks: Marks of the new piece.
        """
        flat = source.ravel()
        mask = np.asarray((source >= 0) & self.mask.ravel()[source])
        solid = np.asarray(mask & self.solid.ravel()[source])
        events = taken(Events.of(self.timeline, self.width), flat, self.solid.size)
        line = timeline_of(events.only(np.argsort(events.times, kind="stable")), source.shape[1])
        return replace(self, solid=solid, mask=mask, marks=marks, timeline=line)

    def _numbers(self) -> Ints:
        return np.arange(self.solid.size, dtype=np.int64).reshape(self.solid.shape)

    def mirror(self, axis: str) -> Piece:
        """Swap left and right (``x``), or top and bottom (``y``).

        Raises:
            InvalidParameter: If ``axis`` is neither.
        """
        width = self.width
        height = self.height
        check_choice("mirror", axis, ("x", "y"))
        if axis == "x":
            marks = moved(self.marks, lambda x, y: (width - x, y), width, height, TURN // 2, -1)
            return self._taken(self._numbers()[:, ::-1], marks)
        marks = moved(self.marks, lambda x, y: (x, height - y), width, height, 0, -1)
        return self._taken(self._numbers()[::-1], marks)

    def rotate(self, quarters: int) -> Piece:
        """Turn the piece counter-clockwise by quarter turns, without loss."""
        piece = self
        for _ in range(whole("rotate", quarters, -1_000_000, 1_000_000) % 4):
            piece = piece._quarter()
        return piece

    def _quarter(self) -> Piece:
        height = self.height
        marks = moved(self.marks, lambda x, y: (height - y, x), height, self.width, TURN // 4)
        # A quarter turn moves (x, y) to (height - y, x).
        return self._taken(self._numbers().T[:, ::-1], marks)

    def turn(self, degrees: int) -> Piece:
        """Turn the piece counter-clockwise by whole degrees; quarter turns are exact.

        At any other angle the walls are rasterised and slightly thickened, so that they have no
        holes. Passages therefore become up to two cells narrower, and two walls that are one cell
        apart may touch. Cells between the turned sides and the new rectangle are undefined. Marks
        move to the nearest half cell.
        """
        whole("turn", degrees, -1_000_000, 1_000_000)
        if degrees % 90 == 0:
            return self.rotate(degrees // 90 % 4)

        # The bounding box of the turned rectangle, rounded up, plus one cell for the raster.
        cos, sin = direction(degrees)
        width, height = (
            -(-(self.width * abs(across) + self.height * abs(along)) // SCALE) + 1
            for across, along in ((cos, sin), (sin, cos))
        )
        check_size(f"turn={degrees}", width, height)

        # Turn each new cell's centre back to find the old cell it falls in. Only whole numbers are
        # used, so that every platform gives the same piece. The first step gives the distance from
        # the middle in half cells.
        x, y = (2 * np.arange(n, dtype=np.int64) + 1 - n for n in (width, height))
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

        # Thicken the walls: add copies that are sampled a little towards each of four corners.
        walls = self.walls()
        for du in (-_THICKER, _THICKER):
            for dv in (-_THICKER, _THICKER):
                near = walls._taken(walls._cell_at(u + du, v + dv), frozen({}))
                turned = overlaid(turned, near, 0, 0, "union")
        return turned

    def _cell_at(self, u: Ints, v: Ints) -> Ints:
        """Return the flat cells that contain points given in fine units; -1 if outside."""
        ix = u // _FINE
        iy = v // _FINE
        inside = (ix >= 0) & (ix < self.width) & (iy >= 0) & (iy < self.height)
        return np.where(inside, iy * self.width + ix, -1)

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
                "a crop of {width} x {height} cells from ({x}, {y}) reaches beyond the "
                "piece of {piece_width} x {piece_height} cells",
                "use a box inside",
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
        """Cut off the outermost ``rim`` cells, such as the solid border of a family's world."""
        rim = whole("inside", rim, 0, MAX_SIDE)
        return self.crop(rim, rim, self.width - 2 * rim, self.height - 2 * rim)

    def trim(self) -> Piece:
        """Cut the piece to the smallest box that contains all its defined cells."""
        rows, columns = (np.flatnonzero(self.mask.any(axis=axis)) for axis in (1, 0))
        # A piece without defined cells has no such box.
        if not len(rows):
            return self
        x = int(columns[0])
        y = int(rows[0])
        return self.crop(x, y, int(columns[-1]) - x + 1, int(rows[-1]) - y + 1)

    def pad(self, left: int, right: int, bottom: int, top: int, *, fill: str = "nothing") -> Piece:
        """Add cells around the piece.

        Args:
            left: Columns to add on the left.
            right: Columns to add on the right.
            bottom: Rows to add below.
            top: Rows to add above.
            fill: ``solid``, ``free``, or ``nothing`` to leave the new cells undefined.

        Raises:
            InvalidParameter: If a number is below 0, or ``fill`` is not one of the three.
        """
        for name, value in (("left", left), ("right", right), ("bottom", bottom), ("top", top)):
            whole(f"pad {name}", value, 0, MAX_SIDE)
        check_choice("fill", fill, ("solid", "free", "nothing"))
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
        """Add a solid border around the piece."""
        return self.pad(cells, cells, cells, cells, fill="solid")

    def tile(self, columns: int, rows: int) -> Piece:
        """Repeat the piece in a grid; only the lower left copy keeps its marks."""
        columns, rows = (
            whole(f"tile {n}", v, 1, MAX_SIDE) for n, v in (("columns", columns), ("rows", rows))
        )
        check_size("tile", self.width * columns, self.height * rows)
        return self._taken(np.tile(self._numbers(), (rows, columns)), self.marks)

    def scale(self, factor: int) -> Piece:
        """Replace each cell by ``factor`` x ``factor`` cells; ``cell_size`` does not change."""
        factor = whole("scale", factor, 1, MAX_SIDE)
        check_size("scale", self.width * factor, self.height * factor)
        numbers = self._numbers().repeat(factor, axis=0).repeat(factor, axis=1)
        width = self.width * factor
        height = self.height * factor
        return self._taken(
            numbers, moved(self.marks, lambda x, y: (x * factor, y * factor), width, height)
        )

    # Choose which cells the piece defines.

    def masked(self, mask: Bools | Piece) -> Piece:
        """Leave the cells outside a mask undefined.

        Args:
            mask: (height, width) bool, or a piece whose solid cells are the mask.

        Raises:
            InvalidParameter: If the mask has another size.
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
        """Keep only the walls: leave cells undefined that are always free."""
        return self.masked(self.solid | self.timeline.cells_that_become(shape=self.solid.shape))

    def floor(self) -> Piece:
        """Keep only the floor: leave cells undefined that are always solid."""
        return self.masked(~self.solid | self.timeline.cells_that_become(shape=self.solid.shape))

    def filled(self, fill: str) -> Piece:
        """Define the undefined cells as ``solid`` or ``free``."""
        check_choice("fill", fill, ("solid", "free"))
        return replace(
            self, solid=self.solid | (~self.mask & (fill == "solid")), mask=np.ones_like(self.mask)
        )

    def dig(
        self, begin: str | tuple[float, float], end: str | tuple[float, float], *, width: int = 2
    ) -> Piece:
        """Dig a passage, first along x and then along y, through whatever is there.

        The passage also removes the events of its cells, so it stays free forever.

        Args:
            begin: A mark's name, or a place in cells.
            end: A mark's name, or a place in cells.
            width: Width of the passage, cells.

        Raises:
            InvalidParameter: If a mark is unknown, or a place is outside the piece.
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
        """Return the first cell of a square of ``width`` cells around a point."""
        if isinstance(point, str):
            if point not in self.marks:
                raise InvalidParameter(
                    "unknown-name",
                    "no mark is called {name!r}; the piece has {known!l:none}",
                    "use [x, y]",
                    name=point,
                    known=list(self.marks),
                )
            mark = self.marks[point]
        else:
            mark = mark_at(*point)
            self._check_inside("dig", mark)
        x, y = (math.floor(at - Fraction(width, 2) + HALF) for at in (mark.x, mark.y))
        return x, y

    # Change the marks and the robot.

    def with_mark(self, name: str, x: float, y: float, *, degrees: float | None = None) -> Piece:
        """Add a named place, or move it.

        Args:
            name: Name of the mark.
            x: Cells from the piece's left side.
            y: Cells from its lower side.
            degrees: Direction that the robot faces, counter-clockwise from +x.

        Raises:
            InvalidParameter: If the place is outside the piece.
        """
        return self._marked(name, mark_at(x, y, degrees))

    def with_start(self, x: float, y: float, *, degrees: float | None = None) -> Piece:
        """Set the start, in cells: (3.5, 2.5) is the centre of cell (3, 2)."""
        return self._marked(START, mark_at(x, y, degrees))

    def with_target(self, x: float, y: float, *, radius: float = 0.5) -> Piece:
        """Set the target; its place and radius are in cells."""
        return self._marked(TARGET, mark_at(x, y, radius=radius))

    def _marked(self, name: str, mark: Mark) -> Piece:
        self._check_inside(name, mark)
        return replace(self, marks={**self.marks, name: mark})

    def _check_inside(self, name: str, mark: Mark) -> None:
        if not (0 <= mark.x <= self.width and 0 <= mark.y <= self.height):
            raise InvalidParameter(
                "outside-grid",
                "{name} at ({x:g}, {y:g}) is outside the piece of {width} x {height} cells",
                "use a place in cells, from its lower left corner",
                name=name,
                x=float(mark.x),
                y=float(mark.y),
                width=self.width,
                height=self.height,
            )

    def without_marks(self, *names: str) -> Piece:
        """Remove some marks, or all of them if no name is given."""
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
        """Set the robot or the size of a cell; omitted values do not change.

        Args:
            radius: Radius of the robot, m.
            speed: Top speed of the robot, m/s.
            cell_size: Side of a cell, m. The number of cells does not change, so the piece grows
                or shrinks in metres.

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

    # Combine two pieces.

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
        """Place another piece on this one, the host.

        Args:
            piece: The piece to place. A mark of it is kept unless the host has one of that name.
            at: Host cell of the piece's lower left cell, or one of these words: ``centre``, a side
                (``left``, ``top``, ...) or a corner (``lower-left``, ...) of the host. The name of
                a mark of the host, which the piece is centred on. ``way`` draws a place on the path
                from the host's start to its target, and ``anywhere`` draws any place; both avoid
                start and target.
            anchor: Point of the piece that goes to the place or mark instead: its ``centre``, a
                side, a corner, or one of its marks; rounded to the nearest whole cell.
            how: ``over`` replaces the host's cells. ``union`` keeps the walls of both.
                ``intersection`` keeps walls that both have, which digs out the piece's floor.
                ``carve`` cuts out the piece's walls. Where the host is undefined, only the piece
                counts, and nothing is carved.
            outside: What to do if the piece sticks out of the host: ``refuse`` raises, ``clip``
                cuts it off, and ``grow`` enlarges the host by undefined cells.
            start: Whose start to keep if both have one, ``host`` or ``piece``.
            target: Whose target to keep if both have one, ``host`` or ``piece``.
            margin: Cells between the piece and the host's sides if ``at`` names or draws a place;
                1 preserves a border.
            seed: Seed of a drawn place.

        Raises:
            InvalidParameter: If a word is unknown, the piece fits nowhere, or the cell sizes
                differ.
            InvalidWorld: If ``at`` is ``way`` and the host has no room for the robot.
        """
        check_choice("how", how, tuple(HOW))
        check_choice("outside", outside, ("refuse", "clip", "grow"))
        corner = corner_of(self, piece, at, anchor, margin, seed)
        return put_down(self, piece, corner, how, outside, {START: start, TARGET: target})

    def union(self, other: Piece) -> Piece:
        """Keep the walls of either piece.

        The lower left corners are aligned, and the result is as large as the larger sides.
        """
        return self.place(other, how="union", outside="grow")

    def intersect(self, other: Piece) -> Piece:
        """Keep walls that both pieces have, where both are defined; align lower left corners."""
        return self.place(other, how="intersection", outside="grow")

    def subtract(self, other: Piece) -> Piece:
        """Cut out the other piece's walls; align the lower left corners."""
        return self.place(other, how="carve", outside="clip")

    # Make a world.

    def layout(self, *, seed: int = 0) -> World:
        """Return the world without proving it; undefined cells become solid.

        A missing start or target is placed far from the other one, as ``worldgen import`` does.

        Args:
            seed: Seed of the search for places that are far apart.

        Raises:
            InvalidWorld: If there is no room for the robot.
        """
        cell_size = usual(self.cell_size, DEFAULT_CELL_SIZE)
        radius = usual(self.robot_radius, DEFAULT_ROBOT_RADIUS)
        speed = usual(self.robot_speed, DEFAULT_ROBOT_SPEED)
        walls = np.asarray(self.solid | ~self.mask)
        return world_of(walls, self.marks, self.timeline, (cell_size, radius, speed), seed)

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
        return proved(self.layout(seed=seed), margin)
