"""Decide which of a robot's sensors are drawn with its run."""

from __future__ import annotations

from typing import Any

from sim.controllers.base import Controller, robot_for
from sim.motion import MOTIONS, THESIS
from sim.options.run import RunOptions

__all__ = ["sensors_of"]


def sensors_of(controller: Controller, options: RunOptions, side: float) -> dict[str, Any]:
    """Return the range beams, in cells and rad, and whether to tint the floor by the signal.

    The floor can only be tinted by a signal that walls do not block.

    Args:
        controller: The controller.
        options: Options of the run.
        side: Size of a cell, m.
    """
    if MOTIONS.get(options.motion).kernel == THESIS:
        return {"beams": 0, "signal": options.thesis.signal == "open"}
    robot = robot_for(controller, options.robot)
    return {
        "beams": robot.beams,
        "range": min(robot.beam_range / side, 1e6),
        "field": robot.beam_field,
        "signal": robot.signal == "open",
    }
