"""A small robot that heads for its target, and follows any wall on its path by touch."""

import math

from sim import Command

# rad: where it touches the wall, it turns this much more than along it.
AWAY = 0.1
# rad per step: where it does not touch the wall, it turns back to it.
BACK = 0.5
# Metres.
FAR = 1e6


class Robot:
    """Follows a wall on its left until it is nearer to the target than at any wall before."""

    def reset(self):
        """Return the memory to start with."""
        # Whether it follows a wall; the least distance from the target at which it hit one, m.
        return (0.0, FAR)

    def act(self, seen, memory):
        """Return the command of a step, and the new memory."""
        follows, nearest = memory
        # Leave the wall once the target is nearer than where the robot hit it.
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
