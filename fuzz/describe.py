"""Failures in words: what happened, the picture, the line that replays it."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from fuzz.boundary import boundaries_in_words
from fuzz.failure import Failure
from sim.describe import evidence_in_words, frames_in_words
from sim.drawing.picture import trail_of
from sim.episode import Episode
from sim.evidence import Evidence
from sim.runners.stopping import OutOfTime
from worldgen.cli.output import shown
from worldgen.render import draw_terminal, wants_color
from worldgen.support.plain_text import counted, shown_lines

_CHANCES = {
    "sure": ", arrives with probability one but not in time",
    "trap": ", never arrives whatever it draws",
    "part": ", some draws are lost for ever",
}

__all__ = ["describe", "run_to_draw", "seeds_in_words"]


def seeds_in_words(failure: Failure) -> str:
    """For how many seeds a failure occurs: ``39 of 40 seeds fail``; empty where its record does not say it."""
    seeds = failure.record.details.get("failing_seeds")
    if not isinstance(seeds, list) or len(seeds) != 2:
        return ""
    return f"{seeds[0]} of {seeds[1]} seeds {'get there' if failure.is_breach else 'fail'}"


def describe(failure: Failure, path: Path, *, met: Counter[str] | None = None) -> str:
    """A failure for the terminal: what happened, the picture, the line that replays it."""
    world, record, kind = failure.world, failure.record, failure.bucket
    evidence: Evidence | None
    try:
        episode, words = run_to_draw(failure)
        trail, evidence = trail_of(episode, world), episode.evidence
    except OutOfTime:  # the controller is slow, and its run no longer needed
        words, trail, evidence = "", None, failure.evidence
    often = f", met {counted(met[kind], 'time')}" if met and met[kind] else ""
    seeds = seeds_in_words(failure)
    chance = f", {seeds}" if seeds else ""
    chance += _CHANCES.get(str(record.details.get("chance")), "")
    begins = boundaries_in_words(failure)
    minimal = ", 1-minimal" if record.details.get("one_minimal") is True else ""
    color = wants_color(sys.stdout)
    return (
        f"{shown(failure.who)}: {record.verdict}{shown(words)}\n"
        f"{shown_lines(frames_in_words(evidence))}"
        f"  class {shown(kind)}{often}; "
        f"{world.width} x {world.height} cells, {world.solid_cells} solid{minimal}{chance}\n"
        f"{f'  {begins}{chr(10)}' if begins else ''}"
        f"{draw_terminal(failure.stored, trail=trail, color=color)}"
        f"  {shown(failure.replay_command(path))}\n"
    )


def run_to_draw(failure: Failure) -> tuple[Episode, str]:
    """A failure's run, and what happened in words that start with a blank; a breach is drawn up to the target.

    Raises:
        InvalidParameter: If its controller cannot be found here.
    """
    episode = failure.run()
    words = evidence_in_words(episode)
    if not failure.is_breach:
        return episode, words + failure.violation.in_words
    whole = failure.run(through_walls=True)
    return whole, f"{words}: reached a walled-off target in step {whole.steps}"
