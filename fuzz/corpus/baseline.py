"""Known failures: a campaign does not report their causes as new."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.cause import CAUSE
from fuzz.corpus.entry import CorpusEntry
from fuzz.facts.proofs import certificate_fault
from fuzz.failure import Failure
from fuzz.triage.judging import failure_of, oracle_of
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
    """Failures whose causes are known.

    Args:
        failures: By controller, motion model and group: the first file, and the failure as it
            occurs today.
        fixed: The failures of the same controller that no longer fail, as stored.
        signatures: Groups and signatures of all that still fail.
        strict: True if a failure is only known if its signature is.
    """

    failures: Mapping[_Key, tuple[Path, Failure]] = field(default_factory=dict)
    fixed: tuple[Failure, ...] = ()
    signatures: frozenset[tuple[str, str]] = frozenset()
    strict: bool = False

    @classmethod
    def of(
        cls,
        entries: Iterable[CorpusEntry],
        scenario: Scenario,
        say: Callable[[str], None],
        *,
        strict: bool = False,
    ) -> Baseline:
        """Return the causes of a controller's known failures as they occur today.

        Each is run again, so that an outdated name does not hide a new cause.

        Args:
            entries: Entries of a corpus; other controllers and motion models are ignored.
            scenario: The campaign's scenario.
            say: Called with a message for each entry that is no longer a failure or has changed
                its cause, and if no entry has this controller and motion model.
            strict: See the class.

        Raises:
            FormatError: If a file can no longer be read.
        """
        failures: dict[_Key, tuple[Path, Failure]] = {}
        fixed: list[Failure] = []
        signatures: set[tuple[str, str]] = set()
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
                say(f"{entry.path}: {reason}, so its cause {entry.facts.group} is not known")
                continue
            # A file from before causes were recorded has none to compare.
            is_same = now.group == entry.facts.group or CAUSE not in failure.record.details
            known = is_same or _is_known(now)
            if not is_same:
                unknown = "" if known else ", which is not known"
                say(
                    f"{entry.path}: stored as {entry.facts.group}, its cause is now "
                    f"{now.group}{unknown}"
                )
            if known:
                failures.setdefault(_key(now), (entry.path, now))
                signatures.add(now.key)
        # A baseline for another controller is probably a mistake, such as a wrong path.
        if others and not is_any_ours:
            say(
                f"the baseline has no failure of {scenario.controller} under "
                f"{scenario.run.motion}, only of {shown(', '.join(sorted(others)[:_SHOWN]))}"
            )
        return cls(failures, tuple(fixed), frozenset(signatures), strict)

    @property
    def is_empty(self) -> bool:
        """True if the controller has no known failures."""
        return not self.failures and not self.fixed

    def failing(self) -> list[Failure]:
        """Return the known failures that still fail, as they occur today."""
        return [failure for _, failure in self.failures.values()]

    def has(self, failure: Failure) -> bool:
        """Return True if a failure is known."""
        is_known = _key(failure) in self.failures
        return is_known and (not self.strict or failure.key in self.signatures)

    def is_new_variant(self, failure: Failure) -> bool:
        """Return True if a failure's cause is known, but none that looks like it."""
        return self.has(failure) and failure.key not in self.signatures


def _who(controller: str, motion: str) -> tuple[str, str]:
    """Return the controller and motion model, with the controller's file as an absolute path."""
    return in_plain_place(controller, resolve=True), motion


def _key(failure: Failure) -> _Key:
    return (*_who(failure.label, failure.record.motion), failure.group)


def _is_known(now: Failure) -> bool:
    """Return True if a failure with a new cause is still the stored one.

    This is true for a robot that loops differently, but not for a controller that crashes, hangs or
    sends invalid commands: that may be a separate fault, introduced by yesterday's edit.
    """
    return now.verdict not in BY_THE_CONTROLLER


def _failure_now(failure: Failure) -> tuple[Failure | None, str]:
    """Return the failure as recorded today, or ``None`` and the reason why it no longer fails."""
    fault = certificate_fault(failure.world, failure.record.motion)
    if fault:
        return None, fault
    try:
        now = failure_of(
            failure.world, failure.scenario, oracle_of(failure), steps=failure.options.steps
        )
    except WorldgenError as error:
        return None, f"cannot be run here ({error})"
    return now, _FIXED
