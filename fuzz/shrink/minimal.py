"""Check that a shrunk world is 1-minimal, with plain code that no shrinking pass uses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.lattice import exact
from worldgen.timeline import Timeline
from worldgen.world import Robot, World


def removable(world: World, still_fails: Callable[[World], World | None]) -> list[str]:
    """Return everything that could still be removed: a robot, a waypoint, a solid cell, a line.

    Args:
        world: A shrunk world.
        still_fails: Returns the candidate with a certificate if it fails with the same verdict.

    Returns:
        A description of each part that can be removed; empty for a 1-minimal world.
    """
    return [name for name, _ in removed(world, still_fails)]


def removed(
    world: World, still_fails: Callable[[World], World | None]
) -> Iterator[tuple[str, World]]:
    """Yield each part that could still be removed, with the certified world that is left."""
    for name, candidate in _neighbours(world.bare):
        left = None if candidate is None else still_fails(candidate)
        if left is not None:
            yield name, left


def _neighbours(world: World) -> Iterator[tuple[str, World | None]]:
    robots = list(world.robots)
    if world.is_fleet:
        for index in range(len(robots)):
            yield f"robot {index + 1}", _changed(world, robots[:index] + robots[index + 1 :])
    for index, robot in enumerate(robots):
        for number in range(len(robot.waypoints)):
            kept = [goal for k, goal in enumerate(robot.waypoints) if k != number]
            fewer = [*robots[:index], replace(robot, waypoints=tuple(kept)), *robots[index + 1 :]]
            yield f"waypoint {number + 1} of robot {index + 1}", _changed(world, fewer)
    for iy, ix in np.argwhere(world.walls).tolist():
        walls = world.walls.copy()
        walls[iy, ix] = False
        yield f"cell ({ix}, {iy})", replace(world, walls=walls)
    for row in range(world.height):
        yield f"row {row}", _without_line(world, row, by_row=True)
    for column in range(world.width):
        yield f"column {column}", _without_line(world, column, by_row=False)


def _without_line(world: World, line: int, *, by_row: bool) -> World | None:
    """Return the world without a row or column; everything beyond it moves back by a cell."""
    # Keep the other lines, of which there must be one.
    kept = [other for other in range(world.height if by_row else world.width) if other != line]
    if not kept:
        return None

    side = exact(world.cell_size)

    # A point within the removed cells stays where it is.
    def moved(metres: float) -> float:
        cells = exact(metres) / side
        return float((cells - 1) * side) if cells >= line + 1 else metres

    # Move what is beyond the line: starts and targets, then the changes of cells.
    robots = []
    for one in world.robots:
        if by_row:
            start = replace(one.start, y=moved(one.start.y))
            *goals, target = [replace(goal, y=moved(goal.y)) for goal in one.goals]
        else:
            start = replace(one.start, x=moved(one.start.x))
            *goals, target = [replace(goal, x=moved(goal.x)) for goal in one.goals]
        robots.append(replace(one, start=start, target=target, waypoints=tuple(goals)))

    events = []
    for event in world.timeline:
        at = event.iy if by_row else event.ix
        beyond = int(at > line)
        if at != line:
            events.append(
                event._replace(iy=event.iy - beyond)
                if by_row
                else event._replace(ix=event.ix - beyond)
            )
    walls = world.walls[kept] if by_row else world.walls[:, kept]
    return _changed(world, robots, walls=walls, timeline=Timeline.of(events))


def _changed(world: World, robots: Iterable[Robot], **parts: Any) -> World | None:
    """Return the world with other robots and parts; None if a robot is then off the grid."""
    try:
        return replace(world, robots=tuple(robots), **parts)
    except InvalidWorld:
        return None
