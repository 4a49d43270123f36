"""Small worlds in which a run is short: for controllers whose steps take long.

A world comes from a family at a small size, or is one of a few scenes: a target nearby, a door, a
cup, a corner, a gap, an island, a slot, walls to go around, posts. The first worlds can be crossed in
about 20 steps of their robot; among later ones are some of up to four times that size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np

from fuzz.layouts.variation import generated, layout_disc, overrides_in
from worldgen.body_room import with_chosen_waypoints, with_room
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.support.arrays import Bools
from worldgen.world import (
    DEFAULT_CELL_SIZE,
    DEFAULT_ROBOT_RADIUS,
    DEFAULT_ROBOT_SPEED,
    Pose,
    Target,
    Value,
    Witness,
    World,
)

# Families whose small worlds a robot can cross in few steps. Changes, by fire or moving walls, would
# make it wait, and harm it in ways that it may not sense.
_FAMILIES = ("trap", "maze", "corridor", "rooms", "forest", "cave", "rubble")
# Steps that it takes to drive straight through the worlds of the first round. In later rounds half of
# the worlds are of that size, a quarter of twice that, and the rest of four times that. That begins
# with one more doubling in each round, up to this many.
_FIRST_STEPS = (20, 40)
_DOUBLED = 2
# Sides of families' worlds, cells. Smaller ones have no room for what makes the family.
_SMALLEST_SIDE = 10
_LARGEST_SIDE = 40
# Cells on the way through a scene.
_SHORTEST = 6
_LONGEST = 40
# Radius of a robot for which a family's usual cells suit its passages, cells.
_USUAL_RADIUS = DEFAULT_ROBOT_RADIUS / DEFAULT_CELL_SIZE
# A world may take this many times the steps that it was made for; other draws replace longer ones.
_MOST_TIMES = 2.0
_DRAWS = 4

# Half the width of a gap or slot, robot radii: from what hardly fits to what two robots share.
_TIGHT = (1.05, 1.1, 1.2, 1.35, 1.6, 2.0, 3.0)
_HEADINGS = 16

# What is in a cell of a scene.
_WALL, _START, _TARGET = 1, 2, 3

Place = tuple[int, int]
"""Row and column of a cell."""


class Scene(NamedTuple):
    """Walls inside a border, with start and target; everything runs from left to right.

    Args:
        walls: (rows, columns) solid cells, without the border.
        start: Cell of the start.
        target: Cell of the target.
        tight: Half the width of its gap of two cells, robot radii; 0 for cells of the usual size.
    """

    walls: Bools
    start: Place
    target: Place
    tight: float = 0.0


Build = Callable[[RandomStream, int], Scene]
"""Makes a scene with about this many cells on the way through it."""


def small_world(
    stream: RandomStream, number: int, values: Mapping[str, Value], time_step: float
) -> World | None:
    """Return a world of the sequence of small worlds, with a witness.

    Scenes and families take turns. The result depends on the arguments alone.

    Args:
        stream: Source of randomness; it is advanced.
        number: Place in the sequence, which decides what is made, and how large it may be.
        values: The robot's ``robot_radius``, m, ``robot_speed``, m/s, body, drive and goal, if they
            are not the usual ones; others are ignored.
        time_step: Duration of a step, s.

    Returns:
        The world; ``None`` if no draw has a path.
    """
    radius, _ = layout_disc(values)
    speed = float(cast("float", values.get("robot_speed", DEFAULT_ROBOT_SPEED)))
    maker = _Maker(stream, values, radius, speed, speed * time_step)
    turn, place = divmod(number, 2 * len(_FAMILIES))
    most = min(turn, _DOUBLED)
    doubled = next((times for times in range(most) if stream.below(2)), most)
    low, high = (steps << doubled for steps in _FIRST_STEPS)
    best: World | None = None
    for _ in range(_DRAWS):
        steps = stream.between(low, high)
        if place % 2:
            world = maker.of_family(_FAMILIES[place // 2], steps)
        else:
            scene = SCENES[(place // 2 + turn * len(_FAMILIES)) % len(SCENES)]
            world = maker.of_scene(scene, steps)
        if world is None:
            continue
        if best is None or _duration(world) < _duration(best):
            best = world
        if _duration(best) <= _MOST_TIMES * steps * time_step:
            break
    return best


def _duration(world: World) -> float:
    return world.certificate.duration if isinstance(world.certificate, Witness) else math.inf


@dataclass(frozen=True)
class _Maker:
    """Makes small worlds for a robot.

    Args:
        stream: Source of randomness.
        values: As for :func:`small_world`.
        radius: Radius of the disc for which worlds are laid out, m.
        speed: Top speed, m/s.
        step: Length of a step, m.
    """

    stream: RandomStream
    values: Mapping[str, Value]
    radius: float
    speed: float
    step: float

    def of_family(self, family: str, steps: int) -> World | None:
        """Return a family's world of about the size that the robot crosses in these steps."""
        side = round(self.radius / _USUAL_RADIUS, 4)
        cells = math.ceil(steps * self.step / side)
        given: dict[str, Value] = {
            "size": min(max(cells + 3, _SMALLEST_SIDE), _LARGEST_SIDE),
            "robot_radius": self.radius,
            "robot_speed": self.speed,
            "cell_size": side,
        }
        try:
            return generated(family, self.stream.next64(), {**self.values, **given})
        except (GenerationFailed, InvalidParameter, InvalidWorld):
            return None

    def of_scene(self, build: Build, steps: int) -> World | None:
        """Return the world of a scene of about the size that the robot crosses in these steps."""
        side = self.radius / _USUAL_RADIUS
        length = steps * self.step / side
        scene = build(self.stream, min(max(round(length), _SHORTEST), _LONGEST))
        return world_of_scene(scene, self.stream, self.values)


def world_of_scene(scene: Scene, stream: RandomStream, values: Mapping[str, Value]) -> World | None:
    """Return a scene's world, turned and mirrored at random; ``None`` if it has no path.

    Args:
        scene: The scene.
        stream: Source of randomness; it is advanced.
        values: As for :func:`small_world`.
    """
    radius, _ = layout_disc(values)
    side = radius / _USUAL_RADIUS
    if scene.tight:
        side = scene.tight * radius
    side = round(side, 4)
    # Mark start and target, so that they turn with the walls.
    cells = np.pad(scene.walls.astype(np.int8), 1, constant_values=_WALL)
    cells[scene.start[0] + 1, scene.start[1] + 1] = _START
    cells[scene.target[0] + 1, scene.target[1] + 1] = _TARGET
    cells = np.rot90(cells, stream.below(4))[:, :: 1 if stream.below(2) else -1]
    heading = stream.below(_HEADINGS) * (2.0 * math.pi / _HEADINGS)
    try:
        world = World(
            np.ascontiguousarray(cells == _WALL),
            start=Pose(*_middle(cells == _START, side), heading),
            target=Target(*_middle(cells == _TARGET, side), round(side / 2, 4)),
            cell_size=side,
            robot_radius=cast("float", values.get("robot_radius", DEFAULT_ROBOT_RADIUS)),
            robot_speed=float(cast("float", values.get("robot_speed", DEFAULT_ROBOT_SPEED))),
        )
        overrides = overrides_in(values)
        if overrides.given():
            world = with_room(world, overrides.applied_to_robot(world.robots[0]))
            world = with_chosen_waypoints(world, overrides)
        decision = decide(world, cut=False)
    except (InvalidWorld, InvalidParameter):
        return None
    is_reachable = decision.result == REACHABLE
    return replace(world, certificate=decision.certificate) if is_reachable else None


def _middle(place: Bools, side: float) -> tuple[float, float]:
    """Return x and y of the centre of the only marked cell, m."""
    row, column = np.argwhere(place)[0].tolist()
    return round((column + 0.5) * side, 6), round((row + 0.5) * side, 6)


def _arena(stream: RandomStream, cells: int) -> tuple[Bools, Place, Place]:
    """Return an empty arena with a start near its left and a target near its right side."""
    rows = stream.between(7, 11)
    walls = np.zeros((rows, cells + 3), bool)
    start = (stream.between(1, rows - 2), 1)
    target = (stream.between(1, rows - 2), cells + 1)
    return walls, start, target


def _across(stream: RandomStream, walls: Bools) -> slice:
    """Return the columns of a wall across the middle of an arena."""
    thickness = stream.between(1, 2)
    middle = walls.shape[1] // 2 + stream.between(-1, 1)
    return slice(middle, middle + thickness)


def _opening(stream: RandomStream, rows: int, width: int) -> slice:
    """Return rows of an opening; half of the openings are at an end, where a wall leads to them."""
    first = stream.between(0, rows - width)
    if stream.below(2):
        first = stream.choice((0, rows - width))
    return slice(first, first + width)


def _near(stream: RandomStream, cells: int) -> Scene:
    """Return a target close to the start, and perhaps close to a wall."""
    rows = stream.between(5, 8)
    walls = np.zeros((rows, stream.between(6, 8 + cells // 8)), bool)
    start, target = (
        (stream.between(1, rows - 2), stream.between(1, walls.shape[1] - 2)) for _ in range(2)
    )
    if start == target:
        target = (start[0], start[1] % (walls.shape[1] - 2) + 1)
    return Scene(walls, start, target)


def _door(stream: RandomStream, cells: int) -> Scene:
    """Return a room with a wall across, and a door in it."""
    walls, start, target = _arena(stream, cells)
    wall = _across(stream, walls)
    walls[:, wall] = True
    walls[_opening(stream, len(walls), stream.between(2, 4)), wall] = False
    return Scene(walls, start, target)


def _gap(stream: RandomStream, cells: int) -> Scene:
    """Return a room with a wall across, and a tight gap of two cells in it."""
    walls, start, target = _arena(stream, cells)
    wall = _across(stream, walls)
    walls[:, wall] = True
    walls[_opening(stream, len(walls), 2), wall] = False
    return Scene(walls, start, target, stream.choice(_TIGHT))


def _cup(stream: RandomStream, cells: int) -> Scene:
    """Return a cup in the way, open towards the start, which is sometimes inside of it."""
    walls, start, target = _arena(stream, cells)
    rows = len(walls)
    mouth = stream.between(2, max(rows - 6, 2))
    depth = stream.between(1, 4)
    top = stream.between(2, max(rows - mouth - 3, 2))
    back = min(max(walls.shape[1] // 2 + stream.between(-1, 2), depth + 3), cells - 1)
    walls[top - 1 : top + mouth + 1, back] = True
    walls[[top - 1, min(top + mouth, rows - 1)], back - depth : back] = True
    if stream.below(2):
        start = (top + mouth // 2, back - 2)
        target = (stream.between(top, top + mouth - 1), target[1])
    walls[start] = False
    return Scene(walls, start, target)


def _corner(stream: RandomStream, cells: int) -> Scene:
    """Return a passage around a corner."""
    width = stream.between(3, 4)
    leg = max(cells // 2, 2) + width
    walls = np.ones((leg, leg), bool)
    walls[:width, :] = False
    walls[:, leg - width :] = False
    row = stream.between(1, width - 2)
    column = leg - 1 - stream.between(1, width - 2)
    return Scene(walls, (row, 1), (leg - 2, column))


def _slot(stream: RandomStream, cells: int) -> Scene:
    """Return a target at the end of a slot of two cells."""
    walls, start, _ = _arena(stream, cells)
    depth = stream.between(2, 4)
    walls[:, -depth:] = True
    rows = _opening(stream, len(walls), 2)
    walls[rows, -depth:] = False
    target = (rows.start + stream.below(2), walls.shape[1] - 1)
    return Scene(walls, start, target, stream.choice(_TIGHT))


def _island(stream: RandomStream, cells: int) -> Scene:
    """Return a block in the way."""
    walls, start, target = _arena(stream, cells)
    rows = len(walls)
    high = stream.between(1, rows - 4)
    long = stream.between(1, max(cells - 5, 1))
    top = stream.between(2, rows - high - 2)
    left = stream.between(3, max(cells - long, 3))
    walls[top : top + high, left : left + long] = True
    # Start and target are level with it, so that the straight way is blocked.
    start = (top + stream.below(high), 1)
    target = (top + stream.below(high), target[1])
    walls[target] = False
    return Scene(walls, start, target)


def _baffles(stream: RandomStream, cells: int) -> Scene:
    """Return two walls to go around, from opposite sides."""
    walls, start, target = _arena(stream, cells)
    rows = len(walls)
    room = stream.between(2, 3)
    first = max(walls.shape[1] // 3, 3)
    second = max(2 * walls.shape[1] // 3, first + 3)
    walls[: rows - room, first] = True
    walls[room:, min(second, walls.shape[1] - 2)] = True
    return Scene(walls, start, target)


def _posts(stream: RandomStream, cells: int) -> Scene:
    """Return some posts of one cell."""
    walls, start, target = _arena(stream, cells)
    for _ in range(stream.between(1, max(cells // 2, 2))):
        walls[stream.below(len(walls)), stream.between(3, walls.shape[1] - 4)] = True
    return Scene(walls, start, target)


SCENES: tuple[Build, ...] = (_near, _door, _cup, _corner, _gap, _island, _slot, _baffles, _posts)
