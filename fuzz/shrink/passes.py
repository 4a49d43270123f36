"""Shrinking passes: each proposes edits that make a failure simpler, the boldest first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from fuzz.shrink.edits import with_robots
from fuzz.simplicity import Case, rounder
from sim.options.run import DEFAULT_TIME_STEP
from sim.runners.edited import CellEdit, EditKind
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.lattice import UNIT, cell_middle, in_cells, lattice_to_metres, metres_to_lattice
from worldgen.world import DEFAULT_ROBOT_RADIUS, DEFAULT_ROBOT_SPEED, Robot, World

Attempt = Callable[[], "Case | None"]
"""Makes one simpler case, or ``None`` if there is nothing to do."""

Edit = CellEdit | Attempt


class Pass(NamedTuple):
    """One kind of simplification.

    Args:
        name: Name in the list of ``worldgen shrink --passes``.
        says: One line that describes it.
        propose: Yields the edits of a case; called again whenever one is taken.
    """

    name: str
    says: str
    propose: Callable[[Case], Iterator[Edit]]


def _drop_robots(case: Case) -> Iterator[Edit]:
    robots = case.world.robots
    for count in _halves(len(robots)):
        for first in range(len(robots) - count, -1, -count):
            kept = (*robots[:first], *robots[first + count :])
            yield partial(_robots, case, kept)


def _drop_waypoints(case: Case) -> Iterator[Edit]:
    for index, robot in enumerate(case.world.robots):
        goals = robot.waypoints
        for count in [len(goals), *_halves(len(goals))]:
            for first in range(len(goals) - count, -1, -max(count, 1)):
                kept = (*goals[:first], *goals[first + count :])
                yield partial(_robot, case, index, waypoints=kept)


def _drop_rows(case: Case) -> Iterator[Edit]:
    world = case.world
    places = [y for one in world.robots for _, y in one.places]
    yield from (
        CellEdit(EditKind.DROP_ROWS, first, count)
        for first, count in _runs(world, places, world.height)
    )


def _drop_columns(case: Case) -> Iterator[Edit]:
    world = case.world
    places = [x for one in world.robots for x, _ in one.places]
    yield from (
        CellEdit(EditKind.DROP_COLUMNS, first, count)
        for first, count in _runs(world, places, world.width)
    )


def _runs(world: World, places: Sequence[float], size: int) -> Iterator[tuple[int, int]]:
    """Yield runs of rows or columns, from the longest to single ones.

    First comes everything beyond or between starts and targets, then halves of the grid, quarters,
    and so on.
    """
    cells = [math.floor(in_cells(place, world.cell_size)) for place in places]
    low = min(cells)
    high = max(cells)
    spans = ((high + 1, size), (low + 1, high), (0, low))
    yield from ((first, end - first) for first, end in spans if end - first > 1)
    for count in _halves(size):
        yield from ((first, count) for first in range(size - count, -1, -max(count // 2, 1)))


def _free_all(case: Case) -> Iterator[Edit]:
    yield CellEdit(EditKind.FREE_BOX, 0, 0, case.world.width, case.world.height)


def _free_rim(case: Case) -> Iterator[Edit]:
    yield CellEdit(EditKind.FREE_RIM)


def _free_blocks(case: Case) -> Iterator[Edit]:
    walls = case.world.walls
    side = 1
    while side * 2 <= max(walls.shape):
        side *= 2
    while side > 1:
        for iy in range(0, walls.shape[0], side):
            for ix in range(0, walls.shape[1], side):
                if walls[iy : iy + side, ix : ix + side].any():
                    yield CellEdit(EditKind.FREE_BOX, ix, iy, side, side)
        side //= 2


def _free_cells(case: Case) -> Iterator[Edit]:
    yield from (CellEdit(EditKind.FREE_RUN, first, 1) for first in range(case.world.solid_cells))


def _drop_events(case: Case) -> Iterator[Edit]:
    events = len(case.world.timeline)
    for count in [events, *_halves(events)]:
        for first in range(0, events, max(count, 1)):
            yield partial(_without_events, case, first, count)


def _straighten(case: Case) -> Iterator[Edit]:
    for index, robot in enumerate(case.world.robots):
        start = robot.start
        for part in (math.pi / 2, math.pi / 4, math.pi / 8):
            for turns in (math.floor(start.heading / part), math.ceil(start.heading / part)):
                yield partial(_robot, case, index, start=replace(start, heading=turns * part))


def _centre(case: Case) -> Iterator[Edit]:
    side = case.world.cell_size
    for index, robot in enumerate(case.world.robots):
        for name in ("start", "target"):
            point = getattr(robot, name)
            x, y = (
                cell_middle(math.floor(in_cells(place, side)), side) for place in (point.x, point.y)
            )
            for where in ({"x": x, "y": y}, {"x": x}, {"y": y}):
                yield partial(_robot, case, index, **{name: replace(point, **where)})
        for number, goal in enumerate(robot.waypoints):
            x, y = (
                cell_middle(math.floor(in_cells(place, side)), side) for place in (goal.x, goal.y)
            )
            yield partial(_waypoint, case, index, number, x=x, y=y)


def _approach(case: Case) -> Iterator[Edit]:
    side = case.world.cell_size
    for index, robot in enumerate(case.world.robots):
        start = robot.start
        across, up = (
            math.floor(in_cells(b, side)) - math.floor(in_cells(a, side))
            for a, b in ((start.x, robot.goals[0].x), (start.y, robot.goals[0].y))
        )
        # Try large moves first: half of the way, then all along one axis, then a single cell.
        moves = [(across // 2, up // 2), (across, 0), (0, up), (_one(across), 0), (0, _one(up))]
        for dx, dy in dict.fromkeys(move for move in moves if move != (0, 0)):
            x = _shifted(start.x, dx, side)
            y = _shifted(start.y, dy, side)
            yield partial(_robot, case, index, start=replace(start, x=x, y=y))


def _simplify_robot(case: Case) -> Iterator[Edit]:
    for index, robot in enumerate(case.world.robots):
        for radius in rounder(robot.radius, DEFAULT_ROBOT_RADIUS):
            yield partial(_robot, case, index, radius=radius)
        for speed in rounder(robot.speed, DEFAULT_ROBOT_SPEED):
            yield partial(_robot, case, index, speed=speed)


def _simplify_target(case: Case) -> Iterator[Edit]:
    for index, robot in enumerate(case.world.robots):
        for radius in rounder(robot.target.radius, case.world.cell_size / 2):
            yield partial(_robot, case, index, target=replace(robot.target, radius=radius))
        for number, goal in enumerate(robot.waypoints):
            for radius in rounder(goal.radius, case.world.cell_size / 2):
                yield partial(_waypoint, case, index, number, radius=radius)


def _simplify_run(case: Case) -> Iterator[Edit]:
    scenario = case.scenario
    for step in rounder(scenario.run.time_step, DEFAULT_TIME_STEP):
        yield partial(_time_step, case, step)
    for name, value in scenario.run.changed().items():
        if isinstance(value, float):
            for number in rounder(value):
                # 0 switches an option off, which makes it a different robot.
                if number != 0.0:
                    yield partial(_option, case, name, number)


def _round_times(case: Case) -> Iterator[Edit]:
    for number, event in enumerate(case.world.timeline):
        if event.time > 0.0:
            for earlier in rounder(event.time, up=False):
                yield partial(_earlier, case, number, earlier)


PASSES: tuple[Pass, ...] = (
    Pass("drop-robots", "drop robots: half of them, a quarter, ... one", _drop_robots),
    Pass("drop-waypoints", "drop waypoints: all, half of them, ... one", _drop_waypoints),
    Pass(
        "drop-rows",
        "drop rows: all outside or between start and goals, then half of the grid, a quarter, "
        "... one",
        _drop_rows,
    ),
    Pass("drop-columns", "drop columns, in the same order", _drop_columns),
    Pass("free-all", "free every solid cell", _free_all),
    Pass(
        "free-rim",
        "free the outermost ring of cells: everything outside the grid is solid anyway",
        _free_rim,
    ),
    Pass("free-blocks", "free square blocks of cells, from the largest to 2 x 2", _free_blocks),
    Pass("drop-events", "drop events: all, half, ... one", _drop_events),
    Pass("free-cells", "free one solid cell at a time", _free_cells),
    Pass(
        "straighten",
        "turn the start's heading to a multiple of a quarter turn, an eighth, a sixteenth",
        _straighten,
    ),
    Pass("centre", "put start and goals in the middle of their cells", _centre),
    Pass("approach", "move the start nearer to the first goal", _approach),
    Pass(
        "simplify-robot",
        "give the robot the usual radius and speed, or values with fewer digits",
        _simplify_robot,
    ),
    Pass(
        "simplify-target",
        "give the goals a radius of half a cell, or a value with fewer digits",
        _simplify_target,
    ),
    Pass(
        "simplify-run", "give the time step and the options values with fewer digits", _simplify_run
    ),
    Pass("round-times", "move events to earlier times with fewer digits, ideally 0", _round_times),
)
"""The passes in order; they are repeated until a whole round changes nothing."""


def _halves(count: int) -> list[int]:
    sizes = []
    while count > 1:
        count //= 2
        sizes.append(count)
    return sizes


def _one(cells: int) -> int:
    return (cells > 0) - (cells < 0)


def _shifted(place: float, cells: int, side: float) -> float:
    return lattice_to_metres(metres_to_lattice(place, side) + cells * UNIT, side)


def _with(case: Case, world: World | None) -> Case | None:
    return None if world is None else case._replace(world=world)


def _without_events(case: Case, first: int, count: int) -> Case | None:
    return _with(case, replace(case.world, timeline=case.world.timeline.without(first, count)))


def _earlier(case: Case, event: int, time: float) -> Case | None:
    try:
        timeline = case.world.timeline.with_time(event, time)
    except InvalidWorld:  # the events would no longer be in order
        return None
    return _with(case, replace(case.world, timeline=timeline))


def _robots(case: Case, robots: Sequence[Robot]) -> Case | None:
    return _with(case, with_robots(case.world, robots))


def _robot(case: Case, index: int, **parts: Any) -> Case | None:
    """Return the case with some parts of one robot replaced."""
    robots = list(case.world.robots)
    robots[index] = replace(robots[index], **parts)
    return _robots(case, robots)


def _waypoint(case: Case, index: int, number: int, **parts: float) -> Case | None:
    """Return the case with some parts of one waypoint replaced."""
    goals = list(case.world.robots[index].waypoints)
    changes: dict[str, Any] = dict(parts)
    goals[number] = replace(goals[number], **changes)
    return _robot(case, index, waypoints=tuple(goals))


def _time_step(case: Case, time_step: float) -> Case | None:
    return case._replace(scenario=case.scenario.with_run(time_step=time_step))


def _option(case: Case, name: str, value: float) -> Case | None:
    try:
        return case._replace(scenario=case.scenario.with_option(name, value))
    except InvalidParameter:  # out of the option's range
        return None
