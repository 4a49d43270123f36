"""Classes of failures: what two failures have in common, stable under mirror, rotation and shift."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from fuzz.contacts import KINDS, Contact, contacts, enclosure, part_of, times_round
from fuzz.crash_bucket import crash_bucket
from fuzz.oracles._plain import cell_of, integer
from sim.episode import Episode
from sim.trace import Trace
from worldgen.world import Value, World

__all__ = ["failure_class"]

_ROUNDING = 1e-6  # cells by which a limit may be passed, so that a mirrored run is on the same side of it


def failure_class(world: World, episode: Episode) -> str:
    """A short name for the kind of failure, fit for a file name; docs/failures.md says what its words mean.

    Args:
        world: Where it happened.
        episode: The run, recorded.
    """
    verdict, trace, evidence = episode.verdict, episode.trace, episode.evidence
    if verdict == "invalid-command":
        return _joined(verdict, re.sub("[^a-z]+", "-", str(evidence.get("error", "")).partition("'")[0]).strip("-"))
    if verdict == "crash":
        return _joined(verdict, crash_bucket(evidence))
    if trace is None:
        return verdict
    if verdict == "loop":
        return _joined(verdict, *_of_loop(world, trace, integer(evidence, "entry"), integer(evidence, "period")))
    if verdict in ("tunnel", "overlap"):
        cell = cell_of(evidence)
        what = "breach" if "reached" in evidence else verdict
        return _joined(what, evidence.get("cause"), part_of(world, *cell) if cell else None)
    if verdict in ("stalled", "timeout"):
        return _joined(verdict, evidence.get("kind"), *_of_second_half(world, trace))
    if verdict == "burned":
        return _joined(verdict, *_of_fire(world, trace, evidence))
    return verdict


def _of_loop(world: World, trace: Trace, entry: int, period: int) -> tuple[str, ...]:
    """Touches, their kind, what shape the path has, how far it gets, and whether that is nearer to the target."""
    last = entry + period
    touched = contacts(world, trace, entry + 1, last)
    cells = {cell for contact in touched for cell in contact.cells}
    side, path = world.cell_size, slice(entry, last + 1)
    rounds = times_round(trace.x[path] / side, trace.y[path] / side, cells)
    shape = ("turn" if _turns(trace, entry, last) else "swing", "round", "rounds")[min(rounds, 2)]
    where = _where(world, trace, touched, entry, last)
    return (
        _touches(len(touched)),
        where,
        shape,
        _extent(world, trace, entry, last),
        _progress(world, trace, entry, last),
    )


def _of_second_half(world: World, trace: Trace) -> tuple[str, ...]:
    """What is touched in the second half of a run, or shuts it in, and how far it gets there."""
    half, last = trace.steps // 2, trace.steps
    touched = contacts(world, trace, half + 1, last)
    free = "" if touched else "free"
    return free, _where(world, trace, touched, half, last), _extent(world, trace, half, last)


def _of_fire(world: World, trace: Trace, evidence: Mapping[str, Value]) -> tuple[str, ...]:
    """In which state the cell is, and whether the robot drove into it or was caught by the change."""
    step, cell = integer(evidence, "step"), cell_of(evidence)
    begun = (step - 1) * trace.time_step + 1e-9
    changes = [event for event in world.timeline if (event.ix, event.iy) == cell and event.time <= begun]
    state = str(evidence.get("state", "burning"))
    return state, "entered" if changes and changes[-1].state.word == state else "caught"


def _joined(*words: object) -> str:
    return "-".join(str(word) for word in words if word)


def _touches(count: int) -> str:
    return ("free", "1bump", "2bump", "bumps")[min(count, 3)]


def _where(world: World, trace: Trace, touched: list[Contact], first: int, last: int) -> str:
    """Of the kinds of wall touched the one that says most; else what shuts in the place nearest to the target."""
    if touched:
        return min((contact.kind for contact in touched), key=KINDS.index)
    apart = _apart(world, trace)[first : last + 1]
    nearest = first + np.flatnonzero(apart <= apart.min() + _ROUNDING)
    x, y = trace.x[nearest] / world.cell_size, trace.y[nearest] / world.cell_size
    return enclosure(world, zip(x.tolist(), y.tolist(), strict=True))


def _turns(trace: Trace, first: int, last: int) -> int:
    """Whole turns of the heading, without sign, from one state to the same state again; half a turn has no side."""
    change = np.diff(trace.heading[first : last + 1])
    wrapped = (change + math.pi) % (2 * math.pi) - math.pi
    wrapped[np.abs(wrapped) > math.pi - _ROUNDING] = 0.0
    return int(abs(float(np.sum(wrapped))) / (2 * math.pi) + _ROUNDING)


def _extent(world: World, trace: Trace, first: int, last: int) -> str:
    x, y = trace.x[first : last + 1], trace.y[first : last + 1]
    cells = max(float(np.ptp(x)), float(np.ptp(y))) / world.cell_size
    for name, limit in (("spot", 0.5), ("near", 4.0), ("wide", 16.0)):
        if cells <= limit + _ROUNDING:
            return name
    return "far"


def _progress(world: World, trace: Trace, first: int, last: int) -> str:
    """Whether these steps come nearer to the target than the start is."""
    apart = _apart(world, trace)
    return "closer" if float(apart[first : last + 1].min()) < float(apart[0]) - _ROUNDING else "away"


def _apart(world: World, trace: Trace) -> npt.NDArray[np.float64]:
    """Distance of each state from the target, cells."""
    dx, dy = (trace.x - world.target.x) / world.cell_size, (trace.y - world.target.y) / world.cell_size
    apart: npt.NDArray[np.float64] = np.sqrt(dx * dx + dy * dy)
    return apart
