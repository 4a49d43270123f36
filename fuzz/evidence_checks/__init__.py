"""Oracles: each confirms one verdict from a recorded trace, sharing no code with the simulator.

The simulator claims; an oracle looks at the positions that were recorded, with shapely and plain Python,
and returns an objection or nothing. A failure is stored only when its oracle has none.

Contents:
    objection: the objection to an episode's verdict, whatever it is.
    object_to_breach: the objection to a walled-off target's being reached.
    burned, loop, overlap, reached, stalled, timeout, tunnel: one verdict a file.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fuzz.evidence_checks.breach import object_to_breach
from fuzz.evidence_checks.burned import object_to_burned
from fuzz.evidence_checks.loop import object_to_loop
from fuzz.evidence_checks.overlap import object_to_overlap
from fuzz.evidence_checks.reached import object_to_reached
from fuzz.evidence_checks.stalled import object_to_stalled
from fuzz.evidence_checks.timeout import object_to_timeout
from fuzz.evidence_checks.tunnel import object_to_tunnel
from sim.evidence import Evidence
from sim.motion import Motion
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.world import World

__all__ = ["ORACLES", "object_to_breach", "objection"]

Oracle = Callable[[World, Trace, Any, Motion], str]

ORACLES: dict[Verdict, Oracle] = {
    Verdict.BURNED: object_to_burned,
    Verdict.LOOP: object_to_loop,
    Verdict.OVERLAP: object_to_overlap,
    Verdict.REACHED: object_to_reached,
    Verdict.STALLED: object_to_stalled,
    Verdict.TIMEOUT: object_to_timeout,
    Verdict.TUNNEL: object_to_tunnel,
}


def objection(verdict: Verdict, world: World, trace: Trace, evidence: Evidence, motion: Motion) -> str:
    """Why a verdict does not hold for a trace; empty if it does, or if no oracle judges that verdict.

    Args:
        verdict: The claim.
        world: Where the run was.
        trace: The recording; for ``loop`` it goes on for a second period.
        evidence: The claim's evidence.
        motion: The motion model, whose stated overlap tolerance counts.
    """
    oracle = ORACLES.get(verdict)
    return oracle(world, trace, evidence, motion) if oracle else ""
