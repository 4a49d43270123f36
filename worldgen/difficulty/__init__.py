"""How hard a world is.

Contents:
    measure, with_metrics: the metrics of a world; the world with them in its provenance.
    Metrics, METRICS, Metric: what is measured, in which unit, and which way is harder.
"""

from __future__ import annotations

from worldgen.difficulty.measuring import measure, with_metrics
from worldgen.difficulty.metrics import METRICS, Metric, Metrics

__all__ = ["METRICS", "Metric", "Metrics", "measure", "with_metrics"]
