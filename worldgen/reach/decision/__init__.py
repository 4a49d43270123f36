"""What the prover answers, with the proofs that a file cannot store.

Contents:
    REACHABLE, BLOCKED, UNDECIDED, Decision, Swap, Confinement, CarConfinement: The answer and its proofs.
    check_radius, check_margin, check_deadline: Reject invalid questions.
    unread_reason: Why nothing is decided on a map of which something was not read.
"""

from worldgen.reach.decision.answer import (
    BLOCKED,
    REACHABLE,
    UNDECIDED,
    Decision,
    Swap,
    check_deadline,
    check_margin,
    check_radius,
    unread_reason,
)
from worldgen.reach.decision.confinement import CarConfinement, Confinement

__all__ = [
    "BLOCKED",
    "REACHABLE",
    "UNDECIDED",
    "CarConfinement",
    "Confinement",
    "Decision",
    "Swap",
    "check_deadline",
    "check_margin",
    "check_radius",
    "unread_reason",
]
