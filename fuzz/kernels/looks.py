"""Many worlds from layout bytes, each with one run of a compiled controller, in one call."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from fuzz.kernels import layout_bytes
from fuzz.kernels._jit import kernel, rare_kernel
from fuzz.kernels.layouts import byte_of, draw_layout, fill_arena, flood_length, places_of, size_of
from sim.kernels import layout
from sim.kernels._views import page
from sim.kernels.geometry import NEAR, cell_state, chessboard_clearance, point_box_distance_sq
from sim.kernels.lattice_batch import lone_step
from sim.kernels.lattice_episode import lattice_episode
from sim.kernels.lattice_sense import turn_towards
from sim.kernels.lattice_state import Arena, Robot, Room
from sim.kernels.lattice_step import is_inside
from sim.kernels.layout import TURN, UNIT

__all__ = ["Batch", "Desk", "look_at_layouts"]

Bytes = npt.NDArray[np.uint8]
Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

NOT_RUN = -1  # an ending: the flood found no way, so nothing was simulated
NOOK, END, POST, CORNER, FACE, NO_CONTACT = range(6)  # kinds of contact, the one that says most first
FAR = NEAR + 1  # a clearance of that many cells, or more
_NEXT = 0b01110_01110_01110 << (2 * NEAR + 1)  # bits of the eight cells beside a cell, and of itself

# Columns of a look (int64); the first OUT_SIZE are those of the episode.
LOOK_DISTANCE = layout.OUT_SIZE  # flood_length + 2: cells of a way to the target, an upper bound; -1
LOOK_BUDGET = LOOK_DISTANCE + 1  # steps
LOOK_WIDTH, LOOK_HEIGHT, LOOK_SOLID = LOOK_BUDGET + 1, LOOK_BUDGET + 2, LOOK_BUDGET + 3  # cells
LOOK_STRAIGHT_SQ = LOOK_SOLID + 1  # squared distance of start and target, cells
LOOK_VISITED = LOOK_STRAIGHT_SQ + 1  # cells that the centre was in
LOOK_LEAST_CLEARANCE = LOOK_VISITED + 1  # least chessboard distance of such a cell to a solid one, at most FAR
LOOK_CLEARANCES = LOOK_LEAST_CLEARANCE + 1  # sum of all these distances
LOOK_WATCHED = LOOK_CLEARANCES + 1  # further steps: one period of a loop
LOOK_BUMPS = LOOK_WATCHED + 1  # times that a wall was begun to be touched in these
LOOK_TURNED, LOOK_EXTENT = LOOK_BUMPS + 1, LOOK_BUMPS + 2  # net turn, heading units; larger side, lattice units
LOOK_CONTACT = LOOK_EXTENT + 1  # of the walls touched in these, the kind that says most; NO_CONTACT for none
LOOK_CLOSER = LOOK_CONTACT + 1  # 1 if these come nearer to the target than the start is
LOOK_AROUND = LOOK_CLOSER + 1  # solid cells that share an edge with the one that was hit; -1: none was
LOOK_SIZE = LOOK_AROUND + 1

# The budget that the way tells: as a witness would, so that who spends it has failed, but for the longest ways.
_FEWEST_STEPS, _MOST_STEPS = 4_000, 8_000
_MULTIPLE = 50  # of the time that the way takes at top speed
_WATCHED_STEPS = 600  # of a run that spent its budget
_SLACK = 20  # lattice units: walls that are no further away than they could be and this are touched


class Batch(NamedTuple):
    """Runs, and what came of them.

    Args:
        layouts: (n, LAYOUT_BYTES or SCENE_BYTES) uint8.
        seeds: (n,) bits of uint64s.
        kinds: (n,) int64, which of the time steps.
        budgets: (n,) int64, steps; 0 for some that the way to the target tells.
        settings: (k, SET_SIZE) of each time step, for any start.
        scales: (k, SCALE_SIZE) of each.
        discs: (radii, 2) int64, squared clear distance and reach of each radius of a scene's robot.
        radii: (radii,) the same in m.
        targets: (targets,) int64, squared radii of a scene's targets, lattice units.
        looks: (n, LOOK_SIZE) int64, filled.
        sums: (n, SUM_SIZE), filled.
        at: (1,) int64, the run that comes next, or that is under way.
    """

    layouts: Bytes
    seeds: Ints
    kinds: Ints
    budgets: Ints
    settings: Ints
    scales: Floats
    discs: Ints
    radii: Floats
    targets: Ints
    looks: Ints
    sums: Floats
    at: Ints


class Desk(NamedTuple):
    """What the kernels work with, so that they make no arrays.

    Args:
        solid: (ROWS,) int64.
        flood: (3, ROWS) int64.
        cells: uint8, as many as the largest world has.
        near: int32, likewise.
        clearance: int32, likewise.
        visited: uint8, likewise.
        events: (0, EVENT_SIZE) int64.
        headings: (131072,) int64.
        settings: (SET_SIZE,) int64.
        scales: (SCALE_SIZE,).
        nothing: (0, 1) int64.
    """

    solid: Ints
    flood: Ints
    cells: Bytes
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    visited: Bytes
    events: Ints
    headings: Ints
    settings: Ints
    scales: Floats
    nothing: Ints


@rare_kernel
def _set_up(batch: Batch, desk: Desk, n: int) -> None:
    """Fills in settings and scales of a run but for its budget."""
    layouts, kind, settings = batch.layouts, batch.kinds[n], desk.settings
    for k in range(settings.size):
        settings[k] = batch.settings[kind, k]
    for k in range(desk.scales.size):
        desk.scales[k] = batch.scales[kind, k]
    start_x, start_y, target_x, target_y = places_of(layouts, n)
    half = UNIT // 2
    settings[layout.SET_X], settings[layout.SET_Y] = start_x * UNIT + half, start_y * UNIT + half
    settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y] = target_x * UNIT + half, target_y * UNIT + half
    heading = byte_of(layouts, n, 4) % layout_bytes.HEADINGS * layout_bytes.FINER
    radius, target = 0, 0
    if layouts.shape[1] == layout_bytes.SCENE_BYTES:
        radius = byte_of(layouts, n, layout_bytes.SCENE_RADIUS) % batch.radii.size
        target = byte_of(layouts, n, layout_bytes.SCENE_TARGET) % batch.targets.size
        heading += byte_of(layouts, n, layout_bytes.SCENE_HEADING) % layout_bytes.FINER
    settings[layout.SET_HEADING] = heading * (TURN // (layout_bytes.HEADINGS * layout_bytes.FINER))
    settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH] = batch.discs[radius, 0], batch.discs[radius, 1]
    settings[layout.SET_TARGET_SQ] = batch.targets[target]
    settings[layout.SET_SEED] = batch.seeds[n]
    desk.scales[layout.SCALE_RADIUS] = batch.radii[radius]


@kernel
def _fastest(scales: Floats) -> int:
    """Lattice units that no step exceeds."""
    return int(scales[layout.SCALE_TOP_SPEED] * scales[layout.SCALE_SPEED]) + 1


@kernel
def _own_budget(distance: int, scales: Floats) -> int:
    return min(max(_MULTIPLE * distance * UNIT // _fastest(scales), _FEWEST_STEPS), _MOST_STEPS)


@kernel
def _arena_of(desk: Desk, height: int, width: int) -> Arena:
    """An arena of a world's size, with a table of distances only where the masks do not reach as far as a step."""
    masks_do = desk.settings[layout.SET_REACH] + _fastest(desk.scales) <= NEAR * UNIT
    rows, columns = (0, 0) if masks_do else (height, width)
    return Arena(
        page(desk.cells, height, width),
        page(desk.near, height, width),
        page(desk.clearance, rows, columns),
        desk.events,
        desk.headings,
        page(desk.visited, height, width),
    )


@rare_kernel
def _note_way(arena: Arena, looks: Ints, n: int) -> None:
    """Notes how many cells the robot was in, and how near they are to solid ones."""
    visited, least, total = 0, FAR, 0
    for iy in range(arena.cells.shape[0]):
        for ix in range(arena.cells.shape[1]):
            if arena.visited[iy, ix] != 0:
                mask = arena.near[iy, ix]
                near = 1 if mask & _NEXT != 0 else (2 if mask != 0 else FAR)
                visited, least, total = visited + 1, min(least, near), total + near
    looks[n, LOOK_VISITED], looks[n, LOOK_LEAST_CLEARANCE], looks[n, LOOK_CLEARANCES] = visited, least, total


@kernel
def _solid_beside(cells: Bytes, ix: int, iy: int) -> int:
    """How many of the four cells that share an edge with a cell are solid."""
    beside = int(cell_state(cells, ix + 1, iy) == layout.SOLID) + int(cell_state(cells, ix - 1, iy) == layout.SOLID)
    beside += int(cell_state(cells, ix, iy + 1) == layout.SOLID) + int(cell_state(cells, ix, iy - 1) == layout.SOLID)
    return beside


@rare_kernel
def _contact(cells: Bytes, reach: int, x: int, y: int) -> int:
    """The kind of wall that a robot touches, by the solid cells next to its disc."""
    across, along, aslant, fewest, farthest = 0, 0, False, 4, (reach + _SLACK) * (reach + _SLACK)
    for iy in range((y - reach - _SLACK) // UNIT, (y + reach + _SLACK) // UNIT + 1):
        for ix in range((x - reach - _SLACK) // UNIT, (x + reach + _SLACK) // UNIT + 1):
            if cell_state(cells, ix, iy) != layout.SOLID or point_box_distance_sq(x, y, ix, iy) > farthest:
                continue
            fewest = min(fewest, _solid_beside(cells, ix, iy))
            beside_x, beside_y = ix * UNIT > x or (ix + 1) * UNIT < x, iy * UNIT > y or (iy + 1) * UNIT < y
            if beside_x and beside_y:
                aslant = True
            elif beside_x:
                across |= 1 if ix * UNIT > x else 2
            else:
                along |= 1 if iy * UNIT > y else 2
    if (across != 0 and along != 0) or across == 3 or along == 3:
        return NOOK
    if fewest <= 1:
        return POST if fewest == 0 else END
    return CORNER if aslant and across == 0 and along == 0 else FACE


@rare_kernel
def _note_wall(arena: Arena, looks: Ints, n: int) -> None:
    """Notes of what kind the wall is that the robot went through or into."""
    ix, iy = looks[n, layout.OUT_HIT_IX], looks[n, layout.OUT_HIT_IY]
    if looks[n, layout.OUT_ENDING] != layout.TUNNEL:
        if looks[n, layout.OUT_OVERLAP_STEP] < 0:
            return
        ix, iy = looks[n, layout.OUT_OVERLAP_IX], looks[n, layout.OUT_OVERLAP_IY]
    looks[n, LOOK_AROUND] = _solid_beside(arena.cells, ix, iy)


@rare_kernel
def _watch(arena: Arena, desk: Desk, act: Any, room: Room, robot: Robot, looks: Ints, n: int) -> None:
    """Lets a robot that loops, or that spent its budget, go on: notes touches, turning, extent and progress."""
    step, state, settings = looks[n, layout.OUT_STEPS], robot.state, desk.settings
    loops = looks[n, layout.OUT_ENDING] == layout.LOOP
    steps = looks[n, layout.OUT_PERIOD] if loops else _WATCHED_STEPS
    robot.counts[layout.OUT_ENDING] = layout.LIMIT
    left, low = state[layout.STATE_X], state[layout.STATE_Y]
    right, high, touched = left, low, room.brent[2] != 0
    watched, bumps, turned, kind = 0, 0, 0, NO_CONTACT
    nearest, apart = (1 << 62), looks[n, LOOK_STRAIGHT_SQ] * UNIT * UNIT
    while watched < steps and robot.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, robot):
        heading = state[layout.STATE_HEADING]
        watched += 1
        lone_step(arena, settings, desk.scales, act, room, robot, step + watched, 0)
        touches = room.observation[layout.OBS_BUMP] != 0.0
        if touches and not touched:
            bumps += 1
            reach = settings[layout.SET_REACH]
            kind = min(kind, _contact(arena.cells, reach, state[layout.STATE_X], state[layout.STATE_Y]))
        touched = touches
        dx = state[layout.STATE_X] - settings[layout.SET_TARGET_X]
        dy = state[layout.STATE_Y] - settings[layout.SET_TARGET_Y]
        nearest = min(nearest, dx * dx + dy * dy)
        turned += turn_towards(heading, state[layout.STATE_HEADING])
        left, right = min(left, state[layout.STATE_X]), max(right, state[layout.STATE_X])
        low, high = min(low, state[layout.STATE_Y]), max(high, state[layout.STATE_Y])
    looks[n, LOOK_WATCHED], looks[n, LOOK_BUMPS], looks[n, LOOK_TURNED] = watched, bumps, turned
    looks[n, LOOK_EXTENT] = max(right - left, high - low)
    looks[n, LOOK_CONTACT], looks[n, LOOK_CLOSER] = kind, int(nearest < apart)


@rare_kernel
def _note_world(batch: Batch, desk: Desk, n: int) -> None:
    """Draws a world and notes what can be said of it before anything runs, an ending ``NOT_RUN`` among it."""
    looks, layouts = batch.looks, batch.layouts
    for k in range(looks.shape[1]):
        looks[n, k] = 0
    looks[n, layout.OUT_ENDING], looks[n, LOOK_AROUND] = NOT_RUN, -1
    looks[n, layout.OUT_HIT_STEP], looks[n, layout.OUT_OVERLAP_STEP] = -1, -1
    for k in range(batch.sums.shape[1]):
        batch.sums[n, k] = 0.0
    draw_layout(layouts, n, desk.solid)
    start_x, start_y, target_x, target_y = places_of(layouts, n)
    dx, dy = target_x - start_x, target_y - start_y
    looks[n, LOOK_STRAIGHT_SQ] = dx * dx + dy * dy
    looks[n, LOOK_WIDTH], looks[n, LOOK_HEIGHT] = size_of(layouts, n)
    length = flood_length(layouts, n, desk.solid, desk.flood)
    looks[n, LOOK_DISTANCE] = length + 2 if length >= 0 else -1


@rare_kernel
def look_at_layouts(batch: Batch, desk: Desk, act: Any, memory: Floats, room: Room, robot: Robot) -> None:
    """Draws each layout, and where a robot can surely reach the target runs the controller once.

    Each run is to the bit that of :func:`sim.simulate` in the world that :func:`fuzz.features.decode_scene` makes of
    the same bytes.

    Args:
        batch: The runs; ``looks`` and ``sums`` are filled from run ``at`` on.
        desk: To be used.
        act: Compiled controller.
        memory: Its memory at reset.
        room: To be used.
        robot: Likewise.
    """
    looks, settings, at = batch.looks, desk.settings, batch.at
    while at[0] < batch.seeds.size:
        n = at[0]
        _note_world(batch, desk, n)
        if looks[n, LOOK_DISTANCE] >= 0:
            _set_up(batch, desk, n)
            budget = batch.budgets[n]
            settings[layout.SET_STEPS] = budget if budget > 0 else _own_budget(looks[n, LOOK_DISTANCE], desk.scales)
            looks[n, LOOK_BUDGET] = settings[layout.SET_STEPS]
            arena = _arena_of(desk, looks[n, LOOK_HEIGHT], looks[n, LOOK_WIDTH])
            looks[n, LOOK_SOLID] = fill_arena(desk.solid, arena)
            if arena.clearance.shape[0] > 0:
                chessboard_clearance(arena.cells, arena.clearance)
            arena.visited[settings[layout.SET_Y] // UNIT, settings[layout.SET_X] // UNIT] = 1
            lattice_episode(arena, settings, desk.scales, act, memory, room, robot, desk.nothing, desk.nothing)
            for k in range(robot.counts.size):
                looks[n, k] = robot.counts[k]
            for k in range(robot.sums.size):
                batch.sums[n, k] = robot.sums[k]
            _note_way(arena, looks, n)
            _note_wall(arena, looks, n)
            if looks[n, layout.OUT_ENDING] == layout.LOOP or looks[n, layout.OUT_ENDING] == layout.LIMIT:
                _watch(arena, desk, act, room, robot, looks, n)
        at[0] = n + 1
