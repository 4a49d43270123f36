"""Native search: the C core draws, simulates and judges thousands of worlds per second in one call.

Contents:
    evaluate: run a compiled controller in the worlds of many layouts.
    Looks: the results.
"""

from __future__ import annotations

from fuzz.screening.evaluation import Screening, can_screen, evaluate

__all__ = ["Screening", "can_screen", "evaluate"]
