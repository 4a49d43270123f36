"""Convert a world of several robots for the joint searches: nodes, ticks, starts and targets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT, in_cells, lattice_units
from worldgen.reach.joint.apart import conflict_limits, stay_apart
from worldgen.reach.joint.rasters import Rasters, make_rasters
from worldgen.reach.single.prove import links
from worldgen.reach.still.disc import Disc, disc_of, is_away, lattice_centre
from worldgen.reach.still.lattice_graph import Graph, nodes_within
from worldgen.reach.still.path import ticks_per_second, travel_ticks
from worldgen.reach.still.walls import ExactPoint, Walls
from worldgen.reach.timed.spans import Spans
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, kept, pointer, writable
from worldgen.world import Robot, World

_MOST_NODES = 60_000_000  # limit on nodes times robots: each has a distance of four bytes
_MOST_CHOICES = 20_000  # limit on the assignments of starts to nodes that are tried

# The steps across and up, in the order of the core.
_EIGHT_STEPS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (-1, 1), (1, -1))


@dataclass(frozen=True)
class RobotEnds:
    """How a robot enters and leaves the nodes.

    Args:
        start: Where it starts, lu.
        nodes: The nodes that it can go to from there, the nearest first; of a question, the chosen
            one.
        goal: Where it ends, lu; None if it ends at a node.
        crossings: (n,) int64, the steps across its target; see :func:`crossing_steps`.
    """

    start: ExactPoint
    nodes: list[int]
    goal: ExactPoint | None
    crossings: Ints

    @property
    def node(self) -> int:
        """The node that it goes to first."""
        return self.nodes[0]


@dataclass(frozen=True)
class JointQuestion:
    """Everything that a joint search needs.

    Args:
        world: The world.
        radii: Radius of each robot, cells.
        rasters: Where the discs are clear.
        spans: When cells are blocked; None in a static world.
        ticks: Whole time units per second.
        tick: Time units in which every robot can take any step.
        ends: Starts and goals of the robots.
        distances: (robots, nodes) int32.
    """

    world: World
    radii: list[Fraction]
    rasters: Rasters
    spans: Spans | None
    ticks: int
    tick: int
    ends: list[RobotEnds]
    distances: npt.NDArray[np.int32]

    @property
    def stride(self) -> int:
        """Nodes per row."""
        return int(self.rasters.clear.shape[-1])

    @property
    def has_first_leg(self) -> bool:
        """True if some robot has to go to a node first; all robots then spend a tick on this."""
        return any(end.start != self.point(end.node) for end in self.ends)

    def point(self, node: int) -> ExactPoint:
        """Return where a node is, lu."""
        unit = UNIT // self.rasters.k
        return (node % self.stride * unit, node // self.stride * unit)

    def apart_sq(self, one: int, other: int) -> Fraction:
        """Return the square of the distance that two robots must keep, lu."""
        return ((self.radii[one] + self.radii[other]) * UNIT) ** 2

    def described(self) -> Any:
        """Return the question in the form that C reads."""
        # Group the robots by radius.
        classes = sorted(set(self.radii))
        class_of = np.array([classes.index(radius) for radius in self.radii], np.int64)
        limits = conflict_limits(classes, self.rasters.k)
        raster_of = self.rasters.raster_of
        if self.has_first_leg:  # the first tick is over when the search begins
            raster_of = np.ascontiguousarray(raster_of[min(1, len(raster_of) - 1) :])
        starts = np.array([end.node for end in self.ends], np.int64)
        crossings = [end.crossings for end in self.ends]
        rows, columns = self.rasters.clear.shape[-2:]
        arrays: dict[str, tuple[Ints | Bools | npt.NDArray[np.int32], type[np.generic]]] = {
            "clear": (np.ascontiguousarray(self.rasters.clear), np.bool_),
            "middle": (np.ascontiguousarray(self.rasters.middle), np.bool_),
            "raster_of": (raster_of, np.int64),
            "class_of": (class_of, np.int64),
            "limits": (limits, np.int64),
            "starts": (starts, np.int64),
            "distances": (self.distances, np.int32),
            "crossed_from": (np.cumsum([0, *map(len, crossings)]), np.int64),
            "crossings": (np.concatenate(crossings), np.int64),
        }
        # Fill in the struct.
        made = ffi.new("WgJoint *")
        made.robots = len(self.radii)
        made.classes = len(classes)
        made.nodes = rows * columns
        made.stride = columns
        made.rasters = len(self.rasters.clear)
        made.ticks = len(raster_of)
        made.reach = math.ceil(2 * self.rasters.k * classes[-1])
        for name, (array, kind) in arrays.items():
            setattr(made, name, pointer(ffi, array, kind))
        return kept(ffi, made, arrays)


def fits_graph(world: World, k: int, robots: int) -> bool:
    """Return True if the graph of a world, with ``k`` nodes per cell side, is small enough."""
    return (k * world.height + 1) * (k * world.width + 1) * robots <= _MOST_NODES


def joint_question(
    world: World, *, k: int, radius: float | None, margin: float
) -> JointQuestion | None:
    """Return the question about a world over a graph; None if some robot has no place on it.

    Args:
        world: The world.
        k: Nodes per cell side.
        radius: Radius of every robot, m; each one's own if None.
        margin: Seconds by which all robots may start late, in a world that changes.
    """
    robots = world.robots
    size = world.cell_size
    if not fits_graph(world, k, len(robots)):
        return None
    radii = [in_cells(robot.radius if radius is None else radius, size) for robot in robots]
    classes = sorted(set(radii))

    # The slowest robot sets the pace.
    spans = Spans(world, margin) if world.is_dynamic else None
    ticks = max(ticks_per_second(size, robot.speed) for robot in robots)
    if spans is not None:
        ticks = spans.ticks
    step = UNIT // k
    tick = max(travel_ticks((0, 0), (step, step), size, robot.speed, ticks) for robot in robots)
    rasters = make_rasters(world, classes, k, spans, tick)
    if rasters is None:
        return None

    # Starts and goals, each with the nodes next to it.
    grounds = [Ground(rasters, which, of_class) for which, of_class in enumerate(classes)]
    distances = np.empty((len(robots), rasters.clear.shape[-2] * rasters.clear.shape[-1]), np.int32)
    ends = [
        grounds[classes.index(of_robot)].ends(robot, size, row)
        for robot, of_robot, row in zip(robots, radii, distances, strict=True)
    ]
    chosen = _choose_nodes(ends, radii, k, rasters.clear.shape[-1])
    if chosen is None:
        return None
    ends = [replace(end, nodes=[node]) for end, node in zip(ends, chosen, strict=True)]
    return JointQuestion(world, radii, rasters, spans, ticks, tick, ends, distances)


class Ground:
    """Where the robots of one class can be.

    Args:
        rasters: Where the discs are clear.
        which: Number of the class.
        radius: Its radius, cells.
    """

    def __init__(self, rasters: Rasters, which: int, radius: Fraction) -> None:
        self._first = Graph(rasters.k, rasters.clear[0, which], rasters.middle[0, which])
        self._first_walls = Walls(rasters.blocked[0], radius)
        self._ever = rasters.ever(which)
        self._ever_walls = Walls(rasters.ever_blocked, radius)

    def ends(self, robot: Robot, size: float, distances: npt.NDArray[np.int32]) -> RobotEnds:
        """Return how a robot gets onto the nodes, and fill in their distances from its target.

        Args:
            robot: The robot.
            size: Side of a cell, m.
            distances: (nodes,) int32, receives the distances.
        """
        start: ExactPoint = (lattice_units(robot.start.x, size), lattice_units(robot.start.y, size))
        nodes = links(self._first_walls, self._first, start)
        target = robot.target
        disc = disc_of(target.x, target.y, target.radius, size)
        flags, goal = _goal_nodes(self._ever_walls, self._ever, disc)
        _fill_distances(self._ever, flags, distances)
        crossings = crossing_steps(disc, self._ever.k, self._ever.stride)
        nodes = _before_parking(nodes, start, disc, self._ever)
        return RobotEnds(
            start, _nearest_first(nodes, start, self._ever, distances), goal, crossings
        )


def crossing_steps(disc: Disc, k: int, stride: int) -> Ints:
    """Return the steps between nodes outside a target that lead across it.

    A robot parks as soon as its centre is in its target, so it never completes such a step.

    Args:
        disc: The target.
        k: Nodes per cell side.
        stride: Nodes per row.

    Returns:
        (n,) int64, ascending: eight times the node where a step begins, plus the number of the
        step.
    """
    # Each number of the disc is a whole number of units.
    scale = math.lcm(disc.x.denominator, disc.y.denominator, disc.radius.denominator)
    x, y, radius = (value.numerator * (scale // value.denominator) for value in disc)
    unit = UNIT // k * scale
    found = []
    # Both ends of such a step are less than a step away from the disc.
    reach = radius + unit
    for j in range(max(0, -((reach - y) // unit)), (y + reach) // unit + 1):
        py = j * unit - y
        for i in range(max(0, -((reach - x) // unit)), min(stride - 1, (x + reach) // unit) + 1):
            px = i * unit - x
            outside = px * px + py * py - radius * radius
            if not 0 < outside <= 2 * unit * (unit + 2 * radius):
                continue
            for step, (dx, dy) in enumerate(_EIGHT_STEPS):
                qx = px + dx * unit
                qy = py + dy * unit
                is_outside = qx * qx + qy * qy > radius * radius
                if is_outside and not is_away(((px, py), (qx, qy)), (0, 0), radius):
                    found.append(8 * (j * stride + i) + step)
    return np.array(sorted(found), np.int64)


def _before_parking(nodes: Sequence[int], start: ExactPoint, disc: Disc, graph: Graph) -> list[int]:
    """Return the nodes to which a robot can go from its start before it parks in its target."""
    unit = UNIT // graph.k
    centre = (disc.x, disc.y)
    found = []
    for node in nodes:
        there = (node % graph.stride * unit, node // graph.stride * unit)
        # A leg that ends in the target leads into it, and keeps to it if it begins in it.
        if disc.holds(there) or is_away((start, there), centre, disc.radius):
            found.append(node)
    return found


def _goal_nodes(walls: Walls, graph: Graph, disc: Disc) -> tuple[Bools, ExactPoint | None]:
    """Return the nodes that end a path, and the point to go to from those outside the target."""
    flags = np.zeros(graph.clear.size, np.bool_)
    flags[nodes_within(disc, graph)] = True
    if flags.any():
        return flags, None
    goal = lattice_centre(disc)
    if goal is None or not walls.is_clear(goal, goal):
        return flags, None
    flags[links(walls, graph, goal)] = True
    return flags, goal


def _fill_distances(graph: Graph, goals: Bools, distances: npt.NDArray[np.int32]) -> None:
    clear = pointer(ffi, np.ascontiguousarray(graph.clear), np.bool_)
    middle = pointer(ffi, np.ascontiguousarray(graph.middle), np.bool_)
    described = ffi.new("WgGraph *", (clear, middle, graph.clear.size, graph.stride))
    made = writable(ffi, distances, np.int32)
    check(lib.wg_joint_distances(described, pointer(ffi, goals, np.bool_), made))


def _nearest_first(
    nodes: Sequence[int], start: ExactPoint, graph: Graph, distances: npt.NDArray[np.int32]
) -> list[int]:
    """Return the nodes from which the target can be reached, those nearest to the start first."""
    unit = UNIT // graph.k

    def away(node: int) -> tuple[Fraction, int]:
        dx = node % graph.stride * unit - start[0]
        dy = node // graph.stride * unit - start[1]
        return Fraction(dx * dx + dy * dy), node

    return sorted((node for node in nodes if distances[node] >= 0), key=away)


def _choose_nodes(
    ends: list[RobotEnds], radii: list[Fraction], k: int, stride: int
) -> list[int] | None:
    """Choose a node for each robot so that all can go there at once, straight from their starts."""
    # Try the nodes of each robot in turn, and backtrack if none fits.
    unit = UNIT // k
    chosen: list[int] = []
    tried = [0] * (len(ends) + 1)
    looked = 0
    while len(chosen) < len(ends):
        robot = len(chosen)
        if tried[robot] == len(ends[robot].nodes) or looked > _MOST_CHOICES:
            if not chosen or looked > _MOST_CHOICES:
                return None
            tried[robot] = 0
            chosen.pop()
            continue
        node = ends[robot].nodes[tried[robot]]
        tried[robot] += 1
        looked += 1
        # The robot's first leg must stay clear of the legs chosen before.
        move = (ends[robot].start, (node % stride * unit, node // stride * unit))
        fits = True
        for other, there in enumerate(chosen):
            apart_sq = ((radii[robot] + radii[other]) * UNIT) ** 2
            path = (ends[other].start, (there % stride * unit, there // stride * unit))
            if not stay_apart(move, path, apart_sq):
                fits = False
                break
        if fits:
            chosen.append(node)
    return chosen
