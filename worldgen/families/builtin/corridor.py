"""Cut corridors through solid rock: winding, with blind side paths, or with loops."""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise
from typing import Annotated, Literal, TypeAlias

import numpy as np

from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.families.parts.corridor_layouts import (
    Edge,
    Node,
    Slot,
    crossings,
    neck_slots,
    place_necks,
    serpentine,
    tees,
    turned_at_random,
)
from worldgen.families.parts.layout import (
    CHOSEN,
    STEPS,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Size,
    Wall,
    Width,
    spread_unevenly,
    without_effect,
)
from worldgen.families.parts.mazes import ROOT, winding_tree
from worldgen.family import Bounds, check_between, family
from worldgen.lattice import exact
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools
from worldgen.world import World

Shape: TypeAlias = Literal["bends", "dead-ends", "junctions", "S", "T", "X", "tunnel"]

# Lattices to try until one has the requested bends and side paths. With the largest allowed number
# of one or both, 20,000 drafts on 2 to 200 lines took 1.0 to 1.5 tries on average, and at most 4.
MAX_DRAFTS = 100
# Random side paths to try, per node from which one can start.
TRIES_PER_ORIGIN = 4
# Lattice steps of a side path if there is room. With two or more, others can branch off it.
BRANCH_STEPS = (2, 4)
# Limit on the lines of a tunnel's lattice: Python takes 2 s to find the longest path through this
# many.
MOST_TUNNEL = 400
MOST_WIDE = 1000.0  # widths of the robot
# With more bends or branches than these, drafts take a long time and often fail.
MOST_BENDS = 1000
MOST_BRANCHES = 500


@family("corridor", version=1)
def corridor(
    rng: RandomStream,
    *,
    size: Size = 30,
    shape: Shape = "bends",
    bends: Annotated[int, Bounds(0, MOST_BENDS, chosen=CHOSEN)] = CHOSEN,
    branches: Annotated[int, Bounds(0, MOST_BRANCHES, chosen=CHOSEN)] = CHOSEN,
    width: Width = CHOSEN,
    robot_widths: Annotated[float, Bounds(1.0, MOST_WIDE, "widths of the robot", chosen=0.0)] = 0.0,
    wall: Wall = 1,
    necks: Annotated[int, Bounds(0, MOST_BENDS, chosen=CHOSEN)] = 0,
    neck: Width = CHOSEN,
    neck_length: Annotated[int, Bounds(1, unit="cells")] = 1,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build a corridor through solid rock from the start at one end to the target at the other.

    Right angles and side corridors confuse a robot that reverses or turns by a fixed rule. The
    corridor is reachable by construction and spans the square.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        shape: bends: one winding corridor; dead-ends: with blind side corridors; junctions: with
            side corridors that lead back, so that there is more than one path; S: back and forth in
            long stretches; T: T junctions, one arm of each blind; X: corridors that cross; tunnel:
            one long path that fills the square.
        bends: Right angles of the corridor from start to target, not counting side corridors, for
            bends, dead-ends, junctions and S; if omitted, drawn.
        branches: Side corridors of dead-ends and junctions, off the corridor or off each other;
            number of junctions of T; corridors of X in each direction; if omitted, drawn.
        width: Width of the corridor, cells; if omitted, the narrowest that lets the robot through.
        robot_widths: The corridor's width in multiples of the robot's instead, at least 1, rounded
            up to whole cells; 0: use ``width``.
        necks: Narrow places on straight stretches from start to target; None (-1 on the command
            line): as many as fit.
        neck: Width of the narrow places, cells; if omitted, the narrowest that lets the robot
            through.
        neck_length: Their length along the corridor, cells; 1 makes a door.
        wall: Minimum thickness of the rock between two stretches, cells.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or the square has no room for that many bends
            or branches.
        GenerationFailed: If no draft of the corridor has that many bends and branches.

    Source: the corridor is a stretch of the longest path through a backtracker's maze.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    width = _width(arena, width, robot_widths)
    neck = _neck(arena, width, necks, neck, neck_length)
    lines = _lines(arena, width, wall)
    if shape in _PLANNED:
        way, side_edges = _planned(rng.child("plan"), shape, lines, bends, branches)
    else:
        way, side_edges = _wound(rng, shape, lines, bends, branches)
    edges = [*pairwise(way), *side_edges]
    columns, rows = (
        _place_lines(rng.child("lines", axis), edges, axis, arena.inside, width, wall)
        for axis in range(2)
    )

    centres = [_centre(node, columns, rows, width) for node in way]
    # Two nodes have the same centre if the line between them was dropped, so look for the first
    # node that is really elsewhere to find the initial heading.
    first = next(k for k, centre in enumerate(centres) if centre != centres[0])
    walls = _cut(arena.solid(), edges, columns, rows, width)
    if necks:
        slots = neck_slots(way, _corners(edges), columns, rows, width, neck_length)
        place_necks(
            rng.child("necks"), walls, _chosen_slots(rng, slots, necks), width, neck_length, neck
        )
    return arena.world(
        walls, start=centres[0], target=centres[-1], quarter=_direction(way[first - 1], way[first])
    )


_PLANNED: tuple[Shape, ...] = ("S", "T", "X", "tunnel")


def _width(arena: Arena, width: int, robot_widths: float) -> int:
    """Return the corridor's width in cells."""
    if robot_widths == 0.0:
        return arena.passage("width", width)
    without_effect("width", width, f"robot_widths={robot_widths:g}")
    return max(arena.narrowest, math.ceil(2 * arena.radius * exact(robot_widths)))


def _lines(arena: Arena, width: int, wall: int) -> int:
    """Return how many stretches of corridor fit side by side."""
    lines = (arena.inside + wall) // (width + wall)
    if lines < 2:
        raise InvalidParameter(
            "no-room",
            "width={width} and wall={wall} leave no room for two stretches side by side in "
            "size={size} cells",
            "use a size of at least {least}, or a narrower corridor",
            width=width,
            wall=wall,
            size=arena.size,
            least=2 * width + wall + 2,
        )
    return lines


def _neck(arena: Arena, width: int, necks: int, neck: int, neck_length: int) -> int:
    """Return the width of narrow places in cells."""
    check_between("neck_length", neck_length, 1, arena.inside, "cells")
    if necks == 0:
        return without_effect("neck", neck, "necks=0")
    neck = arena.passage("neck", neck)
    if neck >= width:
        raise InvalidParameter(
            "above-maximum",
            "neck={neck} is not narrower than the corridor, width={width}",
            "use a wider corridor, or omit necks",
            neck=neck,
            width=width,
        )
    return neck


def _chosen_slots(rng: RandomStream, slots: list[Slot], necks: int) -> list[Slot]:
    """Draw the requested number of slots, or return all of them.

    Raises:
        GenerationFailed: If there are fewer slots than requested.
    """
    if necks == CHOSEN:
        return slots
    if necks > len(slots):
        raise GenerationFailed(
            "no-room",
            "corridor: its straight stretches have room for {most} narrow places, not for "
            "necks={necks}",
            "use fewer or shorter ones, -1 for as many as fit, a larger size, or fewer bends",
            most=len(slots),
            necks=necks,
        )
    slots = list(slots)
    rng.child("slots").shuffle(slots)
    return slots[:necks]


def _wound(
    rng: RandomStream, shape: Shape, lines: int, bends: int, branches: int
) -> tuple[list[Node], list[Edge]]:
    """Return a winding path, and the edges of its side paths."""
    bends = _count(
        rng.child("bends"), "bends", bends, low=3, high=12, most=min(lines * lines // 4, MOST_BENDS)
    )
    if shape == "bends":
        branches = without_effect("branches", branches, "shape=bends")
    else:
        most = min(lines * lines // 8, MOST_BRANCHES)
        branches = _count(rng.child("branches"), "branches", branches, low=2, high=8, most=most)
    return _draft(rng.child("way"), lines, bends, branches, leads_back=shape == "junctions")


def _planned(
    rng: RandomStream, shape: Shape, lines: int, bends: int, branches: int
) -> tuple[list[Node], list[Edge]]:
    """Return a path with a plan, and the edges of its side paths.

    Raises:
        InvalidParameter: If a count is out of range, or has no effect.
    """
    # Reject counts that the shape ignores.
    if shape != "S":
        without_effect("bends", bends, f"shape={shape}")
    if shape in ("S", "tunnel"):
        without_effect("branches", branches, f"shape={shape}")

    # Lay out the plan with as many bends or junctions as requested and possible.
    if shape == "tunnel":
        return _longest_path(rng, min(lines, MOST_TUNNEL)), []
    if shape == "S":
        most = min(2 * lines - 3, MOST_BENDS)
        way, edges = serpentine(_count(rng, "bends", bends, low=min(4, most), high=16, most=most))
    else:
        most = min(lines - 2, MOST_BENDS)
        if most < 1:
            raise InvalidParameter(
                "no-room",
                "shape={shape} needs three stretches side by side, but there is room for only "
                "{lines}",
                "use a larger size, or a narrower corridor",
                shape=shape,
                lines=lines,
            )
        if branches != CHOSEN:
            check_between("branches", branches, 1, most)
        count = rng.between(1, min(most, 5)) if branches == CHOSEN else branches
        way, edges = tees(count) if shape == "T" else crossings(count)
    return turned_at_random(rng.child("turn"), way, edges)


def _count(rng: RandomStream, name: str, count: int, *, low: int, high: int, most: int) -> int:
    if count == CHOSEN:
        return rng.between(min(low, most), min(high, most))
    check_between(name, count, 0, most)
    return count


def _direction(here: Node, there: Node) -> int:
    """Return the direction from one node to a neighbour, in quarter turns."""
    return STEPS.index((there[0] - here[0], there[1] - here[1]))


def _draft(
    rng: RandomStream, lines: int, bends: int, branches: int, *, leads_back: bool
) -> tuple[list[Node], list[Edge]]:
    """Draw a path with exactly ``bends`` bends, and the edges of its side paths.

    The lattice is as small as seems possible, and grows after failed drafts.

    Raises:
        GenerationFailed: If no draft succeeds.
    """
    lattice = min(lines, 2 + math.isqrt(3 * (bends + branches)))
    for draft in range(MAX_DRAFTS):
        way = _stretch(rng, _longest_path(rng, lattice), bends, least_steps=2 if branches else 1)
        if way is not None:
            side_edges = _side_ways(rng, way, branches, lattice, leads_back=leads_back)
            if side_edges is not None:
                return way, side_edges
        lattice = min(lines, lattice + draft % 2)
    raise GenerationFailed(
        "no-room",
        "corridor: none of {drafts} drafts has bends={bends} and branches={branches} on {lines} x "
        "{lines} lines",
        "use fewer, or a larger size",
        drafts=MAX_DRAFTS,
        bends=bends,
        branches=branches,
        lines=lines,
    )


def _longest_path(rng: RandomStream, lattice: int) -> list[Node]:
    """Return the path from the farthest chamber of a backtracker's maze to its root."""
    # List the children of each chamber.
    tree = winding_tree(rng, lattice, lattice).tolist()
    children: dict[Node, list[Node]] = {}
    node: Node = (0, 0)
    root: Node = (0, 0)
    for row in range(lattice):
        for column in range(lattice):
            direction = tree[row][column]
            if direction == ROOT:
                root = (column, row)
            else:
                parent = (column + STEPS[direction][0], row + STEPS[direction][1])
                children.setdefault(parent, []).append((column, row))

    # Search breadth first: the last chamber that leaves the queue is the farthest.
    queue = deque([root])
    while queue:
        node = queue.popleft()
        queue.extend(children.get(node, ()))

    # Walk back to the root.
    way = [node]
    while node != root:
        step = STEPS[tree[node[1]][node[0]]]
        node = (node[0] + step[0], node[1] + step[1])
        way.append(node)
    return way


def _stretch(rng: RandomStream, way: list[Node], bends: int, least_steps: int) -> list[Node] | None:
    """Draw a stretch of a path with exactly ``bends`` bends.

    The runs at its ends are complete, so no stretch begins in the middle of a straight run.

    Args:
        rng: The only source of randomness.
        way: The path.
        bends: Number of bends.
        least_steps: Minimum number of lattice steps of the stretch.

    Returns:
        The stretch, or ``None`` if the path has no such stretch.
    """
    # List the ends and all bends of the path.
    corners = [0]
    corners += [
        k
        for k in range(1, len(way) - 1)
        if _direction(way[k - 1], way[k]) != _direction(way[k], way[k + 1])
    ]
    corners.append(len(way) - 1)

    # Draw one of the stretches between two of these, in either direction.
    runs = bends + 1
    bounds = [
        (low, high)
        for low, high in zip(corners, corners[runs:], strict=False)
        if high - low >= least_steps
    ]
    if not bounds:
        return None
    low, high = rng.choice(bounds)
    stretch = way[low : high + 1]
    return stretch[::-1] if rng.below(2) else stretch


def _side_ways(
    rng: RandomStream, way: list[Node], branches: int, lattice: int, *, leads_back: bool
) -> list[Edge] | None:
    """Draw side paths off a path and off each other.

    Dead ends end at a node that nothing else uses; those that lead back close one loop each.

    Args:
        rng: The only source of randomness.
        way: The path.
        branches: Number of side paths.
        lattice: Lines of the lattice.
        leads_back: True for side paths that lead back.

    Returns:
        Edges of the side paths, or ``None`` if there is no room for all of them.
    """
    used = set(way)
    joined = {frozenset(edge) for edge in pairwise(way)}
    # A blind side path at an end would only make the path look longer.
    origins = list(way) if leads_back else way[1:-1]
    edges: list[Edge] = []
    for _ in range(branches):
        for _ in range(TRIES_PER_ORIGIN * len(origins)):
            branch = _wander(rng, rng.choice(origins), used, lattice)
            if leads_back:
                branch = _lead_back(rng, branch, used, joined, lattice)
            if len(branch) > 1:
                break
        else:
            return None
        used.update(branch)
        # Nothing may branch off a dead end, or it would not be one.
        origins += branch[1:-1]
        joined.update(frozenset(edge) for edge in pairwise(branch))
        edges += pairwise(branch)
    return edges


def _neighbours(node: Node, lattice: int) -> list[Node]:
    around = [(node[0] + dx, node[1] + dy) for dx, dy in STEPS]
    return [(x, y) for x, y in around if 0 <= x < lattice and 0 <= y < lattice]


def _wander(rng: RandomStream, node: Node, used: set[Node], lattice: int) -> list[Node]:
    """Take a few random steps from a node over unused nodes."""
    branch = [node]
    for _ in range(rng.between(*BRANCH_STEPS)):
        free = [
            other
            for other in _neighbours(branch[-1], lattice)
            if other not in used and other not in branch
        ]
        if not free:
            break
        branch.append(rng.choice(free))
    return branch


def _lead_back(
    rng: RandomStream,
    branch: list[Node],
    used: set[Node],
    joined: set[frozenset[Node]],
    lattice: int,
) -> list[Node]:
    """Extend a branch by one step onto a used node.

    Returns an empty list if there is no such node next to the tip, or only nodes that the tip is
    already joined to.
    """
    tip = branch[-1]
    back = [
        other
        for other in _neighbours(tip, lattice)
        if other in used and other not in branch and frozenset((tip, other)) not in joined
    ]
    return [*branch, rng.choice(back)] if back else []


def _place_lines(
    rng: RandomStream, edges: list[Edge], axis: int, inside: int, width: int, wall: int
) -> dict[int, int]:
    """Return the first cell, in x or y, of each lattice line.

    Lines on which nothing turns or ends need no room. Dropping such a line and moving the others
    apart preserves their order, so no two corridors touch.
    """
    # Keep the lines that something turns or ends on, and distribute the spare cells between them.
    straight = {edge[0][axis] for edge in edges} | {edge[1][axis] for edge in edges}
    kept = sorted({node[axis] for node in _corners(edges)})
    spare = inside - len(kept) * width - (len(kept) - 1) * wall
    if len(kept) == 1:
        gaps = [rng.between(0, spare)]
    else:
        gaps = [0, *(wall + extra for extra in spread_unevenly(rng, spare, len(kept) - 1))]
    firsts: list[int] = []
    for gap in gaps:
        firsts.append((firsts[-1] + width if firsts else 1) + gap)

    # A dropped line gets the place of the kept line below it.
    below = np.searchsorted(kept, sorted(straight), side="right") - 1
    return {line: firsts[k] for line, k in zip(sorted(straight), below.tolist(), strict=True)}


def _corners(edges: list[Edge]) -> set[Node]:
    """Return the nodes at which the network ends, turns or branches."""
    ways: dict[Node, set[int]] = {}
    for here, there in edges:
        ways.setdefault(here, set()).add(_direction(here, there))
        ways.setdefault(there, set()).add(_direction(there, here))
    return {node for node, out in ways.items() if out not in ({0, 2}, {1, 3})}


def _cut(
    walls: Bools, edges: list[Edge], columns: dict[int, int], rows: dict[int, int], width: int
) -> Bools:
    for (ax, ay), (bx, by) in edges:
        x = sorted((columns[ax], columns[bx]))
        y = sorted((rows[ay], rows[by]))
        walls[y[0] : y[1] + width, x[0] : x[1] + width] = False
    return walls


def _centre(
    node: Node, columns: dict[int, int], rows: dict[int, int], width: int
) -> tuple[int, int]:
    """Return the middle of the corridor at a node, in half cells."""
    return 2 * columns[node[0]] + width, 2 * rows[node[1]] + width
