"""``stalled``: no proof of a loop, but the second half of the budget brought no new cell."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fuzz.evidence_checks._plain import check_budget, first_new_cell_of_second_half
from sim.evidence import BudgetEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

__all__ = ["check_stalled"]

_SAME_PLACE = 1e-7  # cells, a millionth of the thesis's pixels
_SAME_HEADING = 1e-6  # rad
_ROUNDING = 1e-9  # share by which what was measured in pixels may differ in metres
_PERIODS = 4  # periods that a drifting run must show


def check_stalled(world: World, trace: Trace, evidence: BudgetEvidence, motion: Motion) -> str:
    """Check that each state of the second half is in a cell that a state of the first half has seen.

    That the budget is the stated multiple of the witness's time is judged too; and, where the
    evidence says it, in what manner the run stalls. ``drifting``: poses come back after ``period``
        steps, from ``entry`` to the end, four times
    at least, and not in every bit. ``confined``: they do not. ``box``: columns and rows of cells of
        the second half.
    """
    fresh = first_new_cell_of_second_half(world, trace)
    if fresh:
        return f"cell {fresh} is entered for the first time in the second half"
    kind = evidence.kind
    if kind is None:
        return check_budget(world, trace, evidence)
    half = trace.steps // 2
    if kind == "drifting":
        wrong = _check_drift(world, trace, evidence.entry or 0, evidence.period or 0)
    else:
        period = _period(world, trace, half)
        wrong = f"poses come back every {period} steps, so the run drifts" if period else ""
    wrong = wrong or _check_box(world, trace, half, evidence.box)
    return wrong or check_budget(world, trace, evidence)


def _check_drift(world: World, trace: Trace, entry: int, period: int) -> str:
    if period < 1 or not trace.steps // 2 <= entry <= trace.steps - _PERIODS * period:
        return f"a period of {period} steps is not shown {_PERIODS} times after step {entry}"
    if not _comes_back(world, trace, entry, period):
        return f"after step {entry} poses do not come back every {period} steps"
    states = trace.states[entry:]
    if trace.complete and np.array_equal(states[period:], states[:-period]):
        return f"the complete state comes back every {period} steps, which is a loop"
    return ""


def _comes_back(world: World, trace: Trace, entry: int, period: int) -> bool:
    """Whether poses from ``entry`` on come back after ``period`` steps but for rounding."""
    return bool(_near(world, trace, slice(entry, -period), slice(entry + period, None)).all())


def _near(world: World, trace: Trace, one: slice | int, two: slice | int) -> npt.NDArray[np.bool_]:
    """Which poses of ``one`` are those of ``two`` but for rounding."""
    apart = (
        np.maximum(np.abs(trace.x[one] - trace.x[two]), np.abs(trace.y[one] - trace.y[two]))
        / world.cell_size
    )
    turned = np.abs((trace.heading[one] - trace.heading[two] + np.pi) % (2 * np.pi) - np.pi)
    near: npt.NDArray[np.bool_] = (apart < _SAME_PLACE * (1 + _ROUNDING)) & (
        turned < _SAME_HEADING * (1 + _ROUNDING)
    )
    return near


def _period(world: World, trace: Trace, half: int) -> int:
    """A period in which the last poses come back, shown from a quarter of the second half at most on; 0 if none."""
    last = trace.steps
    for state in np.flatnonzero(_near(world, trace, slice(half, last), last))[::-1]:
        period = last - half - int(state)
        if _PERIODS * period > (last - half) // 2:
            break
        if _comes_back(world, trace, last - _PERIODS * period - (last - half) // 4, period):
            return period
    return 0


def _check_box(world: World, trace: Trace, half: int, box: tuple[int, int] | None) -> str:
    """A place on the line between two cells counts for either, since it was measured in pixels."""
    if box is None:
        return "the evidence has no box of columns and rows"
    for places, claimed in zip((trace.x, trace.y), box, strict=True):
        cells = places[half:] / world.cell_size
        low = float(cells.min())
        high = float(cells.max())
        most = np.floor(high + _ROUNDING) - np.floor(low - _ROUNDING) + 1
        least = np.floor(high - _ROUNDING) - np.floor(low + _ROUNDING) + 1
        if not least <= claimed <= most:
            return f"the second half is in {least:g} to {most:g} cells on an axis, not in {claimed}"
    return ""
