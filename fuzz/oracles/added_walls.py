"""Add walls to a world where neither its witness nor, as far as possible, a given run needs space.

The metamorphic oracles ``wall`` and ``block`` compare the run with one in the resulting world.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy import ndimage

from fuzz.oracles.trial import Trial
from sim.controllers import CONTROLLERS
from sim.runners.lattice import LatticeRun
from worldgen.errors import InvalidParameter
from worldgen.reach import check_certificate
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# Number of cells beyond the reach of a step and the disc: a slide or a back-off may begin at the
# step's end.
_SPARE = 2
# Cells around a wall in which the thesis's noise filter changes the signal.
_FILTER_REACH = 2
# States whose senses are computed together, to bound memory.
_STATES_AT_ONCE = 256


def walled_where_unnoticed(trial: Trial) -> World | None:
    """Return the world with as many walls as possible that the robot can neither touch nor sense.

    A cell stays free if the witness's disc passes through it, or if it is so near the run that a
    step, the disc and the signal sensor could reach it. Beams, and a signal that walls block, can
    reach farther. For these, each state of the run is sensed again between the new walls; if any
    reading changes, the nearer half of the new walls is dropped and the rest is tried again.

    Returns:
        ``None`` if no cell remains, if the world changes over time, or if the run is too long to be
        recorded.

    Raises:
        InvalidParameter: If walls block the signal under ``stepped``, where every wall may affect
            it.
    """
    world = trial.world
    trace = trial.trace
    if trace is None or len(world.timeline):
        return None
    # Candidate cells, nearest to the run first.
    away = _distance(world, trace.x, trace.y)
    unneeded = _unneeded(trial) & (away > _reach(trial))
    places = np.argwhere(unneeded)
    places = places[np.argsort(away[unneeded], kind="stable")]
    if not trial.options.motion_model().on_lattice:
        return _with_walls(trial, places)
    # Under `stepped` the distance alone is enough; otherwise compare what the robot senses.
    run = _far_sighted(trial, world)
    states = np.unique(trace.states[1:, :3].view(np.int64), axis=0)
    while len(places):
        candidate = _with_walls(trial, places)
        if candidate and _senses_alike(run, _far_sighted(trial, candidate), states):
            return candidate
        places = places[(len(places) + 1) // 2 :]
    return None


def with_a_block_near_the_path(trial: Trial) -> World | None:
    """Return the world with one more wall cell, next to a wall and as near to the run as possible.

    Returns:
        ``None`` if the witness leaves no such cell, or if the world changes over time.
    """
    world = trial.world
    trace = trial.trace
    if trace is None or len(world.timeline):
        return None
    next_to_wall = ndimage.binary_dilation(world.walls) & _unneeded(trial)
    places = np.argwhere(next_to_wall)
    away = _distance(world, trace.x, trace.y)[next_to_wall]
    return _with_walls(trial, places[np.argsort(away, kind="stable")][:1])


def _with_walls(trial: Trial, places: Ints) -> World | None:
    """Return the world with walls at these (iy, ix).

    ``None`` if there are none, or if the witness no longer holds.
    """
    walls = trial.world.walls.copy()
    walls[places[:, 0], places[:, 1]] = True
    world = replace(trial.world, walls=walls, failure=None)
    return world if len(places) and check_certificate(world).valid else None


def _unneeded(trial: Trial) -> Bools:
    """Return the free cells that neither the border, start, target nor the witness's disc needs."""
    world = trial.world
    witness = trial.witness
    free = ~world.walls
    free[[0, -1], :] = free[:, [0, -1]] = False
    if witness is None:
        return np.zeros_like(free)
    # Sample the witness finely enough, in s, that no sample skips a cell and its neighbours.
    pause = 0.5 * world.cell_size / world.robot_speed
    times = np.append(np.arange(0.0, witness.times[-1], pause), witness.times[-1])
    x = np.interp(times, witness.times, witness.x)
    y = np.interp(times, witness.times, witness.y)
    needed = _distance(world, x, y) <= math.ceil(world.robot_radius / world.cell_size) + 1
    goals = np.array(world.robots[0].places[1:])
    needed |= _distance(world, *goals.T) == 0
    return free & ~needed


def _distance(world: World, x: Floats, y: Floats) -> Ints:
    """Return (height, width) chessboard distances, in cells, to the nearest of the places."""
    elsewhere = np.ones(world.walls.shape, bool)
    ix = (x // world.cell_size).astype(np.int64)
    iy = (y // world.cell_size).astype(np.int64)
    elsewhere[np.clip(iy, 0, world.height - 1), np.clip(ix, 0, world.width - 1)] = False
    distance: Ints = ndimage.distance_transform_cdt(elsewhere, "chessboard").astype(np.int64)
    return distance


def _reach(trial: Trial) -> int:
    """Return the distance, in cells, at which a wall can affect the robot in its next step."""
    world = trial.world
    options = trial.options
    touch = math.ceil(
        (world.robot_radius + world.robot_speed * options.time_step) / world.cell_size
    )
    if options.motion_model().on_lattice:
        return max(touch, options.robot.sensor_cells) + _SPARE
    if options.thesis.signal != "open":
        raise InvalidParameter(
            "signal-everywhere",
            "oracle wall: under stepped, signal={signal} is sensed through the whole world, so no "
            "wall is far enough",
            "run it without that signal, or with --motion swept",
            at_terminal=True,
            signal=options.thesis.signal,
        )
    return (
        max(touch, options.thesis.sensor_cells + _FILTER_REACH + options.thesis.map_scale) + _SPARE
    )


def _far_sighted(trial: Trial, world: World) -> LatticeRun:
    """Return the run to sense with, without noise, which could hide that a wall was seen."""
    clear = replace(trial.options.robot, sensor_noise=0.0, beam_noise=0.0, beam_dropout=0.0)
    return LatticeRun(world, CONTROLLERS.get(trial.controller), replace(trial.options, robot=clear))


def _senses_alike(one: LatticeRun, other: LatticeRun, states: Ints) -> bool:
    """Return True if the robot senses the same walls in every state."""
    parts: Iterator[Ints] = (
        states[k : k + _STATES_AT_ONCE] for k in range(0, len(states), _STATES_AT_ONCE)
    )
    return all(
        np.array_equal(one.sensed_of_walls(part), other.sensed_of_walls(part)) for part in parts
    )
