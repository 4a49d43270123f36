"""Pieces: rectangles of cells to mirror, rotate, cut and place on each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from worldgen.compose.cells import HOW, Events, How, settled, taken, timeline_of
from worldgen.compose.marks import START, TARGET, Mark, Marks, frozen, mark_at, moved
from worldgen.compose.placing import corner_of, put_down
from worldgen.compose.sizes import check_size, whole
from worldgen.compose.world import USUAL_ROBOT, proved, usual, world_of
from worldgen.domain import MAX_SIDE
from worldgen.errors import InvalidParameter
from worldgen.family import check_choice
from worldgen.lattice import TURN
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools, Ints
from worldgen.timeline import Timeline
from worldgen.world import (
    DEFAULT_CELL_SIZE,
    DEFAULT_ROBOT_RADIUS,
    DEFAULT_ROBOT_SPEED,
    Robot,
    World,
)


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
        robot: What else that robot is: its body, its drive, and what counts as arriving; ``None``
            for a disc that turns on the spot and touches its target. Places and numbers in it are
            ignored.

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
    robot: Robot | None = None

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
        rest = ("marks", "timeline", "cell_size", "robot_radius", "robot_speed", "robot")
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

    def border(self, cells: int = 1) -> Piece:
        """Add a solid border around the piece."""
        cells = whole("border", cells, 0, MAX_SIDE)
        width = self.width + 2 * cells
        height = self.height + 2 * cells
        check_size("border", width, height)
        numbers = np.pad(self._numbers(), cells, constant_values=-1)
        marks = moved(self.marks, lambda x, y: (x + cells, y + cells), width, height)
        inner = self._taken(numbers, marks)
        ring = numbers < 0
        return replace(inner, solid=inner.solid | ring, mask=inner.mask | ring)

    # Change the start and the target.

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
            outside: What to do if the piece sticks out of the host: ``refuse`` raises, and
                ``clip`` cuts it off.
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
        check_choice("outside", outside, ("refuse", "clip"))
        corner = corner_of(self, piece, at, anchor, margin, seed)
        return put_down(self, piece, corner, how, outside, {START: start, TARGET: target})

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
        robot = replace(self.robot or USUAL_ROBOT, radius=radius, speed=speed)
        walls = np.asarray(self.solid | ~self.mask)
        return world_of(walls, self.marks, self.timeline, robot, cell_size, seed)

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
