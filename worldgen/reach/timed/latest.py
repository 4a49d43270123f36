"""Find how long the robot may wait at the start and still arrive.

It is the search over safe intervals with time running backwards.

Source: as in :mod:`worldgen.reach.timed.earliest`. In reversed time, the latest departure is an
    earliest arrival.
"""

from __future__ import annotations

import math

import numpy as np

from worldgen.lattice import UNIT, exact
from worldgen.reach.still.disc import Disc
from worldgen.reach.still.lattice_graph import build_graph, nodes_within
from worldgen.reach.still.path import travel_ticks
from worldgen.reach.still.walls import ExactPoint, Point
from worldgen.reach.timed.earliest import TimedGraph, nodes_round, search_costs
from worldgen.reach.timed.intervals import CellSpans, safe_intervals, touching
from worldgen.reach.timed.spans import FOREVER, ChangingWalls
from worldgen.world import World


def find_latest_start(
    world: World,
    walls: ChangingWalls,
    k: int,
    start: ExactPoint,
    disc: Disc,
    deadline: float | None,
) -> float | None:
    """Return the longest wait at the start, s, after which some path still arrives in time.

    It considers all paths over nodes at multiples of 1/k cell, under the rules of the timed search.

    Args:
        world: The world, for speed and size.
        walls: Its changes and the radius.
        k: Nodes per cell side.
        start: The start, lu.
        disc: The target.
        deadline: Time, s, by which it has to arrive; None for any time.

    Returns:
        Infinite if there is no such limit; None if there is no path.
    """
    # Mirror the time: intervals end where they began.
    spans = walls.spans
    graph = build_graph(spans.fixed, walls.radius, k)
    ends = nodes_within(disc, graph)
    if not len(ends):
        return None
    mirrored = CellSpans(spans.changing, spans.first, FOREVER - spans.end, FOREVER - spans.begin)
    nodes = safe_intervals(graph.clear, mirrored, touching(walls.radius, k, 0))
    middles = safe_intervals(graph.middle, mirrored, touching(walls.radius, k, 1))
    # Begin at the target, at its deadline.
    soonest = 0 if deadline is None else max(FOREVER - math.floor(exact(deadline) * spans.ticks), 0)
    begun = [
        (state, max(int(nodes.begin[state]), soonest))
        for node in ends.tolist()
        for state in range(nodes.first[node], nodes.first[node + 1])
        if soonest < nodes.end[state]
    ]
    # Search backwards.
    unit = UNIT // k
    pace = (world.cell_size, world.robot_speed, spans.ticks)
    ticks = (travel_ticks((0, 0), (unit, 0), *pace), travel_ticks((0, 0), (unit, unit), *pace))
    begun_at = np.array(begun, np.int64).reshape(-1, 2)
    cost = search_costs(TimedGraph(nodes, middles, graph.stride, ticks), begun_at)
    # Link the start to the nodes around it.
    latest = -1
    for node, point in nodes_round(start, graph.clear, unit):
        takes = travel_ticks(start, point, *pace)
        for state in range(nodes.first[node], nodes.first[node + 1]):
            if cost[state] < FOREVER:
                span = (FOREVER - int(nodes.end[state]), FOREVER - int(cost[state]))
                latest = max(latest, _departure(walls, start, point, takes, span))
    if latest < 0:
        return None
    return math.inf if latest > FOREVER // 2 else latest / spans.ticks


def _departure(
    walls: ChangingWalls, start: ExactPoint, point: Point, takes: int, span: tuple[int, int]
) -> int:
    """Return the latest tick at which to leave the start for a node, to be there within a span.

    Return -1 if there is none. Until then the robot is at the start, which must be safe.
    """
    here = walls.spans_near(start, start)
    until = min((begin for begin, end in here if end > 0), default=FOREVER)
    latest = -1
    free = 0
    for begin, end in [*walls.spans_near(start, point), (FOREVER, FOREVER)]:
        leave = min(until, min(span[1], begin) - takes)
        if leave >= max(span[0] - takes, free, 0):
            latest = max(latest, leave)
        free = max(free, end)
    return latest
