"""A small robot: it heads for its target, and follows by touch any wall in between."""

import math

from sim import Command

# Where the robot touches its wall, it turns this much further than along it, rad.
AWAY = 0.1

# Where it does not touch it, it turns back towards it by this much per step, rad.
BACK = 0.5

# A distance that is greater than any in a world, m.
FAR = 1e6


class Robot:
    """Follows a wall on its left until it is nearer to the target than it ever met one."""

    def reset(self):
        """Return the memory at the start.

        It holds whether the robot follows a wall, and the least distance from the target at which
        it met one, m.
        """
        return (0.0, FAR)

    def act(self, seen, memory):
        """Return the command for one step, and the new memory."""
        follows, nearest = memory

        # Leave a wall when nearer to the target, and take one up at a bump.
        if follows and not seen.bump and seen.target_distance < nearest - seen.radius:
            follows = 0.0
        if seen.bump and not follows:
            follows = 1.0
            nearest = min(nearest, seen.target_distance)

        # Head for the target, or turn away from the wall, or back to it.
        if not follows:
            turn = wrapped(seen.target_heading - seen.heading)
        elif seen.bump:
            turn = wrapped(seen.bump_bearing - math.pi / 2 - AWAY)
        else:
            turn = BACK
        return Command(seen.top_speed, turn / seen.time_step), (follows, nearest)


def wrapped(angle):
    """Return the equivalent angle between -pi and pi."""
    return (angle + math.pi) % (2 * math.pi) - math.pi
