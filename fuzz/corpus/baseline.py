"""Known failures: a campaign does not report their classes as new."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.corpus.entry import CorpusEntry, Facts
from fuzz.failure import Failure
from fuzz.triage.judging import failure_of, oracle_of
from fuzz.triage.proofs import certificate_fault
from sim.controllers import in_plain_place
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER
from worldgen.errors import WorldgenError
from worldgen.support.plain_text import shown

_Key = tuple[str, str, str]
_SHOWN = 3  # limit on the controllers that a message names
_FIXED = "no longer fails"


@dataclass(frozen=True)
class Baseline:
    """Failures whose classes are known.

    Args:
        failures: By controller, motion model and class: the first file with that class, and the
            failure as it occurs today.
        fixed: The failures of the same controller that no longer fail, as stored.
    """

    failures: Mapping[_Key, tuple[Path, Failure]] = field(default_factory=dict)
    fixed: tuple[Failure, ...] = ()

    @classmethod
    def of(
        cls, entries: Iterable[CorpusEntry], scenario: Scenario, say: Callable[[str], None]
    ) -> Baseline:
        """Return the classes of a controller's known failures as they occur today.

        Each is run again, so that an outdated class name does not hide a new class.

        Args:
            entries: Entries of a corpus; other controllers and motion models are ignored.
            scenario: The campaign's scenario.
            say: Called with a message for each entry that is no longer a failure or has changed
                its class, and if no entry has this controller and motion model.

        Raises:
            FormatError: If a file can no longer be read.
        """
        failures: dict[_Key, tuple[Path, Failure]] = {}
        fixed: list[Failure] = []
        others: set[str] = set()
        is_any_ours = False
        for entry in entries:
            # Ignore the failures of other robots.
            failure = Failure.read(entry.path)
            record = failure.record
            if _who(record.controller, record.motion) != _who(
                scenario.controller, scenario.run.motion
            ):
                others.add(f"{record.controller} under {record.motion}")
                continue
            is_any_ours = True
            # Run it again, and report if it has changed.
            now, reason = _failure_now(failure)
            if now is None:
                if reason == _FIXED:
                    fixed.append(failure)
                say(f"{entry.path}: {reason}, so its class {entry.facts.bucket} is not known")
                continue
            facts = Facts.of(now, str(entry.path))
            known = facts.bucket == entry.facts.bucket or _is_known(now)
            if facts.bucket != entry.facts.bucket:
                unknown = "" if known else ", which is not known"
                say(
                    f"{entry.path}: stored as {entry.facts.bucket}, its class is now "
                    f"{facts.bucket}{unknown}"
                )
            if known:
                failures.setdefault(_key(facts), (entry.path, now))
        # A baseline for another controller is probably a mistake, such as a wrong path.
        if others and not is_any_ours:
            say(
                f"the baseline has no failure of {scenario.controller} under "
                f"{scenario.run.motion}, only of {shown(', '.join(sorted(others)[:_SHOWN]))}"
            )
        return cls(failures, tuple(fixed))

    @property
    def is_empty(self) -> bool:
        """True if the controller has no known failures."""
        return not self.failures and not self.fixed

    def failing(self) -> list[Failure]:
        """Return the known failures that still fail, as they occur today."""
        return [failure for _, failure in self.failures.values()]

    def has(self, failure: Failure) -> bool:
        """Return True if a failure's class is known."""
        return _key(Facts.of(failure, "the failure")) in self.failures


def _who(controller: str, motion: str) -> tuple[str, str]:
    """Return the controller and motion model, with the controller's file as an absolute path."""
    return in_plain_place(controller, resolve=True), motion


def _key(facts: Facts) -> _Key:
    return (*_who(facts.controller, facts.motion), facts.bucket)


def _is_known(now: Failure) -> bool:
    """Return True if a failure with a new class is still the stored one.

    This is true for a robot that loops differently, but not for a controller that crashes, hangs or
    sends invalid commands: that may be a separate fault, introduced by yesterday's edit.
    """
    return now.verdict not in BY_THE_CONTROLLER


def _failure_now(failure: Failure) -> tuple[Failure | None, str]:
    """Return the failure as recorded today, or ``None`` and the reason why it no longer fails."""
    fault = certificate_fault(failure.world)
    if fault:
        return None, fault
    try:
        now = failure_of(
            failure.world, failure.scenario, oracle_of(failure), steps=failure.options.steps
        )
    except WorldgenError as error:
        return None, f"cannot be run here ({error})"
    return now, _FIXED
