"""Worlds with more wall than another one, where nothing needs the room.

Which cells hangs on the world and the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from fuzz.oracles.trial import Trial
from sim.controllers import CONTROLLERS
from sim.motion.base import THESIS
from sim.runners.lattice import LatticeRun
from worldgen.errors import InvalidParameter
from worldgen.reach import check_certificate
from worldgen.world import World

__all__ = ["walled_where_unnoticed", "with_a_block_beside_the_way"]

Cells = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

_SPARE = (
    2  # cells more than a step and the disc reach: a slide or a back-off may begin at a step's end
)
_FILTER_REACH = 2  # cells round a wall in which the thesis's noise filter changes the signal
_STATES_AT_ONCE = 256


def walled_where_unnoticed(trial: Trial) -> World | None:
    """The world with as much wall more as the robot, in its run, can neither have touched nor sensed.

    Cells stay free that come as near to the run as a step, the disc and the signal sensor's cells
    reach together, or through which the witness's disc passes. For senses that look further, beams
    and a signal that walls hold up, each state of the run is sensed again between the new walls:
        where that gives anything else, the nearer half goes.

    Returns:
        ``None`` if no cell is left, for a world that changes, and for a run too long to be
        recorded.

    Raises:
        InvalidParameter: If walls hold up the signal under ``stepped``, where all of them may
            count.
    """
    world = trial.world
    trace = trial.trace
    if trace is None or len(world.timeline):
        return None
    away = _distance(world, trace.x, trace.y)
    unneeded = _unneeded(trial) & (away > _reach(trial))
    places = np.argwhere(unneeded)
    places = places[np.argsort(away[unneeded], kind="stable")]
    if trial.options.motion_model().kernel == THESIS:
        return _with_walls(trial, places)
    run = _far_sighted(trial, world)
    states = np.unique(trace.states[1:, :3].view(np.int64), axis=0)
    while len(places):
        candidate = _with_walls(trial, places)
        if candidate and _senses_alike(run, _far_sighted(trial, candidate), states):
            return candidate
        places = places[(len(places) + 1) // 2 :]
    return None


def with_a_block_beside_the_way(trial: Trial) -> World | None:
    """The world with one cell of wall more, beside a wall.

    As near to the robot's run as the witness allows.

    Returns:
        ``None`` if there is no such cell, and for a world that changes.
    """
    world = trial.world
    trace = trial.trace
    if trace is None or len(world.timeline):
        return None
    beside = ndimage.binary_dilation(world.walls) & _unneeded(trial)
    places = np.argwhere(beside)
    away = _distance(world, trace.x, trace.y)[beside]
    return _with_walls(trial, places[np.argsort(away, kind="stable")][:1])


def _with_walls(trial: Trial, places: Ints) -> World | None:
    """The world with walls at these (iy, ix).

    ``None`` if there are none, or the witness does not hold among them.
    """
    walls = trial.world.walls.copy()
    walls[places[:, 0], places[:, 1]] = True
    world = replace(trial.world, walls=walls, failure=None)
    return world if len(places) and check_certificate(world).valid else None


def _unneeded(trial: Trial) -> Cells:
    """Free cells but for the border, the target's, those near the start, and those that the witness's disc passes."""
    world = trial.world
    witness = trial.witness
    free = ~world.walls
    free[[0, -1], :] = free[:, [0, -1]] = False
    if witness is None:
        return np.zeros_like(free)
    pause = (
        0.5 * world.cell_size / world.robot_speed
    )  # s, in which nobody leaves a cell and its neighbours
    times = np.append(np.arange(0.0, witness.times[-1], pause), witness.times[-1])
    x = np.interp(times, witness.times, witness.x)
    y = np.interp(times, witness.times, witness.y)
    needed = _distance(world, x, y) <= math.ceil(world.robot_radius / world.cell_size) + 1
    needed |= _distance(world, np.array([world.target.x]), np.array([world.target.y])) == 0
    return free & ~needed


def _distance(world: World, x: Floats, y: Floats) -> Ints:
    """(height, width) cells between each cell and the nearest of the places, straight and diagonal alike."""
    elsewhere = np.ones(world.walls.shape, bool)
    ix = (x // world.cell_size).astype(np.int64)
    iy = (y // world.cell_size).astype(np.int64)
    elsewhere[np.clip(iy, 0, world.height - 1), np.clip(ix, 0, world.width - 1)] = False
    distance: Ints = ndimage.distance_transform_cdt(elsewhere, "chessboard").astype(np.int64)
    return distance


def _reach(trial: Trial) -> int:
    """Cells from the robot's own beyond which no wall matters to its next step, nor to the signal around it."""
    world = trial.world
    options = trial.options
    touch = math.ceil(
        (world.robot_radius + world.robot_speed * options.time_step) / world.cell_size
    )
    if options.motion_model().kernel != THESIS:
        return max(touch, options.robot.sensor_cells) + _SPARE
    if options.thesis.signal != "open":
        raise InvalidParameter(
            "signal-everywhere",
            "oracle wall: under stepped, signal={signal} is sensed through the whole world, so no "
            "wall is far enough",
            "ask it without, or with --motion swept",
            at_terminal=True,
            signal=options.thesis.signal,
        )
    return (
        max(touch, options.thesis.sensor_cells + _FILTER_REACH + options.thesis.map_scale) + _SPARE
    )


def _far_sighted(trial: Trial, world: World) -> LatticeRun:
    """The run, to sense with: whatever noise hides, a wall must not be seen."""
    clear = replace(trial.options.robot, sensor_noise=0.0, beam_noise=0.0, beam_dropout=0.0)
    return LatticeRun(world, CONTROLLERS.get(trial.controller), replace(trial.options, robot=clear))


def _senses_alike(one: LatticeRun, other: LatticeRun, states: Ints) -> bool:
    """Whether walls give the robot the same to sense in every state."""
    parts: Iterator[Ints] = (
        states[k : k + _STATES_AT_ONCE] for k in range(0, len(states), _STATES_AT_ONCE)
    )
    return all(
        np.array_equal(one.sensed_of_walls(part), other.sensed_of_walls(part)) for part in parts
    )
