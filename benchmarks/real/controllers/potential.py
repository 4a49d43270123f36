"""A potential field along a planned path, with noise against local minima."""

import math

import numpy as np
from routes import plan_in, progress, wrapped

from sim import Command, RobotOptions

BEAMS = 16
STEP = math.tau / BEAMS


class Potential:
    """Follows the force; where that makes no progress, it drives at random for a while."""

    needs = RobotOptions(beams=BEAMS, beam_range=1.0)
    senses = ("heading", "x", "y", "beams", "random")
    patience = 12  # steps without a new place on the path
    noise = 1.2  # rad

    def reset(self, world):
        # Place on the path, steps since then.
        return (0.0, 0.0, *plan_in(world, 1.2).ravel().tolist())

    def act(self, seen, memory):
        path = np.reshape(memory[2:], (-1, 2))
        k = progress(path, int(memory[0]), seen.x, seen.y)
        stuck = 0.0 if k > memory[0] else min(memory[1] + 1.0, 2.0 * self.patience)
        goal = path[min(k + 6, len(path) - 1)]
        to_goal = math.atan2(goal[1] - seen.y, goal[0] - seen.x)
        fx, fy = math.cos(to_goal), math.sin(to_goal)
        for i, distance in enumerate(seen.beams):
            gap = max(distance - seen.radius, 0.1 * seen.radius) / seen.radius
            if gap < 0.8:
                push = 0.3 * (1.0 / gap - 1.25)
                fx -= push * math.cos(seen.heading + i * STEP)
                fy -= push * math.sin(seen.heading + i * STEP)
        heading = math.atan2(fy, fx)
        # Stuck in a minimum: leave it in a random direction, wider the longer it takes.
        shaken = stuck > self.patience
        if shaken:
            heading += self.noise * (2.0 * seen.random - 1.0) * stuck / self.patience
        turn = wrapped(heading - seen.heading)
        memory = (float(k), stuck, *memory[2:])
        return Command(0.6 * seen.top_speed, turn / seen.time_step, shaken), memory
