"""Copy cells and their events between grids, and combine two pieces."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Bools, Bytes, Floats, Ints
from worldgen.timeline import CellState, Timeline

How: TypeAlias = Literal["over", "union", "intersection", "carve"]

# Limit per piece: tiling a fire repeats its events and could use up all memory.
MAX_EVENTS = 4_000_000
# State of a cell that is outside a piece's mask.
SILENT = 3
_FREE, _SOLID, _BURNING = (
    int(state) for state in (CellState.FREE, CellState.SOLID, CellState.BURNING)
)
_F = _FREE
_S = _SOLID
_B = _BURNING

# State of a combined cell, indexed by the host's state (free, solid, burning, silent) and then by
# the piece's (free, solid, burning). Where the host is undefined, only the piece counts.
HOW: dict[How, Bytes] = {
    "over": np.array([[_F, _S, _B], [_F, _S, _B], [_F, _S, _B], [_F, _S, _B]], np.uint8),
    "union": np.array([[_F, _S, _B], [_S, _S, _S], [_B, _S, _B], [_F, _S, _B]], np.uint8),
    "intersection": np.array([[_F, _F, _B], [_F, _S, _B], [_B, _B, _B], [_F, _S, _B]], np.uint8),
    "carve": np.array(
        [[_F, _F, _F], [_S, _F, _S], [_B, _F, _B], [SILENT, SILENT, SILENT]], np.uint8
    ),
}


class Events(NamedTuple):
    """Hold changes of cells as arrays, which are easier to move around than a ``Timeline``.

    Args:
        cells: (n,) int64, flat cell indices.
        times: (n,) float64, s.
        states: (n,) uint8, the state that each cell changes to.
    """

    cells: Ints
    times: Floats
    states: Bytes

    @classmethod
    def of(cls, line: Timeline, width: int) -> Events:
        """Convert a timeline over a grid of ``width`` columns."""
        return cls(line.iy * width + line.ix, line.times, line.states)

    def only(self, chosen: Bools | Ints) -> Events:
        """Return the events that a mask or an index array selects."""
        return Events(self.cells[chosen], self.times[chosen], self.states[chosen])

    def with_(self, others: Events) -> Events:
        """Return these events followed by others."""
        return Events(
            np.concatenate((self.cells, others.cells)),
            np.concatenate((self.times, others.times)),
            np.concatenate((self.states, others.states)),
        )


def timeline_of(events: Events, width: int) -> Timeline:
    """Convert events that are sorted by time to a timeline over ``width`` columns."""
    iy, ix = np.divmod(events.cells, width)
    return Timeline(events.times, ix, iy, events.states)


def settled(events: Events, solid: Bools) -> Events:
    """Sort events by time, then by cell, and drop those that have no effect.

    If a cell has several events at the same time, only the last one is kept. An event that sets a
    cell to the state it is already in is dropped.
    """
    # The sort is stable, so the last of several events of a cell and time is the one to keep.
    ordered = events.only(np.lexsort((events.times, events.cells)))
    same_cell = ordered.cells[1:] == ordered.cells[:-1]
    ordered = ordered.only(
        np.append(~(same_cell & (ordered.times[1:] == ordered.times[:-1])), True)[: len(events[0])]
    )

    # Find each cell's state just before its event: the previous event's, or the initial one.
    before = solid.ravel()[ordered.cells].astype(np.uint8)
    follows = np.flatnonzero(ordered.cells[1:] == ordered.cells[:-1]) + 1
    before[follows] = ordered.states[follows - 1]
    ordered = ordered.only(ordered.states != before)
    return ordered.only(np.lexsort((ordered.cells, ordered.times)))


def taken(events: Events, source: Ints, cells: int) -> Events:
    """Return the events of a grid whose cells were copied from another grid.

    Args:
        events: Events of the old grid.
        source: (n,) the flat old cell that each new cell was copied from, or -1.
        cells: Number of cells in the old grid.

    Raises:
        InvalidParameter: If there are more than ``MAX_EVENTS`` events.
    """
    if not len(events.cells):
        return events
    # List the new cells whose old cell changes, sorted by old cell, so that the copies of each old
    # cell are one range that a binary search finds.
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
            "repeat fewer parts that change",
            changes=int(count.sum()),
            most=MAX_EVENTS,
        )

    # Repeat each event once per copy of its cell.
    which = np.repeat(np.arange(len(events.cells)), count)
    offset = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    return Events(new[first[which] + offset], events.times[which], events.states[which])


def state_of_two(host: Bools, host_mask: Bools, piece: Bools, how: How) -> Bools:
    """Return which cells are solid at time 0 after a piece is placed on a host."""
    said = np.where(host_mask, host.astype(np.uint8), np.uint8(SILENT))
    return np.asarray(HOW[how][said, piece.astype(np.uint8)] == _SOLID)


class PlacedCells(NamedTuple):
    """A piece's contents, in the frame of its host.

    Args:
        events: Its events.
        solid: (height, width) bool, its solid cells at time 0.
        mask: (height, width) bool, the cells that it determines.
    """

    events: Events
    solid: Bools
    mask: Bools


def put_together(host: PlacedCells, piece: PlacedCells, how: How) -> Events:
    """Return the events of a host with a piece placed on it, sorted by time.

    Args:
        host: The host.
        piece: The piece, in the host's frame.
        how: How the two are combined.
    """
    # Outside the piece, the host's events stay as they are.
    covered = piece.mask.ravel()
    above = piece.events.only(covered[piece.events.cells])
    own = host.events.only(~covered[host.events.cells])
    under = host.events.only(covered[host.events.cells])

    # "over" replaces the host, so its events under the piece are simply dropped.
    if how != "over" and len(under.cells) + len(above.cells):
        host_says = np.where(host.mask, host.solid.astype(np.uint8), np.uint8(SILENT)).ravel()
        above = _merged(under, above, host_says, piece.solid.ravel().astype(np.uint8), how)
    both = own.with_(above)
    return both.only(np.argsort(both.times, kind="stable"))


def _merged(host: Events, piece: Events, host_says: Bytes, piece_says: Bytes, how: How) -> Events:
    """Combine the events of cells that both host and piece cover.

    The result has one event for each event of either, with the combination of both latest states.

    Args:
        host: The host's events in these cells.
        piece: The piece's events in these cells.
        host_says: (cells of the grid,) uint8, the host's states at time 0; ``SILENT`` outside its
            mask.
        piece_says: (cells of the grid,) uint8, the piece's states at time 0.
        how: How the two are combined.
    """
    # Sort by cell, then by time, and remember where each cell's events begin.
    both = host.with_(piece)
    of_piece = np.repeat([False, True], [len(host.cells), len(piece.cells)])
    order = np.lexsort((both.times, both.cells))
    both = both.only(order)
    of_piece = of_piece[order]
    number = np.arange(len(order))
    begins = np.searchsorted(both.cells, both.cells, "left")

    # For each event, find the state that host or piece has by then: the state of its last event in
    # the cell, or its initial state before the first one.
    def latest(own: Bools, at_first: Bytes) -> Bytes:
        event = np.maximum.accumulate(np.where(own, number, -1))
        return np.where(event >= begins, both.states[event], at_first[both.cells])

    states = HOW[how][latest(~of_piece, host_says), latest(of_piece, piece_says)]
    return Events(both.cells, both.times, states)
