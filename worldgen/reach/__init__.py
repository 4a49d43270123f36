"""Reachability of the target for a disc: a proof either way, and an independent checker.

Contents:
    decide: prove it.
    Decision, REACHABLE, BLOCKED, UNDECIDED: the result.
    Confinement: the proof that a deadline cannot be met.
    Swap: the proof that two robots cannot both arrive.
    reachable_cells, coverage_tour: which cells' centres the disc can reach, and a tour of them.
Imported when they are first used, because few need them, and the checkers load shapely:
    decide_in_time, latest_start, until: with a deadline; how long the robot may wait.
    check_certificate, CheckReport: check a proof.
    check_confinement: check the proof about a deadline.
    check_swap: check the proof about two robots that cannot pass each other.
    witness_margin: how much later a timed witness may begin.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.reach.deciding import decide
from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Confinement, Decision, Swap
from worldgen.reach.still.cells import coverage_tour, reachable_cells
from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from worldgen.reach.check.certificate import CheckReport, check_certificate
    from worldgen.reach.check.confinement import check_confinement
    from worldgen.reach.check.margin import witness_margin
    from worldgen.reach.check.swap import check_swap
    from worldgen.reach.deadline import decide_in_time, latest_start, until

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "check.certificate": ("CheckReport", "check_certificate"),
        "check.confinement": ("check_confinement",),
        "check.swap": ("check_swap",),
        "check.margin": ("witness_margin",),
        "deadline": ("decide_in_time", "latest_start", "until"),
    },
)

__all__ = [
    "BLOCKED",
    "REACHABLE",
    "UNDECIDED",
    "CheckReport",
    "Confinement",
    "Decision",
    "Swap",
    "check_certificate",
    "check_confinement",
    "check_swap",
    "coverage_tour",
    "decide",
    "decide_in_time",
    "latest_start",
    "reachable_cells",
    "until",
    "witness_margin",
]
