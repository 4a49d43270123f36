"""Measures that describe what is around a path, and none of which predicts failure well.

BARN's authors describe a world by averages along a path; ``docs/notes/difficulty.md`` lists the
differences from their program. ``decisions`` counts places from which three or more routes lead.
Everything is plain NumPy and Python, for worlds of some thousand cells.

Source: Perille, Truong, Xiao, Stone, "Benchmarking Metric Ground Navigation", 2020.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.difficulty.nodes import Nodes, nodes_of
from worldgen.difficulty.path import WitnessPath, witness_path_of
from worldgen.lattice import UNIT
from worldgen.world import Witness, World

Floats = npt.NDArray[np.float64]

# By name, the unit.
AROUND: Final = {
    "wall_distance": "m",
    "visibility": "m",
    "dispersion": "",
    "characteristic_dimension": "m",
    "decisions": "",
}
# Maximum number of cells between two samples.
_APART = 0.5
# Cells along the longer axis within which walls count for the dispersion: the authors' radius.
_REACH = 3
# Sixteen directions, counter-clockwise; every second one is along an axis or a diagonal.
_DIRECTIONS = (
    (1, 0), (2, 1), (1, 1), (1, 2), (0, 1), (-1, 2), (-1, 1), (-2, 1),
    (-1, 0), (-2, -1), (-1, -1), (-1, -2), (0, -1), (1, -2), (1, -1), (2, -1),
)  # fmt: skip
_ROOT_2 = math.sqrt(2.0)


class Samples(NamedTuple):
    """Places along a path, cells: the middles of equal parts of each piece, and their lengths."""

    x: Floats
    y: Floats
    weight: Floats


def around(world: World) -> dict[str, float]:
    """Return the measures along a world's witness, in m; empty if it has none."""
    witness = world.certificate
    if not isinstance(witness, Witness) or not len(witness.times):
        return {}
    samples = samples_of(witness_path_of(world, witness))
    found = surroundings(world.walls, samples)
    lengths = {name: found[name] * world.cell_size for name in found if AROUND[name] == "m"}
    nodes = nodes_of(world, world.walls)
    return {**found, **lengths, "decisions": len(decision_points(nodes, samples))}


def samples_of(way: WitnessPath) -> Samples:
    """Return samples at most half a cell apart; a path of no length has its point as the only one."""
    if len(way.x) == 1:
        return Samples(way.x / UNIT, way.y / UNIT, np.ones(1))
    lengths = np.array(way.pieces) / UNIT
    parts = 2 ** np.ceil(np.log2(np.maximum(lengths / _APART, 1.0))).astype(np.int64)
    piece = np.repeat(np.arange(len(parts)), parts)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = (2 * number + 1) / (2 * parts[piece])
    x, y = ((v[:-1][piece] + np.diff(v)[piece] * share) / UNIT for v in (way.x, way.y))
    return Samples(x, y, lengths[piece] / parts[piece])


def surroundings(solid: npt.NDArray[np.bool_], samples: Samples) -> dict[str, float]:
    """Return BARN's averages along the path, weighted by length, in cells."""
    rows, columns = solid.shape
    iy, ix = np.nonzero(solid)
    values: list[tuple[float, ...]] = []
    for x, y in zip(samples.x.tolist(), samples.y.tolist(), strict=True):
        dx = np.maximum(np.maximum(ix - x, x - ix - 1), 0.0)
        dy = np.maximum(np.maximum(iy - y, y - iy - 1), 0.0)
        cells = float(np.hypot(dx, dy).min(initial=np.inf))
        near = min(cells, x, y, columns - x, rows - y)
        far = [_ray(solid, x, y, dx, dy) for dx, dy in _DIRECTIONS]
        straight = far[0::4]
        slanted = [_ROOT_2 * length for length in far[2::4]]
        seen = (sum(straight) + sum(slanted)) / 8.0
        narrow = min(side[k] + side[k + 2] for side in (straight, slanted) for k in (0, 1))
        walled = [
            length * max(abs(dx), abs(dy)) <= _REACH
            for length, (dx, dy) in zip(far, _DIRECTIONS, strict=True)
        ]
        changes = sum(walled[k] != walled[k - 1] for k in range(len(walled)))
        values.append((near, seen, float(changes), narrow))
    means = np.average(np.array(values), axis=0, weights=samples.weight)
    return dict(zip(list(AROUND)[:4], means.tolist(), strict=True))


def _ray(solid: npt.NDArray[np.bool_], x: float, y: float, dx: int, dy: int) -> float:
    """Return the steps of a direction before a ray touches a solid cell; cells are closed.

    Directions between axes and diagonals are only followed for ``_REACH`` cells.
    """
    # Mirror the world so that the ray leads to the upper right.
    rows, columns = solid.shape
    grid = solid[:: -1 if dy < 0 else 1, :: -1 if dx < 0 else 1]
    px = columns - x if dx < 0 else x
    py = rows - y if dy < 0 else y
    a = abs(dx)
    b = abs(dy)
    i = math.floor(px)
    j = math.floor(py)
    most = _REACH / max(a, b) if a + b > 2 else math.inf

    def meets(column: int, row: int) -> bool:
        inside = 0 <= column < columns and 0 <= row < rows
        return not inside or bool(grid[row, column])

    # The point itself may touch a wall.
    on_x = i == px
    on_y = j == py
    if any(meets(i - left, j - low) for left in range(1 + on_x) for low in range(1 + on_y)):
        return 0.0
    while True:
        # Go to the next line between columns or rows, or to the corner where both meet.
        tx = (i + 1 - px) / a if a else math.inf
        ty = (j + 1 - py) / b if b else math.inf
        right = tx <= ty
        up = ty <= tx
        touched = (
            (right and meets(i + 1, j))
            or (up and meets(i, j + 1))
            or (right and up and meets(i + 1, j + 1))
            or (up and on_x and not a and meets(i - 1, j + 1))
            or (right and on_y and not b and meets(i + 1, j - 1))
        )
        if touched:
            return min(tx, ty)
        if min(tx, ty) > most:
            return math.inf
        i += right
        j += up


def decision_points(nodes: Nodes, samples: Samples) -> list[tuple[int, int, int]]:
    """Return the decision points along a path, each once.

    A *place* is a node with a locally largest free disc that is in no larger disc of another place.
    A *decision point* is a place from which three or more routes lead and whose disc the path
    enters; places in each other's discs count as one. A row has column, row and squared radius of
    the disc, in half cells.
    """
    # Find the distance from each node to the path.
    rows, columns = np.indices(nodes.graph.clear.shape)
    away = np.full(rows.shape, np.inf)
    corners = {
        (side_x(2 * x), side_y(2 * y))
        for x, y in zip(samples.x.tolist(), samples.y.tolist(), strict=True)
        for side_x in (math.floor, math.ceil)
        for side_y in (math.floor, math.ceil)
    }
    for i, j in corners:
        away = np.minimum(away, (columns - i) ** 2 + (rows - j) ** 2)

    # Find the places, and keep those that the path enters and that are in no larger disc.
    squared = nodes.clearance_sq
    padded = np.pad(squared, 1)
    largest = nodes.graph.clear.copy()
    for di, dj in itertools.product((0, 1, 2), repeat=2):
        largest &= padded[dj : dj + squared.shape[0], di : di + squared.shape[1]] <= squared
    places = [(int(i), int(j), int(squared[j, i])) for j, i in np.argwhere(largest)]
    chosen = [
        (i, j, size)
        for i, j, size in places
        if away[j, i] <= size
        and not any(other > size and (x - i) ** 2 + (y - j) ** 2 <= other for x, y, other in places)
        and _routes(nodes, i, j, size) >= 3
    ]
    return sorted(max(group, key=lambda spot: spot[2]) for group in _groups(chosen))


def _routes(nodes: Nodes, column: int, row: int, size: int) -> int:
    """Return how many parts of a place's ring reach its outer circle.

    The ring has the nodes from 1.5 to a little over 2 radii of the disc away that the robot can
    reach from the place within the outer circle.
    """
    outer = math.isqrt(4 * size) + 2

    def apart(node: tuple[int, int]) -> int:
        return (node[0] - column) ** 2 + (node[1] - row) ** 2

    inside = _flood(nodes, (column, row), lambda node: apart(node) <= outer * outer)
    ring = {node for node in inside if 4 * apart(node) >= 9 * size}
    count = 0
    while ring:
        part = _flood(nodes, next(iter(ring)), ring.__contains__)
        ring -= part
        count += any(apart(node) >= 4 * size for node in part)
    return count


def _flood(nodes: Nodes, begin: tuple[int, int], allowed: object) -> set[tuple[int, int]]:
    """Return the nodes that the robot can reach from one without leaving the allowed ones."""
    found = {begin}
    waiting = [begin]
    while waiting:
        node = waiting.pop()
        for other in _neighbours(nodes, node):
            if other not in found and allowed(other):  # type: ignore[operator]
                found.add(other)
                waiting.append(other)
    return found


def _neighbours(nodes: Nodes, node: tuple[int, int]) -> Iterator[tuple[int, int]]:
    i, j = node
    clear = nodes.graph.clear
    for di, dj in itertools.product((-1, 0, 1), repeat=2):
        # A slanted step leads through the middle of four nodes.
        if (di or dj) and clear[j + dj, i + di]:
            if di and dj and not nodes.graph.middle[min(j, j + dj), min(i, i + di)]:
                continue
            yield i + di, j + dj


def _groups(spots: list[tuple[int, int, int]]) -> Iterator[list[tuple[int, int, int]]]:
    """Yield the places, grouped if they are in each other's discs."""
    left = set(spots)
    while left:
        group = [left.pop()]
        for x, y, size in group:
            same = {
                (i, j, other)
                for i, j, other in left
                if (i - x) ** 2 + (j - y) ** 2 <= min(size, other)
            }
            left -= same
            group += sorted(same)
        yield sorted(group)
