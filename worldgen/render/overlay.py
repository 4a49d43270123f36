"""Plain data about a robot's run, so that rendering does not depend on a simulator."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, get_args

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Bools, Floats

MarkKind = Literal["bump", "tunnel", "overlap", "end"]


@dataclass(frozen=True, slots=True)
class EventMark:
    """An event at a place.

    Args:
        x: x, m.
        y: y, m.
        kind: ``bump`` (the robot touched a wall), ``tunnel`` (its centre passed through one),
            ``overlap`` (its body cut one) or ``end`` (the run stopped here).
        heading: Heading of the robot there, rad, if its outline is to be drawn.

    Raises:
        InvalidParameter: If the place isn't finite or the kind is unknown.
    """

    x: float
    y: float
    kind: MarkKind
    heading: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in get_args(MarkKind):
            raise InvalidParameter(
                "unknown-name",
                "mark kind {kind!r} is not one of {known!l}",
                kind=self.kind,
                known=list(get_args(MarkKind)),
            )
        if not (math.isfinite(self.x) and math.isfinite(self.y)):
            raise InvalidParameter(
                "not-finite",
                "mark at ({x}, {y}) m: both must be finite numbers",
                x=self.x,
                y=self.y,
            )


@dataclass(frozen=True, slots=True)
class WallPenetration:
    """A wall cell that the robot entered.

    Args:
        ix: Column.
        iy: Row.
        time: Time of the first entry, s.
        place: Where it entered, x and y in m, for the cell that the verdict names.
        is_entered: False if it is not a wall that the robot went into, but a cell that caught or
            burned it, or that it must not touch.
    """

    ix: int
    iy: int
    time: float
    place: tuple[float, float] | None = None
    is_entered: bool = True


@dataclass(frozen=True, slots=True)
class Shove:
    """A displacement of the robot that its wheels did not cause.

    Args:
        x: Where it begins, m; for a place that pushes, a point of its cell.
        y: m.
        dx: m.
        dy: m.
    """

    x: float
    y: float
    dx: float
    dy: float


@dataclass(frozen=True, slots=True)
class Disturbances:
    """Everything that disturbs a robot besides walls.

    Args:
        pushes: Pushes that happened, with their actual lengths.
        places: Cells that push the robot when it is in them.
        decoys: Where other sources of the signal are, x and y in m.
        drift_heading: Direction in which the floor carries the robot, rad; ``None`` if it is level.
    """

    pushes: tuple[Shove, ...] = ()
    places: tuple[Shove, ...] = ()
    decoys: tuple[tuple[float, float], ...] = ()
    drift_heading: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Remembered:
    """A robot's memory of the world at the end of a run; lengths in m.

    Args:
        fills: (n, 5) rectangles, x and y of two corners, and how strongly to tint them, 0 to 1.
        blocked: (n, 4) lines that it takes for walls, x and y of both ends.
        edges: (n, 4) edges of a graph, same.
        plan: (n, 2) corners of the path that it was about to drive.
        nodes: (n, 2) places without a name.
        places: Places by name.
    """

    fills: Floats
    blocked: Floats
    edges: Floats
    plan: Floats
    nodes: Floats
    places: Mapping[str, tuple[float, float]]

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to draw."""
        tables = (self.fills, self.blocked, self.edges, self.plan, self.nodes)
        return not self.places and not any(map(len, tables))


@dataclass(frozen=True, eq=False)
class Trail:
    """The path of the robot's centre.

    Args:
        x: (n,) float64, m, at least one point; straight lines between the points.
        y: (n,) float64, m.
        loop_from: Index of the point where the endless cycle begins; the rest is one or more
            repetitions of the cycle. ``None`` if the run has none.
        stays_from: Index of the point from which a run without a proved cycle reaches nothing new.
            ``None`` if it has a cycle, or reaches something new until it ends.
        marks: Events along the path.
        pierced: Wall cells that the robot entered.
        disturbances: What disturbed the robot.
        missed: (height, width) bool, cells of a coverage task that the robot missed;
            ``None`` for another task.
        memory: The robot's memory at the end; ``None`` if it does not show it.
        blocked_by: The robots, numbered from 1, that this one drives into forever.
        named: Cells (ix, iy) that the text next to the picture names.
        headings: (n,) float64, rad, at the points; ``None`` if unknown. A body that is not a disc is
            drawn with them, and where the robot ends.
        name: What a legend calls it among several.

    Raises:
        InvalidParameter: If the arrays do not match, are empty or not finite, or the index is out
            of range.
    """

    x: Floats
    y: Floats
    loop_from: int | None = None
    marks: Sequence[EventMark] = field(default_factory=tuple)
    pierced: Sequence[WallPenetration] = ()
    disturbances: Disturbances = Disturbances()
    missed: Bools | None = None
    memory: Remembered | None = None
    blocked_by: tuple[int, ...] = ()
    named: tuple[tuple[int, int], ...] = ()
    headings: Floats | None = None
    name: str = ""
    stays_from: int | None = None

    def __post_init__(self) -> None:
        # Copy and lock the arrays: the caller may change its own afterwards.
        for name in ("x", "y") if self.headings is None else ("x", "y", "headings"):
            array = np.array(getattr(self, name), np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "marks", tuple(self.marks))
        shapes = {self.x.shape, self.y.shape} | (
            set() if self.headings is None else {self.headings.shape}
        )
        if self.x.ndim != 1 or len(shapes) > 1 or not len(self.x):
            raise InvalidParameter(
                "wrong-shape",
                "trail: x has shape {x_shape}, y has {y_shape}",
                "use two flat arrays of equal length",
                x_shape=self.x.shape,
                y_shape=self.y.shape,
            )
        if not (np.isfinite(self.x).all() and np.isfinite(self.y).all()):
            raise InvalidParameter("not-finite", "trail: x and y must be finite numbers of metres")
        for name in ("loop_from", "stays_from"):
            row = getattr(self, name)
            if row is not None and not 0 <= row < len(self.x):
                raise InvalidParameter(
                    "out-of-range",
                    "trail: {name}={value} is outside 0 to {last}",
                    name=name,
                    value=row,
                    last=len(self.x) - 1,
                )

    @property
    def points(self) -> Floats:
        """The whole path, (n, 2) float64, m."""
        return np.column_stack((self.x, self.y))

    @property
    def repeats_from(self) -> int | None:
        """Index of the point from which the robot repeats itself, proved or not; ``None`` if it doesn't."""
        return self.stays_from if self.loop_from is None else self.loop_from

    @property
    def approach(self) -> Floats:
        """The path until the robot repeats itself, (k, 2) float64, m; all of it if it doesn't."""
        first = self.repeats_from
        return self.points if first is None else self.points[: first + 1]

    @property
    def loop(self) -> Floats:
        """The path on which the robot repeats itself, (k, 2) float64, m; no points if it doesn't."""
        first = self.repeats_from
        return self.points[len(self.x) :] if first is None else self.points[first:]

    def places(self, kind: MarkKind) -> Floats:
        """Return the places of marks of one kind, a (k, 2) float64 array in m."""
        return np.array(
            [(mark.x, mark.y) for mark in self.marks if mark.kind == kind], np.float64
        ).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Drive:
    """What one robot did, and when.

    Args:
        name: Name of the robot.
        trail: Its path.
        times: (n,) float64, s: the time at each of the trail's points; never decreases.
        headings: (k,) float64, rad: after each step, the first at the start.
        time_step: Time step, s.

    Raises:
        InvalidParameter: If there are not as many times as points, or there is no heading.
    """

    name: str
    trail: Trail
    times: Floats
    headings: Floats
    time_step: float

    def __post_init__(self) -> None:
        if self.times.shape != self.trail.x.shape or not len(self.headings):
            raise InvalidParameter(
                "wrong-length",
                "drive: {times} times and {headings} headings for {points} points",
                "use a time for each point, and at least one heading",
                times=len(self.times),
                points=len(self.trail.x),
                headings=len(self.headings),
            )

    @property
    def end(self) -> float:
        """Time at which the recording ends, s."""
        return float(self.times[-1])

    def moment(self, time: float) -> float:
        """Map a later time to the recorded time that represents it, s.

        A loop repeats forever; any other robot stays in place.
        """
        if time <= self.end or self.trail.loop_from is None:
            return min(time, self.end)
        entry = float(self.times[self.trail.loop_from])
        return entry + (time - entry) % (self.end - entry) if self.end > entry else self.end

    def pose(self, time: float) -> tuple[float, float, float]:
        """Return the place, m, and the heading, rad, at a recorded time."""
        x, y = (
            float(np.interp(time, self.times, values)) for values in (self.trail.x, self.trail.y)
        )
        step = min(int(time / self.time_step + 1e-6), len(self.headings) - 1)
        return x, y, float(self.headings[step])


Trails: TypeAlias = Trail | Sequence[Trail] | None
"""A robot's trail, or one for each of several robots; ``None`` without a run."""


def each_trail(trails: Trails) -> tuple[Trail, ...]:
    """Return trails as a tuple."""
    if trails is None:
        return ()
    return (trails,) if isinstance(trails, Trail) else tuple(trails)


def naming(trails: Sequence[Trail], cells: Sequence[tuple[int, int]]) -> Sequence[Trail]:
    """Return the same trails for a picture next to a text that names some cells."""
    if not cells or not trails:
        return trails
    return [replace(trails[0], named=tuple(cells)), *trails[1:]]
