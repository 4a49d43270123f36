"""The record of one run: its verdict, with the evidence for it."""

from __future__ import annotations

from dataclasses import dataclass

from sim.evidence import Evidence, ReachedEvidence, WallEvidence, evidence_table
from sim.trace import Trace
from sim.verdict import Verdict

__all__ = ["Episode"]


@dataclass(frozen=True)
class Episode:
    """What happened in one run.

    Args:
        verdict: How it ended.
        steps: Steps simulated; for a ``loop``, up to the first return of a state.
        time: Their duration, s.
        path_length: Distance driven, m.
        collisions: Times that the robot began to touch a wall.
        trace_digest: 16 hex digits, a digest of every state.
        evidence: The facts that confirm the verdict for a checker; a record of the verdict's kind.
        trace: The recorded states, if requested.
        cells_left: Cells that a coverage task still asks for; ``None`` for another task.
        area_covered: Area of the cells that its centre was in after a step, the start's included,
            m2.
    """

    verdict: Verdict
    steps: int
    time: float
    path_length: float
    collisions: int
    trace_digest: str
    evidence: Evidence
    trace: Trace | None = None
    area_covered: float = 0.0
    cells_left: int | None = None

    @property
    def went_into_a_wall(self) -> bool:
        """Whether the robot went into a wall, even in a run that a wall does not end."""
        evidence = self.evidence
        entered = isinstance(evidence, ReachedEvidence) and evidence.wall_step is not None
        return entered or isinstance(evidence, WallEvidence)

    def __repr__(self) -> str:
        evidence = "".join(
            f"\n  {name}: {value!r}" for name, value in evidence_table(self.evidence).items()
        )
        return (
            f"{self.verdict}: {self.steps} steps, {self.time:g} s, {self.path_length:.3f} m "
            f"driven, "
            f"{self.collisions} collisions, trace {self.trace_digest}{evidence}"
        )
