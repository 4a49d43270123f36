"""A behaviour tree with recoveries: plan, follow, and if that fails turn, back up, clear."""

import math

from routes import plan, progress, wrapped

from sim import Command


class Tree:
    """Keeps far from walls; where no such path exists, its recoveries lower the distance."""

    senses = ("heading", "x", "y", "bump")
    patience = 30  # steps without a new place on the path
    steps_of_recovery = 8

    def reset(self, world):
        self.world = world
        self.inflation = 1.42  # radii
        self.path = None
        self.k = 0
        self.waited = 0
        self.tries = 0
        self.recovering = 0
        return ()

    def act(self, seen, memory):
        if self.recovering > 0:
            self.recovering -= 1
            return self.recover(seen), memory
        if self.path is None:
            self.path = self.plan(seen)
            self.k = self.waited = 0
        if self.path is None or self.waited > self.patience:
            # The path is gone: begin the next recovery.
            self.path = None
            self.tries += 1
            self.recovering = self.steps_of_recovery
            if self.tries % 3 == 0:
                self.inflation = max(1.0, self.inflation - 0.25)
            return Command(0.0, 0.0), memory
        return self.follow(seen), memory

    def plan(self, seen):
        world = self.world
        return plan(
            world.walls,
            world.cell_size,
            self.inflation * world.robot_radius,
            (seen.x, seen.y),
            (world.target.x, world.target.y),
            1.1,
        )

    def follow(self, seen):
        k = progress(self.path, self.k, seen.x, seen.y)
        self.waited = 0 if k > self.k else self.waited + 1
        self.k = k
        goal = self.path[min(k + 2, len(self.path) - 1)]
        turn = wrapped(math.atan2(goal[1] - seen.y, goal[0] - seen.x) - seen.heading)
        speed = seen.top_speed * (0.8 if abs(turn) < 0.6 else 0.2)
        return Command(speed, turn / seen.time_step)

    def recover(self, seen):
        """Turn to and fro first, then back up, then stand still while the map is cleared."""
        if self.tries % 3 == 1:
            return Command(0.0, math.tau / self.steps_of_recovery / seen.time_step)
        if self.tries % 3 == 2:
            return Command(-0.2 * seen.top_speed, 0.0)
        return Command(0.0, 0.0)
