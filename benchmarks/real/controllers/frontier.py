"""Explore frontiers with a grid from 36 beams until a path to the target is known."""

import math

import numpy as np
from routes import plan, progress, wrapped

from sim import Command, RobotOptions

BEAMS = 36
BEARINGS = np.arange(BEAMS) * math.tau / BEAMS
UNKNOWN, FREE, SOLID = 0, 1, 2


class Frontier:
    """Maps what it sees, and drives to the frontier with the least cost."""

    needs = RobotOptions(beams=BEAMS, beam_range=1.0)
    senses = ("heading", "x", "y", "beams")

    def reset(self, world):
        self.cell = world.cell_size
        self.radius = world.robot_radius
        self.target = (world.target.x, world.target.y)
        self.grid = np.zeros(world.walls.shape, np.int8)
        self.path = None
        self.k = 0
        self.tired = 0
        self.given_up = []
        return ()

    def act(self, seen, memory):
        news = self.look(seen)
        self.tired += 1
        if self.path is None or self.tired > 60 or (news and self.tired > 12):
            self.choose(seen)
        if self.path is None:
            return Command(0.2 * seen.top_speed, 1.0 / seen.time_step), memory
        self.k = progress(self.path, self.k, seen.x, seen.y)
        if self.k >= len(self.path) - 2 and self.goal != self.target:
            self.given_up.append(self.goal)
            self.path = None
            return Command(0.0, 0.0), memory
        goal = self.path[min(self.k + 2, len(self.path) - 1)]
        turn = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)
        speed = seen.top_speed if abs(turn) < 0.5 else 0.2 * seen.top_speed
        return Command(speed, turn / seen.time_step), memory

    def look(self, seen):
        """Enter what the beams cross and hit; return True if a cell is new."""
        before = int(np.count_nonzero(self.grid))
        beams = np.asarray(seen.beams)
        angles = seen.heading + BEARINGS
        for share in np.linspace(0.0, 1.0, 12):
            self.enter(seen, share * (beams - 0.05 * self.cell), angles, FREE)
        self.enter(seen, (beams + 0.05 * self.cell)[beams < 1.0], angles[beams < 1.0], SOLID)
        return int(np.count_nonzero(self.grid)) > before

    def enter(self, seen, reach, angles, state):
        x = (seen.x + reach * np.cos(angles)) / self.cell
        y = (seen.y + reach * np.sin(angles)) / self.cell
        ix, iy = x.astype(int), y.astype(int)
        ny, nx = self.grid.shape
        inside = (ix >= 0) & (ix < nx) & (iy >= 0) & (iy < ny)
        # A beam that ends at a corner may belong to either cell.
        inside &= np.maximum(np.abs(x - np.rint(x)), np.abs(y - np.rint(y))) > 0.1
        self.grid[iy[inside], ix[inside]] = state

    def choose(self, seen):
        """Plan to the target through known space, or to the best frontier."""
        here = (seen.x, seen.y)
        self.k = self.tired = 0
        self.goal = self.target
        self.path = plan(self.grid != FREE, self.cell, self.radius, here, self.target)
        if self.path is not None and math.dist(self.path[-2], self.target) < self.cell:
            return
        for goal in sorted(self.frontiers(), key=lambda place: self.cost(here, place)):
            self.goal = goal
            self.path = plan(self.grid == SOLID, self.cell, self.radius, here, goal)
            if self.path is not None:
                return
            self.given_up.append(goal)
        # Nothing is left to explore: hope that the unknown is free.
        self.goal = self.target
        self.given_up.clear()
        self.path = plan(self.grid == SOLID, self.cell, self.radius, here, self.target)

    def frontiers(self):
        """Return free places next to unknown cells, without those given up."""
        unknown = np.pad(self.grid == UNKNOWN, 1)
        near = unknown[:-2, 1:-1] | unknown[2:, 1:-1] | unknown[1:-1, :-2] | unknown[1:-1, 2:]
        iy, ix = np.nonzero(near & (self.grid == FREE))
        places = [
            ((x + 0.5) * self.cell, (y + 0.5) * self.cell)
            for x, y in zip(ix.tolist(), iy.tolist(), strict=True)
        ]
        return [place for place in places if place not in self.given_up]

    def cost(self, here, place):
        return math.dist(here, place) + math.dist(place, self.target)
