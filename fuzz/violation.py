"""Violations: what an oracle finds wrong with a run, new or read from a failure's file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sim.evidence import Evidence, evidence_table
from worldgen.world import Value


@dataclass(frozen=True)
class Violation:
    """A problem that an oracle found in a run.

    Args:
        bucket: Name shared by violations that look alike, usable as a file name.
        evidence: Evidence for the run's verdict; ``None`` if a file lacks fields that the verdict
            requires.
        oracle: The oracle, as ``--oracle`` takes it; ``None`` if the verdict itself is the
            violation.
        facts: Facts that the oracle found; empty if the verdict itself is the violation.
    """

    bucket: str
    evidence: Evidence | None
    oracle: str | None = None
    facts: Mapping[str, Value] = field(default_factory=dict)

    @property
    def is_repeatable(self) -> bool:
        """True if running the scenario again produces the same run and facts, byte for byte."""
        return self.facts.get("repeatable") is not False

    @property
    def table(self) -> dict[str, Value]:
        """The evidence, as stored in a failure's file."""
        table = {} if self.evidence is None else evidence_table(self.evidence)
        if self.oracle is not None:
            table |= {"oracle": self.oracle, "objection": dict(self.facts)}
        return table

    @property
    def in_words(self) -> str:
        """The oracle's facts, as a clause to follow the run's verdict.

        Empty if the verdict itself is the violation.
        """
        if self.oracle is None:
            return ""
        hidden = ("kind", "repeatable")
        words = ", ".join(
            f"{name} {value}" for name, value in self.facts.items() if name not in hidden
        )
        return f", but oracle {self.oracle} objects: {words or 'it does'}"
