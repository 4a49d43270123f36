"""The prover's answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from worldgen.domain import LATEST, number_fault, radius_fault
from worldgen.errors import InvalidParameter
from worldgen.parameters.bounds import check_between
from worldgen.reach.decision.confinement import CarConfinement, Confinement
from worldgen.world import Certificate

REACHABLE = "reachable"
BLOCKED = "blocked"
UNDECIDED = "undecided"


@dataclass(frozen=True)
class Swap:
    """Two robots that would have to change places in a passage too narrow for both.

    Args:
        first: Number of one robot, from 1.
        second: Number of the other, which is higher.
        axis: ``x`` or ``y``: the direction in which their order would have to be reversed.
    """

    first: int
    second: int
    axis: str


@dataclass(frozen=True)
class Decision:
    """The answer to whether the target can be reached, with its proof.

    Args:
        result: ``REACHABLE`` with a witness, ``BLOCKED`` with a cut, or ``UNDECIDED`` with neither.
        certificate: The proof, for :func:`worldgen.reach.check_certificate`.
        reason: One sentence for people.
        confinement: The proof of ``BLOCKED`` if no cut proves it, for
            :func:`worldgen.reach.check_confinement`, or that of a car, which has a checker of its
            own. It cannot be stored in a file.
        swap: The proof of ``BLOCKED`` if two robots would have to pass each other, for
            :func:`worldgen.reach.check_swap`. It cannot be stored in a file.
    """

    result: str
    certificate: Certificate | None
    reason: str
    confinement: Confinement | CarConfinement | None = None
    swap: Swap | None = None


def unread_reason(unread: Sequence[str]) -> str:
    """Return why nothing is decided on a map of which something was not read."""
    verb = "was" if len(unread) == 1 and unread[0].startswith("1 ") else "were"
    return f"{'; '.join(unread)} {verb} not read, and might block the path"


def check_radius(radius: float, cell_size: float) -> None:
    """Reject an invalid radius.

    Args:
        radius: Radius, m.
        cell_size: Side of the world's cells, m.

    Raises:
        InvalidParameter: If it is outside `worldgen.domain.RADII`.
    """
    fault = radius_fault("radius", radius, cell_size)
    if fault is not None:
        raise InvalidParameter.of(fault)


def check_margin(margin: float) -> None:
    """Reject an invalid margin.

    Raises:
        InvalidParameter: If it is below 0, or above `worldgen.domain.LATEST`.
    """
    check_between("margin", margin, 0.0, LATEST, "s")


def check_deadline(deadline: float | None) -> None:
    """Reject an invalid deadline.

    Raises:
        InvalidParameter: If it is given, and isn't above 0, or exceeds `worldgen.domain.LATEST`.
    """
    fault = None if deadline is None else number_fault("deadline", deadline, (0.0, LATEST), "s")
    if fault is not None:
        raise InvalidParameter.of(fault)
