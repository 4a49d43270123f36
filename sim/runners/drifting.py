"""Find what recurs in a run except for rounding: poses, or poses with a memory that drifts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from sim.evidence import BudgetEvidence
from sim.trace import Trace

# Periods that must be seen before a drift is reported.
_PERIODS = 4

# Largest change in a period that counts as rounding: some last bits of the number, or this much. A
# clock or a counter changes by far more, the rounding errors of some dozen operations by less.
_LAST_BITS = 64 * float(np.finfo(np.float64).eps)
_SMALLEST = 1e-13


def period_of(poses: npt.NDArray[Any], apart: float) -> tuple[int, int]:
    """Return the shortest period in which poses recur until the end, and the first such step.

    Args:
        poses: (n, k) the poses.
        apart: Numbers that differ by less count as equal.

    Returns:
        Zeros if there is no period.
    """
    # Candidates are periods that lead from an earlier pose back to the last one.
    near = (np.abs(poses - poses[-1]) < apart).all(axis=1)
    for last in np.flatnonzero(near[:-1])[::-1]:
        period = len(poses) - 1 - int(last)
        if _PERIODS * period > len(poses):
            break
        # Poses must recur from some entry on, for enough periods to be convincing.
        away = np.flatnonzero((np.abs(poses[period:] - poses[:-period]) >= apart).any(axis=1))
        entry = int(away[-1]) + 1 if len(away) else 0
        if len(poses) - 1 - entry >= _PERIODS * period:
            return period, entry
    return 0, 0


def with_memory_drift(evidence: BudgetEvidence, trace: Trace) -> BudgetEvidence:
    """Add to a stalled run's evidence that all but rounding in its memory recurs, if that is so."""
    half = trace.steps // 2
    if trace.memory_at < 0 or trace.steps < 2 * _PERIODS:
        return evidence
    # Pose, speed and used random numbers, all of them whole numbers.
    moves = trace.moves[half:].view(np.int64)
    period, entry = period_of(moves, 1.0)
    if not period:
        return evidence

    memory = trace.memories[half + entry :]
    # Infinities, such as a distance that is not known yet, differ by nan.
    with np.errstate(invalid="ignore"):
        change = memory[period:] - memory[:-period]
    change = np.where(memory[period:] == memory[:-period], 0.0, change)
    slight = np.maximum(_LAST_BITS * np.abs(memory[:-period]), _SMALLEST)
    # Written so that nan fails the comparison.
    if not (np.abs(change) <= slight).all() or not change.any():
        return evidence
    # A large counter changes by few of its last bits, but in each step by the same whole number.
    counts = (change == change[:1]) & (change == np.round(change)) & (change != 0.0)
    if counts.all(axis=0).any():
        return evidence
    at, number = np.unravel_index(np.argmax(np.abs(change)), change.shape)
    drift = float(change[at, number]) / period
    return replace(evidence, entry=half + entry, period=period, memory_drift=(int(number), drift))
