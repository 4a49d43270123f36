"""``detour``: the robot arrives, but by too long a path."""

from __future__ import annotations

import math

import numpy as np

from fuzz.oracles.trial import Trial
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Floats
from worldgen.world import Value

_DIGITS = 9  # decimal places of lengths in evidence, m
# Relative difference allowed between the recorded path and the length that the simulator summed up.
_RELATIVE = 1e-6


def detour(trial: Trial, bound: float) -> dict[str, Value] | None:
    """Report a run that arrives by a path longer than ``bound`` times the witness.

    A witness shorter than one cell counts as one cell; otherwise a single extra step would be a
    detour.

    Args:
        trial: The run.
        bound: Largest acceptable ratio of the two lengths, at least 1.

    Returns:
        ``path`` and ``witness``, m, and ``ratio``; measured on the recorded path.
    """
    if bound < 1.0:
        raise InvalidParameter(
            "below-minimum",
            "detour={bound:g} is below 1, but no path is shorter than the shortest",
            "choose 1 or more",
            bound=bound,
        )
    if trial.episode.verdict != Verdict.REACHED or trial.witness is None:
        return None
    shortest = max(trial.witness.length, trial.world.cell_size)
    if trial.episode.path_length <= bound * shortest or trial.trace is None:
        return None
    # The simulator's sum is only a quick filter; the recorded path decides.
    path = _length(trial.trace.path_x, trial.trace.path_y)
    if path <= bound * shortest or abs(path - trial.episode.path_length) > _RELATIVE * path:
        return None
    return {
        "path": round(path, _DIGITS),
        "witness": round(trial.witness.length, _DIGITS),
        "ratio": round(path / shortest, 4),
    }


def _length(x: Floats, y: Floats) -> float:
    """Return the length of a polyline, correctly rounded and therefore the same everywhere."""
    pieces = np.sqrt(np.diff(x) ** 2 + np.diff(y) ** 2)
    return math.fsum(pieces.tolist())
