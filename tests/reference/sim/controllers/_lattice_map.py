"""A small map: a square window of the plane in nodes of a grid, with a bit per blocked edge.

A node has eight neighbours, and four bits: its edges to the east, north-east, north and north-west;
the others are its neighbours'. Twelve nodes are packed into one number of a controller's memory.
The window moves with the robot, and nodes outside it are forgotten. The path is planned with A*,
treating every edge as free that is not known to be blocked.

Sources: P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic determination
    of minimum cost
paths", IEEE Transactions on Systems Science and Cybernetics 4 (1968); for planning as if the
unknown were free, A. Zelinsky, "A mobile robot exploration algorithm", IEEE Transactions on
Robotics and Automation 8 (1992).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim.controllers._directions import distance_to_way

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Layout of the memory; places are in nodes from the start.
SIDE, WINDOW_X, WINDOW_Y = 0, 1, 2  # nodes of the window along a side; its lowest node
TARGET_X, TARGET_Y = 3, 4  # the target's place, not rounded
DOORS = 5  # bits of the nodes next to the target from which the path to it was found blocked
PLAN_AT, PLAN_LENGTH = 6, 7  # finished moves, and all moves of the plan
PLAN = 8
OWN = PLAN + 64  # numbers of the controller's own
OWN_SIZE = 12
NODES = OWN + OWN_SIZE  # the bits of the nodes begin here

_MOVES_A_WORD, _NODES_A_WORD = 16, 12  # 3 and 4 bits each: 48 bits, which a float64 holds exactly
SHOWN = (DOORS, *range(PLAN_LENGTH, OWN))
"""Numbers, besides those of the nodes, on which blocked edges and plan depend."""
_MOST_MOVES = _MOVES_A_WORD * (OWN - PLAN)
_STRAIGHT, _DIAGONAL = 5, 7  # costs of a move, nearly in the ratio of 1 to the root of 2
_REACH = 2  # nodes at most this far from the target, along each axis, are next to it
_UNKNOWN = 1 << 40


def memory_size(side: int) -> int:
    """Size of the memory, in numbers, of a map with this many nodes along a side."""
    return NODES + -(-side * side // _NODES_A_WORD)


def neighbour(x: int, y: int, move: int) -> tuple[int, int]:
    """The node that a move leads to: 0 is east, then counter-clockwise by eighths of a turn."""
    dx = 1 if move in (0, 1, 7) else (-1 if move in (3, 4, 5) else 0)
    dy = 1 if move in (1, 2, 3) else (-1 if move in (5, 6, 7) else 0)
    return x + dx, y + dy


def _bit(memory: Floats, x: int, y: int, move: int) -> tuple[int, int]:
    """Word of the memory and bit in it of an edge."""
    if move >= 4:
        x, y = neighbour(x, y, move)
        move -= 4
    side = int(memory[SIDE])
    node = (y % side) * side + x % side
    return NODES + node // _NODES_A_WORD, 4 * (node % _NODES_A_WORD) + move


def _is_blocked(memory: Floats, x: int, y: int, move: int) -> bool:
    word, bit = _bit(memory, x, y, move)
    return (int(memory[word]) >> bit) & 1 != 0


def block(memory: Floats, x: int, y: int, move: int) -> None:
    """Notes that the edge of a move from a node is blocked; the plan is dropped."""
    word, bit = _bit(memory, x, y, move)
    memory[word] = float(int(memory[word]) | (1 << bit))
    memory[PLAN_LENGTH] = 0.0


def block_near(memory: Floats, x: float, y: float, radius: float) -> None:
    """Notes that all edges that come nearer to a point than a radius are blocked; both in nodes."""
    reach = math.floor(radius) + 2
    low_x = int(memory[WINDOW_X])
    low_y = int(memory[WINDOW_Y])
    side = int(memory[SIDE])
    for j in range(
        max(math.floor(y) - reach, low_y + 1), min(math.floor(y) + reach + 1, low_y + side - 2) + 1
    ):
        for i in range(
            max(math.floor(x) - reach, low_x + 1),
            min(math.floor(x) + reach + 1, low_x + side - 2) + 1,
        ):
            for move in range(4):
                to_x, to_y = neighbour(i, j, move)
                if distance_to_way(x, y, float(i), float(j), float(to_x), float(to_y)) < radius:
                    word, bit = _bit(memory, i, j, move)
                    memory[word] = float(int(memory[word]) | (1 << bit))
    memory[PLAN_LENGTH] = 0.0


def _door(memory: Floats, x: int, y: int) -> int:
    """Number of a node among those next to the target; -1 for another."""
    i = x - math.floor(memory[TARGET_X]) + _REACH - 1
    j = y - math.floor(memory[TARGET_Y]) + _REACH - 1
    return int(j * 2 * _REACH + i) if 0 <= i < 2 * _REACH and 0 <= j < 2 * _REACH else -1


def has_door(memory: Floats, x: int, y: int) -> bool:
    """Return whether a node is next to the target, on a path that is not known to be blocked."""
    number = _door(memory, x, y)
    return number >= 0 and (int(memory[DOORS]) >> number) & 1 == 0


def door(memory: Floats, x: int, y: int) -> None:
    """Notes that the path from a node to the target is blocked."""
    memory[DOORS] = float(int(memory[DOORS]) | (1 << max(_door(memory, x, y), 0)))
    memory[PLAN_LENGTH] = 0.0


def forget(memory: Floats) -> None:
    """Empties the map."""
    for word in range(NODES, memory.size):
        memory[word] = 0.0
    memory[DOORS], memory[PLAN_LENGTH] = 0.0, 0.0


def _forget_line(memory: Floats, place: int, column: bool) -> None:
    """Forgets the nodes of a column or a row."""
    side = int(memory[SIDE])
    for k in range(side):
        x, y = (place, k) if column else (k, place)
        for move in range(4):
            word, bit = _bit(memory, x, y, move)
            memory[word] = float(int(memory[word]) & ~(1 << bit))


def move_window(memory: Floats, x: int, y: int) -> None:
    """Moves the window so that a node has a quarter of it on each side.

    Nodes outside it are forgotten.
    """
    side = int(memory[SIDE])
    for axis in range(2):
        place = x if axis == 0 else y
        while place < int(memory[WINDOW_X + axis]) + side // 4:
            memory[WINDOW_X + axis] -= 1.0
            _forget_line(memory, int(memory[WINDOW_X + axis]), axis == 0)
            memory[PLAN_LENGTH] = 0.0
        while place > int(memory[WINDOW_X + axis]) + side - 1 - side // 4:
            _forget_line(memory, int(memory[WINDOW_X + axis]), axis == 0)
            memory[WINDOW_X + axis] += 1.0
            memory[PLAN_LENGTH] = 0.0


def next_move(memory: Floats) -> int:
    """Takes the next move of the plan; -1 if there is none."""
    at = int(memory[PLAN_AT])
    if at >= int(memory[PLAN_LENGTH]):
        return -1
    memory[PLAN_AT] += 1.0
    return (int(memory[PLAN + at // _MOVES_A_WORD]) >> (3 * (at % _MOVES_A_WORD))) & 7


def _push(heap: Ints, count: int, item: int) -> int:
    """Adds an item to a binary heap; returns the new number of items."""
    at = count
    while at > 0 and heap[(at - 1) // 2] > item:
        heap[at] = heap[(at - 1) // 2]
        at = (at - 1) // 2
    heap[at] = item
    return count + 1


def _pop(heap: Ints, count: int) -> int:
    """Removes the smallest item, the first one, from a binary heap; returns the new number of
    items.
    """
    count -= 1
    item, at = heap[count], 0
    while 2 * at + 1 < count:
        child = 2 * at + 1
        if child + 1 < count and heap[child + 1] < heap[child]:
            child += 1
        if heap[child] >= item:
            break
        heap[at] = heap[child]
        at = child
    heap[at] = item
    return count


def _at_least(memory: Floats, x: int, y: int) -> int:
    """Lower bound on the cost of the path from a node to the target."""
    dx = abs(x - float(memory[TARGET_X]))
    dy = abs(y - float(memory[TARGET_Y]))
    return math.floor(_STRAIGHT * max(dx, dy) + (_DIAGONAL - _STRAIGHT) * min(dx, dy))


def _search(memory: Floats, start: tuple[int, int], cost: Ints, came: Ints, heap: Ints) -> int:
    """A* from a node; returns the window's number of the plan's last node, -1 without a path.

    A plan ends next to the target, or where it leaves the window, at the cost of the remaining path
    plus a penalty that makes it the last resort.
    """
    side = int(memory[SIDE])
    low_x = int(memory[WINDOW_X])
    low_y = int(memory[WINDOW_Y])
    first = (start[1] - low_y) * side + start[0] - low_x
    cost[first] = 0
    count = _push(heap, 0, (_at_least(memory, start[0], start[1]) << 32) | first)
    out, out_cost = -1, _UNKNOWN
    while count > 0:
        node = int(heap[0] & 0xFFFFFFFF)
        bound = int(heap[0] >> 32)
        count = _pop(heap, count)
        if bound >= out_cost:
            return out
        x = low_x + node % side
        y = low_y + node // side
        if bound > cost[node] + _at_least(memory, x, y):
            continue  # a better path to it has been found since
        if has_door(memory, x, y):
            return node
        if (node % side in (0, side - 1) or node // side in (0, side - 1)) and node != first:
            if bound + 2 * _DIAGONAL * side < out_cost:
                out, out_cost = node, bound + 2 * _DIAGONAL * side
            continue
        for move in range(8):
            to_x, to_y = neighbour(x, y, move)
            if _is_blocked(memory, x, y, move):
                continue
            there = (to_y - low_y) * side + to_x - low_x
            way = cost[node] + (_DIAGONAL if move % 2 else _STRAIGHT)
            if way < cost[there]:
                cost[there], came[there] = way, move
                count = _push(heap, count, ((way + _at_least(memory, to_x, to_y)) << 32) | there)
    return out


def plan(memory: Floats, x: int, y: int) -> bool:
    """Plans the path from a node.

    The window must contain it; the path leads to a node next to the target or out of the window.

    Returns:
        Whether there is a path, which may have no moves.
    """
    side = int(memory[SIDE])
    cost = np.full(side * side, _UNKNOWN)
    came = np.full(side * side, -1)
    heap = np.empty(8 * side * side + 1, np.int64)
    last = _search(memory, (x, y), cost, came, heap)
    memory[PLAN_AT], memory[PLAN_LENGTH] = 0.0, 0.0
    if last < 0:
        return False
    count = 0
    while came[last] >= 0:  # backwards; the heap is no longer needed and takes the moves
        heap[count] = came[last]
        step_x, step_y = neighbour(0, 0, came[last])
        last -= step_y * side + step_x
        count += 1
    memory[PLAN_LENGTH] = float(min(count, _MOST_MOVES))
    for k in range(int(memory[PLAN_LENGTH])):
        word = PLAN + k // _MOVES_A_WORD
        shift = 3 * (k % _MOVES_A_WORD)
        before = 0 if shift == 0 else int(memory[word])
        memory[word] = float(before | (heap[count - 1 - k] << shift))
    return True
