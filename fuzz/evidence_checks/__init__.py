"""Evidence checks: each confirms one verdict from a recorded trace.

They share no code with the simulator. A check looks at the recorded positions, with shapely and
plain Python, and returns what is wrong with the simulator's claim, or an empty string. A failure
is stored only if its check finds nothing wrong.

Contents:
    check_evidence: Finds errors in an episode's verdict, of any kind.
    check_fleet: The same for a run of several robots.
    check_breach: Finds errors in the claim that a walled-off target is reached.
    EVIDENCE_CHECKS: The checks by verdict.
    budget, burned, covered, loop, reached, walls: Modules, one for each kind of verdict.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fuzz.evidence_checks.breach import check_breach
from fuzz.evidence_checks.budget import check_stalled, check_timeout
from fuzz.evidence_checks.burned import check_burned
from fuzz.evidence_checks.covered import check_covered
from fuzz.evidence_checks.fleet import check_fleet
from fuzz.evidence_checks.loop import check_loop
from fuzz.evidence_checks.reached import check_reached
from fuzz.evidence_checks.walls import check_overlap, check_tunnel
from sim.evidence import Evidence
from sim.motion import Motion
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.world import World

__all__ = ["EVIDENCE_CHECKS", "check_breach", "check_evidence", "check_fleet"]

EvidenceCheck = Callable[[World, Trace, Any, Motion], str]

EVIDENCE_CHECKS: dict[Verdict, EvidenceCheck] = {
    Verdict.BURNED: check_burned,
    Verdict.COVERED: check_covered,
    Verdict.LOOP: check_loop,
    Verdict.OVERLAP: check_overlap,
    Verdict.REACHED: check_reached,
    Verdict.STALLED: check_stalled,
    Verdict.TIMEOUT: check_timeout,
    Verdict.TUNNEL: check_tunnel,
}


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
    check = EVIDENCE_CHECKS.get(verdict)
    return check(world, trace, evidence, motion) if check else ""
