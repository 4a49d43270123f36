"""Check that a car can drive a witness: plain Python, without the code that made it.

Whether its body is clear of walls is checked as for other robots. Here, a car that keeps exactly to
its turning radius, and never slides, is driven along the points; it has to stay near them.
"""

from __future__ import annotations

import math

from worldgen.world import Robot, Witness, World

# Cells by which the car may be away from a point of the witness: the points are rounded to 1/1024
# cell. A leg also stays this near to the arc of which it is a chord.
BOUND = 4 / 1024
# rad: headings are multiples of this
_UNIT = math.tau / 65536
# Half of it, and rounding: how far the first heading may be from the start's.
HEADING_BOUND = 0.51 * _UNIT


def car_fault(world: World, witness: Witness) -> str | None:
    """Return why the world's car cannot drive a witness, in one sentence; None if it can.

    From one point to the next, the car turns by half of the difference of their headings, rounded
    towards zero to 1/65536 turn, drives straight, and turns by the rest. A leg that turns must be at
    least as long as the chord of an arc that turns as much.

    Args:
        world: A world of one robot, a car.
        witness: Its witness, with headings. Its times, and its ends, are checked elsewhere.
    """
    robot = world.robots[0]
    if witness.headings is None:
        return "a car's witness needs headings"
    x, y = ((values / world.cell_size).tolist() for values in (witness.x, witness.y))
    headings = witness.headings.tolist()
    if not all(map(math.isfinite, headings)):
        return "the witness has a heading that is not finite"
    fault = _end_fault(robot, headings)
    if fault is not None:
        return fault
    radius = robot.drive.turning_radius / world.cell_size
    at_x, at_y = x[0], y[0]
    for leg in range(len(x) - 1):
        turn = math.remainder(headings[leg + 1] - headings[leg], math.tau)
        along = headings[leg] + math.trunc(round(turn / _UNIT, 3) / 2) * _UNIT
        cosine, sine = math.cos(along), math.sin(along)
        gear = 1 if (x[leg + 1] - x[leg]) * cosine + (y[leg + 1] - y[leg]) * sine >= 0 else -1
        if not robot.drive.reverse:
            gear = 1
        length = gear * ((x[leg + 1] - at_x) * cosine + (y[leg + 1] - at_y) * sine)
        # The car is as far along its direction as the point, unless it could not turn that much.
        least = 2 * radius * math.sin(abs(turn) / 2)
        if turn and length < least + BOUND:
            length = least
        length = max(length, 0.0)
        at_x += gear * length * cosine
        at_y += gear * length * sine
        off = math.dist((at_x, at_y), (x[leg + 1], y[leg + 1]))
        if not off <= BOUND:
            return (
                f"the car cannot drive the witness to point {leg + 1}: with a turning radius of "
                f"{robot.drive.turning_radius} m"
                f"{'' if robot.drive.reverse else ' and without reverse'}, it would be at least "
                f"{off * world.cell_size:.3g} m away from it"
            )
        if length * abs(turn) / 8 > BOUND:
            return f"the witness turns too much in one leg to be an arc, after point {leg}"
    return None


def _end_fault(robot: Robot, headings: list[float]) -> str | None:
    """Return what is wrong with the first and the last heading."""
    off = abs(math.remainder(headings[0] - math.remainder(robot.start.heading, math.tau), math.tau))
    if off > HEADING_BOUND:
        return f"the witness starts {off:.3g} rad from the start's heading"
    goal = robot.target
    if goal.heading is not None:
        off = abs(math.remainder(headings[-1] - math.remainder(goal.heading, math.tau), math.tau))
        if off > goal.heading_tolerance:
            return f"the witness ends {off:.3g} rad from the target's heading"
    return None
