"""A path follower whose commands go through a velocity smoother, as in Nav2."""

import math

import numpy as np
from routes import plan_in, progress, wrapped

from sim import Command, RobotOptions


class Smoother:
    """Limits the acceleration, and keeps out of the speeds at which the motors stick."""

    needs = RobotOptions(beams=16)
    senses = ("heading", "x", "y", "beams", "target_distance")
    acceleration = 20.0  # m/s2
    dead_band = 0.3  # m/s

    def reset(self, world):
        # Speed, place on the path.
        return (0.0, 0.0, *plan_in(world).ravel().tolist())

    def act(self, seen, memory):
        speed, k = memory[:2]
        path = np.reshape(memory[2:], (-1, 2))
        k = progress(path, int(k), seen.x, seen.y)
        goal = path[min(k + 3, len(path) - 1)]
        bearing = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)
        # Slow down where it is tight, and where the path bends.
        room = (min(seen.beams) - seen.radius) / seen.radius
        wanted = seen.top_speed * min(1.0, 0.12 + room) * max(0.0, math.cos(bearing))
        change = self.acceleration * seen.time_step
        speed = max(speed - change, min(speed + change, wanted))
        speed = self.out_of_the_dead_band(speed, wanted)
        return Command(speed, 0.5 * bearing / seen.time_step), (speed, float(k), *memory[2:])

    def out_of_the_dead_band(self, speed, wanted):
        if wanted < 1e-3:
            return 0.0
        return max(speed, self.dead_band)
