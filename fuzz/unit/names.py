"""Names and conditions of the search strategies, kept apart so that no import loads Hypothesis."""

from __future__ import annotations

from sim.motion import MOTIONS
from sim.scenario import Scenario

SEALED = "sealed"
"""Layouts with a walled-off target, for motion models in which a robot can pass a wall."""

LAYOUT_STRATEGIES = ("features", SEALED)
"""Strategies that ``--family`` also accepts."""

# Time steps, s: the range of the thesis's spinner.
TIME_STEPS = (0.015, 0.03, 0.06, 0.1, 0.15)


def can_breach(scenario: Scenario) -> bool:
    """Return True if a run can continue beyond a wall that it went through.

    Only then can a robot reach a walled-off target, which is a breach.
    """
    return not (MOTIONS.get(scenario.run.motion).on_lattice or scenario.run.thesis.keep_going)
