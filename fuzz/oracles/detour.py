"""``detour``: the robot arrives, by a way that is too long."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from fuzz.oracles.trial import Trial
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.world import Value

__all__ = ["detour"]

_DIGITS = 9  # of lengths in evidence, m
_RELATIVE = (
    1e-6  # by which the recorded path may differ from the length that the simulator summed up
)


def detour(trial: Trial, bound: float) -> dict[str, Value] | None:
    """Objects to a run that arrives after more than ``bound`` times the witness's way.

    A witness shorter than a cell counts as one cell long, for there one step too many is no detour.

    Args:
        trial: The run.
        bound: Greatest ratio of the two lengths that is no failure, at least 1.

    Returns:
        ``path`` and ``witness``, m, and ``ratio``; measured on the recorded path.
    """
    if bound < 1.0:
        raise InvalidParameter(
            "below-minimum",
            "detour={bound:g} is below 1, and no way is shorter than the shortest",
            "give 1 or more",
            bound=bound,
        )
    if trial.episode.verdict != Verdict.REACHED or trial.witness is None:
        return None
    shortest = max(trial.witness.length, trial.world.cell_size)
    if trial.episode.path_length <= bound * shortest or trial.trace is None:
        return None
    path = _length(trial.trace.path_x, trial.trace.path_y)
    if path <= bound * shortest or abs(path - trial.episode.path_length) > _RELATIVE * path:
        return None
    return {
        "path": round(path, _DIGITS),
        "witness": round(trial.witness.length, _DIGITS),
        "ratio": round(path / shortest, 4),
    }


def _length(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> float:
    """Length of a polyline, correctly rounded, so the same everywhere."""
    pieces = np.sqrt(np.diff(x) ** 2 + np.diff(y) ** 2)
    return math.fsum(pieces.tolist())
