"""Turn what the core recorded of a run into a trace in metres and radians."""

from __future__ import annotations

import math

import numpy as np

from sim._core import ffi
from sim.options.run import TARGET, RunOptions
from sim.runners.core_calls import STATE_WORDS
from sim.runners.packing import STEP_TIME
from sim.trace import Trace
from worldgen.lattice import TURN, UNIT, exact, lattice_to_metres
from worldgen.support.arrays import Floats, Ints, Words
from worldgen.world import World

# Columns of a recorded row: whether a wall was touched, then the state. Next, the same for a point
# of the path.
_BUMP = 0
FIRST_OF_STATE = 1
_HEADING = 2  # index in a state, after x and y
_POINT_STEP, _POINT_TIME, _POINT_X, _POINT_Y, _POINT_HEADING = range(5)
POINT_FIELDS = 4
# Words of a WgCarriage.
_OF_A_CAR = ffi.sizeof("WgCarriage") // 8
_OF_A_BODY = 2


def trace_of(
    world: World,
    options: RunOptions,
    rows: Ints,
    path: Ints,
    *,
    complete: bool,
    lean: bool = False,
    passed: Ints | None = None,
) -> Trace:
    """Return a recording in metres and radians.

    Args:
        world: The world that the robot drove in.
        options: Options of the run.
        rows: (n + 1, 1 + w) the start and each step: whether a wall was touched, then the state.
        path: (p, 4) points of the path: step, time within it in 1 / ``STEP_TIME``, x and y. For a
            body or a car, (p, 5): and the heading on the way to it.
        complete: Whether the state alone decides the future.
        lean: Whether the states lack the controller's memory.
        passed: (n + 1,) the waypoints that the robot has arrived at after each step, if the states
            lack them.
    """
    states = rows[:, FIRST_OF_STATE:]
    side = world.cell_size
    way = _with_stands(rows, path)
    has_headings = path.shape[1] > POINT_FIELDS
    after_memory = 0
    if not lean and has_headings:
        after_memory = _OF_A_CAR if world.robots[0].drive.is_car else _OF_A_BODY
    if not lean and has_waypoints(world, options):
        after_memory += 1
        passed = states[:, -after_memory].copy()
    return Trace(
        time_step=options.time_step,
        x=_metres(states[:, 0], side),
        y=_metres(states[:, 1], side),
        heading=_radians(states[:, _HEADING]),
        bump=rows[:, _BUMP] != 0,
        path_x=_metres(way[:, _POINT_X], side),
        path_y=_metres(way[:, _POINT_Y], side),
        path_step=way[:, _POINT_STEP].copy(),
        path_share=way[:, _POINT_TIME] / STEP_TIME,
        words=np.zeros(0, np.uint64) if lean else _words(rows, path),
        states=np.ascontiguousarray(states).view(np.uint64),
        complete=complete and not lean,
        memory_at=-1 if lean else STATE_WORDS,
        after_memory=after_memory,
        path_heading=_radians(way[:, _POINT_HEADING]) if has_headings else np.zeros(0),
        robot=options.robot,
        task=options.task,
        passed=np.zeros(0, np.int64) if passed is None else passed,
    )


def has_waypoints(world: World, options: RunOptions) -> bool:
    """Return True if a run's state counts waypoints, which only a robot with a target has."""
    return options.task == TARGET and bool(world.robots[0].waypoints)


def _with_stands(rows: Ints, path: Ints) -> Ints:
    """Return the path with a point added at the end of each step in which the robot stopped."""
    last = np.zeros(len(rows), np.int64)
    np.maximum.at(last, path[:, _POINT_STEP], path[:, _POINT_TIME])
    last[0] = -1  # Reserve a point for the start too.
    stands = np.flatnonzero(last < STEP_TIME)
    ends = np.zeros((len(stands), path.shape[1]), np.int64)
    ends[:, _POINT_STEP] = stands
    ends[:, _POINT_TIME] = np.where(stands > 0, STEP_TIME, 0)
    ends[:, _POINT_X] = rows[stands, FIRST_OF_STATE]
    ends[:, _POINT_Y] = rows[stands, FIRST_OF_STATE + 1]
    whole = np.concatenate([path, ends])
    if path.shape[1] > POINT_FIELDS:
        # It stands at the heading of the last move of the step, or as it was before the step.
        moved = np.searchsorted(path[:, _POINT_STEP], stands, side="right") - 1
        before = rows[np.maximum(stands - 1, 0), FIRST_OF_STATE + _HEADING]
        has_moved = (moved >= 0) & (path[moved, _POINT_STEP] == stands) if len(path) else False
        last_heading = path[moved, _POINT_HEADING] if len(path) else before
        whole[len(path) :, _POINT_HEADING] = np.where(has_moved, last_heading, before)
    return whole[np.lexsort((whole[:, _POINT_TIME], whole[:, _POINT_STEP]))]


def _words(rows: Ints, path: Ints) -> Words:
    """Return the words of the digest: for each step its contact, path points and final state."""
    # Sort the pieces of all steps into their order in the digest, and find where each one begins.
    steps = np.concatenate([np.arange(1, len(rows)), path[:, _POINT_STEP], np.arange(1, len(rows))])
    kinds = np.repeat([0, 1, 2], [len(rows) - 1, len(path), len(rows) - 1])
    order = np.lexsort((np.arange(len(steps)), kinds, steps))
    width = np.array([1, 3, rows.shape[1] - 1])[kinds]
    starts = np.zeros(len(steps) + 1, np.int64)
    starts[1:] = np.cumsum(width[order])
    places = np.empty(len(steps), np.int64)
    places[order] = starts[:-1]
    words = np.empty(starts[-1], np.int64)

    # Write the pieces there, one column at a time.
    words[places[kinds == 0]] = rows[1:, _BUMP]
    for k, column in enumerate((_POINT_X, _POINT_Y, _POINT_TIME)):
        words[places[kinds == 1] + k] = path[:, column]
    for k in range(rows.shape[1] - 1):
        words[places[kinds == 2] + k] = rows[1:, FIRST_OF_STATE + k]
    return words.view(np.uint64)


def _radians(units: Ints) -> Floats:
    """Return headings in (-pi, pi]."""
    signed = np.where(units > TURN // 2, units - TURN, units)
    return signed * (2.0 * math.pi / TURN)


def _metres(units: Ints, cell_size: float) -> Floats:
    """Return lattice units in metres, correctly rounded, so that short decimals stay short."""
    ratio = exact(cell_size) / UNIT
    if int(np.abs(units).max(initial=0)) * ratio.numerator < 2**53 and ratio.denominator < 2**53:
        # Numerator and denominator are exact here, so this division rounds only once.
        return (units * ratio.numerator) / float(ratio.denominator)
    return np.array([lattice_to_metres(unit, cell_size) for unit in units.tolist()])
