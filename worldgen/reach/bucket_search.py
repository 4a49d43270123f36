"""The search over half cells, compiled: the way that ``lattice_graph`` finds, with buckets and bits for its heap.

The plain search takes the node with the least estimate, and of several the one with the least number. Estimates
never fall, and a step raises one by at most 198. So they wait in a ring of buckets, one for each estimate, and the
nodes of the present estimate are bits in a tree of words, 32 to a word, which gives the least in five looks at most.
Both searches expand the same nodes in the same order; a heap took twice to four times as long where much is open.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from worldgen.jit import lazy_kernel

__all__ = ["BUCKETS", "bucket_search", "bucket_search_compiled", "room_for_search"]

BUCKETS = 1024
"""More than any two estimates that wait at once are apart: 198, and between sources three steps each way."""

RING = BUCKETS - 1  # of an estimate, the bits that number its bucket

_LOWEST_BIT = np.zeros(32, np.int64)  # of a power of two, by the top five bits of its product with a de Bruijn number
for _bit in range(32):
    _LOWEST_BIT[((1 << _bit) * 0x077CB531 & 0xFFFFFFFF) >> 27] = _bit


def room_for_search(size: int) -> tuple[Any, ...]:
    """Work arrays for a graph of ``size`` nodes: the ring, its filled buckets, the bits, where levels begin."""
    levels = [0]
    words = size
    while words > 1:
        words = (words + 31) >> 5
        levels.append(levels[-1] + words)
    bits = np.zeros(levels[-1], np.uint32)
    return np.full(BUCKETS, -1, np.int32), np.zeros(BUCKETS // 32, np.int64), bits, np.array(levels[:-1]), _LOWEST_BIT


def bucket_search(
    clear: Any, middle: Any, goal: Any, stride: Any, steps: Any, sources: Any, goals: Any, toward: Any,
    cost: Any, far: Any, came: Any, left: Any, first: Any, filled: Any, bits: Any, begins: Any, lowest_bit: Any,
) -> Any:  # fmt: skip
    """A* over the eight neighbours, from sources that lie within three steps of each other.

    Args:
        clear: (n,) uint8, 1 where the disc is clear; none on the rim of the grid.
        middle: (n,) uint8, likewise half a step right of and above each node.
        goal: (n,) uint8, 1 where the search stops, 2 where it would be content.
        stride: Nodes a row.
        steps: (8, 4) what each step adds to a number, four along the axes first; where a diagonal one has its middle;
            how far it leads across and up.
        sources: (m,) rising numbers of clear nodes.
        goals: (2,) the least and the largest number with a goal.
        toward: (2,) node that the search leans to.
        cost: (n,) signed, to be filled; negative once a node is done with.
        far: More than any path costs, and no more than ``cost`` can hold.
        came: (n,) uint8 zeros; gets the step (1 to 8) by which a node is reached.
        left: (1,) nodes that may be expanded; -1 comes back if there were more to expand, and then no path.
        first: (BUCKETS,) int32, all -1; this and the rest from :func:`room_for_search`.
        filled: (BUCKETS / 32,) zeros; a bit for each bucket.
        bits: (words,) uint32 zeros; a bit for each node of the present estimate, then one for each word, and so on.
        begins: (levels,) where in ``bits`` each level begins.
        lowest_bit: (32,) number of a power of two's bit.

    Returns:
        (k,) nodes from a source to the end or cheapest spare end, without those in the middle of a straight line; none
        if there is neither.
    """
    for i in range(len(clear)):
        cost[i] = far if clear[i] != 0 else -1
    waiting_node, waiting_next = np.empty(1024, np.int32), np.empty(1024, np.int32)
    waiting, used, unused, depth = 0, 0, -1, len(begins)
    top = begins[depth - 1]
    level, lowest, end = -1, far, -1  # level -1: the sources, by number
    for i in range(len(sources)):
        cost[sources[i]] = 0
        set_bit(bits, begins, sources[i])
    while True:
        if bits[top] == 0:
            if waiting == 0:
                break
            level = lowest if level < 0 else level
            word = filled[(level & RING) >> 5] >> (level & 31)
            while word == 0:
                level = (level | 31) + 1
                word = filled[(level & RING) >> 5]
            level += lowest_bit[((word & -word) * 0x077CB531 & 0xFFFFFFFF) >> 27]
        if level >= 0:
            entry = first[level & RING]
            while entry >= 0:
                node, after = waiting_node[entry], waiting_next[entry]
                waiting_next[entry] = unused
                unused, entry = entry, after
                waiting -= 1
                if cost[node] >= 0:
                    at = np.int64(node)
                    for rung in range(depth):
                        word = np.int64(bits[begins[rung] + (at >> 5)])
                        bits[begins[rung] + (at >> 5)] = word | (1 << (at & 31))
                        if word != 0:
                            break
                        at >>= 5
            first[level & RING] = -1
            filled[(level & RING) >> 5] &= ~(1 << (level & 31))
            if bits[top] == 0:
                continue
        node = 0
        for rung in range(depth - 1, -1, -1):
            word = np.int64(bits[begins[rung] + node])
            node = (node << 5) + lowest_bit[((word & -word) * 0x077CB531 & 0xFFFFFFFF) >> 27]
        at = node
        for rung in range(depth):
            word = np.int64(bits[begins[rung] + (at >> 5)]) & ~(1 << (at & 31))
            bits[begins[rung] + (at >> 5)] = word
            if word != 0:
                break
            at >>= 5
        if goals[0] <= node <= goals[1] and (goal[node] == 1 or (goal[node] == 2 and end < 0)):
            end = node
            if goal[node] == 1:
                break
        left[0] -= 1
        if left[0] < 0:
            return np.empty(0, np.int64)
        here, x, y = cost[node], node % stride - toward[0], node // stride - toward[1]
        cost[node] = -1 - here
        for direction in range(8):
            other = node + steps[direction, 0]
            onward = here + (70 if direction < 4 else 99)
            if onward >= cost[other] or (direction > 3 and middle[node + steps[direction, 1]] == 0):
                continue
            cost[other] = onward
            came[other] = direction + 1
            dx, dy = abs(x + steps[direction, 2]), abs(y + steps[direction, 3])
            estimate = onward + (70 * dx + 29 * dy if dx > dy else 70 * dy + 29 * dx)
            lowest = min(lowest, estimate)
            if unused < 0:
                if used == len(waiting_node):
                    nodes, nexts = np.empty(2 * used, np.int32), np.empty(2 * used, np.int32)
                    for i in range(used):  # a slice would bring its error messages, and 3 s of compiling them
                        nodes[i], nexts[i] = waiting_node[i], waiting_next[i]
                    waiting_node, waiting_next = nodes, nexts
                entry = used
                used += 1
            else:
                entry = unused
                unused = waiting_next[entry]
            waiting_node[entry], waiting_next[entry] = other, first[estimate & RING]
            first[estimate & RING] = entry
            filled[(estimate & RING) >> 5] |= 1 << (estimate & 31)
            waiting += 1
    way = np.empty(corners_of_way(end, came, steps), np.int64)
    follow_way(end, came, steps, way)
    return way


def set_bit(bits: Any, begins: Any, node: Any) -> None:
    """Adds a node to those of the present estimate."""
    for rung in range(len(begins)):
        at = begins[rung] + (node >> 5)
        word = np.int64(bits[at])
        bits[at] = word | (1 << (node & 31))
        if word != 0:
            break
        node >>= 5


def corners_of_way(end: Any, came: Any, steps: Any) -> Any:
    """Number of nodes by which ``end`` was reached, without those in the middle of a straight line; 0 for -1."""
    if end < 0:
        return 0
    count, step = 1, came[end]
    while step > 0:
        end -= steps[step - 1, 0]
        count += came[end] != step
        step = came[end]
    return count


def follow_way(end: Any, came: Any, steps: Any, way: Any) -> None:
    """Fills in these nodes."""
    at, step = len(way) - 1, 0
    while at >= 0:
        if came[end] != step or step == 0:
            way[at] = end
            at -= 1
        step = came[end]
        if step > 0:
            end -= steps[step - 1, 0]


bucket_search_compiled = lazy_kernel(bucket_search, set_bit, corners_of_way, follow_way)
