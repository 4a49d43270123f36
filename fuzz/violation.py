"""Violations: what an oracle finds wrong with a run, fresh or as a failure's file holds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sim.evidence import Evidence, evidence_table
from worldgen.world import Value

__all__ = ["Violation"]


@dataclass(frozen=True)
class Violation:
    """What is wrong with a run.

    Args:
        bucket: The name of violations of its form, fit for a file name.
        evidence: What the run's verdict rests on; ``None`` if a file does not hold what such a
            verdict needs.
        oracle: The oracle, as ``--oracle`` takes it; ``None`` if the verdict itself is the
            violation.
        facts: What the oracle found; empty if the verdict itself is the violation.
    """

    bucket: str
    evidence: Evidence | None
    oracle: str | None = None
    facts: Mapping[str, Value] = field(default_factory=dict)

    @property
    def is_repeatable(self) -> bool:
        """Whether the run and the facts are the same to the byte when the scenario runs again."""
        return self.facts.get("repeatable") is not False

    @property
    def table(self) -> dict[str, Value]:
        """The evidence as a failure's file holds it."""
        table = {} if self.evidence is None else evidence_table(self.evidence)
        if self.oracle is not None:
            table |= {"oracle": self.oracle, "objection": dict(self.facts)}
        return table

    @property
    def in_words(self) -> str:
        """What the oracle found, to follow a run's verdict.

        Empty if the verdict itself is the violation.
        """
        if self.oracle is None:
            return ""
        hidden = ("kind", "repeatable")
        words = ", ".join(
            f"{name} {value}" for name, value in self.facts.items() if name not in hidden
        )
        return f", but oracle {self.oracle} objects: {words or 'it does'}"
