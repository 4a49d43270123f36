"""Lay out serpentines, T junctions and crossings, and put narrow places into any corridor."""

from __future__ import annotations

from itertools import pairwise
from typing import TypeAlias

import numpy as np

from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools

# Column and row of a coarse lattice, each line of which has room for one corridor.
Node: TypeAlias = tuple[int, int]
Edge: TypeAlias = tuple[Node, Node]
# Axis along the corridor, first cell along it, first cell across.
Slot: TypeAlias = tuple[int, int, int]


def serpentine(bends: int) -> tuple[list[Node], list[Edge]]:
    """Return a path that zigzags over two columns, and no side corridors.

    The turns alternate in pairs: two to the left, then two to the right.

    Args:
        bends: Number of bends.
    """
    sides = (0, 1, 1, 0)
    return [(sides[k % 4], k // 2) for k in range(bends + 2)], []


def tees(count: int) -> tuple[list[Node], list[Edge]]:
    """Return a path through T junctions, and their blind arms.

    The path enters each junction by the stem and leaves by one arm, or, if it is reversed, enters
    by an arm and leaves by the stem.

    Args:
        count: Number of junctions.
    """
    way: list[Node] = [(0, 0)]
    blind: list[Edge] = []
    for k in range(count + 1):
        x, y = way[-1]
        ahead = (1, 0) if k % 2 == 0 else (0, 1)
        way += [(x + ahead[0], y + ahead[1]), (x + 2 * ahead[0], y + 2 * ahead[1])]
        if k < count:
            x, y = way[-1]
            blind.append(((x, y), (x - ahead[1], y - ahead[0])))
    return way, blind


def crossings(count: int) -> tuple[list[Node], list[Edge]]:
    """Return a path through a grid of corridors that cross, and the grid's edges.

    All corridors are blind at their ends. The path leads from one end to a far one.

    Args:
        count: Number of corridors in each direction.
    """
    streets = range(1, count + 1)
    edges = [
        edge
        for k in streets
        for x in range(count + 1)
        for edge in (((x, k), (x + 1, k)), ((k, x), (k, x + 1)))
    ]
    way = [(x, 1) for x in range(count + 1)] + [(count, y) for y in range(2, count + 2)]
    return way, edges


def turned_at_random(
    rng: RandomStream, way: list[Node], edges: list[Edge]
) -> tuple[list[Node], list[Edge]]:
    """Apply one of a square's eight symmetries, and perhaps reverse the path."""
    flip_x, flip_y, swap = (1 - 2 * rng.below(2) for _ in range(3))

    def moved(node: Node) -> Node:
        x = flip_x * node[0]
        y = flip_y * node[1]
        return (x, y) if swap > 0 else (y, x)

    way = [moved(node) for node in way]
    return way[::-1] if rng.below(2) else way, [
        (moved(here), moved(there)) for here, there in edges
    ]


def neck_slots(
    way: list[Node],
    corners: set[Node],
    columns: dict[int, int],
    rows: dict[int, int],
    width: int,
    length: int,
) -> list[Slot]:
    """Return the slots for narrow places: on straight runs, a corridor's width apart.

    Args:
        way: The corridor from start to target.
        corners: Nodes at which any corridor ends, turns or branches.
        columns: First cell of each line in x.
        rows: First cell of each line in y.
        width: Width of the corridor, cells.
        length: Length of a narrow place along the corridor, cells.
    """
    stops = [node for k, node in enumerate(way) if node in corners or k in (0, len(way) - 1)]
    slots: list[Slot] = []
    for here, there in pairwise(stops):
        (ax, ay), (bx, by) = ((columns[node[0]], rows[node[1]]) for node in (here, there))
        axis = int(ax == bx)
        low, high = sorted((ax, bx) if axis == 0 else (ay, by))
        first = low + width
        room = high - low - width
        count = (room + width) // (length + width)
        shift = (room + width - count * (length + width)) // 2
        slots += [
            (axis, first + shift + k * (length + width), (ay, ax)[axis]) for k in range(count)
        ]
    return slots


def place_necks(
    rng: RandomStream, walls: Bools, slots: list[Slot], width: int, length: int, neck: int
) -> None:
    """Narrow the corridor to ``neck`` cells at each slot, in place, at a random side position."""
    for axis, along, across in slots:
        block = np.ones((width, length), dtype=np.bool_)
        at = rng.between(0, width - neck)
        block[at : at + neck] = False
        if axis == 0:
            walls[across : across + width, along : along + length] = block
        else:
            walls[along : along + length, across : across + width] = block.T
