"""Whole episodes on the pose lattice: step by step, until there is a verdict."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.lattice_state import Arena, Robot, Room, last_event, set_out
from tests.reference.sim.lattice_step import (
    is_inside,
    load_goal,
    move_and_sense,
    obey,
    one_step,
    remember,
)
from tests.reference.sim.recurrence import TOUCHED, is_proved, period_at

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


_HASH_PRIME = np.uint64(1099511628211)


def _hash(digest: Any, word: int) -> Any:
    return (digest ^ np.uint64(word)) * _HASH_PRIME


def _hash_step(robot: Robot, count: int, bumped: bool) -> None:
    """Adds a step to the digest.

    Whether a wall was touched, the points of its path, the state after it.
    """
    digest = _hash(np.uint64(robot.counts[layout.OUT_DIGEST]), 1 if bumped else 0)
    for k in range(count):
        digest = _hash(
            _hash(_hash(digest, robot.chain[k, 0]), robot.chain[k, 1]), robot.chain[k, 2]
        )
    for k in range(robot.state.size):
        digest = _hash(digest, robot.state[k])
    robot.counts[layout.OUT_DIGEST] = np.int64(digest)


def _write_step(robot: Robot, step: int, count: int, bumped: bool, rows: Ints, path: Ints) -> None:
    """Writes a step into a recording:

    its state, and the points of its path after those of the previous steps.
    """
    rows[step, layout.ROW_BUMP] = 1 if bumped else 0
    for k in range(robot.state.size):
        rows[step, layout.ROW_STATE + k] = robot.state[k]
    first = robot.counts[layout.OUT_POINTS] - count
    for k in range(count):
        path[first + k, layout.POINT_STEP], path[first + k, layout.POINT_TIME] = (
            step,
            robot.chain[k, 2],
        )
        path[first + k, layout.POINT_X], path[first + k, layout.POINT_Y] = (
            robot.chain[k, 0],
            robot.chain[k, 1],
        )


def _period(settings: Ints, room: Room, robot: Robot, step: int, quiet: int) -> int:
    """Returns the steps since the state last occurred, if a recurrence ends the run here.

    Else 0.
    """
    if settings[layout.SET_FIND_LOOP] == layout.SEEK_LOOP:
        return (
            period_at(room.search, robot.state, step, quiet, settings[layout.SET_STEPS])
            if step >= quiet
            else 0
        )
    entry, end = settings[layout.SET_ENTRY], settings[layout.SET_STEPS]
    return end - entry if is_proved(room.search, robot.state, step, entry, end) else 0


def is_over(
    settings: Ints,
    room: Room,
    robot: Robot,
    step: int,
    quiet: int,
    moved: tuple[int, bool],
    rows: Ints,
    path: Ints,
) -> bool:
    """Counts, hashes and records a step; returns whether it was the last one, for any reason.

    Args:
        settings: ``SET_``.
        room: The episode's room.
        robot: The robot after the step.
        step: Its number.
        quiet: Step of the last event.
        moved: Rows of the chain that are filled, and whether a wall was touched.
        rows: Recorded states, or nothing.
        path: Same as above.
    """
    count, bumped = moved
    if bumped and room.search.marks[TOUCHED] == 0:
        robot.counts[layout.OUT_COLLISIONS] += 1
    room.search.marks[TOUCHED] = 1 if bumped else 0
    if settings[layout.SET_DIGEST] != 0:
        _hash_step(robot, count, bumped)
    if step < rows.shape[0]:
        _write_step(robot, step, count, bumped, rows, path)
    if robot.counts[layout.OUT_ENDING] != layout.LIMIT:
        return True
    if settings[layout.SET_FIND_LOOP] != layout.NO_LOOP:
        period = _period(settings, room, robot, step, quiet)
        if period > 0:
            robot.counts[layout.OUT_ENDING], robot.counts[layout.OUT_PERIOD] = layout.LOOP, period
            return True
    return False


def _unvisited(arena: Arena) -> int:
    """How many cells a coverage task requires, except for the start's."""
    return int(((arena.wanted != 0) & (arena.visited == 0)).sum()) if len(arena.wanted) else 0


def lattice_episode(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    room: Room,
    robot: Robot,
    rows: Ints,
    path: Ints,
) -> None:
    """Runs one episode.

    Args:
        arena: Surroundings; ``cells`` must hold the state before the first event, ``visited``
            zeros.
        settings: See :mod:`tests.reference.sim.layout`, ``SET_``.
        scales: ``SCALE_``.
        act: Compiled controller, ``act(observation, memory, command)``.
        memory: Its memory at reset; not changed.
        room: :func:`new_room`, for as many steps if a recurrence is looked for.
        robot: :func:`new_robot`; filled.
        rows: (steps + 1, ROW_STATE + STATE_MEMORY + len(memory)) for a recording, or with 0 rows.
        path: (points, POINT_SIZE) for a recording, with room for all points of the path after the
            start.

    A recurrence of the complete state after the last event is found as described in
    :mod:`tests.reference.sim.recurrence`.
    """
    load_goal(arena, settings, 0)
    robot.journey[:] = 0
    set_out(settings, scales, memory, room, robot, last_event(arena))
    robot.counts[layout.OUT_UNVISITED] = _unvisited(arena)
    if rows.shape[0] > 0:
        for k in range(robot.state.size):
            rows[0, layout.ROW_STATE + k] = robot.state[k]
    quiet, event = last_event(arena), 0
    for step in range(1, settings[layout.SET_STEPS] + 1):
        event, count, bumped = one_step(arena, settings, scales, act, room, robot, step, event)
        if is_over(settings, room, robot, step, quiet, (count, bumped), rows, path):
            break


def lattice_steps(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    memory: Floats,
    room: Room,
    robot: Robot,
    rows: Ints,
    path: Ints,
) -> Iterator[int]:
    """The same for a controller that is not a compiled function: stops whenever it has to act.

    Arguments as for :func:`lattice_episode`. Before it continues, ``room.memory`` and
    ``room.command`` must hold the controller's response to ``room.observation``.

    Yields:
        Number of the step.
    """
    load_goal(arena, settings, 0)
    robot.journey[:] = 0
    set_out(settings, scales, memory, room, robot, last_event(arena))
    robot.counts[layout.OUT_UNVISITED] = _unvisited(arena)
    if rows.shape[0] > 0:
        for k in range(robot.state.size):
            rows[0, layout.ROW_STATE + k] = robot.state[k]
    quiet, event = last_event(arena), 0
    for step in range(1, settings[layout.SET_STEPS] + 1):
        event, count, nx, ny = move_and_sense(arena, settings, scales, room, robot, step, event)
        if robot.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, robot):
            yield step
            obey(settings, scales, room.command, step, robot, arena)
        remember(room, robot)
        if is_over(settings, room, robot, step, quiet, (count, nx != 0.0 or ny != 0.0), rows, path):
            break
