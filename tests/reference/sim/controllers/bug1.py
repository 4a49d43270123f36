"""Bug1 goes around each obstacle once, and leaves it at the point nearest to the target.

It drives straight to the target. If a wall stops it, at the hit point, it follows the wall with its
left hand all the way around, and notes where it was nearest to the target: the leave point. From
the hit point it takes the shorter path there, and drives straight to the target again. Leave
points come nearer and nearer, so it arrives if the target can be reached, on a path of at most the
distance plus one and a half times the perimeters of the obstacles that it meets.

That holds in worlds that do not change. A place counts as the hit point or the leave point if it is
nearer than ``_SAME_PLACE`` of a step and the wall is in a similar direction: the two sides of a
narrow passage are also near each other, but face opposite ways.

Source: V. J. Lumelsky and A. A. Stepanov, "Path-planning strategies for a point mobile automaton
    moving amidst unknown
obstacles of arbitrary shape", Algorithmica 2 (1987), section 4.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body
from tests.reference.sim.controllers._directions import distance, distance_to_way, wrap

Floats = npt.NDArray[np.float64]

# Memory after the body's: what it does, its distance to the target before the step; the hit point
# and the direction of the wall there; the same for the leave point, and its distance to the target;
# path length since the hit, and to the leave point; whether it has been away from the hit point.
MODE, FAR = body.BODY_SIZE, body.BODY_SIZE + 1
HIT = body.BODY_SIZE + 2
LEAVE = body.BODY_SIZE + 5
LEAVE_FAR = body.BODY_SIZE + 8
WAY = body.BODY_SIZE + 9
LEAVE_WAY = body.BODY_SIZE + 10
AWAY = body.BODY_SIZE + 11
SIZE = body.BODY_SIZE + 12

START, GOAL, MEET, ROUND, BACK = 0.0, 1.0, 2.0, 3.0, 4.0

_SAME_PLACE = 0.5  # fraction of a step
_ELSEWHERE = 1.5  # steps: beyond this distance from the hit point, it has left it
_SAME_WALL = math.radians(
    100.0
)  # rad by which the direction of the wall may differ at the same place
# Fraction of a step: unless a hit on the same wall is this much nearer than the last leave point,
# the robot goes back there.
_NEARER = 0.1


def _passes(observation: Floats, memory: Floats, place: int) -> bool:
    """Return whether the last step passed a stored place, along the same wall."""
    x = observation[layout.OBS_X]
    y = observation[layout.OBS_Y]
    apart = distance_to_way(memory[place], memory[place + 1], memory[body.X], memory[body.Y], x, y)
    turned = abs(wrap(memory[body.WALL] - memory[place + 2]))
    return bool(apart < _SAME_PLACE * body.stride(observation) and turned < _SAME_WALL)


def _note(observation: Floats, memory: Floats, place: int) -> None:
    memory[place] = observation[layout.OBS_X]
    memory[place + 1] = observation[layout.OBS_Y]
    memory[place + 2] = memory[body.WALL]


def _go_round(observation: Floats, memory: Floats, touches: bool) -> None:
    """Process one step of the circuit: the nearest place, and whether the hit point is reached
    again.
    """
    far = observation[layout.OBS_TARGET_DISTANCE]
    x = observation[layout.OBS_X]
    y = observation[layout.OBS_Y]
    memory[WAY] += distance(memory[body.X], memory[body.Y], x, y)
    if touches and (memory[MODE] == MEET or far < memory[LEAVE_FAR]):
        _note(observation, memory, LEAVE)
        memory[LEAVE_FAR], memory[LEAVE_WAY] = far, memory[WAY]
    if touches and memory[MODE] == MEET:
        _note(observation, memory, HIT)
        memory[MODE], memory[WAY], memory[LEAVE_WAY], memory[AWAY] = ROUND, 0.0, 0.0, 0.0
    elif distance(x, y, memory[HIT], memory[HIT + 1]) > _ELSEWHERE * body.stride(observation):
        memory[AWAY] = 1.0
    elif memory[AWAY] == 1.0 and _passes(observation, memory, HIT):
        memory[AWAY] = 2.0
    if touches and memory[AWAY] == 2.0:
        memory[MODE] = BACK
        if memory[LEAVE_WAY] > 0.5 * memory[WAY]:
            memory[body.HAND] = -memory[body.HAND]
            body.begin_following(memory, memory[body.WALL])


def _meet(observation: Floats, memory: Floats) -> None:
    """Decides whether a wall on the path to the target is a new obstacle or the last one again."""
    if not body.is_stopped(observation, memory, memory[FAR]):
        return
    body.begin_following(memory, body.touched(observation))
    margin = _NEARER * body.stride(observation)
    if (
        memory[LEAVE_FAR] < math.inf
        and abs(wrap(memory[body.WALL] - memory[LEAVE + 2])) > _SAME_WALL
    ):
        margin = (
            0.0  # a wall across a gap hardly wider than the robot is another wall, however near
        )
    memory[MODE] = (
        MEET if observation[layout.OBS_TARGET_DISTANCE] < memory[LEAVE_FAR] - margin else BACK
    )
    if memory[MODE] == MEET:
        memory[body.HAND] = 1.0


def _bug1(observation: Floats, memory: Floats, command: Floats) -> None:
    if memory[MODE] == START:
        memory[MODE] = GOAL
    elif memory[MODE] == GOAL:
        _meet(observation, memory)
    else:
        touches = body.feel(observation, memory)
        if memory[MODE] != BACK:
            _go_round(observation, memory, touches)
        if body.has_lost_it(memory):
            memory[MODE], memory[LEAVE_FAR] = GOAL, math.inf
        elif memory[MODE] == BACK and _passes(observation, memory, LEAVE):
            memory[MODE] = GOAL
    memory[FAR] = observation[layout.OBS_TARGET_DISTANCE]
    if memory[MODE] == GOAL:
        body.head_for_target(observation, memory, command)
    else:
        body.follow(observation, memory, command)


def _act(observation: Floats, memory: Floats, command: Floats) -> None:
    _bug1(observation, memory, command)
