"""Reachability of the target for a disc: a proof either way, and an independent checker.

``decide`` proves, ``check_certificate`` checks, and ``witness_margin`` measures how much later a timed witness may
begin (these load shapely, so they are imported when first used).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.prove import decide
from worldgen.reach.widest import widest_disc

if TYPE_CHECKING:
    from worldgen.reach.check import CheckReport, check_certificate
    from worldgen.reach.check_margin import delayed, witness_margin

__all__ = [
    "BLOCKED",
    "REACHABLE",
    "UNDECIDED",
    "CheckReport",
    "Decision",
    "check_certificate",
    "decide",
    "delayed",
    "widest_disc",
    "witness_margin",
]


def __getattr__(name: str) -> Any:
    if name in {"CheckReport", "check_certificate"}:
        from worldgen.reach import check

        return getattr(check, name)
    if name in {"delayed", "witness_margin"}:
        from worldgen.reach import check_margin

        return getattr(check_margin, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
