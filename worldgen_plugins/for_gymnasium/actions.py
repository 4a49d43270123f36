"""Check actions, and convert them to the form that the core takes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen_plugins.for_gymnasium.interface import CHOICES, Interface

__all__ = ["checked_actions"]


def checked_actions(interface: Interface, actions: Any, count: int) -> npt.NDArray[Any]:
    """Return actions as (n,) int64 or (n, 2) float32, in C order.

    Continuous actions may exceed their bounds; the core limits them.

    Raises:
        InvalidParameter: If they have another shape or type, contain nan, or are not numbers of
            discrete actions.
    """
    given = np.asarray(actions)
    # Discrete actions are indices into CHOICES, one per environment.
    if interface.actions == "discrete":
        if given.shape != (count,) or given.dtype.kind not in "iu":
            raise InvalidParameter(
                "wrong-shape",
                "actions of shape {shape}, {dtype}: use {count} whole numbers",
                shape=given.shape,
                dtype=str(given.dtype),
                count=count,
            )
        if given.min() < 0 or given.max() >= len(CHOICES):
            raise InvalidParameter(
                "out-of-range",
                "actions from {low} to {high} are out of range: valid actions are 0 to {last}",
                low=given.min(),
                high=given.max(),
                last=len(CHOICES) - 1,
            )
        return np.ascontiguousarray(given, np.int64)
    # Continuous actions are rows of speed and turn rate.
    if given.shape != (count, 2) or given.dtype.kind not in "fiu":
        raise InvalidParameter(
            "wrong-shape",
            "actions of shape {shape}, {dtype}: use fractions of turn rate and top speed for "
            "{count}",
            shape=given.shape,
            dtype=str(given.dtype),
            count=count,
        )
    # The sum is NaN if any entry is, and costs less than a mask; infinities may cancel to NaN too.
    if np.isnan(given.sum()) and np.isnan(given).any():
        raise InvalidParameter(
            "not-finite", "an action is NaN", "use fractions of turn rate and top speed, -1 to 1"
        )
    return np.ascontiguousarray(given, np.float32)
