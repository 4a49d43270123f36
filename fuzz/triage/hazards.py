"""Hazards that a controller cannot sense, or withstand, so that failing is not its fault."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from fuzz.failure import Failure
from sim.controllers import CONTROLLERS, Controller
from sim.controllers.base import DEFAULT_SENSES, robot_for, wants_world
from sim.options.disturbances import why_arrival_is_not_certain
from sim.options.robot import RobotOptions
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER, Verdict
from worldgen.timeline import CellState
from worldgen.world import Value, World

__all__ = ["HAZARD", "can_sense", "hazard_details", "hazard_words", "is_hazard", "is_unsensed"]

HAZARD = "hazard"
"""The detail of a failure's record that may be ``unsensed``, or ``disturbed`` with the reason."""

_UNSENSED = "unsensed"
_DISTURBED = "disturbed: "
_SMOKE_SENSES = ("signal", "signal_heading")


def can_sense(controller: Controller, robot: RobotOptions, state: str, how: str) -> bool:
    """Return True if any of a controller's senses could show it what burned the robot.

    Args:
        controller: The controller, whose declared ``senses`` and ``reset`` count.
        robot: Options of the robot in the run.
        state: State of the cell: ``burning``, or ``solid`` for debris and moving walls.
        how: ``entered`` if the cell was in that state before the step, ``caught`` if it changed
            during the step.
    """
    if wants_world(controller):
        return True
    senses = getattr(controller, "senses", DEFAULT_SENSES)
    robot = robot_for(controller, robot)
    if state == CellState.BURNING.word:
        # Only smoke shows fire: rays and beams pass through flames.
        return robot.smoke > 0.0 and any(name in senses for name in _SMOKE_SENSES)
    return how == "entered" and robot.beams > 0 and "beams" in senses


def hazard_details(world: World, verdict: str, kind: str, scenario: Scenario) -> dict[str, Value]:
    """Return the record's details if a failure is not the controller's fault.

    That is the case if the robot burned and its controller could not have known, or if something
    moves the robot so that no controller is certain to arrive.

    Args:
        world: The world, with its certificate.
        verdict: Verdict of the run.
        kind: The failure's bucket, whose words state what burned the robot.
        scenario: The scenario that ran.
    """
    uncertain = why_arrival_is_not_certain(world, scenario.run.robot)
    if uncertain and verdict not in BY_THE_CONTROLLER:
        return {HAZARD: _DISTURBED + uncertain}
    if verdict != Verdict.BURNED:
        return {}
    _, state, how = (*kind.split("-"), "", "")[:3]
    controller = CONTROLLERS.get(scenario.controller)
    return {} if can_sense(controller, scenario.run.robot, state, how) else {HAZARD: _UNSENSED}


def is_unsensed(details: Mapping[str, Value]) -> bool:
    """Return True if, according to a record's details, its controller cannot sense what burned it."""
    return details.get(HAZARD) == _UNSENSED


def is_hazard(failure: Failure) -> bool:
    """Return True if the failure is a hazard that its controller cannot sense or withstand."""
    return is_unsensed(failure.record.details) or _is_disturbed(failure)


def hazard_words(failures: Iterable[Failure]) -> str:
    """Return what to call these hazards: ``hazards it cannot sense``, or ``sense or withstand``."""
    disturbed = any(_is_disturbed(failure) for failure in failures)
    return "hazards it cannot sense or withstand" if disturbed else "hazards it cannot sense"


def _is_disturbed(failure: Failure) -> bool:
    return str(failure.record.details.get(HAZARD, "")).startswith(_DISTURBED)
