"""Hazards that a controller cannot sense, or withstand, so that failing is not its fault."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum

from fuzz.failure import Failure
from fuzz.triage.signature import is_entered
from sim.controllers import CONTROLLERS, Controller
from sim.controllers.base import DEFAULT_SENSES, robot_for, wants_world
from sim.episode import Episode
from sim.evidence import BurnedEvidence
from sim.fleet import FleetEpisode
from sim.options.disturbances import Doubt, why_arrival_is_not_certain
from sim.options.robot import RobotOptions
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER
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
        controller: The controller, whose declared ``senses`` and ``reset`` count.
        robot: Options of the robot in the run.
        state: State of the cell: ``burning``, or ``solid`` for debris and moving walls.
        entered: Whether the cell was in that state before the step, and did not change during it.
    """
    if wants_world(controller):
        return True
    senses = getattr(controller, "senses", DEFAULT_SENSES)
    robot = robot_for(controller, robot)
    if state == CellState.BURNING.word:
        # Only smoke shows fire: rays and beams pass through flames.
        return robot.smoke > 0.0 and any(name in senses for name in _SMOKE_SENSES)
    return entered and robot.beams > 0 and "beams" in senses


def is_harm_unsensed(world: World, episode: Episode, scenario: Scenario) -> bool:
    """Return True if the robot burned, and its controller could not have sensed what burned it.

    Args:
        world: World of the run.
        episode: The run, recorded.
        scenario: The scenario that ran.
    """
    evidence = episode.evidence
    if not isinstance(evidence, BurnedEvidence):
        return False
    if isinstance(episode, FleetEpisode) and evidence.robot is not None:
        alone = world.alone(evidence.robot)
        return is_harm_unsensed(alone, episode.robots[evidence.robot - 1], scenario)
    if episode.trace is None:
        return False
    entered = is_entered(world, episode.trace, evidence)
    controller = CONTROLLERS.get(scenario.controller)
    return not can_sense(controller, scenario.run.robot, evidence.state, entered=entered)


def hazard_details(world: World, episode: Episode, scenario: Scenario) -> dict[str, Value]:
    """Return the record's details if a failure is not the controller's fault.

    That is the case if the robot burned and its controller could not have known, or if something
    moves the robot so that no controller is certain to arrive.

    Args:
        world: The world, with its certificate.
        episode: The run, recorded.
        scenario: The scenario that ran.
    """
    doubt = why_arrival_is_not_certain(world, scenario.run.robot)
    if doubt is not None and episode.verdict not in BY_THE_CONTROLLER:
        return {_HAZARD: Hazard.DISTURBED.value, _DOUBT: doubt.value}
    return {_HAZARD: Hazard.UNSENSED.value} if is_harm_unsensed(world, episode, scenario) else {}


def hazard_in(details: Mapping[str, Value]) -> Hazard | None:
    """Return the hazard that a record's details state, or ``None``."""
    # Earlier versions wrote "disturbed: " and the reason in words.
    name = str(details.get(_HAZARD, "")).partition(": ")[0]
    return Hazard(name) if name in set(Hazard) else None


def doubt_in(details: Mapping[str, Value]) -> str:
    """Return in words why, according to a record, no controller is certain to arrive.

    Empty if the record gives no reason.
    """
    doubt = str(details.get(_DOUBT, ""))
    if doubt in set(Doubt):
        return Doubt(doubt).sentence
    return str(details.get(_HAZARD, "")).partition(": ")[2]


def is_hazard(failure: Failure) -> bool:
    """Return True if the failure is a hazard that its controller cannot sense or withstand."""
    return hazard_in(failure.record.details) is not None


def hazard_words(failures: Iterable[Failure]) -> str:
    """Return what to call these hazards: ``hazards it cannot sense``, or ``sense or withstand``."""
    hazards = {hazard_in(failure.record.details) for failure in failures}
    withstand = " or withstand" if Hazard.DISTURBED in hazards else ""
    return f"hazards it cannot sense{withstand}"
