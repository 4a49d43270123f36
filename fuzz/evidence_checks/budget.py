"""``stalled`` and ``timeout``: the budget is spent, and no loop is proved.

A robot has timed out if the second half of the budget brought a new cell, else it has stalled.
"""

from __future__ import annotations

import numpy as np

from fuzz.evidence_checks._plain import check_budget, first_new_cell_of_second_half
from sim.evidence import BudgetEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.support.arrays import Bools
from worldgen.world import World

_SAME_PLACE = 1e-7  # cells, a millionth of the thesis's pixels
_SAME_HEADING = 1e-6  # rad
_ROUNDING = 1e-9  # relative difference between what was measured in pixels and in metres
_SLIGHT = 2e-14  # relative change of a memory that is no more than rounding
_SMALLEST = 1e-13  # change that is no more than rounding in any number
_PERIODS = 4  # periods that a drifting run must show


def check_stalled(world: World, trace: Trace, evidence: BudgetEvidence, motion: Motion) -> str:
    """Check that the second half of the run enters no cell that the first half has not entered.

    Also check that the budget is the stated multiple of the witness's time and, if stated in the
    evidence, how the run stalls:

    - ``drifting``: from ``entry`` to the end, poses recur after ``period`` steps at least four
      times, but not in every bit.
    - ``confined``: they do not.
    - ``memory_drift``: poses recur in every bit, and the memory in all but the last bits.
    - ``box``: columns and rows of cells that the second half covers.
    """
    fresh = first_new_cell_of_second_half(world, trace)
    if fresh:
        return f"cell {fresh} is entered for the first time in the second half"
    # Files written by older versions do not state how the run stalls.
    kind = evidence.kind
    if kind is None:
        wrong = "" if evidence.memory_drift is None else _check_memory(trace, evidence)
        return wrong or check_budget(world, trace, evidence)
    half = trace.steps // 2
    if kind == "drifting":
        wrong = _check_drift(world, trace, evidence.entry or 0, evidence.period or 0)
    else:
        period = _period(world, trace, half)
        wrong = f"poses recur every {period} steps, so the run drifts" if period else ""
    wrong = wrong or _check_box(world, trace, half, evidence.box)
    return wrong or check_budget(world, trace, evidence)


def check_timeout(world: World, trace: Trace, evidence: BudgetEvidence, motion: Motion) -> str:
    """Check that the second half has a new cell (else it is ``stalled``), and the budget."""
    if not first_new_cell_of_second_half(world, trace):
        return "the second half has no new cell"
    return check_budget(world, trace, evidence)


def _check_drift(world: World, trace: Trace, entry: int, period: int) -> str:
    if period < 1 or not trace.steps // 2 <= entry <= trace.steps - _PERIODS * period:
        return f"a period of {period} steps is not shown {_PERIODS} times after step {entry}"
    if not _comes_back(world, trace, entry, period):
        return f"after step {entry} poses do not recur every {period} steps"
    states = trace.states[entry:]
    if trace.complete and np.array_equal(states[period:], states[:-period]):
        return f"the complete state recurs every {period} steps, which is a loop"
    return ""


def _check_memory(trace: Trace, evidence: BudgetEvidence) -> str:
    """Check that everything recurs from the entry on, but for a memory that changes slightly."""
    entry = evidence.entry or 0
    period = evidence.period or 0
    number, drift = evidence.memory_drift or (0, 0.0)
    if period < 1 or not trace.steps // 2 <= entry <= trace.steps - _PERIODS * period:
        return f"a period of {period} steps is not shown {_PERIODS} times after step {entry}"
    moves = trace.moves[entry:]
    if not np.array_equal(moves[period:], moves[:-period]):
        return f"after step {entry} poses do not recur every {period} steps"
    memory = trace.memories[entry:]
    with np.errstate(invalid="ignore"):
        change = memory[period:] - memory[:-period]
    change = np.where(memory[period:] == memory[:-period], 0.0, change)
    slight = np.maximum(_SLIGHT * np.abs(memory[:-period]), _SMALLEST)
    if not (np.abs(change) <= slight).all():
        return "the memory changes by more than rounding errors"
    own = np.abs(change[:, number]) if 0 <= number < change.shape[1] else np.zeros(0)
    if not own.any() or own.max() < np.abs(change).max():
        return f"memory[{number}] is not the number that changes most"
    if not np.isclose(own.max(), abs(drift) * period, rtol=_ROUNDING, atol=0.0):
        return f"memory[{number}] does not change by {drift:g} a step"
    return ""


def _comes_back(world: World, trace: Trace, entry: int, period: int) -> bool:
    """Return True if poses recur every ``period`` steps after ``entry``, except for rounding."""
    return bool(_near(world, trace, slice(entry, -period), slice(entry + period, None)).all())


def _near(world: World, trace: Trace, one: slice | int, two: slice | int) -> Bools:
    """Return which poses of ``one`` equal those of ``two``, except for rounding."""
    apart = (
        np.maximum(np.abs(trace.x[one] - trace.x[two]), np.abs(trace.y[one] - trace.y[two]))
        / world.cell_size
    )
    turned = np.abs((trace.heading[one] - trace.heading[two] + np.pi) % (2 * np.pi) - np.pi)
    near: Bools = (apart < _SAME_PLACE * (1 + _ROUNDING)) & (
        turned < _SAME_HEADING * (1 + _ROUNDING)
    )
    return near


def _period(world: World, trace: Trace, half: int) -> int:
    """Return a period with which the last poses recur over most of the second half; 0 if none."""
    last = trace.steps
    for state in np.flatnonzero(_near(world, trace, slice(half, last), last))[::-1]:
        period = last - half - int(state)
        # A longer period could not be shown often enough.
        if _PERIODS * period > (last - half) // 2:
            break
        if _comes_back(world, trace, last - _PERIODS * period - (last - half) // 4, period):
            return period
    return 0


def _check_box(world: World, trace: Trace, half: int, box: tuple[int, int] | None) -> str:
    """Check the size of the box that the second half covers, in cells.

    A place on the line between two cells may count for either, since it was measured in pixels.
    """
    if box is None:
        return "the evidence has no box of columns and rows"
    for places, claimed in zip((trace.x, trace.y), box, strict=True):
        cells = places[half:] / world.cell_size
        low = float(cells.min())
        high = float(cells.max())
        # Count the cells with both ends rounded outwards, and inwards.
        most = np.floor(high + _ROUNDING) - np.floor(low - _ROUNDING) + 1
        least = np.floor(high - _ROUNDING) - np.floor(low + _ROUNDING) + 1
        if not least <= claimed <= most:
            return f"the second half spans cells {least:g} to {most:g} on an axis, not {claimed}"
    return ""
