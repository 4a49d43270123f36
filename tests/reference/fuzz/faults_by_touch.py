"""Faults in the controllers that follow walls by touch: Bug1, Bug2 and wall following."""

from __future__ import annotations

import math

from tests.reference.fuzz.planting import Act, Floats, seeded, unwrap_turn
from tests.reference.sim import layout
from tests.reference.sim.controllers import _boundary as body
from tests.reference.sim.controllers import bug1 as one
from tests.reference.sim.controllers import bug2 as two

_STILL_ROUND = 2.0  # Bug1's AWAY: it is back at the hit point


@seeded("bug1")
def bug1_keeps_the_last_place(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Remembers the last place along the wall instead of the nearest.

    The comparison is missing.
    """
    if memory[one.MODE] == one.ROUND:
        memory[one.LEAVE_FAR] = math.inf
    base(observation, memory, command)


@seeded("bug1")
def bug1_hit_point_moves_along(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Sets the hit point again at each step along the wall, so it never returns to it."""
    base(observation, memory, command)
    if memory[one.MODE] == one.ROUND:
        memory[one.HIT] = observation[layout.OBS_X]
        memory[one.HIT + 1] = observation[layout.OBS_Y]


@seeded("bug1")
def bug1_stale_round_is_over(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """The flag of a finished round is not cleared at the second obstacle.

    That obstacle then counts as explored.
    """
    before = memory[one.MODE]
    base(observation, memory, command)
    if memory[one.AWAY] == _STILL_ROUND:
        memory[one.SIZE] = _STILL_ROUND
    if before == one.MEET and memory[one.MODE] == one.ROUND and memory[one.SIZE] == _STILL_ROUND:
        memory[one.AWAY] = _STILL_ROUND


@seeded("bug1")
def bug1_lost_wall_wrong_side(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Switches sides whenever it loses the wall at a corner: the turn's sign is wrong there."""
    base(observation, memory, command)
    if memory[body.LOST] == 1.0:
        memory[body.HAND] = -memory[body.HAND]


@seeded("bug1")
def bug1_turn_not_wrapped(observation: Floats, memory: Floats, command: Floats, base: Act) -> None:
    """The turn is the difference of two headings, not wrapped at pi.

    So the robot may turn the long way.
    """
    base(observation, memory, command)
    unwrap_turn(observation, command)


@seeded("bug2")
def bug2_leaves_by_equality(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Leaves the wall only exactly on the line: floats are compared for equality."""
    before = memory[two.MODE]
    base(observation, memory, command)
    x = observation[layout.OBS_X] - memory[two.HIT_X]
    y = observation[layout.OBS_Y] - memory[two.HIT_Y]
    off = memory[two.LINE_X] * y - memory[two.LINE_Y] * x
    if before == two.ROUND and memory[two.MODE] != two.ROUND and off != 0.0:
        memory[two.MODE] = two.ROUND


@seeded("bug2")
def bug2_stale_line(observation: Floats, memory: Floats, command: Floats, base: Act) -> None:
    """The hit point and the line of the first obstacle are kept for all later ones."""
    before, line = memory[two.MODE], two.SIZE
    base(observation, memory, command)
    if before != two.GOAL or memory[two.MODE] != two.ROUND:
        return
    if memory[line + 2] == 0.0 and memory[line + 3] == 0.0:
        memory[line], memory[line + 1] = memory[two.HIT_X], memory[two.HIT_Y]
        memory[line + 2], memory[line + 3] = memory[two.LINE_X], memory[two.LINE_Y]
    memory[two.HIT_X], memory[two.HIT_Y] = memory[line], memory[line + 1]
    memory[two.LINE_X], memory[two.LINE_Y] = memory[line + 2], memory[line + 3]


@seeded("bug2")
def bug2_hit_point_not_kept(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """The hit point is forgotten at a corner, so the line then begins where the robot is."""
    base(observation, memory, command)
    if memory[two.MODE] == two.ROUND and memory[body.LOST] == 1.0:
        memory[two.HIT_X] = observation[layout.OBS_X]
        memory[two.HIT_Y] = observation[layout.OBS_Y]


@seeded("bug2")
def bug2_leaves_behind_the_hit_point(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """Leaves wherever it crosses the line.

    The check that the place is nearer than the hit point is missing.
    """
    from_x = memory[body.X] - memory[two.HIT_X]
    from_y = memory[body.Y] - memory[two.HIT_Y]
    base(observation, memory, command)
    x = observation[layout.OBS_X] - memory[two.HIT_X]
    y = observation[layout.OBS_Y] - memory[two.HIT_Y]
    before = memory[two.LINE_X] * from_y - memory[two.LINE_Y] * from_x
    after = memory[two.LINE_X] * y - memory[two.LINE_Y] * x
    away = x * x + y * y > 0.01  # (0.1 m)^2: not immediately
    if memory[two.MODE] == two.ROUND and away and (before > 0.0) != (after > 0.0):
        memory[two.MODE] = two.GOAL


@seeded("bug2")
def bug2_bearing_in_degrees(
    observation: Floats, memory: Floats, command: Floats, base: Act
) -> None:
    """The bearing of a contact on the right is in degrees."""
    if observation[layout.OBS_BUMP_BEARING] < 0.0:
        observation[layout.OBS_BUMP_BEARING] *= 180.0 / math.pi
    base(observation, memory, command)


@seeded("bug2")
def bug2_turn_not_wrapped(observation: Floats, memory: Floats, command: Floats, base: Act) -> None:
    """The turn is the difference of two headings, not wrapped at pi.

    So the robot may turn the long way.
    """
    base(observation, memory, command)
    unwrap_turn(observation, command)
