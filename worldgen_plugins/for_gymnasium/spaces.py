"""The observation and action spaces, and observations in the form of their space."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from worldgen_plugins.for_gymnasium.interface import CHOICES, Interface
from worldgen_plugins.for_gymnasium.options import Rules

__all__ = ["action_space", "observation_space", "shown"]


def action_space(interface: Interface) -> gymnasium.Space[Any]:
    """Return the space of one robot's actions.

    Continuous actions are fractions of the turn rate, counter-clockwise, and of the top speed.
    Discrete actions are numbers.
    """
    if interface.actions == "discrete":
        return gymnasium.spaces.Discrete(len(CHOICES))
    low = np.array([-1.0, -1.0 if interface.reverse else 0.0], np.float32)
    return gymnasium.spaces.Box(low, np.ones(2, np.float32), dtype=np.float32)


def observation_space(rules: Rules) -> gymnasium.Space[Any]:
    """Return the space of one robot's observations: a flat float32 box, or one per sensor."""
    bounds = rules.interface.bounds()
    if rules.observation == "dict":
        boxes: dict[str, gymnasium.Space[Any]] = {
            name: gymnasium.spaces.Box(low, high, dtype=np.float32)
            for name, (low, high) in bounds.items()
        }
        return gymnasium.spaces.Dict(boxes)
    low, high = (np.concatenate(parts) for parts in zip(*bounds.values(), strict=True))
    return gymnasium.spaces.Box(low, high, dtype=np.float32)


def shown(rules: Rules, observation: npt.NDArray[np.float32]) -> Any:
    """Return observations (..., size) in the form of their space."""
    if rules.observation == "box":
        return observation
    found = {}
    first = 0
    for name, (low, _) in rules.interface.bounds().items():
        found[name] = observation[..., first : first + len(low)].copy()
        first += len(low)
    return found
