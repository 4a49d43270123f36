"""Judge whether a trajectory recorded in any simulator was possible in a world.

The audit is an independent check: it shares no code with the simulator.
"""

from sim.audit.judge import DEFAULT_TOLERANCE, KINDS, LEAST_TOLERANCE, Audit, Finding, audit
from worldgen.logs.trajectory import Trajectory

__all__ = [
    "DEFAULT_TOLERANCE",
    "KINDS",
    "LEAST_TOLERANCE",
    "Audit",
    "Finding",
    "Trajectory",
    "audit",
]
