"""The simulator's own random numbers that reach a run."""

from __future__ import annotations

from sim._core import lib
from sim.controllers.base import CompiledController, Controller, robot_for, senses_of
from sim.options.robot import RobotOptions
from sim.options.run import RunOptions


def noisy_senses(robot: RobotOptions) -> int:
    """Return the ``WG_SENSE_`` bits of the senses that an option of the robot makes random."""
    bits = 0
    if robot.odometry_noise > 0.0:
        bits |= lib.WG_SENSE_ODOMETRY
    if robot.sensor_noise > 0.0:
        bits |= lib.WG_SENSE_SIGNAL | lib.WG_SENSE_SIGNAL_HEADING
    if robot.beams and (robot.beam_noise > 0.0 or robot.beam_dropout > 0.0):
        bits |= lib.WG_SENSE_BEAMS
    return bits


def is_noisy(controller: Controller, run: RunOptions) -> bool:
    """Return True if the simulator's own random numbers can change a run of a controller.

    Noise in a sense that the controller does not declare cannot: the core never computes it. Then
    one seed stands for all, and a loop can be proved.

    Args:
        controller: The controller; one that declares no senses reads everything but the clock.
        run: Options of the run.
    """
    robot = robot_for(controller, run.robot)
    noise = bool(senses_of(controller) & noisy_senses(robot))
    return run.thesis.random or robot.slip > 0.0 or noise


def is_random(controller: Controller, options: RunOptions) -> bool:
    """Return True if a controller declares that it draws random numbers, or there is noise."""
    draws = isinstance(controller, CompiledController) and controller.randomised
    return draws or is_noisy(controller, options)
