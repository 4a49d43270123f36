"""Sum up a campaign in at most fifteen lines: does it work, how bad is it, why, and what to do."""

from __future__ import annotations

import shlex
from pathlib import Path

from fuzz.campaign.store import MEMORY
from fuzz.cause import Severity
from fuzz.layouts.variation import changes_on_map
from fuzz.overview.answer import (
    CLEAN,
    NO_ANSWER,
    describe_others,
    describe_rate,
    describe_unmeasured,
    headline,
    how_often,
    numbers_of,
    ranked_causes,
)
from fuzz.overview.building import Overview
from fuzz.overview.counterfactual import describe_changes
from fuzz.overview.result import CampaignResult, CauseResult, NaturalResult
from fuzz.unit.answer import Answer
from worldgen.support.plain_text import alternatives, counted, joined, shown, styled

# The first cause has all of its words, the next ones a line; others are counted. With the lines
# about the whole campaign, this makes fifteen of 80 columns.
_MOST_IN_SHORT = 2

# Changes after which the robot arrives; worldgen explain lists all.
_MOST_CHANGES = 3

# Failures that can depend on a wall or a number; controller errors and the user's rules do not.
_EXPLAINED = (Severity.THROUGH_WALLS, Severity.HARMED, Severity.NEVER_ARRIVES, Severity.TOO_SLOW)

# Of answers without a failure that counts.
_ANSWERS = {NO_ANSWER: "33", CLEAN: "32"}  # yellow, green

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


_BY_WORD = {severity.word: colour for severity, colour in _COLOURS.items()}


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
    numbers = numbers_of(result)
    # Say first whether it works and how often the robot arrives.
    lines = [_first_line(result)]
    if result.natural is not None and result.natural.worlds:
        lines.append(f"  {describe_rate(result.natural)}")
    elif unmeasured := describe_unmeasured(result):
        lines.append(f"  {unmeasured}")
    elif robots > 1 and not numbers.known:
        lines.append(
            "  how often several robots arrive is not measured: no worlds are natural for them; "
            "worldgen compare counts it in worlds that you choose"
        )
    # Describe the worst cause in full, the next ones in short, and name the others.
    causes = ranked_causes(result)
    if causes:
        lines += _in_full(causes[0], overview, folder)
    for number, cause in enumerate(causes[1 : 1 + _MOST_IN_SHORT], 2):
        lines.append(joined(f"{number}. ", _title(cause, result.natural)))
    others = describe_others(result, causes[1 + _MOST_IN_SHORT :], causes)
    lines += [others] if others else []
    if result.comparison is not None:
        lines.append(shown(result.comparison.sentence))
    # Finally, suggest what to do next.
    if causes and folder is not None:
        place = shown(shlex.quote(str(folder)))
        path = _path_of(causes[0], folder)
        if path and causes[0].cause.severity in _EXPLAINED:
            lines.append(f"why: worldgen explain {path}")
        lines.append(f"look at it: worldgen report {place} --out report.html")
    natural = result.natural
    if natural is not None and natural.complete and not natural.worlds and not natural.unsensed:
        lines.append(
            "no natural world has a way to go for this robot: give it a smaller body, or a smaller "
            "--target-radius if the target covers the start"
        )
    elif numbers.answer == Answer.NONE and folder is not None:
        lines.append(f"give it more time: {shown(remedy)}")
    return lines


def _first_line(result: CampaignResult) -> str:
    """Return in a few words whether it works, in the colour of the worst cause."""
    first = headline(result)
    colour = _ANSWERS.get(first.tone) or _BY_WORD[first.tone]
    who = styled(first.who, "1") if first.who and first.tone not in _ANSWERS else first.who
    return joined(who, ": " if who else "", styled(first.words, f"{colour};1"), first.rest)


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
        never.append(f"gaps of {alternatives(clearances)} times the robot's width")
    if turns:
        never.append(f"paths with {alternatives(turns)} quarter turns")
    return never


def _title(cause: CauseResult, natural: NaturalResult | None) -> str:
    name = styled(cause.cause.value, f"{_COLOURS[cause.cause.severity]};1")
    new = (" ", styled("NEW", "35;1")) if cause.state == "new" else ()
    return joined(name, *new, f": {how_often(cause, natural)}")


def _in_full(cause: CauseResult, overview: Overview, folder: Path | None) -> list[str]:
    """Return four lines: what and how often, why, its dependencies, the command."""
    title = _title(cause, overview.result.natural)
    lines = [joined("1. ", title), f"   {cause.sentence} {cause.advice}"]
    if path := _path_of(cause, folder):
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
    return lines


def _path_of(cause: CauseResult, folder: Path | None) -> str:
    """Return a cause's file, quoted for a shell; empty if the folder does not have it."""
    # A known failure has its file elsewhere, and only a copy in the campaign's store.
    if folder is None or not cause.file or cause.file.startswith(MEMORY):
        return ""
    return shown(shlex.quote(str(folder / cause.file)))
