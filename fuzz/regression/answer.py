"""Find out what has become of a stored failure: does it still fail, and how, or is it fixed?"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from fuzz.facts.proofs import certificate_fault
from fuzz.failure import Failure
from fuzz.regression.fixed import is_fixed
from fuzz.triage.replaying import Replay, replay
from sim.episode import Episode
from sim.episode.differences import count_sources
from sim.evidence import (
    BurnedEvidence,
    ContactEvidence,
    Evidence,
    FaultEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.verdict import ARRIVALS, Verdict
from worldgen.errors import WorldgenError


class State(StrEnum):
    """The state of a stored failure today."""

    SAME = "same"
    """Unchanged: verdict, evidence, trace digest and certificate are as stored."""

    FAILS = "fails"
    """It fails, but not as stored."""

    ARRIVES = "arrives"
    """It no longer fails."""

    UNPROVED = "unproved"
    """It cannot be run, its runs differ, or the file's certificate does not hold."""


@dataclass(frozen=True)
class ReplayAnswer:
    """The result of replaying a stored failure.

    Args:
        state: See :class:`State`.
        words: The answer in words, without the file's name.
        replay: The exact comparison.
        episode: The recorded run that shows it; ``None`` if there isn't one.
    """

    state: State
    words: str
    replay: Replay
    episode: Episode | None


def answer(failure: Failure, controller: str | None = None) -> ReplayAnswer:
    """Run a stored failure again and report what has become of it.

    If the run differs from the stored one, it gets the failure's budget or the witness's,
    whichever is longer. A robot that merely needs more than the stored steps therefore arrives.

    Args:
        failure: The stored failure.
        controller: A controller to use instead of the recorded one.

    Raises:
        InvalidParameter: If its record has options that this version does not know.
    """
    # Make the exact comparison first.
    outcome = replay(failure, controller)
    record = failure.record
    if outcome.episode is None:
        return ReplayAnswer(State.UNPROVED, f"cannot be run: {outcome.reason}", outcome, None)
    was = _in_short(record.verdict, failure.evidence) + failure.violation.in_words
    if outcome.confirmed:
        same = (
            "the same, bit for bit"
            if outcome.episode.trace_digest == record.trace_digest
            else "still fails in the same way"
        )
        return ReplayAnswer(State.SAME, f"{same}: {was}", outcome, outcome.episode)

    # Without a valid certificate nothing can be concluded; otherwise check if it is fixed.
    fault = certificate_fault(failure.world, record.motion)
    if fault:
        return ReplayAnswer(
            State.UNPROVED, f"the file proves nothing: {fault}", outcome, outcome.episode
        )
    try:
        now = is_fixed(failure, controller)
    except WorldgenError as error:
        return ReplayAnswer(State.UNPROVED, f"cannot be run: {error}", outcome, None)
    episode = now.seen.episode or outcome.episode
    # Two runs with the same budget must be equal; if they are not, neither says anything.
    is_equal_run = now.seen.options == failure.options
    if is_equal_run and episode.trace_digest != outcome.episode.trace_digest:
        one, other = (_in_short(run.verdict, run.evidence) for run in (outcome.episode, episode))
        driven = failure.driven_by(controller)
        count_sources(driven.world, driven.record.controller, driven.options)
        words = f"its runs differ although the input is the same: {one}, then {other} (was: {was})"
        return ReplayAnswer(State.UNPROVED, words, outcome, episode)
    if not now.reason:
        return ReplayAnswer(
            State.ARRIVES, f"{_mended(failure, episode)} (was: {was})", outcome, episode
        )
    return ReplayAnswer(
        State.FAILS,
        f"still fails: {_how(failure, episode, was, now.reason, outcome)}",
        outcome,
        episode,
    )


def describe_summary(states: list[State]) -> str:
    """Return ``3 of 5 confirmed; 1 still fails, 1 arrives now``."""
    counts = {state: states.count(state) for state in State}
    others = [
        f"{counts[state]} {one if counts[state] == 1 else many}"
        for state, one, many in (
            (State.FAILS, "still fails", "still fail"),
            (State.ARRIVES, "arrives now", "arrive now"),
            (State.UNPROVED, "cannot be judged", "cannot be judged"),
        )
        if counts[state]
    ]
    return f"{counts[State.SAME]} of {len(states)} confirmed" + (
        f"; {', '.join(others)}" if others else ""
    )


def _mended(failure: Failure, episode: Episode) -> str:
    if failure.is_breach:
        return (
            f"no longer reaches the walled-off target: {episode.verdict} after {episode.time:.6g} s"
        )
    return f"arrives now in {episode.time:.6g} s"


def _how(failure: Failure, episode: Episode, was: str, wrong: str, outcome: Replay) -> str:
    """Describe how a failure fails now, and how it failed before."""
    if episode.verdict in ARRIVALS:  # the oracle still finds a violation
        return wrong
    now = _in_short(episode.verdict, episode.evidence)
    if now == was and outcome.verdict != episode.verdict:
        steps = failure.options.steps
        return f"{now}, on another path; within the file's {steps} steps, {outcome.verdict}"
    if now == was:
        return f"{now}, on another path; {outcome.reason}"
    if episode.verdict == Verdict.LOOP and isinstance(failure.evidence, LoopEvidence):
        return f"{now} (was {failure.evidence.period})"
    return f"{now} (was: {was})"


def _in_short(verdict: str, evidence: Evidence | None) -> str:
    """Return a verdict with the one fact that best distinguishes two of its kind."""
    match evidence:
        case LoopEvidence(period=period):
            return f"loop, period {period}"
        case WallEvidence(step=step) | ContactEvidence(step=step) | BurnedEvidence(step=step):
            return f"{verdict} in step {step}"
        case FaultEvidence(step=step) if verdict == Verdict.HANG:
            return f"{verdict} in step {step}"
        case FaultEvidence(error=error):
            return f"{verdict}, {error}"
    return verdict
