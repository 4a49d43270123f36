"""Changes of cells over time: fire, falling debris, openings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from worldgen.domain import LATEST
from worldgen.errors import InvalidWorld
from worldgen.support.arrays import Bools, Bytes, Floats, Ints
from worldgen.support.frozen import HoldsFrozen, frozen

__all__ = ["CellState", "Event", "StateSpans", "Timeline"]


class CellState(IntEnum):
    """The state of a cell. A burning cell does not stop anything, but no robot may touch it."""

    FREE = 0
    SOLID = 1
    BURNING = 2

    @property
    def word(self) -> str:
        """The word used in files."""
        return self.name.lower()


_STATES = tuple(CellState)


class Event(NamedTuple):
    """A change: from ``time`` (s, inclusive) on, the cell (``iy``, ``ix``) has ``state``."""

    time: float
    ix: int
    iy: int
    state: CellState


class StateSpans(NamedTuple):
    """How long changing cells are in which state, sorted by cell and then by time.

    Each span lasts from ``since`` until just before ``until``, and is longer than 0 s.

    Args:
        cells: (n,) int64, ``iy * width + ix``.
        since: (n,) float64, s; -inf for a cell's first state.
        until: (n,) float64, s; inf for its last state.
        states: (n,) uint8, values of :class:`CellState`.
    """

    cells: Ints
    since: Floats
    until: Floats
    states: Bytes


@dataclass(frozen=True, eq=False)
class Timeline(HoldsFrozen):
    """Events in order of time, as parallel arrays.

    Args:
        times: (n,) float64, s, 0 to ``worldgen.domain.LATEST``, never decreasing.
        ix: (n,) int64, column.
        iy: (n,) int64, row, 0 the lowest y.
        states: (n,) uint8, values of :class:`CellState`.
    """

    times: Floats = field(default_factory=lambda: np.zeros(0))
    ix: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    iy: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    states: Bytes = field(default_factory=lambda: np.zeros(0, np.uint8))

    def __post_init__(self) -> None:
        # Convert first: the checks below rely on arrays of these types.
        for name, dtype in (
            ("times", np.float64),
            ("ix", np.int64),
            ("iy", np.int64),
            ("states", np.uint8),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), dtype))
        if self.times.ndim != 1 or len({column.shape for column in self.columns}) != 1:
            raise InvalidWorld(
                "wrong-shape",
                "timeline: times, ix, iy and states must be one-dimensional and of equal length",
            )
        if not np.isfinite(self.times).all() or (self.times < 0).any():
            raise InvalidWorld(
                "not-finite", "timeline: every time must be a finite number of seconds, 0 or later"
            )
        # Later times would overflow when the core counts them in its smallest unit.
        if (self.times > LATEST).any():
            raise InvalidWorld(
                "out-of-range",
                "timeline: {name} {value:g} s of a change is later than {high:g} s",
                "make it earlier",
                name="time",
                value=self.times.max(),
                high=LATEST,
            )
        if (np.diff(self.times) < 0).any():
            at = int(np.argmax(np.diff(self.times) < 0)) + 1
            raise InvalidWorld(
                "not-sorted",
                "timeline: event {at} at {time} s follows one at {previous} s",
                "sort the events by time",
                at=at,
                time=self.times[at],
                previous=self.times[at - 1],
            )
        if self.states.size and int(self.states.max()) > CellState.BURNING:
            raise InvalidWorld("unknown-name", "timeline: a state is one of free, solid, burning")

    @classmethod
    def of(cls, events: Iterable[Event | tuple[float, int, int, CellState]]) -> Timeline:
        """Build a timeline from events in any order; simultaneous events keep their order."""
        ordered = sorted(events, key=lambda event: event[0])
        return cls(*map(np.array, zip(*ordered, strict=True))) if ordered else cls()

    @property
    def columns(self) -> tuple[Floats, Ints, Ints, Bytes]:
        """Times, columns, rows and states, as for the class."""
        return self.times, self.ix, self.iy, self.states

    @property
    def last_time(self) -> float:
        """Time of the last change, s; 0 if nothing ever changes."""
        return float(self.times[-1]) if len(self) else 0.0

    def count_until(self, time: float) -> int:
        """Return the number of events up to and including a time, s."""
        return int(np.searchsorted(self.times, time, side="right"))

    def only(self, kept: Bools | slice) -> Timeline:
        """Return the timeline of the events marked in ``kept``, (n,) bool, or in a slice."""
        return Timeline(self.times[kept], self.ix[kept], self.iy[kept], self.states[kept])

    def until(self, time: float) -> Timeline:
        """Return the timeline up to and including a time, s."""
        return self.only(np.s_[: self.count_until(time)])

    def after(self, time: float) -> Timeline:
        """Return the timeline after a time, s."""
        return self.only(np.s_[self.count_until(time) :])

    def in_cell(self, ix: int, iy: int) -> Timeline:
        """Return the timeline of one cell."""
        return self.only((self.ix == ix) & (self.iy == iy))

    def without(self, first: int, count: int = 1) -> Timeline:
        """Return the timeline without ``count`` events from ``first`` on."""
        kept = np.ones(len(self), np.bool_)
        kept[first : first + count] = False
        return self.only(kept)

    def with_time(self, event: int, time: float) -> Timeline:
        """Return the timeline in which one event happens at another time, s.

        Raises:
            InvalidWorld: If the events would no longer be in order.
        """
        times = self.times.copy()
        times[event] = time
        return replace(self, times=times)

    def moved(self, to: Callable[[Ints, Ints], tuple[Ints, Ints]]) -> Timeline:
        """Return the timeline with its events in other cells.

        Args:
            to: Maps columns and rows, (n,) int64, to the new columns and rows.
        """
        ix, iy = to(self.ix, self.iy)
        return replace(self, ix=ix, iy=iy)

    def without_cells(self, first: int, count: int, axis: int) -> Timeline:
        """Return the timeline of the grid from which rows or columns were deleted.

        Args:
            first: The first row or column.
            count: Their number; those beyond move into their place.
            axis: 0 for rows, 1 for columns, as for ``numpy.delete``.
        """
        end = first + count
        place = self.ix if axis else self.iy
        left = np.where(place < end, place, place - count)
        moved = replace(self, ix=left) if axis else replace(self, iy=left)
        return moved.only((place < first) | (place >= end))

    def spans(self, walls: Bools) -> StateSpans:
        """Return how long each changing cell is in which state.

        Args:
            walls: (height, width) bool, the solid cells before the first event.
        """
        # Each changing cell has its first state until its first event.
        changing = np.flatnonzero(self.cells_that_become(shape=walls.shape))
        cells = np.concatenate([changing, self.iy * walls.shape[1] + self.ix])
        since = np.concatenate([np.full(len(changing), -np.inf), self.times])
        states = np.concatenate([walls.ravel()[changing], self.states])

        # The sort is stable: of a cell's events at one time the last one counts, and the others
        # last for 0 s.
        order = np.lexsort((since, cells))
        cells = cells[order]
        since = since[order]
        until = np.full(len(cells), np.inf)
        same = cells[1:] == cells[:-1]
        until[:-1][same] = since[1:][same]
        lasting = since < until
        return StateSpans(cells[lasting], since[lasting], until[lasting], states[order][lasting])

    def is_within(self, width: int, height: int) -> bool:
        """Return True if every event changes a cell of the grid.

        Args:
            width: Columns of the grid.
            height: Rows of the grid.
        """
        columns = (self.ix >= 0) & (self.ix < width)
        rows = (self.iy >= 0) & (self.iy < height)
        return bool((columns & rows).all())

    def cells_that_become(self, *states: CellState, shape: tuple[int, ...]) -> Bools:
        """Mark the cells of a grid that some event puts into one of ``states``.

        Args:
            *states: New states to look for; all if none are given.
            shape: Rows and columns of the grid.

        Returns:
            (rows, columns) bool.
        """
        chosen = np.isin(self.states, states) if states else np.ones(len(self), np.bool_)
        marked = np.zeros(shape, np.bool_)
        marked[self.iy[chosen], self.ix[chosen]] = True
        return marked

    def __len__(self) -> int:
        return len(self.times)

    def __iter__(self) -> Iterator[Event]:
        *places, states = (column.tolist() for column in self.columns)
        return map(Event._make, zip(*places, map(_STATES.__getitem__, states), strict=True))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Timeline):
            return NotImplemented
        return all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("times", "ix", "iy", "states")
        )

    __hash__ = None  # type: ignore[assignment]  # equal by content, and the content is an array
