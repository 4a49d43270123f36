"""Fill in the core's settings of a run from its world, controller and options."""

from __future__ import annotations

import math
from typing import Any

from sim._core import lib
from sim.controllers.base import CompiledController, Controller, senses_of
from sim.motion import MOTIONS
from sim.options.robot import SIGNALS
from sim.options.run import RunOptions
from sim.runners.packing import disc_numbers, target_sq
from worldgen.lattice import TURN, UNIT, exact, metres_to_lattice
from worldgen.world import World

__all__ = ["fill_settings"]


def fill_settings(settings: Any, world: World, controller: Controller, options: RunOptions) -> None:
    """Fill in all that does not depend on the walls, in the core's units.

    What is left to the caller: the start, which must be clear of walls, disturbances, and what each
    run sets for itself: ``steps``, ``digest`` and ``find_loop``.

    Args:
        settings: The core's ``WgSettings``, all zero.
        world: The world; only the robot's disc, its speed, target and cell size matter.
        controller: The controller, which decides the senses that are computed.
        options: Options of the run, with the robot that this controller needs.
    """
    # Target and disc, in lattice units.
    step = options.time_step
    settings.clear_sq, settings.reach = disc_numbers(world)
    settings.target_x = metres_to_lattice(world.target.x, world.cell_size)
    settings.target_y = metres_to_lattice(world.target.y, world.cell_size)
    settings.target_radius_sq = target_sq(world)
    motion = MOTIONS.get(options.motion)
    settings.motion = motion.code
    settings.seed = options.seed

    # Factors between the lattice and SI units.
    settings.metres = float(exact(world.cell_size) / UNIT)
    settings.speed = float(exact(step) / exact(world.cell_size) * UNIT)
    settings.turn = step * (TURN / (2.0 * math.pi))
    settings.radians = 2.0 * math.pi / TURN
    settings.time_step = step
    settings.top_speed = world.robot_speed
    settings.radius = world.robot_radius
    settings.tolerance = motion.overlap_tolerance * UNIT
    # A compiled controller may set its own initial speed.
    if isinstance(controller, CompiledController):
        settings.start_speed = min(controller.start_speed, world.robot_speed)
    _fill_dynamics(settings, options)
    _fill_sensors(settings, options, senses_of(controller))


def _fill_dynamics(settings: Any, options: RunOptions) -> None:
    """Fill in the dynamics; an option that is off becomes a limit that is never reached."""
    robot = options.robot
    gain = options.time_step * settings.speed * lib.WG_SPEED_UNIT
    settings.turn_limit = robot.turn_limit or math.inf
    settings.gain = max(1.0, robot.acceleration * gain) if robot.acceleration else math.inf
    settings.loss = max(1.0, robot.friction * gain) if robot.friction else math.inf
    settings.wall_friction = robot.wall_friction
    settings.slip = robot.slip
    settings.odometry_noise = robot.odometry_noise
    settings.lattice = UNIT // robot.lattice if robot.lattice else 1


def _fill_sensors(settings: Any, options: RunOptions, senses: int) -> None:
    robot = options.robot
    unit = settings.metres
    settings.senses = senses & ~(0 if robot.beams else lib.WG_SENSE_BEAMS)
    settings.sensor_cells = robot.sensor_cells
    settings.signal = SIGNALS.index(robot.signal)
    settings.plain_sensor = int(robot.plain_sensor)
    settings.sensor_range = robot.sensor_range / unit if robot.sensor_range else math.inf
    settings.sensor_field = _units(robot.sensor_field or 2 * math.pi) / 2
    settings.sensor_noise = robot.sensor_noise
    settings.smoke = robot.smoke
    settings.smoke_reach = robot.smoke_reach
    settings.beams = robot.beams
    settings.neighbours = robot.neighbours
    settings.neighbour_range = robot.neighbour_range / unit
    settings.beam_range = robot.beam_range / unit
    settings.beam_field = _units(robot.beam_field or 2 * math.pi)
    settings.beam_noise = robot.beam_noise
    settings.beam_dropout = robot.beam_dropout
    settings.coin = robot.coin


def _units(radians: float) -> float:
    """Return an angle in heading units; a whole turn is exact."""
    return TURN * (radians / (2 * math.pi))
