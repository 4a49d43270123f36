"""Check whether a stored failure is fixed: the robot now arrives, or stays out as it should."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fuzz.facts.proofs import certificate_fault, certified
from fuzz.failure import Failure
from fuzz.oracles import Oracle, Trial, verdict_oracle
from fuzz.triage.judging import oracle_of, violation_in
from sim.controllers.contract import check_contract
from sim.episode import Episode
from sim.episode.describe import describe_evidence
from sim.options.run import RunOptions, step_budget
from sim.scenario import Scenario
from sim.verdict import ARRIVALS, UNENDED
from worldgen.errors import InvalidWorld
from worldgen.world import Cut, World


@dataclass(frozen=True)
class RegressionRun:
    """The run on which a regression test was decided.

    Args:
        world: The world, without the record of an older failure.
        scenario: The scenario that ran; ``None`` if nothing ran.
        options: Options of the run.
        episode: The recorded run.
        stored: The command that replays the stored file, if it shows the same.
    """

    world: World
    scenario: Scenario | None = None
    options: RunOptions | None = None
    episode: Episode | None = None
    stored: str = ""


@dataclass(frozen=True)
class Checked:
    """The result of checking a stored failure.

    Args:
        reason: Why it is not as expected; empty if it is.
        seen: The run that was checked.
    """

    reason: str
    seen: RegressionRun


def is_fixed(failure: Failure, controller: str | None = None) -> Checked:
    """Run a stored failure's world again; if it is not fixed, report why.

    Args:
        failure: The stored failure.
        controller: A controller to use instead of the recorded one.

    Raises:
        InvalidParameter: If a name is unknown.
    """
    failure = failure.driven_by(controller)
    world = failure.world
    stored = failure.options
    budget = step_budget(world, stored)
    options = replace(stored, steps=max(stored.steps, budget))
    return _checked(world, failure.scenario, options, oracle_of(failure))


def arrives(world: World, controller: str) -> Checked:
    """Run a controller in a world without a failure; if it does not arrive, report why.

    Raises:
        InvalidParameter: If a name is unknown.
        InvalidWorld: If the target cannot be reached.
    """
    proved = world if world.certificate is not None else certified(world)
    if proved is None:
        raise InvalidWorld(
            "not-proved-reachable",
            "this world's target is not proved to be reachable",
            "see worldgen verify",
            at_terminal=True,
        )
    scenario = Scenario.parse(controller)
    return _checked(proved, scenario, scenario.options(proved), verdict_oracle(proved))


def _checked(world: World, scenario: Scenario, options: RunOptions, oracle: Oracle) -> Checked:
    """Run a scenario and check its verdict, and what the oracle finds, against the certificate."""
    fault = certificate_fault(world, options.motion)
    if fault:
        return Checked(
            f"the file proves nothing: {fault}; create the failure again", RegressionRun(world)
        )
    trial = Trial.recorded(world, scenario.controller, options)
    episode = trial.episode
    check_contract(scenario.controller, episode.evidence, episode.steps)
    seen = RegressionRun(world, scenario, options, episode)
    ended = f"{who_drives(scenario)}: {episode.verdict}{describe_evidence(episode)}"

    # If the target is walled off, the robot only has to stay out.
    if isinstance(world.certificate, Cut):
        stays_out = episode.verdict in UNENDED
        return Checked("" if stays_out else f"{ended}, but the target is walled off", seen)
    if episode.verdict not in ARRIVALS:
        return Checked(f"{ended}, but the target can be reached", seen)
    if trial.flaw:
        return Checked(f"{ended}, but {trial.flaw}", seen)
    found = violation_in(trial, oracle)
    return Checked("" if found is None else ended + found.in_words, seen)


def who_drives(scenario: Scenario) -> str:
    """Describe the controller and the motion model: ``turn-left under swept``."""
    return f"{scenario.label()} under {scenario.run.motion}"
