"""Whether a stored failure is fixed: the robot arrives now, or stays where it should."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fuzz.asked import asked_by, objection_in_words
from fuzz.failure import certificate_fault, certified, judge, judge_asked, scenario_of
from sim.controllers.contract import check_contract
from sim.episode import Episode
from sim.run_options import RunOptions, step_budget
from sim.scenario import Scenario
from sim.verdict import UNENDED, Verdict
from sim.words import evidence_in_words
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.world import Cut, World

__all__ = ["Checked", "Seen", "fixed", "who_drives"]


@dataclass(frozen=True)
class Seen:
    """What a test looked at.

    Args:
        world: The world, without a record of an older failure.
        scenario: What ran in it; ``None`` if nothing did.
        options: How it ran.
        episode: How it ended, recorded.
        stored: The file, if it shows the same again.
    """

    world: World
    scenario: Scenario | None = None
    options: RunOptions | None = None
    episode: Episode | None = None
    stored: str = ""


@dataclass(frozen=True)
class Checked:
    """Whether a stored failure is as expected.

    Args:
        reason: Why it is not; empty if it is.
        seen: What was looked at.
    """

    reason: str
    seen: Seen


def fixed(world: World, controller: str | None = None) -> Checked:
    """Run a world, or that of a stored failure, and say why it is not fixed, if it is not.

    Args:
        world: With a failure's record or without.
        controller: Instead of the one that the record names; a world without a failure needs one.

    Raises:
        InvalidParameter: If a name is unknown, or the world holds no failure and no controller is named.
        InvalidWorld: If it holds no failure and its target cannot be reached.
    """
    asked = asked_by(world.failure.evidence) if world.failure else None
    world, scenario, options = _what_runs(world, controller)
    fault = certificate_fault(world)
    if fault:
        return Checked(f"the file proves nothing: {fault}; make the failure again", Seen(world))
    episode, wrong = judge(world, scenario.controller, options)
    check_contract(scenario.controller, episode.evidence, episode.steps)
    seen = Seen(world, scenario, options, episode)
    ended = f"{who_drives(scenario)}: {episode.verdict}{evidence_in_words(episode)}"
    if isinstance(world.certificate, Cut):
        return Checked("" if episode.verdict in UNENDED else f"{ended}, where the target is walled off", seen)
    if episode.verdict == Verdict.REACHED and asked is not None and not wrong:
        said = judge_asked(world, scenario.controller, options, asked)[1]
        words = "" if said is None else objection_in_words({"oracle": asked.text, "objection": said})
        return Checked(f"{ended}{words}" if words else "", seen)
    if episode.verdict == Verdict.REACHED:
        return Checked(f"{ended}, but {wrong}" if wrong else "", seen)
    return Checked(f"{ended}, though the target can be reached", seen)


def _what_runs(world: World, controller: str | None) -> tuple[World, Scenario, RunOptions]:
    """The world without its record, what is to run in it, and with which budget."""
    if world.failure is not None:
        record, stored = scenario_of(world)
        options = replace(stored, steps=max(stored.steps, step_budget(world, stored.time_step)))
        return replace(world, failure=None), Scenario.of(controller or record.controller, options), options
    if controller is None:
        raise InvalidParameter(
            "no-failure",
            "this world holds no failure, so it names no controller",
            "give --worldgen-controller",
            at_terminal=True,
        )
    proved = world if world.certificate is not None else certified(world)
    if proved is None:
        raise InvalidWorld(
            "not-proved-reachable",
            "it is not proved that this world's target can be reached",
            "worldgen verify says more",
            at_terminal=True,
        )
    scenario = Scenario.parse(controller)
    return proved, scenario, scenario.options(proved)


def who_drives(scenario: Scenario) -> str:
    """Return ``turn-left under swept``, with the options that vary the run."""
    return f"{scenario.label(scenario.motion, scenario.time_step)} under {scenario.motion}"
