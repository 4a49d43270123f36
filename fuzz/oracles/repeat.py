"""``repeat``: two runs of one scenario differ."""

from __future__ import annotations

import numpy as np

from fuzz.oracles.trial import Trial
from sim.trace import Trace
from worldgen.errors import InvalidParameter
from worldgen.world import Value

_MOST = 1000


def repeat(trial: Trial, times: float = 3) -> dict[str, Value] | None:
    """Report a scenario that does not repeat when it runs again.

    The cause is hidden memory, or randomness without a seed.

    Args:
        trial: The run.
        times: Limit on repetitions, 1 to 1,000.

    Returns:
        ``step``: the first that ends in another pose. ``poses``: x m, y m and heading rad after it
        in both runs; empty for a run that has ended by then. ``verdicts``. ``repeatable``: False.
    """
    if not 1 <= times <= _MOST or times % 1:
        raise InvalidParameter(
            "out-of-range",
            "repeat={times:g} is not an integer from 1 to {most}",
            "choose a number in that range",
            times=times,
            most=_MOST,
        )
    first = trial.trace
    for _ in range(int(times)):
        other = trial.again(record=True)
        step = _first_difference(first, other.trace)
        if step < 0 and other.verdict == trial.episode.verdict:
            continue
        return {
            "step": max(step, 0),
            "poses": [_pose(first, step), _pose(other.trace, step)],
            "verdicts": [trial.episode.verdict, other.verdict],
            "repeatable": False,
        }
    return None


def _first_difference(one: Trace | None, other: Trace | None) -> int:
    """Return the first step that ends in another pose, or after which only one run continues.

    -1 if there is none.
    """
    if one is None or other is None:
        return -1 if one is other else 0
    both = min(one.steps, other.steps) + 1
    differs = np.zeros(both, bool)
    for name in ("x", "y", "heading"):
        differs |= getattr(one, name)[:both] != getattr(other, name)[:both]
    if differs.any():
        return int(np.argmax(differs))
    return -1 if one.steps == other.steps else both


def _pose(trace: Trace | None, step: int) -> list[Value]:
    if trace is None or not 0 <= step <= trace.steps:
        return []
    return [float(trace.x[step]), float(trace.y[step]), float(trace.heading[step])]
