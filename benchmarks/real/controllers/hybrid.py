"""A planner without a map: it believes that all is free until its beams see a wall."""

import math

import numpy as np
from routes import plan, progress, wrapped

from sim import Command, RobotOptions

BEAMS = 32
BEARINGS = np.arange(BEAMS) * math.tau / BEAMS


class Hybrid:
    """Marks walls in a grid, plans again when they block its path, and follows the path."""

    needs = RobotOptions(beams=BEAMS, beam_range=1.0)
    senses = ("heading", "x", "y", "beams", "target_heading", "target_distance", "bump", "bump_bearing")
    look_again = 40  # steps between two plans without a reason

    def reset(self, world):
        self.cell = world.cell_size
        self.target = (world.target.x, world.target.y)
        self.radius = world.robot_radius
        self.hits = np.zeros(world.walls.shape, int)
        self.path = None
        self.k = 0
        self.age = 0
        return ()

    def act(self, seen, memory):
        news = self.mark(seen)
        self.age += 1
        if self.path is None or self.age > self.look_again or (news and self.is_cut()):
            walls = self.hits > 0
            self.path = plan(walls, self.cell, self.radius, (seen.x, seen.y), self.target)
            self.k = self.age = 0
            if self.path is None:
                # Everything is closed by false marks: forget them.
                self.hits[:] = 0
                return Command(0.0, 1.0), memory
        self.k = progress(self.path, self.k, seen.x, seen.y)
        goal = self.path[min(self.k + 2, len(self.path) - 1)]
        turn = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)
        speed = seen.top_speed if abs(turn) < 0.5 else 0.2 * seen.top_speed
        return Command(speed, turn / seen.time_step), memory

    def mark(self, seen):
        """Mark the cells in which beams end; return True if any is new."""
        beams = np.asarray(seen.beams)
        ends = beams < 1.0
        # A little further, into the cell that the beam has hit.
        reach = beams[ends] + 0.05 * self.cell
        angles = seen.heading + BEARINGS[ends]
        ix = ((seen.x + reach * np.cos(angles)) / self.cell).astype(int)
        iy = ((seen.y + reach * np.sin(angles)) / self.cell).astype(int)
        ny, nx = self.hits.shape
        inside = (ix >= 0) & (ix < nx) & (iy >= 0) & (iy < ny)
        before = int(np.count_nonzero(self.hits))
        self.hits[iy[inside], ix[inside]] = 1
        return int(np.count_nonzero(self.hits)) > before

    def is_cut(self):
        """Return True if a wall is on the rest of the path."""
        rest = self.path[self.k :]
        ix = np.minimum((rest[:, 0] / self.cell).astype(int), self.hits.shape[1] - 1)
        iy = np.minimum((rest[:, 1] / self.cell).astype(int), self.hits.shape[0] - 1)
        return bool((self.hits[iy, ix] > 0).any()) or self.age > 5
