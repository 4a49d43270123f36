"""Verdicts: how a run ended, in one word."""

from __future__ import annotations

from enum import StrEnum

__all__ = ["BY_THE_CONTROLLER", "FAILURES", "NEVER", "UNENDED", "Verdict"]


class Verdict(StrEnum):
    """How a run ended; equal to its word, as files and JSON have it.

    The order is that of tables: whether the robot arrived, then the milder failures before the graver ones.
    """

    REACHED = "reached"
    LOOP = "loop"
    STALLED = "stalled"
    TIMEOUT = "timeout"
    TUNNEL = "tunnel"
    OVERLAP = "overlap"
    BURNED = "burned"
    CRASH = "crash"
    HANG = "hang"
    INVALID_COMMAND = "invalid-command"


FAILURES = tuple(verdict for verdict in Verdict if verdict != Verdict.REACHED)
"""Every verdict on a robot that does not arrive."""

NEVER = (Verdict.LOOP, Verdict.STALLED)
"""Verdicts on a robot that drives on forever."""

UNENDED = (*NEVER, Verdict.TIMEOUT)
"""Verdicts on a run that only its budget ended, or the proof that it repeats."""

BY_THE_CONTROLLER = (Verdict.CRASH, Verdict.HANG, Verdict.INVALID_COMMAND)
"""Verdicts on what the controller itself did, wherever the robot was."""
