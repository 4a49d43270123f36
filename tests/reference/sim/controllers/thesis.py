"""The thesis's robot: seek the signal, drive, and turn by a fixed or random angle when it collides.

Three behaviours (drive, seek, collide) under an arbiter; the one that takes control keeps it until
it is done. Under ``stepped`` the thesis's own program runs, to the last bit
(:mod:`tests.reference.sim.thesis_episode`). This is the same idea on the pose lattice, for the
other motion models, with the same arbiter.

Names are from the robot's own view: ``turn-right`` is the thesis's algorithm 1, which adds pi/2 to
a heading that grows clockwise on a screen whose y points down. Its legend calls that "left", the
side of the screen on which the robot then passes, and its text contradicts itself.

Source: the thesis on behaviour-based search and rescue robots that this program descends from
    (2005-2006),
sections 3 and 4 and its listing; the arbiter is reconstructed from the prose.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout, thesis_arbiter
from tests.reference.sim.thesis_arbiter import A0, run_behaviour, select_behaviour

Floats = npt.NDArray[np.float64]

TURN_STEP = round(0.08 / (2 * math.pi) * layout.TURN)  # heading units turned in a step: 0.08 rad
SNAP = round(
    0.2 / (2 * math.pi) * layout.TURN
)  # a remainder of at most 0.2 rad is turned in one step
COLLIDE_TICKS, DRIVE_TICKS = 5, 2  # as in the thesis: 6 steps of escape, 3 of drive

# Memory: behaviour in charge, its counter, target heading (units; -1 none), speed and the speed
# before the collision (shares of the top speed).
BEHAVIOUR, COUNTER, TARGET, SPEED, OLD_SPEED = 0, 1, 2, 3, 4
AT_RESET = (float(thesis_arbiter.IDLE), 0.0, -1.0, 1.0, 1.0)

RIGHT, LEFT, RANDOM = 1, 2, 3  # the thesis's numbers for its rules
_UNITS = layout.TURN / (2 * math.pi)


def turn_towards(heading: int, target: int) -> int:
    """Signed units, in (-half turn, half turn], from one heading to another."""
    turn = (target - heading) % layout.TURN
    return turn - layout.TURN if turn > layout.TURN // 2 else turn


def _turn_after_collision(rule: int, heading: int, random: float) -> int:
    """Target heading, units, after a collision."""
    if rule == RIGHT:
        return (heading - layout.TURN // 4) % layout.TURN
    if rule == LEFT:
        return (heading + layout.TURN // 4) % layout.TURN
    return math.floor(random * layout.TURN)


def _act(observation: Floats, memory: Floats, command: Floats, rule: int) -> None:
    """One tick of the three behaviours; see :mod:`tests.reference.sim.thesis_arbiter`."""
    collision = observation[layout.OBS_BUMP] != 0.0
    heading = math.floor(observation[layout.OBS_HEADING] * _UNITS + 0.5) % layout.TURN
    signal = math.floor(observation[layout.OBS_SIGNAL_HEADING] * _UNITS + 0.5) % layout.TURN
    target = int(memory[TARGET])
    behaviour, counter, taken = select_behaviour(
        A0,
        int(memory[BEHAVIOUR]),
        int(memory[COUNTER]),
        collision,
        target == signal,
        COLLIDE_TICKS,
        DRIVE_TICKS,
    )
    if taken and behaviour == thesis_arbiter.COLLIDE:
        memory[OLD_SPEED], memory[SPEED] = memory[SPEED], 0.0
        target = _turn_after_collision(rule, heading, observation[layout.OBS_RANDOM])
        command[layout.CMD_DRAW] = 1.0 if rule == RANDOM else 0.0
    if behaviour == thesis_arbiter.SEEK:
        memory[SPEED], target = 0.0, signal
    wheels, behaviour, counter = run_behaviour(behaviour, counter, collision, heading == target)
    if wheels == thesis_arbiter.TURN:
        rest = turn_towards(heading, target)
        turn = rest if abs(rest) <= SNAP else (TURN_STEP if rest > 0 else -TURN_STEP)
        command[layout.CMD_TURN_RATE] = turn / _UNITS / observation[layout.OBS_TIME_STEP]
    elif wheels == thesis_arbiter.GO:
        memory[SPEED] = 1.0
    elif wheels == thesis_arbiter.RESUME:
        memory[SPEED] = memory[OLD_SPEED]
    memory[BEHAVIOUR], memory[COUNTER], memory[TARGET] = behaviour, counter, target
    command[layout.CMD_SPEED] = memory[SPEED] * observation[layout.OBS_TOP_SPEED]


def _act_right(observation: Floats, memory: Floats, command: Floats) -> None:
    _act(observation, memory, command, RIGHT)


def _act_left(observation: Floats, memory: Floats, command: Floats) -> None:
    _act(observation, memory, command, LEFT)


def _act_random(observation: Floats, memory: Floats, command: Floats) -> None:
    _act(observation, memory, command, RANDOM)
