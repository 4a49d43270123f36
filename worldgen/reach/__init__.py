"""Reachability of the target for a disc: a proof either way, and an independent checker.

``decide`` proves, ``check_certificate`` checks (it loads shapely, so it is imported when first used).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.prove import decide
from worldgen.reach.widest import widest_disc

if TYPE_CHECKING:
    from worldgen.reach.check import CheckReport, check_certificate

__all__ = ["BLOCKED", "REACHABLE", "UNDECIDED", "CheckReport", "Decision", "check_certificate", "decide", "widest_disc"]


def __getattr__(name: str) -> Any:
    if name in {"CheckReport", "check_certificate"}:
        from worldgen.reach import check

        return getattr(check, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
