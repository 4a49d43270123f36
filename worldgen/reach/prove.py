"""Decides whether the disc can get from the start to the target, with a proof either way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from worldgen.lattice import UNIT, exact, in_cells, metres_to_lattice
from worldgen.reach.decision import BLOCKED, REACHABLE, UNDECIDED, Decision
from worldgen.reach.lattice_graph import Graph, build_graph, find_path
from worldgen.reach.path import make_witness, shorten
from worldgen.reach.walls import Cell, Point, Walls
from worldgen.world import Cut, World

__all__ = ["decide"]


@dataclass(frozen=True)
class _Question:
    world: World
    walls: Walls
    start: Point
    target: Point


def decide(world: World, *, radius: float | None = None) -> Decision:
    """Whether a disc can get from the start to the target.

    Args:
        world: The world; its own certificate is not looked at.
        radius: Radius of the disc, m; the robot's where left out.
    """
    radius = world.robot_radius if radius is None else radius
    walls = Walls(world.walls, in_cells(radius, world.cell_size))
    start, target = (
        (metres_to_lattice(point.x, world.cell_size), metres_to_lattice(point.y, world.cell_size))
        for point in (world.start, world.target)
    )
    question = _Question(world, walls, start, target)
    blocker = walls.blocker(start, start)
    if blocker is not None:
        return Decision(BLOCKED, None, f"the start is nearer than the radius to cell {blocker}")
    for k in (2, 4, 8):
        path = _find(question, build_graph(world.walls, walls.radius, k))
        if path:
            witness = make_witness(
                walls, shorten(walls, path), (world.start.x, world.start.y), world.cell_size, world.robot_speed
            )
            return Decision(REACHABLE, witness, f"a path of {witness.length:.3g} m")
    return Decision(UNDECIDED, None, "no path found")


def _links(walls: Walls, graph: Graph, point: Point) -> list[int]:
    """Clear nodes near a point to which the disc may go straight."""
    unit = UNIT // graph.k
    x, y = point
    if x % unit == 0 and y % unit == 0:
        columns, rows = range(x // unit, x // unit + 1), range(y // unit, y // unit + 1)
    else:
        columns, rows = range(x // unit - 1, x // unit + 3), range(y // unit - 1, y // unit + 3)
    nodes = []
    for j in rows:
        for i in columns:
            inside = 0 <= i < graph.clear.shape[1] and 0 <= j < graph.clear.shape[0]
            if inside and graph.clear[j, i] and walls.is_clear(point, (i * unit, j * unit)):
                nodes.append(j * graph.stride + i)
    return nodes


def _spare_ends(world: World, graph: Graph) -> list[int]:
    """Clear nodes in the target's disc."""
    k = graph.k
    x, y, rho = (k * in_cells(value, world.cell_size) for value in (world.target.x, world.target.y, world.target.radius))
    rows, columns = graph.clear.shape
    nodes = []
    for j in range(max(0, math.ceil(y - rho)), min(rows - 1, math.floor(y + rho)) + 1):
        for i in range(max(0, math.ceil(x - rho)), min(columns - 1, math.floor(x + rho)) + 1):
            if graph.clear[j, i] and (i - x) ** 2 + (j - y) ** 2 <= rho * rho:
                nodes.append(j * graph.stride + i)
    return nodes


def _find(question: _Question, graph: Graph) -> list[Point]:
    unit = UNIT // graph.k
    sources = _links(question.walls, graph, question.start)
    if not sources:
        return []
    ends = _links(question.walls, graph, question.target) if question.walls.is_clear(question.target, question.target) else []
    toward = (round(question.target[0] / unit), round(question.target[1] / unit))
    nodes = find_path(graph, sources, ends, _spare_ends(question.world, graph), toward)
    if not nodes:
        return []
    points = [(node % graph.stride * unit, node // graph.stride * unit) for node in nodes]
    points.insert(0, question.start)
    if nodes[-1] in ends:
        points.append(question.target)
    return points
