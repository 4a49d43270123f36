"""A small robot: heads for its target, and follows by touch the wall that is in its way."""

import math

from sim import Command

AWAY = 0.1  # rad: where it touches the wall, it turns this much further than along it
BACK = 0.5  # rad a step: where it does not, it turns back to it
FAR = 1e6  # m


class Robot:
    """Follows a wall on its left until it is nearer to the target than it has ever met one."""

    def reset(self):
        """Return the memory to start with."""
        return (
            0.0,
            FAR,
        )  # whether it follows a wall; the least distance from the target at which it met one, m

    def act(self, seen, memory):
        """Return what to do in a step, and what to keep in mind."""
        follows, nearest = memory
        if follows and not seen.bump and seen.target_distance < nearest - seen.radius:
            follows = 0.0
        if seen.bump and not follows:
            follows = 1.0
            nearest = min(nearest, seen.target_distance)
        if not follows:
            turn = wrapped(seen.target_heading - seen.heading)
        elif seen.bump:
            turn = wrapped(seen.bump_bearing - math.pi / 2 - AWAY)
        else:
            turn = BACK
        return Command(seen.top_speed, turn / seen.time_step), (follows, nearest)


def wrapped(angle):
    """Return the same angle between -pi and pi."""
    return (angle + math.pi) % (2 * math.pi) - math.pi
