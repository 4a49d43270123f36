"""Replay a failure's file: run it again, and compare the run with the record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from fuzz.facts.proofs import certificate_fault
from fuzz.failure import Failure
from fuzz.oracles import Trial, Violation
from fuzz.triage.judging import oracle_of, repeatable, violation_in
from sim.controllers.catalogue.renewal import as_loaded
from sim.controllers.instances import origin_of
from sim.episode import Episode, prepare
from sim.evidence import LoopEvidence
from sim.motion import MOTIONS
from sim.verdict import ARRIVALS
from worldgen.errors import WorldgenError
from worldgen.world import FailureRecord, Value


@dataclass(frozen=True)
class Replay:
    """The result of replaying a failure.

    Args:
        verdict: Verdict of the new run.
        confirmed: True if the new run equals the recorded one.
        reason: The difference, if it is not confirmed; else empty.
        episode: The new run; ``None`` if there was none.
    """

    verdict: str
    confirmed: bool
    reason: str
    episode: Episode | None = None


def replay(failure: Failure, controller: str | None = None) -> Replay:
    """Run a failure again from its file and compare verdict, evidence, digest and certificate.

    Args:
        failure: The stored failure.
        controller: Another name for the controller, if the recorded one cannot be found.

    Raises:
        InvalidParameter: If the record has options that this version does not know.
    """
    failure = failure.driven_by(controller)
    record = failure.record
    options = failure.options
    # Records that cannot belong to failures, such as those edited by hand.
    if failure.oracle is not None and not failure.violation.facts:
        return Replay("error", False, "the evidence does not name an oracle and what it found")
    if failure.oracle is None and record.verdict in ARRIVALS:
        return Replay(
            "reached", False, "the file records that the robot arrived, which is not a failure"
        )
    try:
        oracle = oracle_of(failure)
        _retrace(failure)
        trial = Trial.recorded(failure.world, record.controller, options)
        found = violation_in(trial, oracle)
    except WorldgenError as error:
        return Replay("error", False, str(error))
    # The first difference explains why the failure is not confirmed.
    reason = _what_differs(failure, trial, found) or certificate_fault(failure.world, record.motion)
    episode = trial.episode
    if found is not None and found.evidence is not None:
        episode = replace(episode, evidence=found.evidence)
    return Replay(episode.verdict, not reason, reason, episode)


def _retrace(failure: Failure) -> None:
    """Let a slow class act for the two periods that prove its loop, and no longer.

    The runs that follow search for the loop as if it were unknown, but reuse the answers.
    """
    loop = failure.evidence
    controller = as_loaded(failure.record.controller)
    origin = origin_of(controller)
    if isinstance(loop, LoopEvidence) and origin is not None and not origin.answers.is_off:
        run = prepare(failure.world, controller, failure.options)
        run.prove(loop.entry, loop.period, record=False)


def _what_differs(failure: Failure, trial: Trial, found: Violation | None) -> str:
    """Describe how a run differs from the record, or return an empty string."""
    if found is None and failure.oracle is not None:
        return f"oracle {failure.oracle} finds nothing wrong with the run"
    if found is None:
        unchanged = Violation(failure.signature, trial.episode.evidence)
        return (
            _difference(failure.record, trial.episode, unchanged.table)
            or trial.flaw
            or "the run is not a failure"
        )
    if found.is_repeatable:
        return _difference(failure.record, trial.episode, found.table)
    # Of an unrepeatable run, only the kind of violation can be expected again.
    is_alike = found.facts.get("kind") == failure.violation.facts.get("kind")
    return "" if is_alike else f"oracle {found.oracle} finds something else: {dict(found.facts)}"


def _difference(record: FailureRecord, episode: Episode, evidence: Mapping[str, Value]) -> str:
    """Describe how a run and its evidence differ from the record, or return an empty string."""
    made = record.details.get("motion_version")
    now = MOTIONS.get(record.motion).version
    other = (
        f" (recorded with version {made} of {record.motion}; this is version {now})"
        if made not in (None, now)
        else ""
    )
    if episode.verdict != record.verdict:
        return f"the verdict is {episode.verdict}, not {record.verdict}{other}"
    if episode.trace_digest != record.trace_digest:
        return f"the trace digest is {episode.trace_digest}{other}"
    if repeatable(evidence) != repeatable(record.evidence):
        return f"the evidence is {evidence}{other}"
    return ""
