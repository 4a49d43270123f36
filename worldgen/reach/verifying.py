"""Check the certificate of a world or, if it has none, decide the world and check that proof."""

from __future__ import annotations

import math
from typing import Any

from worldgen.reach.body.prove import also_for_smaller
from worldgen.reach.check.car_confinement import check_car_confinement
from worldgen.reach.check.certificate import CheckReport, check_certificate
from worldgen.reach.check.confinement import check_confinement
from worldgen.reach.check.margin import witness_margin
from worldgen.reach.check.swap import check_swap
from worldgen.reach.deadline import decide_in_time, latest_start, until
from worldgen.reach.deciding import decide
from worldgen.reach.decision import (
    BLOCKED,
    REACHABLE,
    UNDECIDED,
    CarConfinement,
    Decision,
    check_deadline,
    check_radius,
)
from worldgen.world import Cut, Witness, World


def verify_world(
    world: World, radius: float | None = None, deadline: float | None = None
) -> dict[str, Any]:
    """Check a world's certificate, or decide the world and check that.

    Args:
        world: The world.
        radius: Radius of the disc, m; the robot's if omitted.
        deadline: Time, s, by which the robot must be in the target; None for any time.

    Returns:
        ``result``, ``certificate`` (witness, cut, confinement, swap or None),
        ``certificate_valid``, ``decided`` (again, or read from the file), ``clearance``, ``radius``
        and ``reason``; ``unread``, a list, if the world lacks elements of the map that it was
        imported from, and then ``result`` is undecided; ``deadline`` if there is one; ``robots``,
        their number, if there are several, and then ``radius`` is the largest of theirs; for a
        witness in a world that changes or under a deadline, also ``margin`` (s by which it may
        begin later) and ``latest_start`` (s until which the robot may wait at the start, on the
        best path); both None if there is no limit.

    Raises:
        InvalidParameter: If the radius or the deadline isn't a finite number above 0.
    """
    asked = max(robot.radius for robot in world.robots) if radius is None else radius
    check_radius(asked, world.cell_size)
    check_deadline(deadline)
    # Use the file's own certificate if it answers this question; otherwise decide.
    decision = Decision(UNDECIDED, world.certificate, "")
    decided = not world.unread and not _answers(world, radius, deadline)
    if world.unread:
        decision = decide(world)
    elif decided:
        decision = decide_in_time(world, deadline, radius=radius)
        if radius is None and not (world.is_fleet or world.is_dynamic):
            decision = also_for_smaller(world, decision)
    # Check the proof, with code that shares nothing with the prover.
    certificate = decision.certificate
    ahead = world if deadline is None else until(world, deadline)
    proof = None
    claim = BLOCKED
    report = CheckReport(False, decision.reason, 0.0)
    if certificate is not None:
        proof, claim = ("cut", BLOCKED) if isinstance(certificate, Cut) else ("witness", REACHABLE)
        about = world if certificate is world.certificate else ahead
        report = check_certificate(about, certificate, radius=radius)
    elif isinstance(decision.confinement, CarConfinement):
        proof = "confinement"
        report = check_car_confinement(ahead, decision.confinement)
    elif decision.confinement is not None:
        proof = "confinement"
        report = check_confinement(ahead, decision.confinement, radius=asked)
    elif decision.swap is not None:
        proof = "swap"
        report = check_swap(world, decision.swap, radius=radius)
    answer: dict[str, Any] = {
        "result": claim if report.valid else UNDECIDED,
        "certificate": proof,
        "certificate_valid": report.valid,
        "decided": decided,
        "clearance": None if certificate is None else report.clearance,
        "radius": asked,
        "reason": report.reason,
    }
    answer |= {"unread": list(world.unread)} if world.unread else {}
    answer |= {} if deadline is None else {"deadline": deadline}
    answer |= {"robots": len(world.robots)} if world.is_fleet else {}
    # How late the robot may begin matters only if something changes or there is a deadline.
    is_timed = world.is_dynamic or deadline is not None
    witness = certificate if isinstance(certificate, Witness) and report.valid else None
    # The other paths of a body, or through waypoints, are not searched for a later start.
    is_searched = not world.robots[0].waypoints and witness is not None
    if is_timed and witness is not None and is_searched and witness.headings is None:
        answer |= _lateness(world, witness, asked, deadline)
    return answer


def _answers(world: World, radius: float | None, deadline: float | None) -> bool:
    """Return True if the certificate in the file answers the question.

    It may still be invalid.
    """
    certificate = world.certificate
    is_other = radius is not None and any(radius != robot.radius for robot in world.robots)
    if certificate is None or (is_other and not check_certificate(world, radius=radius).valid):
        return False
    return deadline is None or isinstance(certificate, Cut) or certificate.duration <= deadline


def _lateness(
    world: World, witness: Witness, radius: float, deadline: float | None
) -> dict[str, float | None]:
    """Return how much later the witness may begin, and how late the robot may on any path."""
    margin = witness_margin(world, witness, radius=radius) if world.is_dynamic else math.inf
    if deadline is not None:
        margin = min(margin, deadline - witness.duration)
    latest = max(latest_start(world, deadline, radius=radius) or 0.0, margin)
    return {"margin": _finite(margin), "latest_start": _finite(latest)}


def _finite(seconds: float) -> float | None:
    return round(seconds, 9) if math.isfinite(seconds) else None
