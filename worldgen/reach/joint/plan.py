"""Search for a joint plan, with the cheapest methods first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen._core import ffi, lib
from worldgen.reach.joint.question import JointQuestion, RobotEnds
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, kept, pointer, writable

# Each robot without a path is planned first in the next round. In most worlds this works within a
# few rounds; twice the number of robots is enough, and more than forty only cost time.
_MOST_ORDERS = 40
_MOST_ONE = 2_000_000  # states of one robot
_MOST_EXHAUST = 300_000  # joint states: about 3 s for two robots in a narrow place
_FEW = 3  # robots whose joint states are searched one by one
_MOST_LACAM = 30_000  # joint states for more robots
_QUICK_EXHAUST = 30_000  # for a search that is not thorough: tens of milliseconds
_QUICK_LACAM = 1_000
_QUICK_ONE = 200_000
_QUICK_ORDERS = 6
# Ticks, spans or moves between two checks for Ctrl-C.
_PORTION = 1_000_000


@dataclass(frozen=True)
class PlanResult:
    """The result of the searches.

    Args:
        nodes: (ticks + 1, robots) int64, node of each robot; None if no plan was found.
        is_exhausted: True if it is known that there is no plan over this graph.
    """

    nodes: Ints | None
    is_exhausted: bool = False


def find_plan(question: JointQuestion, *, thorough: bool = True) -> PlanResult:
    """Look for a plan in which all robots get from their nodes to their targets.

    At first, the robots are planned one after another, in several orders. If that fails, it
    searches the joint states: all of them for few robots, and depth first for many.

    Args:
        question: Robots, nodes and ticks.
        thorough: True to search for long; a generator has other places to try instead.
    """
    described = question.described()
    nodes = _one_after_the_other(question, described, thorough=thorough)
    if nodes is not None:
        return PlanResult(nodes)
    if len(question.ends) <= _FEW:
        most = _MOST_EXHAUST if thorough else _QUICK_EXHAUST
        return _joint(lib.wg_joint_exhaust, described, most)
    most = _MOST_LACAM if thorough else _QUICK_LACAM
    return _joint(lib.wg_joint_lacam, described, most)


def _one_after_the_other(question: JointQuestion, described: Any, *, thorough: bool) -> Ints | None:
    """Plan by priority; a robot that finds no path gets the highest priority in the next try."""
    # Begin with the robots that have the longest paths.
    starts = [end.node for end in question.ends]
    far = question.distances[np.arange(len(starts)), starts]
    order = np.argsort(-far, kind="stable").astype(np.int64)
    tried: set[bytes] = set()
    most = _MOST_ONE if thorough else _QUICK_ONE
    orders = _MOST_ORDERS if thorough else _QUICK_ORDERS
    for _ in range(min(2 * len(starts) + 2, orders)):
        tried.add(order.tobytes())
        planned = RobotOrder(described)
        stuck = next(
            (
                robot
                for robot in order.tolist()
                if not planned.add(robot, question.ends[robot], question.distances[robot], most)
            ),
            None,
        )
        if stuck is None:
            return planned.plan()
        # A robot that has no path even if all others make room for it has to make room itself.
        is_first = stuck == order[0]
        rest = order[order != stuck]
        order = np.concatenate([rest, [stuck]] if is_first else [[stuck], rest])
        if order.tobytes() in tried:
            order = np.ascontiguousarray(order[::-1])
        if order.tobytes() in tried:
            return None
    return None


def _joint(search: Any, described: Any, most: int) -> PlanResult:
    begun = ffi.new("WgJointSearch **")
    check(search(described, most, begun))
    made = ffi.new("WgJointPlan **")
    progress = ffi.new("WgProgress *")
    try:
        while progress[0] == lib.WG_GOING:
            check(lib.wg_joint_search_advance(begun[0], _PORTION, made, progress))
    finally:
        lib.wg_joint_search_free(begun[0])
    if made[0] != ffi.NULL:
        return PlanResult(_taken_nodes(made[0], described.robots))
    return PlanResult(None, progress[0] == lib.WG_EXHAUSTED)


class RobotOrder:
    """Robots that are planned one after another, each around those before it.

    Args:
        described: ``WgJoint`` of the question. Only the number and classes of its robots count.
    """

    def __init__(self, described: Any) -> None:
        self._robots = described.robots
        made = ffi.new("WgJointOrder **")
        check(lib.wg_joint_order_new(described, made))
        self._order = kept(ffi, made[0], described, free=lib.wg_joint_order_free)

    def add(
        self, number: int, ends: RobotEnds, distances: npt.NDArray[np.int32], most: int
    ) -> bool:
        """Add a robot if it has a path; return True if it has.

        Args:
            number: Number of the robot, from 0.
            ends: Its node, and the steps that lead across its target.
            distances: (nodes,) int32, steps from each node to its target.
            most: Limit on the states that its search reaches.
        """
        robot = ffi.new("WgJointRobot *")
        robot.number = number
        robot.start = ends.node
        robot.distances = pointer(ffi, distances, np.int32)
        robot.crossings = pointer(ffi, ends.crossings, np.int64)
        robot.crossing_count = len(ends.crossings)
        check(lib.wg_joint_order_add(self._order, robot, most))
        progress = ffi.new("WgProgress *")
        while progress[0] == lib.WG_GOING:
            check(lib.wg_joint_order_advance(self._order, _PORTION, progress))
        return bool(progress[0] == lib.WG_FOUND)

    def plan(self) -> Ints:
        """Return the nodes of all robots, each of which has a path: (ticks + 1, robots)."""
        made = ffi.new("WgJointPlan **")
        check(lib.wg_joint_order_plan(self._order, made))
        return _taken_nodes(made[0], self._robots)


def _taken_nodes(plan: Any, robots: int) -> Ints:
    """Return the nodes of a plan, which is freed."""
    try:
        nodes = np.empty((lib.wg_joint_length(plan) + 1, robots), np.int64)
        lib.wg_joint_nodes(plan, writable(ffi, nodes, np.int64))
    finally:
        lib.wg_joint_free(plan)
    return nodes
