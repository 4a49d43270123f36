"""Following a wall by touch: what wall followers and bug algorithms share.

The robot knows its position and the direction to the wall that it touched last. It
*advances* along that wall, turned a little towards it, so that it slides on a flat wall and stays
in touch around a corner. If it hits something else, it *presses* against its own wall again before
it continues, because the obstacle may be the far side of a passage hardly wider than itself. Only
if it then cannot move ahead at all does it turn to the other wall. If it loses its wall, it turns
towards it step by step. So it follows the edge of the area that its centre can reach, and skips no
opening.

A step is never longer than :func:`stride`, which is less than the robot's diameter.

The memory of a controller begins with ``BODY_SIZE`` numbers:

=============  =====================================================================================
``X``, ``Y``   position before the last step, m
``STEP``       length requested in the last step, m
``HAND``       side of the wall: 1 left, -1 right
``WALL``       direction from the robot to its wall, rad
``PHASE``      ``ADVANCE`` or ``PRESS``
``STUCK``      consecutive times that it touched its wall and did not move
``LOST``       steps since it touched a wall
``SMOOTH``     consecutive times that its wall had not turned, at most ``_FLAT_AFTER``
=============  =====================================================================================
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import steer, wrap
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

X, Y, STEP, HAND, WALL, PHASE, STUCK, LOST, SMOOTH = 0, 1, 2, 3, 4, 5, 6, 7, 8
BODY_SIZE = 9
ADVANCE, PRESS = 0.0, 1.0

_STRIDE = (
    0.03 / 0.07
)  # radii: longest step along a wall; less than the diameter, or it steps over openings
_LEAST_STRIDE = 0.005  # m: a robot smaller than half of this would take forever
_DEGREE = math.pi / 180.0
# lean on a flat wall, and around a corner
_FLAT = 20.0 * _DEGREE
_ROUND = 40.0 * _DEGREE
_FLAT_AFTER = 2.0  # touches in a row after which a wall counts as flat
_SEARCH = 30.0 * _DEGREE  # turn towards a wall that is lost, in each step
_WHOLE_TURN, _WHOLE_TURNS = (
    12.0,
    24.0,
)  # steps in which a search turns once all around; then the count starts over
_GIVE_WAY = 40.0 * _DEGREE  # turn away from a wall at which it is stuck
_SAME_FLAT = 5.0 * _DEGREE  # a wall that turns by less is flat
# turns of one wall: into the path, and out of it
_AHEAD = 45.0 * _DEGREE
_BEHIND = 120.0 * _DEGREE
_STANDS = 0.02  # a move ahead of less than this share of a step is none
_PROGRESS = 0.5  # share of a step by which the target must come nearer; such a slide continues
_PRESSES = 3.0  # presses that miss the wall before the robot searches for it


def stride(observation: Floats) -> float:
    """Length of a step along a wall, m."""
    longest = max(_STRIDE * float(observation[layout.OBS_RADIUS]), _LEAST_STRIDE)
    return min(
        longest, float(observation[layout.OBS_TOP_SPEED] * observation[layout.OBS_TIME_STEP])
    )


def drive(
    observation: Floats, memory: Floats, command: Floats, direction: float, length: float
) -> None:
    """Commands a step of a length, m, in a world direction, rad, and records it."""
    memory[X] = observation[layout.OBS_X]
    memory[Y] = observation[layout.OBS_Y]
    memory[STEP] = length
    turn = wrap(direction - observation[layout.OBS_HEADING])
    steer(observation, command, turn, length / observation[layout.OBS_TIME_STEP])


def head_for_target(observation: Floats, memory: Floats, command: Floats) -> None:
    """Commands a step straight to the target.

    A short one if the last step touched a wall, else as long as possible.
    """
    length = observation[layout.OBS_TOP_SPEED] * observation[layout.OBS_TIME_STEP]
    if observation[layout.OBS_BUMP] != 0.0:
        length = stride(observation)
    length = min(length, observation[layout.OBS_TARGET_DISTANCE])
    drive(observation, memory, command, observation[layout.OBS_TARGET_HEADING], length)


def is_stopped(observation: Floats, memory: Floats, far: float) -> bool:
    """Return whether a wall stopped, not deflected, the last step to the target, at most a stride.

    A wall that is no longer ahead has only deflected it, however far that step went: the disc has
    slid around it.

    Args:
        observation: What is sensed.
        memory: Where the step began.
        far: Distance to the target before the step, m.
    """
    nearer = far - observation[layout.OBS_TARGET_DISTANCE]
    if observation[layout.OBS_BUMP] == 0.0 or memory[STEP] > 1.001 * stride(observation):
        return False
    ahead = abs(wrap(touched(observation) - observation[layout.OBS_TARGET_HEADING])) < 0.5 * math.pi
    return bool(nearer <= (_PROGRESS if ahead else _STANDS) * memory[STEP])


def touched(observation: Floats) -> float:
    """Direction in the world, rad, of the obstacle that the last step touched."""
    return wrap(observation[layout.OBS_HEADING] + observation[layout.OBS_BUMP_BEARING])


def begin_following(memory: Floats, wall: float) -> None:
    """Starts to follow a wall in a direction, rad; the robot presses against it first."""
    memory[WALL], memory[PHASE], memory[STUCK], memory[LOST], memory[SMOOTH] = (
        wall,
        PRESS,
        0.0,
        0.0,
        0.0,
    )


def _ahead(observation: Floats, memory: Floats) -> float:
    """Return how far the last step went in its direction, m.

    Walls may have pushed the robot back, or aside.
    """
    x = observation[layout.OBS_X]
    y = observation[layout.OBS_Y]
    heading = observation[layout.OBS_HEADING]
    return float((x - memory[X]) * cos(heading) + (y - memory[Y]) * sin(heading))


def feel(observation: Floats, memory: Floats) -> bool:
    """Processes the contact of the last step.

    Returns:
        Return whether that was the followed wall, so that ``WALL`` was measured here.
    """
    stands = _ahead(observation, memory) < _STANDS * memory[STEP]
    if observation[layout.OBS_BUMP] == 0.0:
        memory[STUCK], memory[SMOOTH] = 0.0, 0.0
        memory[LOST] += 1.0 if memory[LOST] < _WHOLE_TURNS else 1.0 - _WHOLE_TURN
        if memory[LOST] >= _PRESSES:
            memory[PHASE] = ADVANCE
        return False
    wall = touched(observation)
    turn = wrap(memory[HAND] * (wall - memory[WALL]) + _AHEAD - math.pi) + math.pi - _AHEAD
    searched, memory[LOST] = memory[LOST], 0.0
    advanced = memory[PHASE] == ADVANCE
    if turn < _BEHIND + _SEARCH * searched:
        smooth = advanced and searched == 0.0 and abs(turn) < _SAME_FLAT
        memory[SMOOTH] = min(memory[SMOOTH] + 1.0, _FLAT_AFTER) if smooth else 0.0
        memory[STUCK] = memory[STUCK] + 1.0 if stands and advanced else 0.0
    elif stands or memory[STUCK] > 0.0:
        memory[STUCK], memory[SMOOTH] = 0.0, 0.0
    else:
        memory[PHASE] = PRESS
        return False
    memory[WALL], memory[PHASE] = wall, ADVANCE
    return True


def has_lost_it(memory: Floats) -> bool:
    """Return whether the wall is no longer anywhere around the robot.

    Only a world that changes can take it away.
    """
    return bool(memory[LOST] >= _WHOLE_TURNS)


def follow(observation: Floats, memory: Floats, command: Floats) -> None:
    """Commands the next step along the wall."""
    length = stride(observation)
    if memory[PHASE] == PRESS:
        drive(observation, memory, command, memory[WALL], 0.5 * length)
        return
    lean = _FLAT if memory[SMOOTH] >= _FLAT_AFTER else _ROUND
    lean += _SEARCH * memory[LOST] - _GIVE_WAY * memory[STUCK]
    if memory[LOST] > 0.0:
        length *= 0.5
    drive(
        observation, memory, command, memory[WALL] + memory[HAND] * (lean - math.pi / 2.0), length
    )
