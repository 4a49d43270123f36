"""Failures in words: what happened, the picture, the line that replays it."""

from __future__ import annotations

import shlex
import sys
from collections import Counter
from pathlib import Path

from fuzz.asked import objection_in_words
from fuzz.boundary import boundaries_in_words
from fuzz.failure import regardless_of_walls, scenario_of
from sim.episode import Episode, simulate
from sim.evidence import Evidence, fault_evidence
from sim.picture import trail_of
from sim.run_options import RunOptions
from sim.scenario import Scenario
from sim.stopping import OutOfTime
from sim.words import evidence_in_words, frames_in_words
from worldgen.cli.output import shown
from worldgen.plain_text import counted, shown_lines
from worldgen.render import draw_terminal, wants_color
from worldgen.world import Cut, World

_CHANCES = {
    "sure": ", arrives with probability one but not in time",
    "trap": ", never arrives whatever it draws",
    "part": ", some draws are lost for ever",
}

__all__ = ["describe", "replay_line", "run_to_draw", "seeds_in_words"]


def replay_line(path: Path) -> str:
    """The command that shows a failure again."""
    return f"worldgen replay {shlex.quote(str(path))}"


def seeds_in_words(world: World) -> str:
    """For how many seeds a failure occurs: ``39 of 40 seeds fail``; empty where its record does not say it."""
    seeds = world.failure.details.get("failing_seeds") if world.failure else None
    if not isinstance(seeds, list) or len(seeds) != 2:
        return ""
    return f"{seeds[0]} of {seeds[1]} seeds {'get there' if isinstance(world.certificate, Cut) else 'fail'}"


def describe(world: World, path: Path, *, met: Counter[str] | None = None) -> str:
    """A failure for the terminal: what happened, the picture, the line that replays it."""
    record = world.failure
    if record is None:
        return str(path)
    options = RunOptions.of(record.motion, record.seed, record.parameters)
    evidence: Evidence
    try:
        episode, words = run_to_draw(world)
        trail, evidence = trail_of(episode, world), episode.evidence
    except OutOfTime:  # the controller is slow, and its run no longer needed
        words, trail, evidence = "", None, fault_evidence(record.evidence)
    who = Scenario.of(record.controller, options).label(record.motion, options.time_step)
    kind = str(record.details.get("class", record.verdict))
    often = f", met {counted(met[kind], 'time')}" if met and met[kind] else ""
    seeds = seeds_in_words(world)
    chance = f", {seeds}" if seeds else ""
    chance += _CHANCES.get(str(record.details.get("chance")), "")
    begins = boundaries_in_words(world)
    minimal = ", 1-minimal" if record.details.get("one_minimal") is True else ""
    color = wants_color(sys.stdout)
    return (
        f"{shown(who)} under {record.motion}: {record.verdict}{shown(words)}\n"
        f"{shown_lines(frames_in_words(evidence))}"
        f"  class {shown(kind)}{often}; "
        f"{world.width} x {world.height} cells, {world.solid_cells} solid{minimal}{chance}\n"
        f"{f'  {begins}{chr(10)}' if begins else ''}"
        f"{draw_terminal(world, trail=trail, color=color)}"
        f"  {shown(replay_line(path))}\n"
    )


def run_to_draw(world: World) -> tuple[Episode, str]:
    """A failure's run, and what happened in words that start with a blank; a breach is drawn up to the target.

    Raises:
        InvalidParameter: If the world holds no failure, or its controller cannot be found here.
    """
    record, options = scenario_of(world)
    episode = simulate(world, record.controller, options, record=True)
    words = evidence_in_words(episode)
    if not isinstance(world.certificate, Cut):
        return episode, words + objection_in_words(record.evidence)
    whole = simulate(world, record.controller, regardless_of_walls(options), record=True)
    return whole, f"{words}: reached a walled-off target in step {whole.steps}"
