"""Reachability of the target for a disc: a proof either way, and an independent checker.

Contents:
    decide, decide_many: decide one world, or many, with a proof.
    Decision, REACHABLE, BLOCKED, UNDECIDED: the result.
    decide_in_time, latest_start, until: the same with a deadline, and how long the robot may wait.
    Confinement: the proof that a deadline cannot be met.
    widest_disc: the largest disc that gets through. The following are imported when first used,
because they load shapely:
    check_certificate, CheckReport: check a proof. check_confinement: check the proof about a
    deadline. witness_margin, delayed: how much later a timed witness may begin, and that witness.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.reach.confinement import Confinement
from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.still.prove import decide, decide_many
from worldgen.reach.still.widest import widest_disc
from worldgen.reach.timed.deadline import decide_in_time, latest_start, until
from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from worldgen.reach.check.certificate import CheckReport, check_certificate
    from worldgen.reach.check.confinement import check_confinement
    from worldgen.reach.check.margin import delayed, witness_margin

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "check.certificate": ("CheckReport", "check_certificate"),
        "check.confinement": ("check_confinement",),
        "check.margin": ("delayed", "witness_margin"),
    },
)

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
