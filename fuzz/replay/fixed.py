"""Whether a stored failure is fixed: the robot arrives now, or stays where it should."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fuzz.failure import Failure
from fuzz.oracles import Asked, objection_in_words
from fuzz.triage.judging import judge, judge_asked
from fuzz.triage.proofs import certificate_fault, certified
from sim.controllers.contract import check_contract
from sim.describe import evidence_in_words
from sim.episode import Episode
from sim.options.run import RunOptions, step_budget
from sim.scenario import Scenario
from sim.verdict import UNENDED, Verdict
from worldgen.errors import InvalidWorld
from worldgen.world import Cut, World

__all__ = ["Checked", "Seen", "arrives", "is_fixed", "who_drives"]


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


def is_fixed(failure: Failure, controller: str | None = None) -> Checked:
    """Run a stored failure's world again and say why it is not fixed, if it is not.

    Args:
        failure: From its file.
        controller: Instead of the one that the record names.

    Raises:
        InvalidParameter: If a name is unknown.
    """
    failure = failure.driven_by(controller)
    world, stored = failure.world, failure.options
    options = replace(stored, steps=max(stored.steps, step_budget(world, stored.time_step)))
    asked = None if failure.oracle is None else Asked.parse(failure.oracle)
    checked, wrong = _checked(world, failure.scenario, options, failure.expectations)
    episode = checked.seen.episode
    if asked is None or wrong or checked.reason or episode is None or episode.verdict != Verdict.REACHED:
        return checked
    said = judge_asked(world, failure.record.controller, options, asked)[1]
    words = "" if said is None else _ended(failure.scenario, episode) + objection_in_words(asked.text, said)
    return Checked(words, checked.seen)


def arrives(world: World, controller: str) -> Checked:
    """Run a controller in a world without a failure, and say why it does not arrive, if it does not.

    Raises:
        InvalidParameter: If a name is unknown.
        InvalidWorld: If the target cannot be reached.
    """
    proved = world if world.certificate is not None else certified(world)
    if proved is None:
        raise InvalidWorld(
            "not-proved-reachable",
            "it is not proved that this world's target can be reached",
            "worldgen verify says more",
            at_terminal=True,
        )
    scenario = Scenario.parse(controller)
    expected = UNENDED if isinstance(proved.certificate, Cut) else (Verdict.REACHED,)
    return _checked(proved, scenario, scenario.options(proved), expected)[0]


def _checked(
    world: World, scenario: Scenario, options: RunOptions, expected: tuple[Verdict, ...]
) -> tuple[Checked, str]:
    """The outcome of a run against the verdicts that are right there, and what is wrong with its own verdict."""
    fault = certificate_fault(world)
    if fault:
        return Checked(f"the file proves nothing: {fault}; make the failure again", Seen(world)), ""
    episode, wrong = judge(world, scenario.controller, options)
    check_contract(scenario.controller, episode.evidence, episode.steps)
    seen = Seen(world, scenario, options, episode)
    ended = _ended(scenario, episode)
    if episode.verdict not in expected:
        what = "the target is walled off" if Verdict.REACHED not in expected else "the target can be reached"
        joined = ", where" if Verdict.REACHED not in expected else ", though"
        return Checked(f"{ended}{joined} {what}", seen), wrong
    return Checked(f"{ended}, but {wrong}" if wrong and Verdict.REACHED in expected else "", seen), wrong


def _ended(scenario: Scenario, episode: Episode) -> str:
    return f"{who_drives(scenario)}: {episode.verdict}{evidence_in_words(episode)}"


def who_drives(scenario: Scenario) -> str:
    """Return ``turn-left under swept``, with the options that vary the run."""
    return f"{scenario.label(scenario.motion, scenario.time_step)} under {scenario.motion}"
