"""What the prover answers."""

from __future__ import annotations

import math
from dataclasses import dataclass

from worldgen.errors import InvalidParameter
from worldgen.reach.timed.confinement import Confinement
from worldgen.world import Certificate

__all__ = ["BLOCKED", "REACHABLE", "UNDECIDED", "Decision", "check_deadline", "check_margin", "check_radius"]

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
        confinement: The proof of ``BLOCKED`` where no cut is one; for :func:`worldgen.reach.check_confinement`.
            A file holds none.
    """

    result: str
    certificate: Certificate | None
    reason: str
    confinement: Confinement | None = None


def check_radius(radius: float) -> None:
    """Refuses a radius that no disc has.

    Raises:
        InvalidParameter: If it is not a finite number above 0.
    """
    if not (math.isfinite(radius) and radius > 0):
        raise InvalidParameter("not-positive", "radius={radius} m: must be a finite number above 0", radius=radius)


def check_margin(margin: float) -> None:
    """Refuses a margin by which nothing can be late.

    Raises:
        InvalidParameter: If it is not a finite number, 0 or above.
    """
    if not (math.isfinite(margin) and margin >= 0):
        raise InvalidParameter("below-minimum", "margin={margin} s: must be a finite number, 0 or above", margin=margin)


def check_deadline(deadline: float | None) -> None:
    """Refuses a deadline that is no time.

    Raises:
        InvalidParameter: If it is given and not a finite number above 0.
    """
    if deadline is not None and not (math.isfinite(deadline) and deadline > 0):
        raise InvalidParameter(
            "not-positive", "deadline={deadline} s: must be a finite number above 0", deadline=deadline
        )
