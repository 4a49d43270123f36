"""Hazards that a controller cannot sense, or withstand, so that failing is not its fault."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum

from fuzz.facts.changed_worlds import OtherWorlds, fails_by_timing
from fuzz.facts.signature import is_entered
from fuzz.failure import Failure
from sim.controllers import CONTROLLERS, Controller
from sim.controllers.base import DEFAULT_SENSES, robot_for
from sim.controllers.timeline_reads import noting_reads
from sim.episode import Episode, simulate
from sim.evidence import BurnedEvidence
from sim.options.disturbances import Doubt, why_arrival_is_not_certain
from sim.options.robot import RobotOptions
from sim.outcome import FleetEpisode
from sim.runners.controller_host import host_of
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER, OUT_OF_BUDGET, Verdict
from worldgen.errors import WorldgenError
from worldgen.timeline import CellState
from worldgen.world import Value, World

_HAZARD = "hazard"
_DOUBT = "hazard_reason"
HAZARD_DETAILS = (_HAZARD, _DOUBT)
"""Names of the details of a failure's record that describe a hazard."""

_SMOKE_SENSES = ("signal", "signal_heading")


class Hazard(StrEnum):
    """Why a failure is not its controller's fault."""

    UNSENSED = "unsensed"
    DISTURBED = "disturbed"


def can_sense(controller: Controller, robot: RobotOptions, state: str, *, entered: bool) -> bool:
    """Return True if any of a controller's senses could show it what burned the robot.

    Args:
        controller: The controller, whose declared ``senses`` count.
        robot: Options of the robot in the run.
        state: State of the cell: ``burning``, or ``solid`` for debris and moving walls.
        entered: Whether the cell was in that state before the step, and did not change during it.
    """
    senses = getattr(controller, "senses", DEFAULT_SENSES)
    robot = robot_for(controller, robot)
    if state == CellState.BURNING.word:
        # Only smoke shows fire: rays and beams pass through flames.
        return robot.smoke > 0.0 and any(name in senses for name in _SMOKE_SENSES)
    return entered and robot.beams > 0 and "beams" in senses


def could_not_know(world: World, episode: Episode, scenario: Scenario) -> bool:
    """Return True if a change harmed the robot or shut its way, and its controller could not know.

    A controller knows of a change if a sense shows it, or if it reads the changes of the world that
    its ``reset`` gets.

    Args:
        world: World of the run.
        episode: The run, recorded if the robot burned.
        scenario: The scenario that ran.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if isinstance(episode.evidence, BurnedEvidence):
        is_hidden = _is_harm_hidden(world, episode, scenario, controller)
    else:
        is_hidden = _is_plan_outdated(world, episode, scenario, controller)
    steps = max(scenario.options(world).steps, episode.steps)
    return is_hidden and not _reads_changes(world, scenario, controller, steps)


def _is_harm_hidden(
    world: World, episode: Episode, scenario: Scenario, controller: Controller
) -> bool:
    """Return True if the robot burned, and no sense showed what burned it."""
    evidence = episode.evidence
    if not isinstance(evidence, BurnedEvidence):
        return False
    if isinstance(episode, FleetEpisode) and evidence.robot is not None:
        alone = world.alone(evidence.robot)
        own = episode.robots[evidence.robot - 1]
        return _is_harm_hidden(alone, own, scenario, controller)
    if episode.trace is None:
        return False
    entered = is_entered(world, episode.trace, evidence)
    return not can_sense(controller, scenario.run.robot, evidence.state, entered=entered)


def _is_plan_outdated(
    world: World, episode: Episode, scenario: Scenario, controller: Controller
) -> bool:
    """Return True if a robot that planned on a map never arrives because the map has changed.

    A robot that does not plan has sensed the walls that it remembers, and so can sense them again.
    """
    stuck = episode.verdict == Verdict.LOOP or episode.verdict in OUT_OF_BUDGET
    if not stuck or world.is_fleet or not world.is_dynamic or not _is_planner(controller):
        return False
    if can_sense(controller, scenario.run.robot, CellState.SOLID.word, entered=True):
        return False
    others = OtherWorlds(scenario.controller, scenario.options(world))
    return fails_by_timing(world, others.arrives)


def _is_planner(controller: Controller) -> bool:
    return host_of(controller).plans


def _reads_changes(world: World, scenario: Scenario, controller: Controller, steps: int) -> bool:
    """Return True if a controller reads the future changes of its world within some steps.

    Vector classes, compiled controllers and programs do not get the world.
    """
    if not _is_planner(controller):
        return False
    with noting_reads() as reads:
        try:
            simulate(world, scenario.controller, scenario.options(world, steps))
        except WorldgenError:
            return True
    return reads.any


def hazard_details(world: World, episode: Episode, scenario: Scenario) -> dict[str, Value]:
    """Return the record's details if a failure is not the controller's fault.

    That is the case if its controller could not have known of the change that harmed it or shut its
    way, or if something moves the robot so that no controller is certain to arrive.

    Args:
        world: The world, with its certificate.
        episode: The run, recorded if the robot burned.
        scenario: The scenario that ran.
    """
    doubt = why_arrival_is_not_certain(world, scenario.run.robot)
    if doubt is not None and episode.verdict not in BY_THE_CONTROLLER:
        return {_HAZARD: Hazard.DISTURBED.value, _DOUBT: doubt.value}
    return {_HAZARD: Hazard.UNSENSED.value} if could_not_know(world, episode, scenario) else {}


def hazard_in(details: Mapping[str, Value]) -> Hazard | None:
    """Return the hazard that a record's details state, or ``None``."""
    name = str(details.get(_HAZARD, ""))
    return Hazard(name) if name in set(Hazard) else None


def doubt_in(details: Mapping[str, Value]) -> str:
    """Return in words why, according to a record, no controller is certain to arrive.

    Empty if the record gives no reason.
    """
    doubt = str(details.get(_DOUBT, ""))
    return Doubt(doubt).sentence if doubt in set(Doubt) else ""


def is_hazard(failure: Failure) -> bool:
    """Return True if the failure is a hazard that its controller cannot sense or withstand."""
    return hazard_in(failure.record.details) is not None


def hazard_words(failures: Iterable[Failure]) -> str:
    """Return what to call these hazards: ``hazards it cannot sense``, or ``sense or withstand``."""
    hazards = {hazard_in(failure.record.details) for failure in failures}
    withstand = " or withstand" if Hazard.DISTURBED in hazards else ""
    return f"hazards it cannot sense{withstand}"
