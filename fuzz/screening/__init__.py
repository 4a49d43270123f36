"""Native search: the C core draws, simulates and judges thousands of worlds per second in one call.

Contents:
    evaluate: run a compiled controller in the worlds of many layouts.
    Screening: the results.
    can_screen: tell whether a scenario can run in it.
    WIDEST: the largest radius of a robot, m.
"""

from __future__ import annotations

from fuzz.screening.evaluation import WIDEST, Screening, can_screen, evaluate

__all__ = ["WIDEST", "Screening", "can_screen", "evaluate"]
