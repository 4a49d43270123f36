"""The error of a controller that fails in a run, with all known facts."""

from __future__ import annotations

import signal
from collections.abc import Mapping

from sim.evidence import fault_evidence
from sim.verdict import Verdict
from worldgen.world import Value

NO_ANSWER = "no answer"
"""The error of a controller that hangs."""


class ControllerError(Exception):
    """A fault of a controller, which decides the verdict of its run.

    Args:
        verdict: One of :data:`sim.verdict.BY_THE_CONTROLLER`.
        error: The fault, in the same words in every replay.
        facts: Other facts, by names of :class:`FaultEvidence`.

    Attributes:
        evidence: All of this as evidence, without the step.
        facts: The other facts.
    """

    def __init__(
        self, verdict: Verdict, error: str, facts: Mapping[str, Value] | None = None
    ) -> None:
        super().__init__(f"{verdict}: {error}")
        self.verdict = verdict
        self.error = error
        self.facts = dict(facts or {})
        self.evidence = fault_evidence({**(facts or {}), "error": error})


def rule_of(error: str) -> str:
    """Return the name of the rule that an answer breaks: the error in lower case with dashes."""
    return error.lower().replace("_", "-").replace(" ", "-")


def how_it_ended(code: int) -> tuple[str, dict[str, Value]]:
    """Return how a controller's process ended, in words and as facts of a :class:`FaultEvidence`.

    Args:
        code: Its exit code, or a signal's number with a minus sign.
    """
    if code >= 0:
        return f"exit code {code}", {"exit_code": code}
    try:
        name = signal.Signals(-code).name
    except ValueError:  # a real-time signal
        return f"killed by signal {-code}", {"signal": str(-code)}
    return f"killed by {name}", {"signal": name}
