"""Find the earliest arrival in a world that changes, by safe-interval search on the same graph.

A point of the graph is safe while no blocked cell is closer than the radius. The clearance of an
edge is attained at its ends or its middle, whatever the cells, so an edge is safe while these
points are. A state of the search is (node, safe interval): within one interval, an earlier arrival
is never worse, since the robot can wait.

Source: Mike Phillips, Maxim Likhachev, "SIPP: Safe Interval Path Planning for Dynamic
    Environments", 2011.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT, exact
from worldgen.reach.still.disc import Disc
from worldgen.reach.still.lattice_graph import build_graph, nodes_within
from worldgen.reach.still.path import metres, root_down, travel_ticks
from worldgen.reach.still.walls import ExactPoint, Point
from worldgen.reach.timed.intervals import Intervals, safe_intervals, touching
from worldgen.reach.timed.spans import FOREVER, MARGIN, ChangingWalls
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, pointer, writable
from worldgen.world import Witness, World

# Limit on the corners that one straight line may replace.
_LOOK_AHEAD = 24
# Limit on straight lines tried per path; long paths look ahead less.
_TESTS = 20_000
# Queue entries to process between checks for Ctrl-C.
_PORTION = 200_000


@dataclass(frozen=True)
class TimedPath:
    """Points, 1/1024 cell, and the ticks at which the robot is there.

    It moves uniformly between them.
    """

    points: list[ExactPoint]
    times: list[int]


def find_timed_path(
    world: World, walls: ChangingWalls, k: int, start: ExactPoint, disc: Disc
) -> TimedPath | None:
    """Return the earliest path over nodes at multiples of 1/k cell, from the start at time 0.

    Args:
        world: The world, for speed and size.
        walls: Its changes and the radius.
        k: Nodes per cell side.
        start: The start, lu.
        disc: The target.
    """
    spans = walls.spans
    graph = build_graph(spans.fixed, walls.radius, k)
    ends = nodes_within(disc, graph)
    unit = UNIT // k
    pace = (world.cell_size, world.robot_speed, spans.ticks)
    axis = travel_ticks((0, 0), (unit, 0), *pace)
    diagonal = travel_ticks((0, 0), (unit, unit), *pace)
    near = [
        (node, p, travel_ticks(start, p, *pace))
        for node, p in nodes_round(start, graph.clear, unit)
    ]
    sources = [(node, arrival) for node, p, arrival in near if walls.is_clear(start, p, 0, arrival)]
    if not sources or not len(ends):
        return None
    nodes = safe_intervals(graph.clear, spans, touching(walls.radius, k, 0))
    middles = safe_intervals(graph.middle, spans, touching(walls.radius, k, 1))
    toward = (round(disc.x / unit), round(disc.y / unit))
    timed = TimedGraph(nodes, middles, graph.stride, (axis, diagonal))
    states = _search_states(timed, sources, ends, toward)
    return _with_waits(start, states, graph.stride, unit) if states else None


def _with_waits(
    start: ExactPoint, states: list[tuple[int, int, int]], stride: int, unit: int
) -> TimedPath:
    """Return the points and times of a path of (node, previous departure, arrival)."""
    points: list[ExactPoint] = [start]
    times = [0]
    for node, depart, arrival in states:
        point = (node % stride * unit, node // stride * unit)
        if depart > times[-1]:
            points.append(points[-1])
            times.append(depart)
        if arrival > times[-1]:
            points.append(point)
            times.append(arrival)
    return TimedPath(points, times)


def shorten_timed(walls: ChangingWalls, path: TimedPath) -> TimedPath:
    """Replace corners by straight lines at uniform speed that stay clear of all blocked cells.

    Waits are kept: a line never spans one.
    """
    points, times = _merge_even(path)
    ahead = min(_LOOK_AHEAD, max(2, _TESTS // len(points)))
    kept = [0]
    at = 0
    while at < len(points) - 1:
        far = at + 1
        while (
            far < min(at + ahead, len(points) - 1)
            and points[far] != points[far - 1]
            and points[far + 1] != points[far]
        ):
            far += 1
        while far > at + 1 and not walls.is_clear(
            points[at], points[far], times[at] - MARGIN, times[far] + MARGIN
        ):
            far -= 1
        kept.append(far)
        at = far
    return TimedPath([points[i] for i in kept], [times[i] for i in kept])


def _merge_even(path: TimedPath) -> tuple[list[ExactPoint], list[int]]:
    """Drop points on a straight line that the robot passes without a change of speed."""
    points = path.points[:1]
    times = path.times[:1]
    for i in range(1, len(path.points)):
        while len(points) > 1 and _is_even(points[-2:], times[-2:], path.points[i], path.times[i]):
            points.pop()
            times.pop()
        points.append(path.points[i])
        times.append(path.times[i])
    return points, times


def _is_even(points: list[ExactPoint], times: list[int], point: ExactPoint, time: int) -> bool:
    a, b = points
    before = times[1] - times[0]
    after = time - times[1]
    return all((b[axis] - a[axis]) * after == (point[axis] - b[axis]) * before for axis in (0, 1))


def make_timed_witness(world: World, walls: ChangingWalls, path: TimedPath) -> Witness:
    """Return the path in metres and seconds, with its clearance."""
    x, y = metres(path.points, world.cell_size)
    clearance = root_down(
        walls.clearance_sq(path.points, path.times) * (exact(world.cell_size) / UNIT) ** 2
    )
    return Witness(
        np.array([time / walls.spans.ticks for time in path.times]),
        np.array(x),
        np.array(y),
        clearance,
    )


def nodes_round(start: ExactPoint, clear: Bools, unit: int) -> list[tuple[int, Point]]:
    """Return the start's node, or the nodes around the start."""
    x, y = start
    exactly = x % unit == 0 and y % unit == 0
    spread = range(1) if exactly else range(-1, 3)
    found = []
    for j in (y // unit + d for d in spread):
        for i in (x // unit + d for d in spread):
            if 0 <= j < clear.shape[0] and 0 <= i < clear.shape[1] and clear[j, i]:
                found.append((j * clear.shape[1] + i, (i * unit, j * unit)))
    return found


@dataclass(frozen=True)
class TimedGraph:
    """The nodes that a robot can be at, with their safe intervals.

    Args:
        nodes: Safe intervals of the nodes.
        middles: Safe intervals of the middles of their squares.
        stride: Nodes per row.
        ticks: Ticks of an axis step and of a diagonal one.
    """

    nodes: Intervals
    middles: Intervals
    stride: int
    ticks: tuple[int, int]


def _search_states(
    graph: TimedGraph, sources: Sequence[tuple[int, int]], ends: Ints, toward: tuple[int, int]
) -> list[tuple[int, int, int]]:
    """Return (node, departure from the previous one, arrival) along the earliest path.

    It is empty if there is none.
    """
    goal = np.zeros(len(graph.nodes.first) - 1, np.uint8)
    goal[ends] = 1
    x, y = toward
    rows, columns = np.divmod(ends, graph.stride)
    spread = int(np.maximum(np.abs(columns - x), np.abs(rows - y)).max())
    # An end is closer than ``toward`` by at most this much.
    lean = (x, y, spread * graph.ticks[1])
    begun = _first_states(graph.nodes, sources)
    final, node_of, cost, came, depart = _search(graph, begun, goal, lean)
    path = []
    while final >= 0:
        path.append((int(node_of[final]), int(depart[final]), int(cost[final])))
        final = int(came[final])
    return path[::-1]


def search_costs(graph: TimedGraph, begun: Ints) -> Any:
    """Return the earliest tick at which each state is reached from any of the initial ones.

    It is ``FOREVER`` for states that are not reached.

    Args:
        graph: The nodes.
        begun: (n, 2) states and ticks.
    """
    nowhere = np.zeros(len(graph.nodes.first) - 1, np.uint8)
    return _search(graph, begun, nowhere, (0, 0, FOREVER))[2]


def _search(
    graph: TimedGraph, begun: Ints, goal: Any, lean: tuple[int, int, int]
) -> tuple[int, Any, Any, Any, Any]:
    """Search; return the final state, and all states' nodes, costs, predecessors, departures."""
    # Describe the search to C.
    nodes = graph.nodes
    middles = graph.middles
    size = len(nodes.first) - 1
    count = len(nodes.begin)
    node_of = np.repeat(np.arange(size, dtype=np.int32), np.diff(nodes.first))
    cost = np.full(count, FOREVER, np.int64)
    came = np.full(count, -1, np.int32)
    depart = np.zeros(count, np.int64)
    lists = (nodes.first, nodes.begin, nodes.end, middles.first, middles.begin, middles.end)
    names = ("first", "begin", "end", "mid_first", "mid_begin", "mid_end")
    fields = {
        **{name: pointer(ffi, array, np.int64) for name, array in zip(names, lists, strict=True)},
        "nodes": size,
        "stride": graph.stride,
        "states": count,
        "node_of": pointer(ffi, node_of, np.int32),
        "goal": pointer(ffi, goal, np.uint8),
        "toward_x": lean[0],
        "toward_y": lean[1],
        "slack": min(lean[2], 2 * FOREVER),
        # A step that takes longer than any interval is never taken.
        "axis_ticks": min(graph.ticks[0], FOREVER),
        "diagonal_ticks": min(graph.ticks[1], FOREVER),
        "cost": writable(ffi, cost, np.int64),
        "came": writable(ffi, came, np.int32),
        "depart": writable(ffi, depart, np.int64),
    }
    asked = ffi.new("WgTimed *", fields)
    made = ffi.new("WgTimedSearch **")
    progress = ffi.new("WgProgress *")
    final = ffi.new("int64_t *")
    # Search in portions, so that Ctrl-C is noticed.
    check(lib.wg_timed_new(asked, pointer(ffi, begun, np.int64), len(begun), made))
    try:
        while True:
            check(lib.wg_timed_advance(made[0], _PORTION, progress, final))
            if progress[0] != lib.WG_GOING:
                return final[0], node_of, cost, came, depart
    finally:
        lib.wg_timed_free(made[0])


def _first_states(nodes: Intervals, sources: Sequence[tuple[int, int]]) -> Ints:
    """Return a (n, 2) array: states in which the robot gets to a node, with the tick of arrival."""
    found = [
        (state, arrival)
        for node, arrival in sources
        for state in range(nodes.first[node], nodes.first[node + 1])
        if nodes.begin[state] <= arrival < nodes.end[state]
    ]
    return np.array(found, np.int64).reshape(-1, 2)
