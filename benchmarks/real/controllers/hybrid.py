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
    senses = (
        "heading",
        "x",
        "y",
        "beams",
        "target_heading",
        "target_distance",
        "bump",
        "bump_bearing",
    )
    look_again = 40  # steps between two plans without a reason

    def reset(self, world):
        self.cell = world.cell_size
        self.target = (world.target.x, world.target.y)
        self.radius = world.robot_radius
        self.seen_at = np.zeros(world.walls.shape, int)
        self.now = 0
        self.path = None
        self.k = 0
        self.age = 0
        return ()

    def act(self, seen, memory):
        self.now += 1
        news = self.mark(seen)
        self.age += 1
        if self.path is None or self.age > self.look_again or (news and self.is_cut()):
            walls = self.seen_at > 0
            self.path = plan(walls, self.cell, self.radius, (seen.x, seen.y), self.target)
            self.k = self.age = 0
            if self.path is None:
                # Everything is closed by false marks: forget them.
                self.seen_at[:] = 0
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
        x = (seen.x + reach * np.cos(angles)) / self.cell
        y = (seen.y + reach * np.sin(angles)) / self.cell
        ix, iy = x.astype(int), y.astype(int)
        ny, nx = self.seen_at.shape
        inside = (ix >= 0) & (ix < nx) & (iy >= 0) & (iy < ny)
        # A beam that ends at a corner may belong to either cell.
        inside &= np.maximum(np.abs(x - np.rint(x)), np.abs(y - np.rint(y))) > 0.1
        before = int(np.count_nonzero(self.seen_at))
        self.seen_at[iy[inside], ix[inside]] = self.now
        return int(np.count_nonzero(self.seen_at)) > before

    def is_cut(self):
        """Return True if a wall is on the rest of the path."""
        rest = self.path[self.k :]
        ix = np.minimum((rest[:, 0] / self.cell).astype(int), self.seen_at.shape[1] - 1)
        iy = np.minimum((rest[:, 1] / self.cell).astype(int), self.seen_at.shape[0] - 1)
        return bool((self.seen_at[iy, ix] > 0).any()) or self.age > 5
