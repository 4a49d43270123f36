"""Estimate how likely a controller of the library fails in a world; fitted on campaigns.

The model is a weighted sum of a few metrics, each as ``v / (v + scale)``, which maps it to 0 to 1
without a logarithm. The sum ``s`` becomes ``(1 + s / (1 + |s|)) / 2``, which is monotone and needs
only division. Each weight has the sign that :data:`worldgen.difficulty.METRICS` states, so a
metric that makes a world harder never lowers its difficulty.

``python -m benchmarks.difficulty`` fits scales and weights and prints them;
docs/notes/difficulty.md shows how good they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from worldgen.difficulty.metrics import METRICS

# Metric: (scale, weight). Lengths are in radii of the robot, so that a world and its robot can be
# scaled together.
WEIGHTS: Final = {"concavity": (7.8, 3.46), "detour": (0.39, 2.2)}
OFFSET: Final = -2.13
INPUTS: Final = tuple(WEIGHTS)
_LENGTHS: Final = frozenset(name for name, metric in METRICS.items() if metric.unit == "m")


def difficulty(
    metrics: Mapping[str, float],
    robot_radius: float,
    weights: Mapping[str, tuple[float, float]] = WEIGHTS,
    offset: float = OFFSET,
) -> float:
    """Return the difficulty, 0 to 1.

    Args:
        metrics: At least those with weights, :data:`INPUTS`.
        robot_radius: Radius of the robot, m.
        weights: Scale and weight by metric.
        offset: Added to the weighted sum.
    """
    total = offset
    for name, (scale, weight) in weights.items():
        total += weight * squashed(name, metrics[name], scale, robot_radius)
    return (1.0 + total / (1.0 + abs(total))) / 2.0


def squashed(name: str, value: float, scale: float, robot_radius: float) -> float:
    """Map a metric to 0 to 1; a detour counts from 1, and lengths are in radii of the robot."""
    if name == "detour":
        value = max(0.0, value - 1.0)
    elif name in _LENGTHS:
        value = value / robot_radius
    return value / (value + scale)
