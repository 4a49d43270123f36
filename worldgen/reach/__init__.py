"""Reachability of the target for a disc: a proof either way, and an independent checker.

``decide`` proves, ``decide_many`` does so of many worlds, ``decide_in_time`` for a deadline; ``latest_start`` says how
long the robot may wait.
``check_certificate`` and ``check_confinement`` check, ``witness_margin`` measures how much later a timed witness may
begin (these three load shapely, so they are imported when first used).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.still.prove import decide, decide_many
from worldgen.reach.still.widest import widest_disc
from worldgen.reach.timed.confinement import Confinement
from worldgen.reach.timed.deadline import decide_in_time, latest_start, until

if TYPE_CHECKING:
    from worldgen.reach.check.certificate import CheckReport, check_certificate
    from worldgen.reach.check.confinement import check_confinement
    from worldgen.reach.check.margin import delayed, witness_margin

__all__ = [
    "BLOCKED",
    "REACHABLE",
    "UNDECIDED",
    "CheckReport",
    "Confinement",
    "Decision",
    "check_certificate",
    "check_confinement",
    "decide",
    "decide_in_time",
    "decide_many",
    "delayed",
    "latest_start",
    "until",
    "widest_disc",
    "witness_margin",
]


def __getattr__(name: str) -> Any:
    if name in {"CheckReport", "check_certificate"}:
        from worldgen.reach.check import certificate

        return getattr(certificate, name)
    if name == "check_confinement":
        from worldgen.reach.check import confinement

        return confinement.check_confinement
    if name in {"delayed", "witness_margin"}:
        from worldgen.reach.check import margin

        return getattr(margin, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
