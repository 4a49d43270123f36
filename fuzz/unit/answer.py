"""Decide what a campaign answers: it found failures, it found none, or it tried too little to say.

``docs/howto/campaigns.md`` states the rule for users.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import msgspec

from worldgen.support.plain_text import counted, lasting

_Count = Annotated[int, msgspec.Meta(ge=0)]

FEWEST = 5
"""Fewest worlds that an answer without failures rests on.

A controller that fails in every second world arrives in five of five with a probability of 3 %.
"""

MOST_UNJUDGED = 0.05
"""Largest share of the runs that may end without arrival and without a judgement."""

# Seconds; below that, more time is not what the proofs lack.
_WORTH_SAYING = 1.0


class Answer(StrEnum):
    """What a campaign answers."""

    FAILURES = "failures"
    CLEAN = "clean"
    NONE = "none"


class AnswerNumbers(msgspec.Struct, frozen=True, kw_only=True):
    """The numbers that decide the answer.

    A run is unjudged if it ended without arriving, and is neither proved to be a failure nor known
    not to be one.

    Args:
        failures: Classes of failures that no baseline has.
        known: Classes and causes met that a baseline has.
        natural: Natural worlds that were finished; ``None`` if they are not defined for the
            campaign, as with a map of the user's or several robots.
        natural_unjudged: Those of them that are unjudged.
        natural_hazards: Those of them in which a hazard that the robot cannot sense ended the run:
            judged, but not in the robot's favour.
        searched: Runs that the search finished.
        searched_unjudged: Those of them that are unjudged.
        proof_seconds: Seconds that proving one unjudged run takes, estimated from the controller's
            pace.
        needed: Fewest natural worlds for an answer without failures; fewest runs of the search if
            natural worlds are not defined.
    """

    failures: _Count = 0
    known: _Count = 0
    natural: _Count | None = None
    natural_unjudged: _Count = 0
    natural_hazards: _Count = 0
    searched: _Count = 0
    searched_unjudged: _Count = 0
    proof_seconds: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    needed: _Count = FEWEST


def answer_of(numbers: AnswerNumbers) -> tuple[Answer, str]:
    """Return the answer, and the reason for it as a sentence without a full stop."""
    # What was found counts, however little was tried.
    if numbers.failures:
        return Answer.FAILURES, "at least one failure is proved"
    if numbers.known:
        return Answer.FAILURES, "only known failures were met"
    # Too few worlds say nothing, even if the robot arrived in all of them.
    is_natural = numbers.natural is not None
    finished = numbers.searched if numbers.natural is None else numbers.natural
    what = "natural worlds" if is_natural else "worlds"
    if finished < numbers.needed:
        return Answer.NONE, (
            f"{finished or 'none'} of the {numbers.needed} {what} that an answer needs "
            f"{'was' if finished == 1 else 'were'} finished{_pending(numbers)}"
        )
    # A search has thousands of small worlds, which must not hide what natural worlds show.
    for unjudged, runs, kind in (
        (numbers.natural_unjudged, numbers.natural or 0, "natural worlds"),
        (numbers.searched_unjudged, numbers.searched, "worlds searched"),
    ):
        if unjudged > MOST_UNJUDGED * runs:
            return Answer.NONE, (
                f"it did not arrive in {unjudged} of {runs} {kind}, and none of these is proved to "
                f"be a failure{_proving(numbers)}"
            )
    reason = f"no failure in {finished} {what}"
    if numbers.natural_hazards:
        reason += f"; a hazard that it cannot sense ended {numbers.natural_hazards} of them"
    return Answer.CLEAN, reason


def _pending(numbers: AnswerNumbers) -> str:
    """Return how many runs wait for a proof, to follow a reason; empty if none does."""
    runs = _unjudged(numbers)
    return f"; {counted(runs, 'run')} did not arrive{_proving(numbers)}" if runs else ""


def _proving(numbers: AnswerNumbers) -> str:
    """Return how long the proofs take; empty if that is not what keeps them from an answer."""
    seconds = seconds_to_prove(numbers)
    if seconds < _WORTH_SAYING:
        return ""
    what = "it" if _unjudged(numbers) == 1 else "them"
    return f", and proving {what} needs about {lasting(seconds)}"


def seconds_to_prove(numbers: AnswerNumbers) -> float:
    """Return the estimated seconds that proving the unjudged runs takes."""
    return _unjudged(numbers) * numbers.proof_seconds


def _unjudged(numbers: AnswerNumbers) -> int:
    return numbers.natural_unjudged + numbers.searched_unjudged
