"""VFH+ with 36 beams behind a planner (Ulrich and Borenstein, 1998)."""

import math

import numpy as np
from routes import plan_in, progress, wrapped

from sim import Command, RobotOptions

SECTORS = 36
BEARINGS = np.arange(SECTORS) * math.tau / SECTORS


class Vfh:
    """Masks the sectors that obstacles block, and takes the cheapest open one."""

    needs = RobotOptions(beams=SECTORS, beam_range=2.0)
    senses = ("heading", "x", "y", "beams", "target_distance")
    reach = 1.6  # radii within which an obstacle blocks sectors
    w_goal, w_turn, w_last = 5.0, 1.0, 0.5

    def reset(self, world):
        # The place on the path, and the direction chosen last.
        return (0.0, 0.0, *plan_in(world).ravel().tolist())

    def act(self, seen, memory):
        path = np.reshape(memory[2:], (-1, 2))
        k = progress(path, int(memory[0]), seen.x, seen.y)
        goal = path[min(k + 3, len(path) - 1)]
        wanted = math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading

        # Each hit blocks the sectors into which the robot would touch it.
        blocked = np.zeros(SECTORS, bool)
        for bearing, distance in zip(BEARINGS, seen.beams, strict=True):
            if distance < self.reach * seen.radius:
                widening = math.asin(min(1.0, 0.8 * seen.radius / max(distance, seen.radius)))
                blocked |= (
                    np.abs(np.remainder(BEARINGS - bearing + math.pi, math.tau) - math.pi)
                    < widening
                )
        last = memory[1] - seen.heading
        off_goal = self.off(BEARINGS, wanted)
        cost = (
            self.w_goal * off_goal
            + self.w_turn * self.off(BEARINGS, 0.0)
            + self.w_last * self.off(BEARINGS, last)
        )
        # The way ahead is open if no beam ends before the goal.
        if (blocked | (off_goal > 1.7)).all() or not self.is_blocked(blocked, wanted):
            turn = wrapped(wanted)
        else:
            turn = wrapped(
                BEARINGS[int(np.argmin(np.where(blocked | (off_goal > 1.7), np.inf, cost)))]
            )
        speed = min(seen.top_speed, 8.0 * seen.target_distance)
        memory = (float(k), seen.heading + turn, *memory[2:])
        return Command(0.6 * speed, turn / seen.time_step), memory

    def off(self, angles, to):
        return np.abs(np.remainder(angles - to + math.pi, math.tau) - math.pi)

    def is_blocked(self, blocked, bearing):
        return blocked[round(bearing / (math.tau / SECTORS)) % SECTORS]
