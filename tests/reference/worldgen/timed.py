"""Safe intervals, the search over them, and the spread of a robot.

The specification of ``intervals.c``, ``timed.c`` and
``confine.c``.
"""

import heapq
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.reach.still.lattice_graph import neighbour_shifts
from worldgen.reach.still.walls import Cell
from worldgen.reach.timed.intervals import Blocked, Intervals
from worldgen.reach.timed.spans import FOREVER


def safe_intervals(
    clear: npt.NDArray[np.bool_], spans: Blocked, classes: Sequence[Sequence[Cell]]
) -> Intervals:
    """Return when the points of a raster are safe, like the package's function."""
    inputs, most = _points_and_spans(clear, spans, classes)
    lists = [array.tolist() for array in inputs]
    counts = [0] * (clear.size + 1)
    low = [0] * (most + 2)
    high = [0] * (most + 2)
    _safe_intervals(*lists, counts, [], [], low, high, False)
    total = np.cumsum(counts)
    begin = [0] * int(total[-1])
    end = [0] * int(total[-1])
    _safe_intervals(*lists, total.tolist(), begin, end, low, high, True)
    return Intervals(total, np.array(begin, np.int64), np.array(end, np.int64))


def _points_and_spans(
    clear: npt.NDArray[np.bool_], spans: Blocked, classes: Sequence[Sequence[Cell]]
) -> tuple[Any, int]:
    """The first eight arguments of ``_safe_intervals``, and how many spans one point may have
    around it.
    """
    k = round(len(classes) ** 0.5)
    pad = max((max(abs(dx), abs(dy)) for found in classes for dx, dy in found), default=0) + 1
    cells = np.pad(spans.changing, pad)
    number = np.zeros(cells.size, np.int64)
    number[cells.ravel()] = np.diff(spans.first)[spans.changing.ravel()]
    span_first = np.concatenate([[0], np.cumsum(number)])
    steps = np.array([dy * cells.shape[1] + dx for found in classes for dx, dy in found], np.int64)
    class_first = np.concatenate([[0], np.cumsum([len(found) for found in classes])]).astype(
        np.int64
    )
    rows, columns = clear.shape
    y = np.arange(rows, dtype=np.int32)[:, None]
    x = np.arange(columns, dtype=np.int32)[None, :]
    place = (
        (y // k + pad) * cells.shape[1] + x // k + pad
    )  # 32 bits: there are tens of millions of points
    kind = y % k * k + x % k
    points = [clear.view(np.uint8).ravel(), place.ravel(), kind.ravel()]
    most = int(number.max(initial=0)) * max(len(found) for found in classes)
    return [*points, class_first, steps, span_first, spans.begin, spans.end], most


def _safe_intervals(
    clear: Any, place: Any, kind: Any, class_first: Any, steps: Any,
    span_first: Any, span_begin: Any, span_end: Any, first: Any, begin: Any, end: Any, low: Any, high: Any, fill: Any,
) -> None:  # fmt: skip
    """Counts the safe intervals of point p in first[p + 1], or writes them from first[p] on.

    ``low`` and ``high`` hold the blocked spans around one point, sorted by insertion.
    """
    for p in range(len(clear)):
        if clear[p] == 0:
            continue
        count = 0
        for s in range(class_first[kind[p]], class_first[kind[p] + 1]):
            cell = place[p] + steps[s]
            for span in range(span_first[cell], span_first[cell + 1]):
                at = count
                while at > 0 and low[at - 1] > span_begin[span]:
                    low[at], high[at] = low[at - 1], high[at - 1]
                    at -= 1
                low[at] = span_begin[span]
                high[at] = span_end[span]
                count += 1
        free, found = 0, 0  # free: tick from which nothing seen so far blocks the point
        for i in range(count + 1):
            until = low[i] if i < count else FOREVER
            if until > free:
                if fill:
                    begin[first[p] + found], end[first[p] + found] = free, until
                found += 1
            if i < count and high[i] > free:
                free = high[i]
        if not fill:
            first[p + 1] = found


def search(graph: Any, begun: Any, goal: Any, lean: Any) -> tuple[Any, ...]:
    """Return the final state, and the node, cost, predecessor and departure of each state.

    Like the package's function.
    """
    nodes = graph.nodes
    count = len(nodes.begin)
    node_of = np.repeat(np.arange(len(nodes.first) - 1), np.diff(nodes.first)).tolist()
    cost = [FOREVER] * count
    came = [-1] * count
    depart = [0] * count
    lists = [
        array.tolist()
        for part in (nodes, graph.middles)
        for array in (part.first, part.begin, part.end)
    ]
    final = _safe_search(
        *lists,
        node_of,
        graph.stride,
        *neighbour_shifts(graph.stride),
        begun.tolist(),
        goal.tolist(),
        lean,
        graph.ticks,
        cost,
        came,
        depart,
    )
    return final, node_of, cost, came, depart


def _safe_search(
    first: Any, begin: Any, end: Any, mid_first: Any, mid_begin: Any, mid_end: Any, node_of: Any, stride: Any,
    shifts: Any, corners: Any, begun: Any, goal: Any, lean: Any, ticks: Any,
    cost: Any, came: Any, depart: Any,
) -> Any:  # fmt: skip
    """A* over (node, safe interval); cost is the tick of arrival. Returns the final state or -1."""
    gx, gy, slack = lean
    axis, diagonal = ticks
    queue = [(0, 0, 0)]
    heapq.heappop(queue)
    for i in range(len(begun)):
        state = int(begun[i][0])
        arrival = int(begun[i][1])
        cost[state] = arrival
        heapq.heappush(queue, (arrival, arrival, state))
    while len(queue) > 0:
        _, now, state = heapq.heappop(queue)
        if now != cost[state]:
            continue
        node = node_of[state]
        if goal[node] == 1:
            return state
        for direction in range(8):
            other = node + shifts[direction]
            takes = axis if direction < 4 else diagonal
            for onto in range(first[other], first[other + 1]):
                leave = max(now, begin[onto])
                close = min(end[state], end[onto])
                if leave + takes > close or leave + takes >= cost[onto]:
                    continue
                if direction > 3:
                    found, corner = -1, node + corners[direction]
                    for middle in range(mid_first[corner], mid_first[corner + 1]):
                        if found < 0 and max(leave, mid_begin[middle]) + takes <= min(
                            close, mid_end[middle]
                        ):
                            found = max(leave, mid_begin[middle])
                    if found < 0 or found + takes >= cost[onto]:
                        continue
                    leave = found
                cost[onto], came[onto], depart[onto] = leave + takes, state, leave
                dx = abs(other % stride - gx)
                dy = abs(other // stride - gy)
                guess = max(0, axis * max(dx, dy) + (diagonal - axis) * min(dx, dy) - slack)
                heapq.heappush(queue, (leave + takes + guess, leave + takes, onto))
    return -1


def spread_out(
    first: Any,
    tile: Any,
    low: Any,
    high: Any,
    goal: Any,
    columns: Any,
    rows: Any,
    sources: Any,
    came: Any,
) -> Any:
    """Fills ``came``, state by state in order of slabs.

    Returns the slab in which the goal is reached, or -1.
    """
    queue = [(0, 0)]
    heapq.heappop(queue)
    for i in range(len(sources)):
        came[sources[i]] = 0
        heapq.heappush(queue, (0, int(sources[i])))
    while len(queue) > 0:
        now, state = heapq.heappop(queue)
        here = tile[state]
        if goal[here] == 1:
            return now
        x = here % columns
        y = here // columns
        for iy in range(max(y - 1, 0), min(y + 2, rows)):
            for ix in range(max(x - 1, 0), min(x + 2, columns)):
                other = iy * columns + ix
                for onto in range(first[other], first[other + 1]):
                    at = max(now + 1, low[onto])
                    if came[onto] < 0 and at <= high[onto] and at <= high[state] + 1:
                        came[onto] = at
                        heapq.heappush(queue, (at, onto))
    return -1
