"""Small worlds cut out of a user's own map: windows around narrow places.

A window is the part of the map around a place, with start and target on two sides of it. Everything
outside is solid, as outside any grid. Each window has a witness, and its provenance says in words
which part of the map it is, and what was changed there.

Lengths and places are in *nodes*, the multiples of half a cell, unless a name or a comment says
otherwise.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from fuzz.layouts.narrow_places import Ground, NarrowPlace, narrow_places
from fuzz.layouts.variation import MAP, map_provenance
from worldgen.body_room import layout_radius, with_fitting_heading
from worldgen.lattice import UNIT, in_cells, lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.reach.still.grid_search import components, shortest_path, steps_from
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import Pose, Provenance, Value, World

# Steps of the robot from start to target: enough to see it react, few enough that a slow controller
# runs many windows.
_STEPS = (20, 60)
# The same in radii of the robot: with fewer it would hardly move, with more the window would be
# most of the map.
_FEWEST_RADII = 10.0
_MOST_RADII = 40.0
# The shortest path is at most this share of the longest, so that there are places to choose from.
_SHORTEST = 0.5
# Longest side, in cells, of the part of a map that is examined. This many take two seconds and
# 200 MB.
_LONGEST_SIDE = 1_500
_HEADINGS = 16
# Parameter of the provenance that names the kind.
_KIND = "variation"


class Kind(StrEnum):
    """The kinds of worlds that a campaign draws on a map, in the order in which they are listed."""

    POSE = "pose"
    WINDOW = "window"
    DOOR = "door"
    BOX = "box"
    PERSON = "person"
    PIECE = "piece"


_NAMES = {
    Kind.POSE: ("pose", "poses"),
    Kind.WINDOW: ("window", "windows"),
    Kind.DOOR: ("door closed", "doors closed"),
    Kind.BOX: ("box put down", "boxes put down"),
    Kind.PERSON: ("person in the way", "people in the way"),
    Kind.PIECE: ("piece moved", "pieces moved"),
}


def kind_of(world: World, fixed_map: World) -> Kind:
    """Return the kind of a world that was drawn on a map."""
    made = world.provenance
    if made is None or made == map_provenance(fixed_map):
        return Kind.POSE
    return Kind(str(made.params.get(_KIND, Kind.POSE)))


def describe_tried(tried: Mapping[str, int]) -> str:
    """Describe how many worlds of each kind were tried: ``212 poses, 96 windows, 41 doors closed``.

    Args:
        tried: Numbers of worlds by kind.
    """
    return ", ".join(
        f"{number} {one if number == 1 else several}"
        for kind, (one, several) in _NAMES.items()
        if (number := tried.get(kind))
    )


class Box(NamedTuple):
    """A rectangle of cells of the map: its first row and column, and those after its last."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def cells(self) -> tuple[slice, slice]:
        """Its cells, as an index of the map's walls."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def corner(self) -> Ints:
        """The node (row, column) at its lower-left corner."""
        return np.array((2 * self.top, 2 * self.left))

    def joined(self, other: Box) -> Box:
        """Return the smallest box around both."""
        return Box(*map(min, self[:2], other[:2]), *map(max, self[2:], other[2:]))


class Ends(NamedTuple):
    """Start and target, as nodes (row, column) of the map."""

    start: Ints
    target: Ints


class Windows:
    """Cuts windows out of a map, and out of the map with changed walls.

    Args:
        world: The map, with one robot; it must not change over time.
        step: Length of the robot's step, m.

    Attributes:
        walls: The map's walls.
        cell: Side of a cell, m.
        radius: Radius of the robot.
        reach: Longest path from the middle of a window to start or target.
    """

    def __init__(self, world: World, step: float) -> None:
        # Waypoints may be outside of a window.
        self._waypoints = world.robots[0].waypoints
        robot = replace(world.robots[0], waypoints=())
        self._plain = replace(world.bare, robots=(robot,))
        self._made = map_provenance(world)
        self._family = "" if world.provenance is None else world.provenance.family
        # Narrow places for a body are those where it has to turn while it moves.
        robot = world.robots[0]
        radius = robot.radius if robot.is_round else layout_radius(robot)
        self._disc = in_cells(radius, world.cell_size)
        self.walls = world.walls
        self.cell = world.cell_size
        self.radius = 2.0 * float(self._disc)
        # Half of the path is on each side of the place.
        longest = max(_STEPS[1] * step / self.cell, 0.5 * _FEWEST_RADII * self.radius)
        self.reach = math.ceil(min(longest, 0.5 * _MOST_RADII * self.radius))
        self._nearest = math.ceil(min(_STEPS[0] * step / self.cell, _SHORTEST * self.reach))
        self._margin = math.ceil(self.radius) + 4

    @functools.cached_property
    def part(self) -> Box:
        """The part of the map that is examined: all of it, or if it is huge, that near the start."""
        start = self._plain.start
        first = [
            max(min(int(at / self.cell) - _LONGEST_SIDE // 2, side - _LONGEST_SIDE), 0)
            for at, side in zip((start.y, start.x), self.walls.shape, strict=True)
        ]
        last = [min(at + _LONGEST_SIDE, n) for at, n in zip(first, self.walls.shape, strict=True)]
        return Box(*first, *last)

    @functools.cached_property
    def ground(self) -> Ground:
        """The nodes of the part that is examined."""
        return self.ground_in(self.part)

    @functools.cached_property
    def places(self) -> tuple[NarrowPlace, ...]:
        """The map's narrow places."""
        row, column = self.part.corner.tolist()
        return tuple(
            replace(one, row=one.row + row, column=one.column + column)
            for one in narrow_places(self.ground, 0.5 * self.radius)
        )

    def ground_in(self, box: Box, walls: Bools | None = None) -> Ground:
        """Return the nodes of a box, outside of which everything is solid.

        Args:
            box: The box.
            walls: The walls of the whole map; unchanged if omitted.
        """
        return Ground.of((self.walls if walls is None else walls)[box.cells], self._disc)

    def open_place(self, box: Box, ground: Ground, rng: RandomStream) -> NarrowPlace | None:
        """Return a node in a box where the robot fits, as a place without a gap."""
        if not len(ground.floor):
            return None
        node = divmod(_any_of(ground.floor, rng), ground.clear.shape[1])
        row, column = (box.corner + node).tolist()
        return NarrowPlace(row, column, 0.0)

    def around(self, nodes: Ints, reach: float = 0.0) -> Box:
        """Return the cells around nodes (row, column), with room for the robot next to them.

        Args:
            nodes: (n, 2) int64.
            reach: Further distance from them.
        """
        far = math.ceil(reach) + self._margin
        first = np.maximum((nodes.min(axis=0) - far) // 2, 0)
        last = np.minimum((nodes.max(axis=0) + far) // 2 + 1, self.walls.shape)
        return Box(*first.tolist(), *last.tolist())

    def around_place(self, place: NarrowPlace) -> Box:
        """Return the cells of the window around a place."""
        return self.around(place.nodes, self.reach)

    def path(self, box: Box, ends: Ends, walls: Bools | None = None) -> Ints:
        """Return the nodes (row, column) of a shortest path inside a box; empty without a path.

        Args:
            box: The box.
            ends: Its ends.
            walls: As for :meth:`ground_in`.
        """
        clear = self.ground_in(box, walls).clear
        stride = clear.shape[1]
        start, target = (
            row * stride + column for row, column in (np.array(ends) - box.corner).tolist()
        )
        is_free = clear.flat[start] and clear.flat[target]
        nodes = shortest_path(clear, start, target) if is_free else []
        return np.stack(np.divmod(np.array(nodes, np.int64), stride), axis=1) + box.corner

    def ends_at(
        self,
        place: NarrowPlace,
        rng: RandomStream,
        walls: Bools | None = None,
        middle: Floats | None = None,
    ) -> Ends | None:
        """Draw a start and a target on different sides of a place; ``None`` if none fit.

        Args:
            place: The place.
            rng: The source of randomness.
            walls: As for :meth:`ground_in`.
            middle: On open floor, the node (row, column) to have between them; the place if omitted.
        """
        # Find how far each node is from the place, inside the window.
        box = self.around_place(place)
        clear = self.ground_in(box, walls).clear
        stride = clear.shape[1]
        row, column = (place.nodes[0] - box.corner).tolist()
        if not clear[row, column]:
            return None
        steps = steps_from(clear, row * stride + column)[0].reshape(clear.shape)
        near = (steps >= 0) & (steps <= self.reach)

        # Without the nodes in the gap, the two sides of a narrow place are not connected.
        rows, columns = np.ogrid[: clear.shape[0], : clear.shape[1]]
        gap = max(place.clearance - self.radius + 1.5, 0.0)
        near &= (rows - row) ** 2 + (columns - column) ** 2 > gap * gap
        side, count = components(near)
        far = np.flatnonzero(near & (steps >= self._nearest))
        if not len(far):
            return None
        sizes = np.bincount(side[far], minlength=count)
        first, *others = np.argsort(-sizes, kind="stable").tolist()
        if others and sizes[others[0]]:
            start = _any_of(far[side[far] == first], rng)
            target = _any_of(far[side[far] == others[0]], rng)
        else:
            # On open floor, the middle is between start and target.
            start = _any_of(far, rng)
            between = (place.nodes[0] if middle is None else middle) - box.corner
            y, x = divmod(start, stride) - between
            behind = far[(far // stride - between[0]) * y + (far % stride - between[1]) * x < 0.0]
            if not len(behind):
                return None
            target = _any_of(behind, rng)
        both = (start, target) if rng.below(2) else (target, start)
        return Ends(*(box.corner + divmod(node, stride) for node in both))

    def world(
        self,
        kind: Kind,
        box: Box,
        ends: Ends,
        rng: RandomStream,
        walls: Bools | None = None,
        words: str = "",
    ) -> World | None:
        """Return a window with a witness; ``None`` if its target cannot be reached.

        Args:
            kind: Its kind.
            box: Its cells.
            ends: Its start and target.
            rng: Chooses the heading.
            walls: As for :meth:`ground_in`.
            words: What was changed on the map; empty if nothing was.
        """
        heading = rng.below(_HEADINGS) * (2.0 * math.pi / _HEADINGS)
        start, target = (
            [lattice_to_metres(at * UNIT // 2, self.cell) for at in place]
            for place in (np.array(ends) - box.corner).tolist()
        )
        world = replace(
            self._plain,
            walls=(self.walls if walls is None else walls)[box.cells],
            start=Pose(start[1], start[0], heading),
            target=replace(self._plain.target, x=target[1], y=target[0]),
            provenance=self._provenance(kind, box, words),
        )
        world = with_fitting_heading(self._with_waypoints(world, box))
        decision = decide(world, cut=False)
        if decision.result != REACHABLE:
            return None
        return replace(world, certificate=decision.certificate)

    def _with_waypoints(self, world: World, box: Box) -> World:
        """Return a window's world with those of the map's waypoints that are in it."""
        left, low = box.left * self.cell, box.top * self.cell
        width, height = world.width * self.cell, world.height * self.cell
        kept = [
            replace(goal, x=round(goal.x - left, 9), y=round(goal.y - low, 9))
            for goal in self._waypoints
            if left <= goal.x <= left + width and low <= goal.y <= low + height
        ]
        if not kept:
            return world
        return replace(world, robots=(replace(world.robots[0], waypoints=tuple(kept)),))

    def _provenance(self, kind: Kind, box: Box, words: str) -> Provenance:
        """Return the map's provenance, with what was changed, for a part of it."""
        made = self._made or Provenance(MAP, 1, 0, {"from": self._family} if self._family else {})
        changed = [*made.changed, *([words] if words else [])]
        height = box.bottom - box.top
        width = box.right - box.left
        if (height, width) != self.walls.shape:
            changed.append(f"window of {width} x {height} cells at {self.describe(*box.corner)}")
        params: dict[str, Value] = {**made.params, _KIND: kind.value, "changed": list(changed)}
        # The window's corner is somewhere else in the frame of the original map.
        if box.top or box.left:
            x, y = made.origin
            params["origin"] = [
                round(x + box.left * self.cell, 9),
                round(y + box.top * self.cell, 9),
            ]
        return replace(made, params=params, metrics={})

    def describe(self, row: float, column: float) -> str:
        """Describe where a node is on the map: ``(3.4, 2) m``."""
        return f"({0.5 * column * self.cell:.4g}, {0.5 * row * self.cell:.4g}) m"


def _any_of(nodes: Ints, rng: RandomStream) -> int:
    return int(nodes[rng.below(len(nodes))])
