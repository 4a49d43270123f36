"""Sum up a campaign in at most fifteen lines: does it work, how bad is it, why, and what to do."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from msgspec import UNSET

from fuzz.campaign.store import MEMORY, Summary
from fuzz.cause import Cause, Severity
from fuzz.layouts.variation import changes_on_map
from fuzz.overview.building import Overview
from fuzz.overview.counterfactual import describe_changes
from fuzz.overview.result import CampaignResult, CauseResult, NaturalResult
from fuzz.unit.answer import Answer, AnswerNumbers
from worldgen.support.plain_text import alternatives, counted, joined, shown, styled

# The first cause has all of its words, the next ones a line; others are counted. With the lines
# about the whole campaign, this makes fifteen of 80 columns.
_MOST_IN_SHORT = 2

# Changes after which the robot arrives; worldgen explain lists all.
_MOST_CHANGES = 3

# Failures that can depend on a wall or a number; controller errors and the user's rules do not.
_EXPLAINED = (Severity.THROUGH_WALLS, Severity.HARMED, Severity.NEVER_ARRIVES, Severity.TOO_SLOW)

# A robot arrives rarely if its rate of arrival is certainly below the first, usually does not if it
# is certainly below the second, and nearly always does if it is certainly above the third.
_RARE = 0.2
_LESS_THAN_HALF = 0.5
_NEARLY_ALWAYS = 0.95

_COLOURS = {
    Severity.THROUGH_WALLS: "31",  # red
    Severity.THROUGH_ROBOTS: "31",  # red
    Severity.CONTROLLER_ERROR: "31",  # red
    Severity.HARMED: "31",  # red
    Severity.NEVER_ARRIVES: "33",  # yellow
    Severity.TOO_SLOW: "33",  # yellow
    Severity.QUESTIONABLE: "36",  # cyan
    Severity.UNSENSED: "34",  # blue
}


def overview_lines(
    overview: Overview, folder: Path | None, *, remedy: str = "", robots: int = 1
) -> list[str]:
    """Return the summary for the terminal, in colour; ``say`` removes it if necessary.

    Args:
        overview: The campaign's result, with its numbers.
        folder: Its folder; ``None`` if it is deleted after the command, so that no command can use
            it.
        remedy: The command that gives it more time.
        robots: Robots in each world.
    """
    result = overview.result
    numbers = _numbers(result)
    # Say first whether it works and how often the robot arrives.
    lines = [_verdict_line(result)]
    if result.natural is not None and result.natural.worlds:
        lines.append(f"  {describe_rate(result.natural)}")
    elif result.natural is not None and result.natural.unsensed:
        harmed = counted(result.natural.unsensed, "natural world")
        lines.append(f"  hazards that it cannot sense harmed it in {harmed}, and no other was run")
    elif robots > 1 and not numbers.known:
        lines.append(
            "  how often several robots arrive is not measured: no worlds are natural for them; "
            "worldgen compare counts it in worlds that you choose"
        )
    # Describe the worst cause in full, the next ones in short, and name the others.
    causes = _counted_causes(result) or [one for one in result.causes if one.is_met]
    if causes:
        lines += _in_full(causes[0], overview, folder)
    for number, cause in enumerate(causes[1 : 1 + _MOST_IN_SHORT], 2):
        lines.append(joined(f"{number}. ", _title(cause, result.natural)))
    lines += _others(result, causes[1 + _MOST_IN_SHORT :], causes)
    if result.comparison is not None:
        lines.append(shown(result.comparison.sentence))
    # Finally, suggest what to do next.
    if causes and folder is not None:
        place = shown(shlex.quote(str(folder)))
        lines.append(f"look at it: worldgen report {place} --out report.html")
    if numbers.answer == Answer.NONE and folder is not None:
        lines.append(f"give it more time: {shown(remedy)}")
    return lines


def _numbers(result: CampaignResult) -> Summary:
    assert result.summary is not UNSET, "the terminal shows results with their numbers"
    return result.summary


def _others(
    result: CampaignResult, more: Sequence[CauseResult], causes: Sequence[CauseResult]
) -> list[str]:
    """Return at most one line, with the names of further causes and of those that do not count."""
    parts = []
    if more:
        names = ", ".join(cause.cause.value for cause in more)
        parts.append(f"and {counted(len(more), 'more cause')}: {names}")
    others = [one for one in result.causes if one not in causes]
    if others:
        parts.append(f"not counted: {', '.join(map(_uncounted, others))}")
    return ["; ".join(parts)] if parts else []


def _counted_causes(result: CampaignResult) -> list[CauseResult]:
    """Return the causes that count: the controller's own, met in a world that nobody shrunk."""
    return [one for one in result.causes if one.cause.severity != Severity.UNSENSED and one.is_met]


def _uncounted(cause: CauseResult) -> str:
    """Return why a cause does not count, after its name."""
    if not cause.is_met:
        return f"{cause.cause} (only in worlds that shrinking made)"
    met = _verdicts(cause)
    return f"{cause.cause}{f' ({met})' if met else ''}"


def describe_rate(natural: NaturalResult) -> str:
    """Return how often the robot arrives, with its interval, and what it does otherwise.

    ``arrives in 72 % of 900 natural worlds (95 %: 69 to 75 %); goes through walls in 6; ...``
    """
    low, high = (round(100 * share) for share in natural.interval)
    if natural.arrived == natural.worlds:
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


def describe_coverage(natural: NaturalResult) -> str:
    """Return which natural worlds were tried, and which were not."""
    tried = [name for name, tally in natural.families.items() if tally.worlds]
    never = never_tried(natural)
    text = f"natural worlds: {counted(len(tried), 'family', 'families')} at default settings"
    return text + (f"; never tried: {'; '.join(never)}" if never else "")


def never_tried(natural: NaturalResult) -> list[str]:
    """Return which gaps and turns did not occur in any natural world."""
    clearances = [name for name, row in natural.clearances.items() if not row.worlds]
    turns = [name for name, row in natural.turns.items() if not row.worlds]
    never = []
    if clearances:
        never.append(f"gaps of {alternatives(clearances)} robot radii")
    if turns:
        never.append(f"paths with {alternatives(turns)} quarter turns")
    return never


def _verdict_line(result: CampaignResult) -> str:
    """Return in a few words whether it works."""
    numbers = _numbers(result)
    controller = shown(f"{numbers.controller} under {numbers.motion}")
    decisive = numbers.answer_numbers or AnswerNumbers()
    # Hazards that the robot cannot sense are not its own failures.
    own = _counted_causes(result)
    searched = f"{counted(numbers.worlds, 'world')} searched"
    if numbers.answer == Answer.NONE:
        open_still = styled("no answer", "33;1")
        reason = shown(str(numbers.answer_reason))
        return joined(f"{controller}: ", open_still, f": {reason}; {searched}")
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
        return joined(styled(found, "32;1"), f"; {searched}")
    # Otherwise the worst cause determines the verdict.
    own = own or [one for one in result.causes if one.is_met] or result.causes
    who = styled(f"{numbers.controller} under {numbers.motion}", "1")
    worst = own[0].cause.severity
    words = own[0].cause.phrase
    if worst in (Severity.HARMED, Severity.NEVER_ARRIVES):
        # It does not arrive in the failures, but that is not what it does in general.
        often = how_often_it_arrives(result.natural)
        words = f"{often}, and {words}" if worst == Severity.HARMED else often
    elif worst == Severity.TOO_SLOW:
        words = f"sometimes {words}"
    failed = styled(words, f"{_COLOURS[worst]};1")
    found = f"; {counted(len(own), 'cause')}, {searched}"
    return joined(who, ": ", failed, found)


def how_often_it_arrives(natural: NaturalResult | None) -> str:
    """Return the words for how often a robot with failures arrives, to follow its name."""
    if natural is not None and natural.worlds:
        if not natural.arrived:
            return "arrived in no natural world"
        if natural.high < _RARE:
            return "rarely arrives"
        if natural.high < _LESS_THAN_HALF:
            return "usually does not arrive"
        if natural.low > _NEARLY_ALWAYS:
            return "nearly always arrives"
    return "does not always arrive"


def _title(cause: CauseResult, natural: NaturalResult | None) -> str:
    name = styled(cause.cause.value, f"{_COLOURS[cause.cause.severity]};1")
    new = (" ", styled("NEW", "35;1")) if cause.state == "new" else ()
    return joined(name, *new, f": {_how_often(cause, natural)}")


def _how_often(cause: CauseResult, natural: NaturalResult | None) -> str:
    parts = []
    if natural is not None and natural.worlds and cause.natural is not None:
        of = natural.worlds if cause.cause.severity != Severity.UNSENSED else 0
        if of:
            parts.append(f"{cause.natural or 'none'} of {counted(of, 'natural world')}")
    # The search proves and classifies only some of the runs that fail in the same way.
    met = _verdicts(cause)
    if met:
        parts.append(f"examined: {met}")
    else:
        parts.append("not met by the search")
    return "; ".join(parts)


def _verdicts(cause: CauseResult) -> str:
    return ", ".join(f"{count} {verdict}" for verdict, count in cause.verdicts.items() if count)


def _in_full(cause: CauseResult, overview: Overview, folder: Path | None) -> list[str]:
    """Return four lines: what and how often, why, its dependencies, the command."""
    title = _title(cause, overview.result.natural)
    lines = [joined("1. ", title), f"   {cause.sentence} {cause.advice}"]
    # A known failure has its file elsewhere, and only a copy in the campaign's store.
    path = ""
    if folder is not None and cause.file and not cause.file.startswith(MEMORY):
        path = shown(shlex.quote(str(folder / cause.file)))
        lines.append(f"   worldgen replay {path} --show")
    why = describe_changes(cause.changes, _MOST_CHANGES) if cause.changes else cause.why
    known = [one for one in (cause.repeats, why) if one]
    example = overview.examples.get(cause.cause)
    if example is not None and (changes := changes_on_map(example.world)):
        lines.append(f"   {shown(changes)}")
    if cause.fault:
        lines.append(f"   {shown(cause.fault)}")
    elif known:
        who = "the fleet" if example is not None and example.world.is_fleet else "it"
        lines.append(f"   In this world {who} {shown('. It '.join(known))}.")
    elif path and cause.cause.severity in _EXPLAINED:
        lines.append(f"   what the failure depends on: worldgen explain {path}")
    return lines
