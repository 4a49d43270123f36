"""Native search: thousands of worlds a second, drawn, simulated and judged at first look in one call of the C core.

Contents:
    evaluate: runs of a compiled controller in the worlds of many layouts.
    Looks: what came of them.
"""

from __future__ import annotations

from fuzz.screening.evaluation import Screening, can_screen, evaluate

__all__ = ["Screening", "can_screen", "evaluate"]
