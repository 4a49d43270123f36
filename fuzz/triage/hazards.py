"""Hazards that a controller cannot sense.

A robot that burns there is no fault of its controller.
"""

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
"""The detail of a failure's record that says ``unsensed``."""

_UNSENSED = "unsensed"
_SMOKE_SENSES = ("signal", "signal_heading")


def can_sense(controller: Controller, robot: RobotOptions, state: str, how: str) -> bool:
    """Return True if something that a controller is shown tells it of what burned the robot.

    Args:
        controller: Whose ``senses`` and ``reset`` count, as it declares them.
        robot: Its options in the run.
        state: What the cell was: ``burning``, or ``solid`` for debris and moving walls.
        how: ``entered`` where the cell was so before the step, ``caught`` where it became so in the
            step.
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
    """Return what a failure's record says if the robot burned where its controller could not have known better.

    Args:
        verdict: Of the run.
        kind: The failure's class, whose words say what burned the robot.
        scenario: What ran.
    """
    if verdict != Verdict.BURNED:
        return {}
    _, state, how = (*kind.split("-"), "", "")[:3]
    controller = CONTROLLERS.get(scenario.controller)
    return {} if can_sense(controller, scenario.robot, state, how) else {HAZARD: _UNSENSED}


def is_unsensed(failure: Failure) -> bool:
    """Return True if a failure is one of a hazard that its controller cannot sense."""
    return failure.record.details.get(HAZARD) == _UNSENSED
