"""The answer of a campaign, which terminal and studio give: does it work, why, what to check."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec
from msgspec import UNSET

from fuzz.campaign.store import MEMORY, Summary
from fuzz.cause import Cause, Severity
from fuzz.overview.result import CampaignResult, CauseResult, NaturalResult
from fuzz.unit.answer import FEWEST, Answer, AnswerNumbers, seconds_to_prove
from worldgen.support.plain_text import counted, shown

# A robot arrives rarely if its rate of arrival is certainly below the first, usually does not if it
# is certainly below the second, and nearly always does if it is certainly above the third.
_RARE = 0.2
_LESS_THAN_HALF = 0.5
_NEARLY_ALWAYS = 0.95


NO_ANSWER = "none"
CLEAN = "clean"

# Times its seconds, and seconds, that a campaign without an answer is offered at least.
MORE = 4
_FEWEST_SECONDS = 300
# Times the seconds that the proofs need: the search comes before them, and shrinking after.
_TIMES_THE_PROOFS = 2
_MINUTE = 60


class Headline(msgspec.Struct, frozen=True):
    """The first line of an answer.

    Args:
        who: The controller under its motion model; empty if the words name it.
        words: Whether it works.
        rest: What follows them.
        tone: ``none``, ``clean``, or the severity of the worst cause.
    """

    who: str
    words: str
    rest: str
    tone: str


class RankedCause(msgspec.Struct, frozen=True):
    """A cause as an answer gives it.

    Args:
        cause: Its name.
        severity: Its severity, in a word.
        is_new: True if the campaign is the first to meet it.
        often: How often it was met.
        sentence: What the robot does wrong, and what to check.
        why: What its example depends on; may be empty.
        file: Name of the example's file; empty if there is none.
        groups: The groups of its failures.
    """

    cause: str
    severity: str
    is_new: bool
    often: str
    sentence: str
    why: str
    file: str
    groups: list[str]


class CampaignAnswer(msgspec.Struct, frozen=True):
    """What a campaign found out, ready to be shown.

    Args:
        headline: Whether the controller works.
        rate: How often it arrives in natural worlds, or why that is not known; empty if it was not
            to be measured.
        causes: The causes, the worst first.
        others: The names of the causes that do not count; may be empty.
        comparison: What changed since an earlier campaign; may be empty.
        more_seconds: Time that is likely to bring an answer; 0 if there is one.
    """

    headline: Headline
    rate: str
    causes: list[RankedCause]
    others: str
    comparison: str
    more_seconds: int


def more_seconds(spent: float, numbers: AnswerNumbers) -> int:
    """Return the seconds, whole minutes, that a campaign without an answer is offered.

    Args:
        spent: Seconds that it had.
        numbers: Those that decide its answer.
    """
    wanted = max(MORE * spent, _TIMES_THE_PROOFS * seconds_to_prove(numbers), _FEWEST_SECONDS)
    return math.ceil(wanted / _MINUTE) * _MINUTE


def answer_of(result: CampaignResult) -> CampaignAnswer:
    """Return the answer of a campaign from its result, with its numbers."""
    causes = ranked_causes(result)
    natural = result.natural
    numbers = numbers_of(result)
    decisive = numbers.answer_numbers or AnswerNumbers()
    is_open = numbers.answer == Answer.NONE
    return CampaignAnswer(
        headline=headline(result),
        rate=describe_rate(natural)
        if natural is not None and natural.worlds
        else describe_unmeasured(result),
        causes=[_ranked(one, natural) for one in causes],
        others=describe_others(result, (), causes),
        comparison="" if result.comparison is None else shown(result.comparison.sentence),
        more_seconds=more_seconds(numbers.seconds, decisive) if is_open else 0,
    )


def _ranked(cause: CauseResult, natural: NaturalResult | None) -> RankedCause:
    return RankedCause(
        cause=cause.cause.value,
        severity=cause.severity,
        is_new=cause.state == "new",
        often=how_often(cause, natural),
        sentence=f"{cause.sentence} {cause.advice}".strip(),
        why=". It ".join(one for one in (cause.repeats, cause.why) if one) or cause.fault,
        file="" if cause.file.startswith(MEMORY) else cause.file,
        groups=list(cause.groups),
    )


def counted_causes(result: CampaignResult) -> list[CauseResult]:
    """Return the causes that count: the controller's own, met in a world that nobody shrunk."""
    return [one for one in result.causes if one.cause.severity != Severity.UNSENSED and one.is_met]


def ranked_causes(result: CampaignResult) -> list[CauseResult]:
    """Return the causes to describe, the worst first: those that count, or else all that were met."""
    return counted_causes(result) or [one for one in result.causes if one.is_met]


def describe_others(
    result: CampaignResult, more: Sequence[CauseResult], causes: Sequence[CauseResult]
) -> str:
    """Return the names of further causes and of those that do not count."""
    parts = []
    if more:
        names = ", ".join(cause.cause.value for cause in more)
        parts.append(f"and {counted(len(more), 'more cause')}: {names}")
    others = [one for one in result.causes if one not in causes]
    if others:
        parts.append(f"not counted: {', '.join(map(_uncounted, others))}")
    return "; ".join(parts)


def _uncounted(cause: CauseResult) -> str:
    """Return why a cause does not count, after its name."""
    if not cause.is_met:
        return f"{cause.cause} (only in worlds that shrinking made)"
    met = verdicts_of(cause)
    return f"{cause.cause}{f' ({met})' if met else ''}"


def describe_rate(natural: NaturalResult) -> str:
    """Return how often the robot arrives, with its interval, and what it does otherwise.

    ``arrives in 72 % of 900 natural worlds (95 %: 69 to 75 %); goes through walls in 6; ...``
    """
    low, high = (round(100 * share) for share in natural.interval)
    if natural.worlds == 1:
        does = "arrives" if natural.arrived else "does not arrive"
        text = (
            f"{does} in the only natural world that was finished (95 %: {low} to {high} % arrive)"
        )
    elif natural.arrived == natural.worlds:
        text = f"arrives in all {counted(natural.worlds, 'natural world')} (95 %: at least {low} %)"
    else:
        text = (
            f"arrives in {natural.percent} % of {counted(natural.worlds, 'natural world')} "
            f"(95 %: {low} to {high} %)"
        )
    for severity in Severity:
        causes = {Cause(name): number for name, number in natural.causes.items()}
        found = {cause: n for cause, n in causes.items() if cause.severity == severity}
        # That it does not arrive in the rest need not be said.
        is_rest = sum(found.values()) == natural.worlds - natural.arrived
        if found and not (is_rest and severity == Severity.NEVER_ARRIVES):
            one, *others = found
            several = f": {len(found)} causes" if others else ""
            phrase = severity.phrase if others else one.phrase
            text += f"; {phrase} in {sum(found.values())}{several}"
    if natural.unsensed:
        text += f"; {natural.unsensed} more with hazards that it cannot sense"
    return text


def headline(result: CampaignResult) -> Headline:
    """Return in a few words whether it works."""
    if result.summary is UNSET:
        return _of_causes(result, "", "")
    numbers = numbers_of(result)
    controller = shown(f"{numbers.controller} under {numbers.motion}")
    decisive = numbers.answer_numbers or AnswerNumbers()
    # Hazards that the robot cannot sense are not its own failures.
    own = counted_causes(result)
    searched = f"{counted(numbers.worlds, 'world')} searched"
    if numbers.answer == Answer.NONE:
        reason = shown(str(numbers.answer_reason))
        return Headline(controller, "no answer", f": {reason}; {searched}", NO_ANSWER)
    # A campaign that was killed has not decided what it answers.
    if numbers.answer is UNSET and numbers.answer_numbers is UNSET:
        if result.causes:
            return _of_causes(result, controller, f", {searched}")
        return Headline(controller, "no answer yet", f"; {searched}", NO_ANSWER)
    # Without failures, mention the runs that the search did not count as failures.
    if not decisive.failures:
        what = "new failure" if numbers.known else "failure"
        pushed = any(one.cause == Cause.PUSHED_TOO_HARD for one in result.causes)
        beyond = "sense or withstand" if pushed else "sense"
        others = len(own) < len(result.causes)
        hazards = f", except for hazards that it cannot {beyond}" if others else ""
        found = f"no {what} of {controller} found{hazards}"
        if decisive.searched_unjudged and not numbers.known:
            searched += (
                f"; it did not arrive in {decisive.searched_unjudged}, and none of these is proved "
                "to be a failure"
            )
        return Headline("", found, f"; {searched}", CLEAN)
    return _of_causes(result, controller, f", {searched}")


def _of_causes(result: CampaignResult, controller: str, searched: str) -> Headline:
    """Return a headline that the worst cause decides."""
    own = ranked_causes(result) or result.causes
    worst = own[0].cause.severity
    words = own[0].cause.phrase
    if worst in (Severity.HARMED, Severity.NEVER_ARRIVES):
        # It does not arrive in the failures, but that is not what it does in general.
        often = how_often_it_arrives(result.natural)
        words = f"{often}, and {words}" if worst == Severity.HARMED else often
    elif worst == Severity.TOO_SLOW:
        words = f"sometimes {words}"
    return Headline(controller, words, f"; {counted(len(own), 'cause')}{searched}", worst.word)


def how_often_it_arrives(natural: NaturalResult | None) -> str:
    """Return the words for how often a robot with failures arrives, to follow its name."""
    if natural is not None and natural.worlds:
        # A few worlds hardly show how often it arrives.
        if not natural.arrived and natural.worlds >= FEWEST:
            return "arrived in no natural world"
        if natural.high < _RARE:
            return "rarely arrives"
        if natural.high < _LESS_THAN_HALF:
            return "usually does not arrive"
        if natural.low > _NEARLY_ALWAYS:
            return "nearly always arrives"
    return "does not always arrive"


def describe_unmeasured(result: CampaignResult) -> str:
    """Return why it is not known how often a robot arrives.

    Empty if it is known, if it was not to be measured, or if the headline says so.
    """
    natural = result.natural
    if natural is None or natural.worlds or numbers_of(result).answer == Answer.NONE:
        return ""
    if natural.unsensed:
        harmed = counted(natural.unsensed, "natural world")
        return f"hazards that it cannot sense harmed it in {harmed}, and no other was finished"
    return "how often it arrives is not known: no natural world was finished"


def how_often(cause: CauseResult, natural: NaturalResult | None) -> str:
    """Return in how many natural worlds a cause was met, and what the search made of it."""
    parts = []
    if natural is not None and natural.worlds and cause.natural is not None:
        of = natural.worlds if cause.cause.severity != Severity.UNSENSED else 0
        if of == 1:
            parts.append(f"{'' if cause.natural else 'not '}in the only natural world")
        elif of:
            parts.append(f"{cause.natural or 'none'} of {of} natural worlds")
    # The search proves and classifies only some of the runs that fail in the same way.
    met = verdicts_of(cause)
    if met:
        parts.append(f"examined: {met}")
    else:
        parts.append("not met by the search")
    return "; ".join(parts)


def verdicts_of(cause: CauseResult) -> str:
    """Return how often a cause was met with each verdict."""
    return ", ".join(f"{count} {verdict}" for verdict, count in cause.verdicts.items() if count)


def numbers_of(result: CampaignResult) -> Summary:
    """Return the numbers of a result that has them."""
    assert result.summary is not UNSET, "an answer needs the numbers"
    return result.summary
