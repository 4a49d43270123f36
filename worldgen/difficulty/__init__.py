"""Measure how hard a world is, and search for worlds of a given difficulty.

Contents, each imported when it is first used:
    measure, with_metrics: the metrics of a world; a world with the metrics in its provenance.
    Metrics, METRICS, OF_DISCS, Metric: what is measured, in which unit, and which direction is harder.
    parse, Expression: constraints on metrics.
    search_world, Search: worlds that satisfy a constraint.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from worldgen.difficulty.expression import Expression, parse
    from worldgen.difficulty.measuring import measure, with_metrics
    from worldgen.difficulty.metrics import METRICS, OF_DISCS, Metric, Metrics
    from worldgen.difficulty.search import Search, search_world

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "expression": ("Expression", "parse"),
        "measuring": ("measure", "with_metrics"),
        "metrics": ("METRICS", "OF_DISCS", "Metric", "Metrics"),
        "search": ("Search", "search_world"),
    },
)

__all__ = [
    "METRICS",
    "OF_DISCS",
    "Expression",
    "Metric",
    "Metrics",
    "Search",
    "measure",
    "parse",
    "search_world",
    "with_metrics",
]
