"""Known failures: their classes are no news."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.corpus.entry import CorpusEntry, Facts
from fuzz.failure import Failure
from fuzz.triage.crash_bucket import has_facts
from fuzz.triage.judging import failure_of, oracle_of
from fuzz.triage.proofs import certificate_fault
from sim.controllers import in_plain_place
from sim.evidence import FaultEvidence
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER
from worldgen.errors import WorldgenError
from worldgen.support.plain_text import shown

__all__ = ["Baseline"]

_Key = tuple[str, str, str]
_SHOWN = 3  # controllers that a message names


@dataclass(frozen=True)
class Baseline:
    """Failures whose classes are known.

    Args:
        failures: By controller, motion model and class: the first file of it, and the failure as it
            is now.
    """

    failures: Mapping[_Key, tuple[Path, Failure]] = field(default_factory=dict)

    @classmethod
    def of(
        cls, entries: Iterable[CorpusEntry], scenario: Scenario, say: Callable[[str], None]
    ) -> Baseline:
        """What a controller's failures are today.

        Each is run again, so that no old name hides a new class.

        Args:
            entries: Of a corpus; those of other controllers and motion models are passed over.
            scenario: The campaign's.
            say: Told of each failure that is none any more, or is of another class than its file
                says; and if there are failures, but none is of this controller and motion model.

        Raises:
            FormatError: If a file can no longer be read.
        """
        failures: dict[_Key, tuple[Path, Failure]] = {}
        others: set[str] = set()
        is_any_ours = False
        for entry in entries:
            failure = Failure.read(entry.path)
            record = failure.record
            if _who(record.controller, record.motion) != _who(scenario.controller, scenario.motion):
                others.add(f"{record.controller} under {record.motion}")
                continue
            is_any_ours = True
            now, reason = _failure_now(failure)
            if now is None:
                say(f"{entry.path}: {reason}, so its class {entry.facts.kind} is not known")
                continue
            facts = Facts.of(now, str(entry.path))
            known = facts.kind == entry.facts.kind or _is_known(failure, now)
            if facts.kind != entry.facts.kind:
                unknown = "" if known else ", which is not known"
                say(
                    f"{entry.path}: stored as {entry.facts.kind}, its class is {facts.kind} "
                    f"now{unknown}"
                )
            if known:
                failures.setdefault(_key(facts), (entry.path, now))
        if others and not is_any_ours:
            say(
                f"the baseline has no failure of {scenario.controller} under {scenario.motion}, "
                f"only of "
                f"{shown(', '.join(sorted(others)[:_SHOWN]))}"
            )
        return cls(failures)

    def has(self, failure: Failure) -> bool:
        """Whether a failure is of a class that is known."""
        return _key(Facts.of(failure, "the failure")) in self.failures


def _who(controller: str, motion: str) -> tuple[str, str]:
    """Return what two records of the same robot share, wherever the controller's file was named from."""
    return in_plain_place(controller, resolve=True), motion


def _key(facts: Facts) -> _Key:
    return (*_who(facts.controller, facts.motion), facts.kind)


def _is_known(stored: Failure, now: Failure) -> bool:
    """Return whether a failure whose class is another today is still the one that was stored.

    A robot that loops in another manner is. A controller that crashes, hangs or commands nonsense
        is not: that is a
    fault of its own, which may have come into the known world with yesterday's edit. Only files
    from before classes of crashes named a place are taken at their word, if the run is the same up
    to the same crash.
    """
    if now.verdict not in BY_THE_CONTROLLER:
        return True
    return not has_facts(_crash_evidence(stored)) and _crash(stored) == _crash(now)


def _crash(failure: Failure) -> tuple[object, ...]:
    evidence = _crash_evidence(failure)
    return failure.verdict, failure.record.trace_digest, evidence.error, evidence.step


def _crash_evidence(failure: Failure) -> FaultEvidence:
    return failure.evidence if isinstance(failure.evidence, FaultEvidence) else FaultEvidence()


def _failure_now(failure: Failure) -> tuple[Failure | None, str]:
    """The failure with a record of what happens today, or ``None`` and why there is none."""
    fault = certificate_fault(failure.world)
    if fault:
        return None, fault
    try:
        now = failure_of(
            failure.world, failure.scenario, oracle_of(failure), steps=failure.options.steps
        )
    except WorldgenError as error:
        return None, f"cannot be run here ({error})"
    return now, "does not fail any more"
