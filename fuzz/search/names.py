"""What is known of the lanes in which Hypothesis draws before one of them works, and so without loading Hypothesis."""

from __future__ import annotations

from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.scenario import Scenario

__all__ = ["DATABASE", "LAYOUT_LANES", "SEALED", "TIME_STEPS", "can_breach"]

DATABASE = "database"
"""The lane of what failed before."""

SEALED = "sealed"
"""Layouts with a walled-off target, for motion models in which a robot can go on past a wall."""

LAYOUT_LANES = ("features", SEALED)
"""Lanes that may be named like families."""

TIME_STEPS = (0.015, 0.03, 0.06, 0.1, 0.15)  # s: the range of the thesis's spinner


def can_breach(scenario: Scenario) -> bool:
    """Whether a run can show what it does past a wall that it goes through.

    So that a target walled off is of use.
    """
    return MOTIONS.get(scenario.run.motion).kernel == THESIS and not scenario.run.thesis.keep_going
