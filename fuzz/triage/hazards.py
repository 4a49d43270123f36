"""Hazards that a controller cannot sense, so that burning there is not the controller's fault."""

from __future__ import annotations

from fuzz.failure import Failure
from sim.controllers import CONTROLLERS, Controller
from sim.controllers.base import DEFAULT_SENSES, robot_for, wants_world
from sim.options.robot import RobotOptions
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.timeline import CellState
from worldgen.world import Value

__all__ = ["HAZARD", "can_sense", "hazard_details", "is_unsensed"]

HAZARD = "hazard"
"""The detail of a failure's record that may be ``unsensed``."""

_UNSENSED = "unsensed"
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


def hazard_details(verdict: str, kind: str, scenario: Scenario) -> dict[str, Value]:
    """Return the record's details if the robot burned where its controller could not know better.

    Args:
        verdict: Verdict of the run.
        kind: The failure's bucket, whose words state what burned the robot.
        scenario: The scenario that ran.
    """
    if verdict != Verdict.BURNED:
        return {}
    _, state, how = (*kind.split("-"), "", "")[:3]
    controller = CONTROLLERS.get(scenario.controller)
    return {} if can_sense(controller, scenario.run.robot, state, how) else {HAZARD: _UNSENSED}


def is_unsensed(failure: Failure) -> bool:
    """Return True if the failure is a hazard that its controller cannot sense."""
    return failure.record.details.get(HAZARD) == _UNSENSED
