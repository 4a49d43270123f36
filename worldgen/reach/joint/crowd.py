"""Add robots one after another, each with a path around those before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from worldgen._core import ffi
from worldgen.reach.joint.apart import stay_apart
from worldgen.reach.joint.plan import RobotOrder
from worldgen.reach.joint.question import Ground, RobotEnds, joint_question
from worldgen.reach.joint.witness import make_joint_witness
from worldgen.support.ccall import kept, pointer
from worldgen.world import JointWitness, Robot, World

_MOST_STATES = 50_000  # states of one robot: enough for a path through a hall of 1000 robots


class Crowd:
    """Robots of equal size and speed that have paths around each other.

    A robot that finds no path is left out, and another one can be tried instead. So a crowd takes
    about as many searches as it has robots, whereas the search for a joint plan of robots that are
    already placed may never end.

    Args:
        world: A world of one robot, which is the first.
        count: Limit on the robots that can be added, including the first.
        margin: Seconds by which all robots may start late, in a world that changes.
    """

    def __init__(self, world: World, count: int, margin: float = 0.0) -> None:
        self.robots: list[Robot] = []
        self._question = joint_question(world, k=2, radius=None, margin=margin)
        if self._question is None:
            return
        self._ground = Ground(self._question.rasters, 0, self._question.radii[0])
        self._ends: list[RobotEnds] = []
        described = self._question.described()
        # The order knows only how many robots there are; each brings its own start and target.
        zeros = np.zeros(count + 1, np.int64)
        described.robots = count
        described.class_of = described.starts = described.crossed_from = pointer(
            ffi, zeros, np.int64
        )
        self._order = RobotOrder(kept(ffi, described, zeros))
        self.add(world.robots[0])

    def add(self, robot: Robot) -> bool:
        """Add a robot if it finds a path without changing the others' paths."""
        # Find out how it gets onto the nodes.
        question = self._question
        if question is None:
            return False
        distances = np.empty(question.distances.shape[1], np.int32)
        ends = self._ground.ends(robot, question.world.cell_size, distances)
        if not ends.nodes or not self._leg_fits(ends):
            return False
        # Search for a path, and keep the robot only if there is one.
        found = self._order.add(len(self.robots), ends, distances, _MOST_STATES)
        if found:
            self.robots.append(robot)
            self._ends.append(ends)
        return found

    def witness(self, world: World) -> JointWitness | None:
        """Return the proof for a world of these robots; None if their last legs conflict."""
        assert self._question is not None
        count = len(self.robots)
        question = replace(
            self._question, world=world, radii=self._question.radii * count, ends=self._ends
        )
        return make_joint_witness(question, self._order.plan())

    def _leg_fits(self, ends: RobotEnds) -> bool:
        """Return True if the first leg of a robot stays clear of the others' first legs."""
        question = self._question
        assert question is not None
        if self.robots and not question.has_first_leg and ends.start != question.point(ends.node):
            return False  # no tick is reserved for first legs
        apart_sq = question.apart_sq(0, 0)
        leg = (ends.start, question.point(ends.node))
        # Most of the others already stand on a node; their legs have length zero, but still count.
        return all(
            stay_apart(leg, (other.start, question.point(other.node)), apart_sq)
            for other in (self._ends if question.has_first_leg else ())
        )
