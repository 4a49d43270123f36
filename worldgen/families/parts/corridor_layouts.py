"""Corridors with a plan: serpentines, T junctions, crossings; and narrow places in any corridor."""

from __future__ import annotations

from itertools import pairwise
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.random_streams import RandomStream

__all__ = [
    "Edge",
    "Node",
    "Slot",
    "crossings",
    "neck_slots",
    "place_necks",
    "serpentine",
    "tees",
    "turned_at_random",
]

Node: TypeAlias = tuple[
    int, int
]  # column and row of a coarse lattice whose lines can hold a corridor each
Edge: TypeAlias = tuple[Node, Node]
Slot: TypeAlias = tuple[
    int, int, int
]  # axis along the corridor, first cell along it, first cell across


def serpentine(bends: int) -> tuple[list[Node], list[Edge]]:
    """A way to and fro over two columns, with so many bends, all to the same side two by two."""
    sides = (0, 1, 1, 0)
    return [(sides[k % 4], k // 2) for k in range(bends + 2)], []


def tees(count: int) -> tuple[list[Node], list[Edge]]:
    """A way through so many T junctions: in by the stem, out by one arm, the other blind.

    Or the other way round.
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
    """So many corridors across as many others, all blind at their ends.

    A way from one end to a far one.
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
    """Way and edges mirrored and turned by one of the eight symmetries, the way from either end."""
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
    """Where narrow places can be: on straight runs of the way, a corridor's width from one to the next.

    Args:
        way: The corridor from start to target.
        corners: Nodes at which anything ends, turns or branches.
        columns: First cell of each line in x.
        rows: First cell of each line in y.
        width: Of the corridor, cells.
        length: Of a narrow place, along the corridor, cells.
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
    rng: RandomStream,
    walls: npt.NDArray[np.bool_],
    slots: list[Slot],
    width: int,
    length: int,
    neck: int,
) -> None:
    """Narrows the corridor to ``neck`` cells at each slot, in place; where across, is drawn."""
    for axis, along, across in slots:
        block = np.ones((width, length), dtype=np.bool_)
        at = rng.between(0, width - neck)
        block[at : at + neck] = False
        if axis == 0:
            walls[across : across + width, along : along + length] = block
        else:
            walls[along : along + length, across : across + width] = block.T
