"""Evidence checks: each confirms one verdict from a recorded trace.

They share no code with the simulator. A check looks at the recorded positions, with shapely and
plain Python, and returns what is wrong with the simulator's claim, or an empty string. A failure
is stored only if its check finds nothing wrong.

Contents:
    check_evidence: Finds errors in an episode's verdict, of any kind.
    check_fleet: The same for a run of several robots.
    check_breach: Finds errors in the claim that a walled-off target is reached.
    budget, burned, contact, covered, loop, reached, walls: Modules, one for each kind of verdict; each is
        imported when a run has that verdict.
    waypoints: Finds errors in the waypoints that a run claims.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from sim.evidence import Evidence
from sim.motion import Motion
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.support.lazy import lazy_names
from worldgen.world import World

if TYPE_CHECKING:
    from fuzz.evidence_checks.breach import check_breach
    from fuzz.evidence_checks.fleet import check_fleet

__getattr__, __dir__ = lazy_names(
    __name__, {"breach": ("check_breach",), "fleet": ("check_fleet",)}
)

__all__ = ["check_breach", "check_evidence", "check_fleet"]

EvidenceCheck = Callable[[World, Trace, Any, Motion], str]


def check_evidence(
    verdict: Verdict, world: World, trace: Trace, evidence: Evidence, motion: Motion
) -> str:
    """Return the reason why a verdict does not hold for a trace.

    Empty if it holds, or if there is no check for that verdict.

    Args:
        verdict: The claim.
        world: World of the run.
        trace: The recording; for ``loop`` it includes a second period.
        evidence: The claim's evidence.
        motion: The motion model, which states how much overlap is tolerated.
    """
    # A goal that forbids contact ends every run at the first one.
    if world.robots[0].contact == "fail" and trace.bump[:-1].any():
        return f"the robot touches a wall in step {int(trace.bump.argmax())}"
    # The other checks are about the goal that counts at the end.
    if world.robots[0].waypoints and len(trace.passed):
        from fuzz.evidence_checks.waypoints import check_waypoints

        fault = check_waypoints(world, trace)
        if fault:
            return fault
        world = world.for_goal(int(trace.passed[-1]))
    check = _check_of(verdict)
    return check(world, trace, evidence, motion) if check else ""


def _check_of(verdict: Verdict) -> EvidenceCheck | None:
    """Import the check for a verdict; a command needs few of them."""
    if verdict == Verdict.BURNED:
        from fuzz.evidence_checks.burned import check_burned

        return check_burned
    if verdict == Verdict.CONTACT:
        from fuzz.evidence_checks.contact import check_contact

        return check_contact
    if verdict == Verdict.COVERED:
        from fuzz.evidence_checks.covered import check_covered

        return check_covered
    if verdict == Verdict.LOOP:
        from fuzz.evidence_checks.loop import check_loop

        return check_loop
    if verdict == Verdict.REACHED:
        from fuzz.evidence_checks.reached import check_reached

        return check_reached
    if verdict in (Verdict.STALLED, Verdict.TIMEOUT):
        from fuzz.evidence_checks.budget import check_stalled, check_timeout

        return check_stalled if verdict == Verdict.STALLED else check_timeout
    if verdict in (Verdict.OVERLAP, Verdict.TUNNEL):
        from fuzz.evidence_checks.walls import check_overlap, check_tunnel

        return check_overlap if verdict == Verdict.OVERLAP else check_tunnel
    return None
