"""MPPI with few samples along a planned path (Williams et al., 2017)."""

import math

import numpy as np
from routes import clear_points, plan_in, progress, wrapped

from sim import Command

SAMPLES = 24
HORIZON = 10


class Mppi:
    """Averages random turn rates by how well they follow the path and keep out of walls."""

    senses = ("heading", "x", "y", "target_distance")
    temperature = 0.05
    spread = 8.0  # rad/s

    def reset(self, world):
        self.rng = np.random.default_rng(1)
        self.path = plan_in(world)
        self.k = 0
        self.cell = world.cell_size
        self.clear = clear_points(world.walls, 0.95 * world.robot_radius / world.cell_size)
        self.rates = np.zeros(HORIZON)
        return ()

    def act(self, seen, memory):
        self.k = progress(self.path, self.k, seen.x, seen.y)
        goal = self.path[min(self.k + 4, len(self.path) - 1)]
        bearing = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)
        if abs(bearing) > 1.2:
            self.rates[:] = 0.0
            return Command(0.0, bearing / seen.time_step), memory
        speed = 0.6 * min(seen.top_speed, 8.0 * seen.target_distance)
        noise = self.rng.normal(0.0, self.spread, (SAMPLES, HORIZON))
        rates = self.rates + noise
        headings = seen.heading + np.cumsum(rates, axis=1) * seen.time_step
        xs = seen.x + np.cumsum(np.cos(headings), axis=1) * speed * seen.time_step
        ys = seen.y + np.cumsum(np.sin(headings), axis=1) * speed * seen.time_step
        cost = np.hypot(xs[:, -1] - goal[0], ys[:, -1] - goal[1]) / (4 * self.cell)
        cost += 0.1 * self.touches(xs, ys).sum(axis=1)
        weights = np.exp(-(cost - cost.min()) / self.temperature)
        self.rates = weights @ rates / weights.sum()
        rate = self.rates[0]
        self.rates = np.append(self.rates[1:], 0.0)
        return Command(float(speed), float(rate)), memory

    def touches(self, xs, ys):
        ny, nx = self.clear.shape
        ix = np.clip(np.rint(xs * 4 / self.cell).astype(int), 0, nx - 1)
        iy = np.clip(np.rint(ys * 4 / self.cell).astype(int), 0, ny - 1)
        return ~self.clear[iy, ix]
