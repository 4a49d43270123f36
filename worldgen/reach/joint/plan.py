"""Search for a joint plan, with the cheapest methods first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from worldgen._core import ffi, lib
from worldgen.reach.joint.question import JointQuestion
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, pointer, writable

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
    made = ffi.new("WgJointPlan **")
    failed = ffi.new("int64_t *")
    most = _MOST_ONE if thorough else _QUICK_ONE
    orders = _MOST_ORDERS if thorough else _QUICK_ORDERS
    for _ in range(min(2 * len(starts) + 2, orders)):
        tried.add(order.tobytes())
        check(
            lib.wg_joint_prioritised(described, pointer(ffi, order, np.int64), most, made, failed)
        )
        if made[0] != ffi.NULL:
            return taken_nodes(made[0], described.robots)
        stuck = int(failed[0])
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
    made = ffi.new("WgJointPlan **")
    progress = ffi.new("WgProgress *")
    check(search(described, most, made, progress))
    if made[0] != ffi.NULL:
        return PlanResult(taken_nodes(made[0], described.robots))
    return PlanResult(None, progress[0] == lib.WG_EXHAUSTED)


def taken_nodes(plan: Any, robots: int) -> Ints:
    """Return the nodes of a plan, which is freed."""
    try:
        nodes = np.empty((lib.wg_joint_length(plan) + 1, robots), np.int64)
        lib.wg_joint_nodes(plan, writable(ffi, nodes, np.int64))
    finally:
        lib.wg_joint_free(plan)
    return nodes
