"""TangentBug looks ahead with range beams, and goes around obstacles along their tangents.

It drives to the target as long as it sees no wall in front of it. Otherwise it drives to the
visible end of the wall that gives the shortest path to the target. When that path stops getting
shorter, it drives up to the wall and follows it by touch, on the side that it had chosen, until it
sees a free place that is nearer to the target than any place of the wall so far, and goes there.

With a perfect scan, a point robot arrives if the target can be reached. Here the robot is a disc
that treats the points hit by its beams as the walls, each as wide as itself, and it sees nothing
between two beams: a long path past a thin wall can look free without being free. The fuzzer shows
what that costs.

It needs ``beams`` all around with a ``beam_range`` of ``RANGE``, which it gets unless the run sets
other values.

Source: I. Kamon, E. Rimon and E. Rivlin, "TangentBug: a range-sensor-based navigation algorithm",
    The International
Journal of Robotics Research 17 (1998).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body
from tests.reference.sim.controllers._directions import (
    WHOLE_TURN,
    angle_of,
    bearing_of,
    distance,
    wrap,
)
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

BEAMS = 72
RANGE = 1.0  # m: points farther away are ignored
_APART = 1.4  # radii: points farther apart than this from beam to beam are also ignored
# Fraction of the radius: a touched wall counts as at least this far away, so that it does not block
# the path along itself.
_TOUCHING = 0.97
_JUMP = (
    0.08 / 0.07
)  # radii: a wall ends where the free distance is longer by this in the next direction
_LONGER = 0.05  # m: how much longer the path by an end may become before the robot follows the wall
_HANGS_TOGETHER = (
    0.5  # share of its distance by which a wall may be nearer or farther in the next direction
)
# m: a robot leaves a wall only for a place that is nearer to the target by this than all of the
# wall
_NEARER = 0.03
_PATIENCE = 60.0  # steps in which the path must have become shorter

# Memory after the body's: what it does; shortest path so far, and steps since; the wall's least
# distance to the target; distance to the target before the step; the place for which it leaves the
# wall.
MODE, BEST, SINCE, WALL_FAR, FAR = (body.BODY_SIZE + k for k in range(5))
LEAVE_X = body.BODY_SIZE + 5
LEAVE_Y = body.BODY_SIZE + 6
SIZE = body.BODY_SIZE + 7

GOAL, APPROACH, WALL, LEAVE = 0.0, 1.0, 2.0, 3.0


def _sight(observation: Floats) -> float:
    """Distance, m, up to which points count.

    A disc has a free path of at most that minus its radius.
    """
    beams = observation.size - layout.OBS_SIZE
    return min(RANGE, float(_APART * observation[layout.OBS_RADIUS] * beams / WHOLE_TURN))


def _free_way(observation: Floats, bearing: float) -> float:
    """Return how far, m, the disc can go in a direction from the heading, rad, past all points that
    beams hit.
    """
    beams = observation.size - layout.OBS_SIZE
    sight = _sight(observation)
    free = float(sight - observation[layout.OBS_RADIUS])
    wide = _TOUCHING * observation[layout.OBS_RADIUS]
    for beam in range(beams):
        far = observation[layout.OBS_SIZE + beam]
        if far >= 0.999 * sight:
            continue
        angle = wrap(bearing_of(beam, beams) - bearing)
        along = far * cos(angle)
        across = far * sin(angle)
        if along > 0.0 and abs(across) < wide:
            free = min(free, along - math.sqrt(wide * wide - across * across))
    return max(free, 0.0)


def _rest(observation: Floats, bearing: float, length: float) -> float:
    """Distance to the target from the place at this distance in a direction from the heading."""
    far = observation[layout.OBS_TARGET_DISTANCE]
    angle = observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING] - bearing
    return math.sqrt(max(far * far + length * length - 2.0 * far * length * cos(wrap(angle)), 0.0))


def _best_end(observation: Floats) -> tuple[float, float, float]:
    """Find the end of a wall that gives the shortest path to the target.

    Returns:
        The length of that path, m (inf if there is no end); the end's direction from the heading,
        rad; its distance.
    """
    beams = observation.size - layout.OBS_SIZE
    radius = observation[layout.OBS_RADIUS]
    best, best_bearing, best_length = math.inf, 0.0, 0.0
    first = _free_way(observation, 0.0)
    before = first
    for beam in range(1, beams + 1):
        bearing = bearing_of(beam, beams)
        free = first if beam == beams else _free_way(observation, bearing)
        if abs(free - before) > _JUMP * radius:
            length = min(min(free, before) + radius, max(free, before))
            towards = bearing if free > before else bearing - WHOLE_TURN / beams
            way = length + _rest(observation, towards, length)
            if way < best:
                best, best_bearing, best_length = way, towards, length
        before = free
    return best, best_bearing, best_length


def _nearest_seen(observation: Floats) -> tuple[float, float, float]:
    """Find the visible free place that is nearest to the target.

    Return its distance to the target, its direction and its distance.
    """
    beams = observation.size - layout.OBS_SIZE
    offset = observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING]
    best, best_bearing, best_length = math.inf, 0.0, 0.0
    for beam in range(-1, beams):
        bearing = offset if beam < 0 else bearing_of(beam, beams)
        along = observation[layout.OBS_TARGET_DISTANCE] * cos(wrap(offset - bearing))
        if along <= 0.0:
            continue
        length = min(along, _free_way(observation, bearing))
        rest = _rest(observation, bearing, length)
        if rest < best:
            best, best_bearing, best_length = rest, bearing, length
    return best, best_bearing, best_length


def _take_up(memory: Floats, far: float) -> None:
    """Begins to approach the wall that is in the way."""
    memory[MODE], memory[WALL_FAR] = APPROACH, far


def _go(observation: Floats, memory: Floats, command: Floats) -> None:
    """Drive towards the target, or to the best end of the wall in front of it.

    If both fail, start to follow the wall.
    """
    far = observation[layout.OBS_TARGET_DISTANCE]
    heading = observation[layout.OBS_HEADING]
    ahead = observation[layout.OBS_TARGET_HEADING] - heading
    way, bearing, length = far, ahead, far
    if _free_way(observation, ahead) < min(
        far, 0.999 * (_sight(observation) - observation[layout.OBS_RADIUS])
    ):
        way, bearing, length = _best_end(observation)
        memory[body.HAND] = -1.0 if wrap(bearing - ahead) > 0.0 else 1.0
    memory[SINCE] += 1.0
    if way < memory[BEST]:
        memory[BEST], memory[SINCE] = way, 0.0
    stopped = body.is_stopped(observation, memory, memory[FAR])
    if way > memory[BEST] + _LONGER or memory[SINCE] > _PATIENCE or stopped:
        _take_up(memory, far)
        body.head_for_target(observation, memory, command)
        return
    step = observation[layout.OBS_TOP_SPEED] * observation[layout.OBS_TIME_STEP]
    if observation[layout.OBS_BUMP] != 0.0:
        step = body.stride(observation)
    body.drive(observation, memory, command, heading + bearing, min(step, length))


def _see_wall(observation: Floats, memory: Floats, side: int) -> None:
    """Records how near the followed wall comes to the target.

    As far as the wall is visible to one side, 1 or -1.
    """
    beams = observation.size - layout.OBS_SIZE
    radius = observation[layout.OBS_RADIUS]
    towards = wrap(memory[body.WALL] - observation[layout.OBS_HEADING]) / WHOLE_TURN
    beam = math.floor(towards * beams + 0.5)
    before = radius
    sight = _sight(observation)
    for k in range(beams // 2):
        at = (beam + side * k) % beams
        far = observation[layout.OBS_SIZE + at]
        if far >= 0.999 * sight or abs(far - before) > _HANGS_TOGETHER * before:
            break
        rest = _rest(observation, bearing_of(at, beams), max(far - radius, 0.0))
        memory[WALL_FAR], before = min(memory[WALL_FAR], rest), far


def _see_whether_to_leave(observation: Floats, memory: Floats) -> None:
    """Chooses a visible place that is nearer to the target than the whole wall so far, if any."""
    _see_wall(observation, memory, 1)
    _see_wall(observation, memory, -1)
    memory[WALL_FAR] = min(memory[WALL_FAR], observation[layout.OBS_TARGET_DISTANCE])
    rest, bearing, length = _nearest_seen(observation)
    if rest < memory[WALL_FAR] - _NEARER:
        heading = observation[layout.OBS_HEADING] + bearing
        memory[LEAVE_X] = observation[layout.OBS_X] + length * cos(wrap(heading))
        memory[LEAVE_Y] = observation[layout.OBS_Y] + length * sin(wrap(heading))
        memory[MODE] = LEAVE


def _leave(observation: Floats, memory: Floats, command: Floats) -> None:
    """Drives to the place for which a wall is left."""
    x = observation[layout.OBS_X]
    y = observation[layout.OBS_Y]
    left = distance(x, y, memory[LEAVE_X], memory[LEAVE_Y])
    step = observation[layout.OBS_TOP_SPEED] * observation[layout.OBS_TIME_STEP]
    body.drive(
        observation,
        memory,
        command,
        angle_of(memory[LEAVE_X] - x, memory[LEAVE_Y] - y),
        min(step, left),
    )


def _tangent_bug(observation: Floats, memory: Floats, command: Floats) -> None:
    far = observation[layout.OBS_TARGET_DISTANCE]
    bump = observation[layout.OBS_BUMP] != 0.0
    if memory[MODE] == LEAVE:
        moved = distance(
            memory[body.X], memory[body.Y], observation[layout.OBS_X], observation[layout.OBS_Y]
        )
        if far < memory[WALL_FAR] - 0.5 * _NEARER:
            memory[MODE], memory[BEST], memory[SINCE] = GOAL, math.inf, 0.0
        elif bump or moved < 0.01 * body.stride(observation):
            memory[MODE] = APPROACH
    elif memory[MODE] == APPROACH and body.is_stopped(observation, memory, memory[FAR]):
        memory[MODE] = WALL
        body.begin_following(memory, body.touched(observation))
    elif memory[MODE] == WALL and body.feel(observation, memory):
        _see_whether_to_leave(observation, memory)
    elif memory[MODE] == WALL and body.has_lost_it(memory):
        memory[MODE], memory[BEST], memory[SINCE] = GOAL, math.inf, 0.0
    if memory[MODE] == GOAL:
        _go(observation, memory, command)
    elif memory[MODE] == APPROACH:
        memory[WALL_FAR] = min(memory[WALL_FAR], far)
        body.head_for_target(observation, memory, command)
    elif memory[MODE] == LEAVE:
        _leave(observation, memory, command)
    else:
        body.follow(observation, memory, command)
    memory[FAR] = far


def _act(observation: Floats, memory: Floats, command: Floats) -> None:
    _tangent_bug(observation, memory, command)
