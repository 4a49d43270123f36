"""Fill in the core's settings of a run: world, controller, options, and outside forces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.controllers.base import senses_of
from sim.controllers.shared.guarded import CoreMemory
from sim.motion import MOTIONS
from sim.options.disturbances import decoys_of, pushes_of, pushing_places_of
from sim.options.robot import SIGNALS, RobotOptions
from sim.options.run import RunOptions
from sim.runners.controller_host import ControllerHost
from sim.runners.core_calls import headings
from sim.runners.packing import body_of, disc_numbers, target_sq
from worldgen.errors import InvalidParameter
from worldgen.lattice import (
    TURN,
    UNIT,
    exact,
    heading_to_lattice,
    in_cells,
    metres_to_lattice,
    turn_to_lattice,
)
from worldgen.support.arrays import Ints
from worldgen.support.ccall import pointer
from worldgen.world import Target, World

_PUSH_FIELDS = 6  # fields of a WgPush
_SCALE_BITS = 30  # scale of the table of headings
_FASTEST = 1 << 62  # units of speed, more than any robot has
_ARRIVALS = {
    "touch": lib.WG_ARRIVAL_TOUCH,
    "step": lib.WG_ARRIVAL_STEP,
    "stop": lib.WG_ARRIVAL_STOP,
}
_CONTACTS = {
    "slide": lib.WG_CONTACT_SLIDE,
    "stop": lib.WG_CONTACT_STOP,
    "fail": lib.WG_CONTACT_FAIL,
}
_LONGEST_PUSH = 1_000  # cells: beyond that, lattice arithmetic comes near the limit of 64 bits


def fill_settings(settings: Any, world: World, host: ControllerHost, options: RunOptions) -> None:
    """Fill in all that does not depend on the walls, in the core's units.

    The caller sets the rest: the start, which must be clear of walls, disturbances, and the
    settings of each run: ``steps``, ``digest`` and ``find_loop``.

    Args:
        settings: The core's ``WgSettings``, all zero.
        world: The world; only the robot's disc, its speed, goals and cell size matter.
        host: The controller's host; the controller decides the senses that are computed.
        options: Options of the run, with the robot that this controller needs.
    """
    # Goals and disc, in lattice units.
    step = options.time_step
    settings.clear_sq, settings.reach = disc_numbers(world)
    body = body_of(world)
    settings.footprint.count = len(body)
    settings.footprint.x[0 : len(body)] = body[:, 0].tolist()
    settings.footprint.y[0 : len(body)] = body[:, 1].tolist()
    robot = world.robots[0]
    settings.contact = _CONTACTS[robot.contact]
    _fill_goal(settings.target, robot.target, world.cell_size, step)
    settings.waypoint_count = len(robot.waypoints)
    for into, goal in zip(settings.waypoints, robot.waypoints, strict=False):
        _fill_goal(into, goal, world.cell_size, step)
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
    settings.start_speed = min(host.start_speed, world.robot_speed)
    _fill_drive(settings, world)
    _fill_dynamics(settings, options)
    _fill_sensors(settings, options, senses_of(host.controller))


def _fill_drive(settings: Any, world: World) -> None:
    """Fill in what a car can do; by default a robot is none."""
    drive = world.robots[0].drive
    settings.reverse = int(drive.reverse)
    settings.steering_rate = drive.steering_rate or math.inf
    if drive.is_car:
        settings.turning_radius = drive.turning_radius
        settings.turn_per_unit = settings.metres / drive.turning_radius * (TURN / (2.0 * math.pi))


def _fill_goal(into: Any, goal: Target, cell_size: float, time_step: float) -> None:
    """Fill in a ``WgGoal``: its place, and what else it asks for.

    The limits are exact and rounded down, so that nothing above them counts.
    """
    into.x = metres_to_lattice(goal.x, cell_size)
    into.y = metres_to_lattice(goal.y, cell_size)
    into.radius_sq = target_sq(goal, cell_size)
    into.arrival = _ARRIVALS[goal.arrival]
    into.has_heading = int(goal.heading is not None)
    if goal.heading is not None:
        into.heading = heading_to_lattice(goal.heading)
        into.heading_tolerance = min(turn_to_lattice(goal.heading_tolerance), TURN)
    cells = in_cells(goal.arrival_speed, cell_size) * exact(time_step)
    into.arrival_speed = min(math.floor(cells * UNIT * lib.WG_SPEED_UNIT), _FASTEST)
    turn = turn_to_lattice(exact(goal.arrival_turn_rate) * exact(time_step))
    into.arrival_turn = min(turn, TURN)


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


def _units(radians: float) -> float:
    """Return an angle in heading units; a whole turn is exact."""
    return TURN * (radians / (2 * math.pi))


class PackedDisturbances:
    """Pushes, drift and decoys of a run, as a WgSettings points to them.

    Args:
        world: The world.
        robot: Options of the robot.
        time_step: s.
        memory: Where the core will look for the arrays.

    Raises:
        InvalidParameter: If a push is longer than 1,000 cells, or the drift less than half a
            lattice unit a step.
    """

    def __init__(
        self, world: World, robot: RobotOptions, time_step: float, memory: CoreMemory
    ) -> None:
        self._moved = robot.moved
        self._measures = robot.moved or robot.odometry_noise > 0.0
        self._drift = _drift_of(world, robot, time_step)
        self._places = len(pushing_places_of(robot))
        self._pushes = memory.own(_push_rows(world, robot, time_step))
        decoys = decoys_of(robot)
        self._decoy_count = len(decoys)
        self._decoys = memory.new("WgDecoy[]", max(1, len(decoys)))
        for k, decoy in enumerate(decoys):
            self._decoys[k].x = metres_to_lattice(decoy.x, world.cell_size)
            self._decoys[k].y = metres_to_lattice(decoy.y, world.cell_size)
            self._decoys[k].strength = decoy.strength

    @property
    def last_step(self) -> int:
        """Step of the last push at a time; 0 if there is none."""
        timed = self._pushes[self._places :]
        return int(timed[-1, 0]) if len(timed) else 0

    def fill(self, settings: Any) -> None:
        """Write them into a WgSettings, which must keep this object alive."""
        settings.disturbed = int(self._moved)
        settings.measures = int(self._measures)
        settings.drift_x, settings.drift_y, settings.drift_reach = self._drift
        settings.pushes = ffi.cast("WgPush *", pointer(ffi, self._pushes, np.int64))
        settings.push_count = len(self._pushes)
        settings.place_count = self._places
        settings.decoys = self._decoys
        settings.decoy_count = self._decoy_count


def _drift_of(world: World, robot: RobotOptions, time_step: float) -> tuple[int, int, int]:
    """Return the drift in a step along x and y, and its length rounded up, in lattice units."""
    if robot.drift == 0.0:
        return 0, 0, 0
    # Exact fractions: the drift per step must not depend on the rounding of the platform.
    cells = exact(robot.drift) * exact(time_step) / exact(world.cell_size)
    if cells > _LONGEST_PUSH:
        raise InvalidParameter(
            "out-of-range",
            "drift={drift:g} m/s moves the robot {cells:.3g} cells in a step, and at most {most} "
            "can be simulated",
            "use a smaller drift or a shorter --time-step",
            at_terminal=True,
            drift=robot.drift,
            cells=float(cells),
            most=_LONGEST_PUSH,
        )
    length = math.floor(cells * UNIT + exact(0.5))
    if length == 0:
        raise InvalidParameter(
            "drift-too-slow",
            "drift={drift:g} m/s moves the robot less than half of 1/1024 of a cell in a step of "
            "{time_step:g} s, which rounds to nothing",
            "use a faster drift or a longer --time-step",
            at_terminal=True,
            drift=robot.drift,
            time_step=time_step,
        )
    table = headings()
    heading = heading_to_lattice(robot.drift_heading)
    along = _rounded(length * int(table[heading]))
    across = _rounded(length * int(table[(heading - TURN // 4) % TURN]))
    return along, across, length + 1


def _rounded(product: int) -> int:
    """Return a length times a cosine of the table, rounded, halves away from zero."""
    half = 1 << (_SCALE_BITS - 1)
    rounded = (abs(product) + half) >> _SCALE_BITS
    return rounded if product >= 0 else -rounded


def _push_rows(world: World, robot: RobotOptions, time_step: float) -> Ints:
    """Return (n, 6) int64, WgPush: first those at places, then those at times, by step."""
    side = world.cell_size
    rows: list[tuple[int, ...]] = []
    for place in pushing_places_of(robot):
        ix = math.floor(in_cells(place.x, side))
        iy = math.floor(in_cells(place.y, side))
        rows.append((0, ix, iy, *_shove(place.dx, place.dy, place.turn, side, "push_places")))
    timed = []
    for push in pushes_of(robot):
        step = max(1, math.ceil(exact(push.time) / exact(time_step)))
        timed.append((step, -1, -1, *_shove(push.dx, push.dy, push.turn, side, "pushes")))
    # Timed pushes come after the places, in order of their step.
    rows += sorted(timed, key=lambda row: row[0])
    return np.array(rows, np.int64).reshape(-1, _PUSH_FIELDS)


def _shove(dx: float, dy: float, turn: float, side: float, name: str) -> tuple[int, int, int]:
    """Return a displacement and a turn in lattice and heading units."""
    longest = max(abs(in_cells(dx, side)), abs(in_cells(dy, side)))
    if longest > _LONGEST_PUSH:
        raise InvalidParameter(
            "out-of-range",
            "{name}: a displacement of {cells:.4g} cells is more than {most}",
            "use a shorter one",
            name=name,
            cells=float(longest),
            most=_LONGEST_PUSH,
        )
    return metres_to_lattice(dx, side), metres_to_lattice(dy, side), heading_to_lattice(turn)
