"""Describe failures in text: what happened, the picture, and the command that replays it."""

from __future__ import annotations

import contextlib
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from fuzz.boundary import describe_boundaries
from fuzz.facts.hazards import doubt_in
from fuzz.failure import Failure, ShrinkState
from fuzz.layouts.variation import changes_on_map
from fuzz.triage.diagnosis import diagnosis_of
from fuzz.triage.repeated_moves import describe_period
from sim.clock.stopping import OutOfTime
from sim.drawing.picture import trails_of
from sim.episode import Episode
from sim.episode.describe import describe_evidence, describe_frames
from sim.evidence import Evidence
from worldgen.render import draw_terminal, wants_color
from worldgen.render.overlay import naming
from worldgen.support.plain_text import Styled, counted, joined, shown
from worldgen.support.results import results

if TYPE_CHECKING:
    from fuzz.overview.counterfactual import Counterfactuals

_SHRUNK = {
    ShrinkState.DONE: "1-minimal",
    ShrinkState.CUT_SHORT: "shrinking cut short",
    ShrinkState.NONE: "not shrunk",
}
_CHANCES = {
    "sure": ", arrives with probability one but not in time",
    "trap": ", never arrives whatever it draws",
    "part": ", after some draws it is lost forever",
}


def describe_seeds(failure: Failure) -> str:
    """Return for how many seeds a failure occurs, such as ``39 of 40 seeds fail``.

    Empty if its record has no such count.
    """
    seeds = failure.record.details.get("failing_seeds")
    if not isinstance(seeds, list) or len(seeds) != 2:
        return ""
    return f"{seeds[0]} of {seeds[1]} seeds {'get there' if failure.is_breach else 'fail'}"


def describe(
    failure: Failure,
    path: Path,
    *,
    met: Counter[str] | None = None,
    why: Counterfactuals | None = None,
) -> Styled:
    """Return a failure for the terminal: what happened, why, the picture, the command to replay it.

    Args:
        failure: The failure.
        path: Its file.
        met: By group, the number of times that a campaign met it.
        why: The changes after which its robot arrives; the picture marks their cells.
    """
    world = failure.world
    record = failure.record
    evidence: Evidence | None
    try:
        episode, words = run_to_draw(failure)
        trails = trails_of(episode, world)
        evidence = episode.evidence
    except OutOfTime:
        # The controller is slow. The picture is not worth the wait, so it has no trail.
        words = ""
        trails = []
        evidence = failure.evidence

    # Collect everything known about how often, from where and how reliably the failure occurs.
    often = f", met {counted(met[failure.group], 'time')}" if met and met[failure.group] else ""
    seeds = describe_seeds(failure)
    chance = f", {shown(seeds)}" if seeds else ""
    chance += _CHANCES.get(str(record.details.get("chance")), "")
    begins = describe_boundaries(failure)
    changes = changes_on_map(failure.world)
    diagnosis = diagnosis_of(failure)
    cause = diagnosis.cause
    repeats = ""
    if trails and not failure.is_breach and failure.oracle is None:
        with contextlib.suppress(OutOfTime):
            repeats = describe_period(world, episode)
    who = "The fleet" if world.is_fleet else "It"
    depends = f"  {who} {why.describe()}.\n" if why else ""
    marked = naming(trails, why.cells if why else ())
    color = wants_color(results())
    happened = f"{record.verdict}{shown(words)}"
    first = happened if cause.is_vague else diagnosis.sentence(world)
    return joined(
        f"{shown(failure.who)}: {first}\n"
        f"{depends}"
        f"{f'  {who} {repeats}.{chr(10)}' if repeats else ''}"
        f"{'' if cause.is_vague else f'  {happened}{chr(10)}'}"
        f"{describe_frames(evidence)}"
        f"{_doubt(failure)}"
        f"{f'  {shown(changes)}{chr(10)}' if changes else ''}"
        f"{f'  {shown(begins)}{chr(10)}' if begins else ''}"
        f"  cause {shown(failure.group)}{often}; "
        f"{world.width} x {world.height} cells, {world.solid_cells} solid, "
        f"{_SHRUNK[failure.shrinking]}{chance}\n",
        draw_terminal(failure.stored, trail=marked, color=color),
        f"  {shown(failure.replay_command(path))}\n",
    )


def _doubt(failure: Failure) -> str:
    """Return a line with the reason why no controller is certain to arrive, or nothing."""
    why = doubt_in(failure.record.details)
    return f"  no controller is certain to arrive: {shown(why)}\n" if why else ""


def run_to_draw(failure: Failure, known: Episode | None = None) -> tuple[Episode, str]:
    """Return the run to draw for a failure, and a description of what happened.

    The description begins with a space, to follow the verdict. The run of a breach continues
    through the wall to the target.

    Args:
        failure: The failure.
        known: Its recorded run, if that has been done already.

    Raises:
        InvalidParameter: If the failure's controller cannot be found.
    """
    episode = failure.run() if known is None else known
    words = describe_evidence(episode)
    if not failure.is_breach:
        return episode, words + failure.violation.in_words
    whole = failure.run(through_walls=True)
    return whole, f"{words}: reached a walled-off target in step {whole.steps}"
