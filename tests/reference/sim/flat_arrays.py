"""The core's arguments, in the flat arrays of the reference."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from sim.runners.core_calls import CoreArena
from tests.reference.sim import lattice_state

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

_SETTINGS = (
    "start_x", "start_y", "start_heading", "target.x", "target.y", "target.radius_sq", "clear_sq", "reach", "motion",
    "steps", "find_loop", "seed", "senses", "digest", "sensor_cells", "signal", "beams", "plain_sensor", "smoke_reach",
    "loop_entry", "disturbed", "measures", "drift_x", "drift_y", "drift_reach", "place_count",
    "target.arrival", "contact",
    "target.has_heading", "target.heading", "target.heading_tolerance", "target.arrival_speed", "target.arrival_turn",
)  # fmt: skip
_SCALES = (
    "metres", "speed", "turn", "radians", "time_step", "top_speed", "tolerance", "start_speed", "turn_limit", "gain",
    "loss", "wall_friction", "slip", "odometry_noise", "sensor_range", "sensor_field", "sensor_noise", "beam_range",
    "beam_field", "beam_noise", "beam_dropout", "radius", "smoke",
)  # fmt: skip
_GOAL = (
    "x", "y", "radius_sq", "arrival", "has_heading", "heading", "heading_tolerance", "arrival_speed", "arrival_turn",
)  # fmt: skip
COUNTS = (
    "ending", "steps", "period", "collisions", "last_new_cell", "points", "digest", "hit_step", "hit_ix", "hit_iy",
    "overlap_step", "overlap_ix", "overlap_iy", "hit_state", "cells_visited", "cells_left", "goals",
)  # fmt: skip


def settings_of(settings: Any) -> tuple[Ints, Floats]:
    """Return a WgSettings as ``SET_`` and ``SCALE_`` of :mod:`tests.reference.sim.layout`."""
    whole = [int(attrgetter(name)(settings)) for name in _SETTINGS]
    ints = np.array([np.uint64(number % 2**64) for number in whole], np.uint64).view(np.int64)
    return ints, np.array([getattr(settings, name) for name in _SCALES], np.float64)


def arena_of(arena: CoreArena, settings: Any) -> lattice_state.Arena:
    """Return an arena for the reference, with the pushes and decoys of a WgSettings."""
    pushes = [settings.pushes[k] for k in range(settings.push_count)]
    decoys = [settings.decoys[k] for k in range(settings.decoy_count)]
    return lattice_state.Arena(
        arena.cells,
        arena.near,
        arena.clearance,
        arena.events,
        arena.headings,
        arena.visited,
        np.array([[p.step, p.ix, p.iy, p.dx, p.dy, p.turn] for p in pushes], np.int64).reshape(
            -1, 6
        ),
        tuple((int(d.x), int(d.y), float(d.strength)) for d in decoys),
        arena.wanted,
        _carriage_of(settings),
        tuple(
            tuple(int(getattr(goal, name)) for name in _GOAL)
            for goal in (*settings.waypoints[0 : settings.waypoint_count], settings.target)
        ),
    )


def _carriage_of(settings: Any) -> lattice_state.Carriage | None:
    body = settings.footprint
    corners = tuple((int(body.x[k]), int(body.y[k])) for k in range(body.count))
    if not corners and settings.turn_per_unit == 0.0:
        return None
    return lattice_state.Carriage(
        corners,
        float(settings.turn_per_unit),
        float(settings.turning_radius),
        float(settings.steering_rate),
        bool(settings.reverse),
    )
