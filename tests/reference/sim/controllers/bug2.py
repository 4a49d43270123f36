"""Bug2 goes around an obstacle until it is back on the straight line to the target, nearer to it.

It drives straight to the target. If a wall stops it, at the hit point, it follows the wall with its
left hand until it crosses the line from the hit point to the target at a place nearer to the target
than the hit point; it returns to that place and drives to the target again. The line enters the
obstacle at the hit point and ends outside, so it leaves it somewhere on the same wall: there is
such a place, and each is nearer than the last. So it arrives if the target can be reached. It is
often quicker than Bug1, because it need not go around the whole obstacle; in mazes it may pass the
same places many times.

In the paper, the line goes from the start to the target. Here each hit point has its own line,
which differs by how far the robot slid along a wall before it was stopped.

Source: V. J. Lumelsky and A. A. Stepanov, "Path-planning strategies for a point mobile automaton
    moving amidst unknown
obstacles of arbitrary shape", Algorithmica 2 (1987), section 5.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body
from tests.reference.sim.controllers._directions import angle_of, distance
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

# Memory after the body's: what it does, its distance to the target before the step; the hit point,
# its distance to the target and the direction of the line (a unit vector); the leave point.
MODE, FAR = body.BODY_SIZE, body.BODY_SIZE + 1
HIT_X, HIT_Y, HIT_FAR, LINE_X, LINE_Y = (body.BODY_SIZE + k for k in range(2, 7))
LEAVE_X = body.BODY_SIZE + 7
LEAVE_Y = body.BODY_SIZE + 8
SIZE = body.BODY_SIZE + 9

START, GOAL, ROUND, BACK = 0.0, 1.0, 2.0, 3.0

_NEARER = (
    # fraction of a step by which a leave point must be nearer to the target than the hit point
    0.05
)
_THERE = 0.02  # fraction of a step: within this distance it is at the leave point


def _hit(observation: Floats, memory: Floats) -> None:
    """Starts to follow a wall, with a new line if it is nearer to the target than the last one."""
    body.begin_following(memory, body.touched(observation))
    memory[MODE] = ROUND
    far = observation[layout.OBS_TARGET_DISTANCE]
    if far < memory[HIT_FAR] - 0.5 * _NEARER * body.stride(observation):
        memory[HIT_X] = observation[layout.OBS_X]
        memory[HIT_Y] = observation[layout.OBS_Y]
        memory[HIT_FAR] = far
        heading = observation[layout.OBS_TARGET_HEADING]
        memory[LINE_X] = cos(heading)
        memory[LINE_Y] = sin(heading)


def _crosses(observation: Floats, memory: Floats) -> bool:
    """Return whether the last step crossed the line at a leave point, and note that point."""
    from_x = memory[body.X] - memory[HIT_X]
    from_y = memory[body.Y] - memory[HIT_Y]
    to_x = observation[layout.OBS_X] - memory[HIT_X]
    to_y = observation[layout.OBS_Y] - memory[HIT_Y]
    before = memory[LINE_X] * from_y - memory[LINE_Y] * from_x
    after = memory[LINE_X] * to_y - memory[LINE_Y] * to_x
    if (before > 0.0) == (after > 0.0):
        return False
    share = before / (before - after)
    x = from_x + share * (to_x - from_x)
    y = from_y + share * (to_y - from_y)
    along = memory[LINE_X] * x + memory[LINE_Y] * y
    memory[LEAVE_X], memory[LEAVE_Y] = memory[HIT_X] + x, memory[HIT_Y] + y
    return bool(_NEARER * body.stride(observation) < along < memory[HIT_FAR])


def _bug2(observation: Floats, memory: Floats, command: Floats) -> None:
    far = observation[layout.OBS_TARGET_DISTANCE]
    x = observation[layout.OBS_X]
    y = observation[layout.OBS_Y]
    if memory[MODE] == START:
        memory[MODE] = GOAL
    elif memory[MODE] == GOAL and body.is_stopped(observation, memory, memory[FAR]):
        _hit(observation, memory)
    elif memory[MODE] == ROUND:
        body.feel(observation, memory)
        if body.has_lost_it(memory):
            memory[MODE], memory[HIT_FAR] = GOAL, math.inf
        elif _crosses(observation, memory):
            memory[MODE] = BACK
    elif memory[MODE] == BACK:
        memory[MODE] = GOAL
    memory[FAR] = far
    left = distance(x, y, memory[LEAVE_X], memory[LEAVE_Y])
    if memory[MODE] == BACK and left < _THERE * body.stride(observation):
        memory[MODE] = GOAL
    if memory[MODE] == GOAL:
        body.head_for_target(observation, memory, command)
    elif memory[MODE] == BACK:
        body.drive(
            observation, memory, command, angle_of(memory[LEAVE_X] - x, memory[LEAVE_Y] - y), left
        )
    else:
        body.follow(observation, memory, command)


def _act(observation: Floats, memory: Floats, command: Floats) -> None:
    _bug2(observation, memory, command)
