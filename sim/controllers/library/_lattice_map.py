"""Read the map that mapping controllers keep in their memory.

``sim/core/controllers/shared/lattice_map.c`` writes it, with several entries packed into each number.
"""

from __future__ import annotations

import math

import numpy as np

from sim.controllers.core_act import place, size_of
from worldgen.support.arrays import Floats

__all__ = ["NODES", "SHOWN", "blocked_edges", "memory_size", "neighbour", "planned_moves"]


SIDE = place("WgMapperMemory", "side")
WINDOW_X = place("WgMapperMemory", "window_x")
WINDOW_Y = place("WgMapperMemory", "window_y")
TARGET_X = place("WgMapperMemory", "target_x")
TARGET_Y = place("WgMapperMemory", "target_y")
DOORS = place("WgMapperMemory", "doors")
PLAN_AT = place("WgMapperMemory", "plan_at")
PLAN_LENGTH = place("WgMapperMemory", "plan_length")
PLAN = place("WgMapperMemory", "plan")
# The controller's own numbers begin here.
OWN = place("WgMapperMemory", "mode")

# The nodes' bits begin here, and extend to the end of the memory.
NODES = size_of("WgMapperMemory")

# Moves per number, at 3 bits each.
_MOVES_A_WORD = 16

# Nodes per number, at 4 bits each.
_NODES_A_WORD = 12

# Nodes at most this far from the target along each axis have an edge to it.
_REACH = 2

SHOWN = (DOORS, *range(PLAN_LENGTH, OWN))
"""Indices of the other numbers that the blocked edges and the plan depend on."""


def memory_size(side: int) -> int:
    """Return the number of memory entries that a map takes, given the nodes along one side."""
    return NODES + -(-side * side // _NODES_A_WORD)


def neighbour(x: int, y: int, move: int) -> tuple[int, int]:
    """Return the node that a move leads to.

    Moves are numbered counter-clockwise by eighths of a turn; 0 is east.
    """
    dx = 1 if move in (0, 1, 7) else (-1 if move in (3, 4, 5) else 0)
    dy = 1 if move in (1, 2, 3) else (-1 if move in (5, 6, 7) else 0)
    return x + dx, y + dy


def blocked_edges(memory: Floats) -> Floats:
    """Return the edges that are blocked on the map: (n, 4), x and y of the nodes at both ends.

    A blocked door is an edge that ends at the target.
    """
    # Unpack the four bits of each node, one for each direction in which an edge leaves it.
    side = int(memory[SIDE])
    words = memory[NODES:].astype(np.int64)
    bits = (
        ((words[:, None] >> (4 * np.arange(_NODES_A_WORD))) & 15)
        .ravel()[: side * side]
        .reshape(side, side)
    )

    # The map is a ring in both directions, so that the window can move without copying.
    low_x = int(memory[WINDOW_X])
    low_y = int(memory[WINDOW_Y])
    found = []
    for move in range(4):
        row, column = np.nonzero((bits >> move) & 1)
        x = low_x + (column - low_x) % side
        y = low_y + (row - low_y) % side
        dx, dy = neighbour(0, 0, move)
        found.append(np.column_stack((x, y, x + dx, y + dy)).astype(np.float64))

    # Doors are the edges between the target and the nodes around it.
    for number in range(4 * _REACH * _REACH):
        if (int(memory[DOORS]) >> number) & 1:
            up, along = divmod(number, 2 * _REACH)
            node_x, node_y = (math.floor(memory[TARGET_X + k]) - _REACH + 1 for k in range(2))
            found.append(
                np.array([[node_x + along, node_y + up, memory[TARGET_X], memory[TARGET_Y]]])
            )
    return np.concatenate(found)


def planned_moves(memory: Floats) -> list[int]:
    """Return all moves of the plan, including those already done."""
    count = int(memory[PLAN_LENGTH])
    return [
        (int(memory[PLAN + k // _MOVES_A_WORD]) >> (3 * (k % _MOVES_A_WORD))) & 7
        for k in range(count)
    ]
