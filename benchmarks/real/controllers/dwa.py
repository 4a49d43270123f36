"""A dynamic window that follows a planned path, with 24 range beams, as in Nav2."""

import math

import numpy as np
from routes import plan_in, progress, wrapped

from sim import Command, RobotOptions

BEAMS = 24
BEARINGS = np.arange(BEAMS) * math.tau / BEAMS


class Dwa:
    """Rolls out 5 x 15 velocities and takes the one with the best score."""

    needs = RobotOptions(beams=BEAMS)
    senses = ("heading", "x", "y", "beams", "target_distance")
    turn_rate = 6.0  # rad/s
    horizon = 6  # steps
    w_heading, w_clearance, w_speed = 1.0, 0.2, 0.15

    def reset(self, world):
        return (0.0, *plan_in(world).ravel().tolist())

    def act(self, seen, memory):
        path = np.reshape(memory[1:], (-1, 2))
        k = progress(path, int(memory[0]), seen.x, seen.y)
        goal = path[min(k + 3, len(path) - 1)]
        memory = (float(k), *memory[1:])
        bearing = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)

        # The window: all velocities, and the poses that they lead to in the robot's frame.
        speeds = np.linspace(0.2, 1.0, 5) * min(seen.top_speed, 8.0 * seen.target_distance)
        rates = np.linspace(-self.turn_rate, self.turn_rate, 15)
        v, w = (grid.ravel() for grid in np.meshgrid(speeds, rates))
        times = np.arange(1, self.horizon + 1) * seen.time_step
        turned = w[:, None] * times
        step = v[:, None] * seen.time_step
        xs = np.cumsum(step * np.cos(turned), axis=1)
        ys = np.cumsum(step * np.sin(turned), axis=1)

        # Distance of each trajectory from what the beams hit.
        beams = np.asarray(seen.beams)
        hits = np.column_stack((beams * np.cos(BEARINGS), beams * np.sin(BEARINGS)))
        gaps = np.hypot(xs[:, :, None] - hits[:, 0], ys[:, :, None] - hits[:, 1]).min(axis=(1, 2))
        admissible = gaps > 0.95 * seen.radius
        # Too far off the path to drive in an arc: turn on the spot.
        if abs(bearing) > 2.0 or not admissible.any():
            rate = math.copysign(min(self.turn_rate, abs(bearing) / seen.time_step), bearing)
            # If it faces the path already, creep: beams at an angle see walls that it can pass.
            creep = 0.1 * seen.top_speed if abs(bearing) < 0.3 else 0.0
            return Command(creep, rate), memory

        local = goal - (seen.x, seen.y)
        ahead = math.hypot(*local)
        gx, gy = ahead * math.cos(bearing), ahead * math.sin(bearing)
        off = np.hypot(gx - xs[:, -1], gy - ys[:, -1]) / ahead
        score = (
            -self.w_heading * off
            + self.w_clearance * np.minimum(gaps / seen.radius, 2.0)
            + self.w_speed * v / seen.top_speed
        )
        best = int(np.argmax(np.where(admissible, score, -np.inf)))
        return Command(float(v[best]), float(w[best])), memory
