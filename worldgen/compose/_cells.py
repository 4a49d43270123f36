"""Cells and their events as arrays: taken from elsewhere, or of two pieces at once."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen.timeline import CellState, Timeline

__all__ = [
    "HOW",
    "Bools",
    "Events",
    "How",
    "put_together",
    "settled",
    "state_of_two",
    "taken",
    "timeline_of",
]

Bools: TypeAlias = npt.NDArray[np.bool_]
Whole: TypeAlias = npt.NDArray[np.int64]
How: TypeAlias = Literal["over", "union", "intersection", "carve"]

MAX_EVENTS = 4_000_000  # of one piece; a repeated fire could take all memory
SILENT = 3  # for a cell of which a piece says nothing
_FREE, _SOLID, _BURNING = (
    int(state) for state in (CellState.FREE, CellState.SOLID, CellState.BURNING)
)
_F = _FREE
_S = _SOLID
_B = _BURNING

# What a cell is, by what the host says (free, solid, burning, nothing) and then the piece (free,
# solid, burning). Where the host says nothing, the piece alone counts.
HOW: dict[How, npt.NDArray[np.uint8]] = {
    "over": np.array([[_F, _S, _B], [_F, _S, _B], [_F, _S, _B], [_F, _S, _B]], np.uint8),
    "union": np.array([[_F, _S, _B], [_S, _S, _S], [_B, _S, _B], [_F, _S, _B]], np.uint8),
    "intersection": np.array([[_F, _F, _B], [_F, _S, _B], [_B, _B, _B], [_F, _S, _B]], np.uint8),
    "carve": np.array(
        [[_F, _F, _F], [_S, _F, _S], [_B, _F, _B], [SILENT, SILENT, SILENT]], np.uint8
    ),
}


class Events(NamedTuple):
    """Changes of cells: flat cells (n,) int64, times (n,) float64, s, and states (n,) uint8."""

    cells: Whole
    times: npt.NDArray[np.float64]
    states: npt.NDArray[np.uint8]

    @classmethod
    def of(cls, line: Timeline, width: int) -> Events:
        """The events of a timeline over a grid of ``width`` columns."""
        return cls(line.iy * width + line.ix, line.times, line.states)

    def only(self, chosen: Bools | Whole) -> Events:
        """Some of the events."""
        return Events(self.cells[chosen], self.times[chosen], self.states[chosen])

    def with_(self, others: Events) -> Events:
        """These and others."""
        return Events(
            np.concatenate((self.cells, others.cells)),
            np.concatenate((self.times, others.times)),
            np.concatenate((self.states, others.states)),
        )


def timeline_of(events: Events, width: int) -> Timeline:
    """The timeline of events in order of time, over a grid of ``width`` columns."""
    iy, ix = np.divmod(events.cells, width)
    return Timeline(events.times, ix, iy, events.states)


def settled(events: Events, solid: Bools) -> Events:
    """In order of time, then of place; of one cell and time the last.

    None that says what already is.
    """
    ordered = events.only(np.lexsort((events.times, events.cells)))
    same_cell = ordered.cells[1:] == ordered.cells[:-1]
    ordered = ordered.only(
        np.append(~(same_cell & (ordered.times[1:] == ordered.times[:-1])), True)[: len(events[0])]
    )
    before = solid.ravel()[ordered.cells].astype(np.uint8)
    follows = np.flatnonzero(ordered.cells[1:] == ordered.cells[:-1]) + 1
    before[follows] = ordered.states[follows - 1]
    ordered = ordered.only(ordered.states != before)
    return ordered.only(np.lexsort((ordered.cells, ordered.times)))


def taken(events: Events, source: Whole, cells: int) -> Events:
    """The events of cells that were taken from others.

    Args:
        events: Of the cells that were taken from.
        source: (n,) the flat cell that each new one was taken from, -1 for none.
        cells: How many cells there were.

    Raises:
        InvalidParameter: If there are too many.
    """
    if not len(events.cells):
        return events
    changes = np.zeros(cells, dtype=np.bool_)
    changes[events.cells] = True
    new = np.flatnonzero((source >= 0) & changes[source])
    new = new[np.argsort(source[new], kind="stable")]
    first = np.searchsorted(source[new], events.cells, "left")
    count = np.searchsorted(source[new], events.cells, "right") - first
    if int(count.sum()) > MAX_EVENTS:
        raise InvalidParameter(
            "above-maximum",
            "{changes} changes of cells; a piece has at most {most}",
            "repeat less of what changes",
            changes=int(count.sum()),
            most=MAX_EVENTS,
        )
    which = np.repeat(np.arange(len(events.cells)), count)
    offset = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    return Events(new[first[which] + offset], events.times[which], events.states[which])


def state_of_two(host: Bools, host_mask: Bools, piece: Bools, how: How) -> Bools:
    """Whether cells are solid at the beginning, where a piece is put on a host."""
    said = np.where(host_mask, host.astype(np.uint8), np.uint8(SILENT))
    return np.asarray(HOW[how][said, piece.astype(np.uint8)] == _SOLID)


def put_together(
    host: Events,
    piece: Events,
    solid: Bools,
    mask: Bools,
    piece_solid: Bools,
    says: Bools,
    how: How,
) -> Events:
    """The events of a host with a piece on it, in order of time.

    Args:
        host: The host's events.
        piece: The piece's, in the host's frame.
        solid: (height, width) the host's cells.
        mask: (height, width) of which the host speaks.
        piece_solid: (height, width) the piece's cells in the host's frame.
        says: (height, width) where the piece counts.
        how: How the two are put together.
    """
    covered = says.ravel()
    piece = piece.only(covered[piece.cells])
    own = host.only(~covered[host.cells])
    under = host.only(covered[host.cells])
    if how != "over" and len(under.cells) + len(piece.cells):
        host_says = np.where(mask, solid.astype(np.uint8), np.uint8(SILENT)).ravel()
        piece = _merged(under, piece, host_says, piece_solid.ravel().astype(np.uint8), how)
    both = own.with_(piece)
    return both.only(np.argsort(both.times, kind="stable"))


def _merged(
    host: Events,
    piece: Events,
    host_says: npt.NDArray[np.uint8],
    piece_says: npt.NDArray[np.uint8],
    how: How,
) -> Events:
    """What happens to cells of which host and piece speak, by both's events.

    Args:
        host: The host's events in these cells.
        piece: The piece's.
        host_says: (cells of the grid,) states at the beginning, ``SILENT`` where it says nothing.
        piece_says: (cells of the grid,) likewise.
        how: How the two are put together.
    """
    both = host.with_(piece)
    of_piece = np.repeat([False, True], [len(host.cells), len(piece.cells)])
    order = np.lexsort((both.times, both.cells))
    both = both.only(order)
    of_piece = of_piece[order]
    number = np.arange(len(order))
    begins = np.searchsorted(both.cells, both.cells, "left")

    def latest(own: Bools, at_first: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        event = np.maximum.accumulate(np.where(own, number, -1))
        return np.where(event >= begins, both.states[event], at_first[both.cells])

    states = HOW[how][latest(~of_piece, host_says), latest(of_piece, piece_says)]
    return Events(both.cells, both.times, states)
