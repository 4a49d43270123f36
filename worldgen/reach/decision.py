"""What the prover answers."""

from __future__ import annotations

from dataclasses import dataclass

from worldgen.world import Certificate

__all__ = ["BLOCKED", "REACHABLE", "UNDECIDED", "Decision"]

REACHABLE = "reachable"
BLOCKED = "blocked"
UNDECIDED = "undecided"


@dataclass(frozen=True)
class Decision:
    """Whether the target can be reached, with the proof.

    Args:
        result: ``REACHABLE`` with a witness, ``BLOCKED`` with a cut, or ``UNDECIDED`` with neither.
        certificate: The proof, for :func:`worldgen.reach.check_certificate`.
        reason: One sentence for people.
    """

    result: str
    certificate: Certificate | None
    reason: str
