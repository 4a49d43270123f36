"""Changes of cells over time: fire, falling debris, openings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.domain import LATEST
from worldgen.errors import InvalidWorld
from worldgen.support.frozen import HoldsFrozen, frozen

__all__ = ["CellState", "Event", "Timeline"]


class CellState(IntEnum):
    """The state of a cell. A burning cell does not stop anything, but no robot may touch it."""

    FREE = 0
    SOLID = 1
    BURNING = 2

    @property
    def word(self) -> str:
        """The word used in files."""
        return self.name.lower()


class Event(NamedTuple):
    """A change: from ``time`` (s, inclusive) on, the cell (``iy``, ``ix``) has ``state``."""

    time: float
    ix: int
    iy: int
    state: CellState


@dataclass(frozen=True, eq=False)
class Timeline(HoldsFrozen):
    """Events in order of time, as parallel arrays.

    Args:
        times: (n,) float64, s, 0 to ``worldgen.domain.LATEST``, never decreasing.
        ix: (n,) int64, column.
        iy: (n,) int64, row, 0 the lowest y.
        states: (n,) uint8, values of :class:`CellState`.
    """

    times: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    ix: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    iy: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    states: npt.NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))

    def __post_init__(self) -> None:
        # Convert first: the checks below rely on arrays of these types.
        for name, dtype in (
            ("times", np.float64),
            ("ix", np.int64),
            ("iy", np.int64),
            ("states", np.uint8),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), dtype))
        if not (
            self.times.ndim == 1
            and self.times.shape == self.ix.shape == self.iy.shape == self.states.shape
        ):
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
                "timeline: event {at} at {time} s comes after one at {previous} s",
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
        return (
            cls(*(np.array([event[k] for event in ordered]) for k in range(4)))
            if ordered
            else cls()
        )

    @property
    def last_time(self) -> float:
        """Time of the last change, s; 0 if nothing ever changes."""
        return float(self.times[-1]) if len(self) else 0.0

    def count_until(self, time: float) -> int:
        """Return the number of events up to and including a time, s."""
        return int(np.searchsorted(self.times, time, side="right"))

    def only(self, kept: npt.NDArray[np.bool_]) -> Timeline:
        """Return the timeline of the events marked in ``kept``, (n,) bool."""
        return Timeline(self.times[kept], self.ix[kept], self.iy[kept], self.states[kept])

    def is_within(self, width: int, height: int) -> bool:
        """Return True if every event changes a cell of the grid.

        Args:
            width: Columns of the grid.
            height: Rows of the grid.
        """
        columns = (self.ix >= 0) & (self.ix < width)
        rows = (self.iy >= 0) & (self.iy < height)
        return bool((columns & rows).all())

    def cells_that_become(
        self, *states: CellState, shape: tuple[int, ...]
    ) -> npt.NDArray[np.bool_]:
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
        for time, ix, iy, state in zip(self.times, self.ix, self.iy, self.states, strict=True):
            yield Event(float(time), int(ix), int(iy), CellState(int(state)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Timeline):
            return NotImplemented
        return all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("times", "ix", "iy", "states")
        )

    __hash__ = None  # type: ignore[assignment]  # equal by content, and the content is an array
