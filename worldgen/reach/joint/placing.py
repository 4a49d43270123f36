"""Place several robots in a world: starts and targets that do not overlap, drawn from a stream."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.lattice import (
    TURN,
    UNIT,
    heading_from_lattice,
    lattice_to_metres,
    lattice_units,
    radius_in_cells,
)
from worldgen.random_streams import RandomStream
from worldgen.reach.joint.crowd import Crowd
from worldgen.reach.joint.few_robots import FEW_ROBOTS, MOST_TOGETHER
from worldgen.reach.joint.question import fits_graph
from worldgen.reach.still.lattice_graph import build_graph, flood
from worldgen.support.arrays import Bools, Ints
from worldgen.support.progress import Work, working
from worldgen.world import Pose, Robot, Target, World

_HALF = UNIT // 2
# Cells that robots keep between their discs, if there is room; otherwise they may touch.
_GAP = 1
# Placements to try before giving up, because greedy draws can block each other.
_TRIES = 20
# Number of targets drawn, of which the farthest is taken: robots with short paths seldom meet.
_DRAWS = 4
# Places drawn for a robot that finds no path around those before it.
_REDRAWS = 20
# Placements of all robots to try, one robot by one, as long as some robot finds no room.
_PLACEMENTS = 4

Box: TypeAlias = tuple[int, int, int, int]
"""Cells (first column, first row, last column, last row) of a rectangle."""


class PlacedEnds(NamedTuple):
    """Where a robot starts and what it must reach, in half cells."""

    start: tuple[int, int]
    target: tuple[int, int]


class _Room:
    """The places where a robot fits, and the distance of each from the taken ones.

    Args:
        places: (n, 2) int64, half cells.
        radius: Radius of the robots, cells.
    """

    def __init__(self, places: Ints, radius: Fraction) -> None:
        self._places = places
        self._nearest_sq = np.full(len(places), np.iinfo(np.int64).max)
        self._apart_sq = [math.ceil((2 * (2 * radius + gap)) ** 2) for gap in (_GAP, 0)]

    def take(self, place: tuple[int, int]) -> None:
        """Keep other robots away from a place."""
        apart = self._places - np.array(place)
        np.minimum(self._nearest_sq, (apart * apart).sum(axis=1), out=self._nearest_sq)

    def left(self, box: Box | None) -> Ints:
        """Return the places in a box that are far enough from those that are taken."""
        inside: Bools = np.ones(len(self._places), np.bool_)
        if box is not None:
            low = 2 * np.array(box[:2])
            high = 2 * np.array(box[2:]) + 2
            inside = np.logical_and.reduce((self._places >= low) & (self._places <= high), axis=1)
        for apart_sq in self._apart_sq:
            found = self._places[inside & (self._nearest_sq >= apart_sq)]
            if len(found):
                break
        return found


def place_robots(
    world: World, rng: RandomStream, count: int, owner: str, *, margin: float = 0.0
) -> World:
    """Return a world with more robots like its own, between places that its robot can reach.

    If there are more than ``FEW_ROBOTS``, the world has a joint witness, if one was found.

    Args:
        world: A world of one robot.
        rng: The only source of randomness.
        count: Total number of robots.
        owner: Name of the family, for the error message.
        margin: Seconds by which all robots may start late, in a world that changes.

    Raises:
        InvalidParameter: If there is no room for that many robots, or the world is too large.
    """
    first = PlacedEnds(
        (_halves(world.start.x, world), _halves(world.start.y, world)),
        (_halves(world.target.x, world), _halves(world.target.y, world)),
    )
    boxes: list[tuple[Box | None, Box | None]] = [(None, None)] * (count - 1)
    radius = radius_in_cells(world)
    never = world.walls | world.changing_cells
    if count > FEW_ROBOTS:
        _check_plannable(world, owner)
        places = _places(never, radius, first)
        return _crowd(world, places, rng, boxes, first, owner, margin)
    try:
        places = _places(never, radius, first)
        placed = _draw_ends(places, radius, rng.child("safe"), boxes, [first], owner)
    except InvalidParameter:
        # If nearly every cell changes, only cells that are solid at first count. The proof decides
        # later whether the robots are safe.
        if not world.is_dynamic:
            raise
        places = _places(world.walls, radius, first)
        placed = _draw_ends(places, radius, rng.child("bold"), boxes, [first], owner)
    return replace(world, robots=(world.robots[0], *(_robot(world, ends) for ends in placed)))


def place_in_boxes(
    world: World, rng: RandomStream, boxes: Sequence[tuple[Box, Box]], owner: str
) -> World:
    """Return a world with a robot for each pair of boxes, from one to the other.

    Args:
        world: A world whose own robot gives size and speed; its start and target are replaced.
        rng: The only source of randomness.
        boxes: Where each robot starts and where it must go.
        owner: Name of the family, for the error message.

    Raises:
        InvalidParameter: If there is no room for that many robots, or the world is too large.
    """
    if len(boxes) > FEW_ROBOTS:
        _check_plannable(world, owner)
    radius = radius_in_cells(world)
    places = _places(world.walls, radius, None)
    if len(boxes) > FEW_ROBOTS:
        rooms = (_Room(places, radius), _Room(places, radius))
        drawn = _draw_one(rooms, rng, boxes[0], _DRAWS)
        if drawn is None:
            raise _too_many(owner, 0, len(boxes))
        robot = _robot(world, drawn)
        world = replace(world, start=robot.start, target=robot.target)
        return _crowd(world, places, rng, boxes[1:], drawn, owner)
    placed = _draw_ends(places, radius, rng, boxes, [], owner)
    return replace(world, robots=tuple(_robot(world, ends) for ends in placed))


def _draw_ends(
    places: Ints,
    radius: Fraction,
    rng: RandomStream,
    boxes: Sequence[tuple[Box | None, Box | None]],
    before: list[PlacedEnds],
    owner: str,
) -> list[PlacedEnds]:
    # Draw all robots again in each try, because the first ones may leave no room for the others.
    most = 0
    for _ in range(_TRIES):
        rooms = (_Room(places, radius), _Room(places, radius))
        ends = list(before)
        for one in before:
            _take(rooms, one)
        for box in boxes:
            drawn = _draw_one(rooms, rng, box, _DRAWS)
            if drawn is None:
                break
            _take(rooms, drawn)
            ends.append(drawn)
        most = max(most, len(ends))
        if len(ends) == len(before) + len(boxes):
            return ends[len(before) :]
    raise _too_many(owner, most, len(before) + len(boxes))


def _crowd(
    world: World,
    places: Ints,
    rng: RandomStream,
    boxes: Sequence[tuple[Box | None, Box | None]],
    first: PlacedEnds,
    owner: str,
    margin: float = 0.0,
) -> World:
    """Return a world with a robot for each pair of boxes, if possible with a joint witness.

    If some robot finds no path around those before it, these may still make way for it. Up to
    ``MOST_TOGETHER`` robots are then placed without a witness, and left to the joint search.
    """
    radius = radius_in_cells(world)
    # Don't plan the paths of robots that there is no room for.
    together = _draw_ends(places, radius, rng.child("room"), boxes, [first], owner)
    most = 0
    for number in range(_PLACEMENTS):
        stream = rng if number == 0 else rng.child("again", number)
        try:
            return _one_by_one(world, places, stream, boxes, first, owner, margin)
        except InvalidParameter as full:
            most = max(most, full.facts["placed"])
            # Robots at other places may leave more room, but hardly shorter searches.
            if full.code != "too-many-robots":
                break
    if len(boxes) >= MOST_TOGETHER:
        raise _no_paths(owner, most, len(boxes) + 1)
    return replace(world, robots=(world.robots[0], *(_robot(world, ends) for ends in together)))


def _one_by_one(
    world: World,
    places: Ints,
    rng: RandomStream,
    boxes: Sequence[tuple[Box | None, Box | None]],
    first: PlacedEnds,
    owner: str,
    margin: float,
) -> World:
    """Return a world with a robot for each pair of boxes, each with a path around the others.

    Each robot is drawn again until it has a path around those before it. The world has a joint
    witness, unless the robots' last legs, from the graph to their targets, conflict.

    Raises:
        InvalidParameter: If there is no room left for a robot, or it finds no path.
    """
    # Begin with the first robot.
    count = len(boxes) + 1
    radius = radius_in_cells(world)
    planned = Crowd(world, count, margin)
    rooms = (_Room(places, radius), _Room(places, radius))
    _take(rooms, first)
    # Add the others. Only large crowds are reported, as layouts are.
    is_reported = count >= MOST_TOGETHER
    with working("one by one", often=True) if is_reported else nullcontext(Work("")) as work:
        for box in boxes if planned.robots else ():
            work.say(f"robot {len(planned.robots) + 1}")
            for number in range(_REDRAWS):
                # Targets that are far away come first, because they are the hardest to reach.
                drawn = _draw_one(rooms, rng, box, max(1, _DRAWS - number))
                if drawn is None:
                    raise _too_many(owner, len(planned.robots), count)
                if planned.add(_robot(world, drawn)):
                    _take(rooms, drawn)
                    break
            else:
                raise _no_paths(owner, len(planned.robots), count)
    # Prove that all of them can arrive.
    if not planned.robots:
        raise _no_paths(owner, 0, count)
    placed = replace(world, robots=(world.robots[0], *planned.robots[1:]))
    return replace(placed, certificate=planned.witness(placed))


def _places(blocked: Bools, radius: Fraction, first: PlacedEnds | None) -> Ints:
    """Return the places where a robot fits: all, or those that the first robot can reach."""
    graph = build_graph(blocked, radius, 2)
    clear = graph.clear.ravel()
    if first is not None:
        # Only what the first robot can reach, so that no robot is walled off.
        node = first.start[1] * graph.stride + first.start[0]
        if clear[node]:
            clear = flood(graph, np.array([node], np.int64))
    rows, columns = np.divmod(np.flatnonzero(clear), graph.stride)
    return np.stack([columns, rows], axis=1)


def _check_plannable(world: World, owner: str) -> None:
    """Reject a world that is too large to plan the paths of several robots."""
    if not fits_graph(world, 2, 1):
        raise InvalidParameter(
            "too-large",
            "{family}: a world of {width} x {height} cells is too large to plan the paths of more "
            "than {few} robots",
            "use a smaller size, or fewer robots",
            family=owner,
            width=world.width,
            height=world.height,
            few=FEW_ROBOTS,
        )


def _too_many(owner: str, placed: int, robots: int) -> InvalidParameter:
    return InvalidParameter(
        "too-many-robots",
        "{family}: only {placed} robots fit, not robots={robots}",
        "use fewer or smaller robots, or a larger size",
        family=owner,
        placed=placed,
        robots=robots,
    )


def _no_paths(owner: str, planned: int, robots: int) -> InvalidParameter:
    return InvalidParameter(
        "no-joint-paths",
        "{family}: only {placed} robots, not robots={robots}, were placed so that each has a path "
        "around the others",
        "use fewer or smaller robots, or a larger size",
        family=owner,
        placed=planned,
        robots=robots,
    )


def _draw_one(
    rooms: tuple[_Room, _Room], rng: RandomStream, box: tuple[Box | None, Box | None], draws: int
) -> PlacedEnds | None:
    starts = rooms[0].left(box[0])
    targets = rooms[1].left(box[1])
    if not len(starts) or not len(targets):
        return None
    start = starts[rng.below(len(starts))].tolist()
    drawn = [targets[rng.below(len(targets))].tolist() for _ in range(draws)]
    target = max(drawn, key=lambda place: math.dist(place, start))
    return PlacedEnds((start[0], start[1]), (target[0], target[1]))


def _take(rooms: tuple[_Room, _Room], ends: PlacedEnds) -> None:
    """Keep other robots away from where one starts and where it ends."""
    rooms[0].take(ends.start)
    rooms[1].take(ends.target)


def _halves(metres: float, world: World) -> int:
    """Return the nearest multiple of half a cell."""
    return round(lattice_units(metres, world.cell_size) / _HALF)


def _robot(world: World, ends: PlacedEnds) -> Robot:
    """Return a robot like the world's own, facing along the axis nearest to its target."""
    dx = ends.target[0] - ends.start[0]
    dy = ends.target[1] - ends.start[1]
    quarter = (0 if dx >= 0 else 2) if abs(dx) >= abs(dy) else (1 if dy > 0 else 3)
    size = world.cell_size
    x, y, u, v = (lattice_to_metres(_HALF * value, size) for value in (*ends.start, *ends.target))
    return Robot(
        Pose(x, y, heading_from_lattice(quarter * TURN // 4)),
        Target(u, v, lattice_to_metres(_HALF, size)),
        world.robot_radius,
        world.robot_speed,
    )
