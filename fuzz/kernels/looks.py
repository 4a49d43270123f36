"""Many worlds from layout bytes, each with one run of a controller: of a compiled one all of them in one call.

For a controller that is no compiled function the same work comes in parts: :func:`next_look` draws worlds until there
is one to run in, :func:`sim.kernels.lattice_episode.lattice_steps` runs it and stops wherever the controller is to
act, :func:`close_look` notes what happened, and :func:`watch_steps` goes on for a while.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from fuzz.kernels import layout_bytes
from fuzz.kernels._jit import allocating_kernel, kernel, rare_kernel
from fuzz.kernels.layouts import byte_of, draw_layout, fill_arena, flood_length, places_of, size_of
from sim.kernels import layout
from sim.kernels._views import page
from sim.kernels.geometry import NEAR, cell_state, chessboard_clearance, point_box_distance_sq
from sim.kernels.lattice_batch import lone_step
from sim.kernels.lattice_episode import lattice_episode
from sim.kernels.lattice_sense import turn_towards
from sim.kernels.lattice_state import Arena, Robot, Room
from sim.kernels.lattice_step import is_inside, move_and_sense, obey, remember
from sim.kernels.layout import TURN, UNIT
from sim.kernels.recurrence import TOUCHED

__all__ = [
    "Batch",
    "Desk",
    "begin_watch",
    "close_look",
    "goes_on",
    "longest",
    "look_at_layouts",
    "masks_do",
    "next_look",
    "note_step",
    "watch_steps",
]

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
LOOK_TURNED = LOOK_BUMPS + 1  # net turn in these, heading units
LOOK_LEFT, LOOK_RIGHT = LOOK_TURNED + 1, LOOK_TURNED + 2  # least and greatest x of the centre in these, lattice units
LOOK_LOW, LOOK_HIGH = LOOK_RIGHT + 1, LOOK_RIGHT + 2  # the same of y
LOOK_CONTACT = LOOK_HIGH + 1  # of the walls touched in these, the kind that says most; NO_CONTACT for none
LOOK_CLOSER = LOOK_CONTACT + 1  # 1 if these come nearer to the target than the start is
LOOK_AROUND = LOOK_CLOSER + 1  # solid cells that share an edge with the one that was hit; -1: none was
LOOK_SIZE = LOOK_AROUND + 1

# Patience (int64): how many steps a run gets that has no budget of its own, and for how many it is watched after that.
MULTIPLE = 0  # of the time that the way takes at top speed
FEWEST_STEPS, MOST_STEPS = 1, 2
WATCHED_STEPS = 3  # of a run that spent its budget
PATIENCE_SIZE = 4

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
        patience: (PATIENCE_SIZE,) int64.
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
    patience: Ints
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


def longest(batch: Batch) -> int:
    """Return the most steps that a run of a batch can have."""
    return max(int(batch.patience[MOST_STEPS]), int(batch.budgets.max(initial=0)))


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
def _own_budget(distance: int, scales: Floats, patience: Ints) -> int:
    by_way = patience[MULTIPLE] * distance * UNIT // _fastest(scales)
    return int(min(max(by_way, patience[FEWEST_STEPS]), patience[MOST_STEPS]))


@kernel
def masks_do(settings: Ints, scales: Floats) -> bool:
    """Whether the masks reach as far as a step, so that a run needs no table of distances."""
    return bool(settings[layout.SET_REACH] + _fastest(scales) <= NEAR * UNIT)


@kernel
def _arena_of(desk: Desk, height: int, width: int) -> Arena:
    """An arena of a world's size."""
    rows, columns = (0, 0) if masks_do(desk.settings, desk.scales) else (height, width)
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
def begin_watch(robot: Robot, batch: Batch, n: int) -> int:
    """Prepares the notes on a robot that loops, or that spent its budget, and goes on for a while.

    Returns:
        Steps for which it is watched, one period of a loop.
    """
    state, looks = robot.state, batch.looks
    looks[n, LOOK_WATCHED], looks[n, LOOK_BUMPS], looks[n, LOOK_TURNED] = 0, 0, 0
    looks[n, LOOK_LEFT], looks[n, LOOK_RIGHT] = state[layout.STATE_X], state[layout.STATE_X]
    looks[n, LOOK_LOW], looks[n, LOOK_HIGH] = state[layout.STATE_Y], state[layout.STATE_Y]
    looks[n, LOOK_CONTACT], looks[n, LOOK_CLOSER] = NO_CONTACT, 0
    robot.counts[layout.OUT_ENDING] = layout.LIMIT
    loops = looks[n, layout.OUT_ENDING] == layout.LOOP
    return int(looks[n, layout.OUT_PERIOD] if loops else batch.patience[WATCHED_STEPS])


@kernel
def goes_on(arena: Arena, robot: Robot, looks: Ints, n: int, steps: int) -> bool:
    """Whether a robot is watched for another step."""
    ended = robot.counts[layout.OUT_ENDING] != layout.LIMIT
    return looks[n, LOOK_WATCHED] < steps and not ended and is_inside(arena, robot)


@rare_kernel
def note_step(
    arena: Arena, settings: Ints, room: Room, robot: Robot, before: tuple[int, bool], looks: Ints, n: int
) -> bool:
    """Notes touches, turning, extent and progress of a step that was watched.

    Args:
        arena: Surroundings.
        settings: ``SET_``.
        room: With what the robot observed in this step.
        robot: After it.
        before: Heading before this step, and whether the robot touched a wall then.
        looks: To be filled.
        n: The run.

    Returns:
        Whether it touches a wall now.
    """
    state = robot.state
    looks[n, LOOK_WATCHED] += 1
    x, y = state[layout.STATE_X], state[layout.STATE_Y]
    touches = bool(room.observation[layout.OBS_BUMP] != 0.0)
    if touches and not before[1]:
        looks[n, LOOK_BUMPS] += 1
        looks[n, LOOK_CONTACT] = min(looks[n, LOOK_CONTACT], _contact(arena.cells, settings[layout.SET_REACH], x, y))
    dx, dy = x - settings[layout.SET_TARGET_X], y - settings[layout.SET_TARGET_Y]
    if dx * dx + dy * dy < looks[n, LOOK_STRAIGHT_SQ] * UNIT * UNIT:
        looks[n, LOOK_CLOSER] = 1
    looks[n, LOOK_TURNED] += turn_towards(before[0], state[layout.STATE_HEADING])
    looks[n, LOOK_LEFT], looks[n, LOOK_RIGHT] = min(looks[n, LOOK_LEFT], x), max(looks[n, LOOK_RIGHT], x)
    looks[n, LOOK_LOW], looks[n, LOOK_HIGH] = min(looks[n, LOOK_LOW], y), max(looks[n, LOOK_HIGH], y)
    return touches


@rare_kernel
def _watch(arena: Arena, batch: Batch, desk: Desk, act: Any, room: Room, robot: Robot, n: int) -> None:
    """Lets a robot of a compiled controller go on, and notes what it does."""
    looks, touches = batch.looks, room.search.marks[TOUCHED] != 0
    steps, done = begin_watch(robot, batch, n), looks[n, layout.OUT_STEPS]
    while goes_on(arena, robot, looks, n, steps):
        before, step = (robot.state[layout.STATE_HEADING], touches), done + looks[n, LOOK_WATCHED] + 1
        lone_step(arena, desk.settings, desk.scales, act, room, robot, step, 0)
        touches = note_step(arena, desk.settings, room, robot, before, looks, n)


@allocating_kernel
def watch_steps(
    arena: Arena, settings: Ints, scales: Floats, room: Room, robot: Robot, batch: Batch, n: int
) -> Iterator[int]:
    """Lets a robot go on whose controller is no compiled function: stops wherever it is to act, as ``lattice_steps``.

    Yields:
        Number of the step.
    """
    looks, touches = batch.looks, room.search.marks[TOUCHED] != 0
    steps, done = begin_watch(robot, batch, n), looks[n, layout.OUT_STEPS]
    while goes_on(arena, robot, looks, n, steps):
        before, step = (robot.state[layout.STATE_HEADING], touches), done + looks[n, LOOK_WATCHED] + 1
        move_and_sense(arena, settings, scales, room, robot, step, 0)
        if robot.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, robot):
            yield step
            obey(settings, scales, room.command, step, robot)
        remember(room, robot)
        touches = note_step(arena, settings, room, robot, before, looks, n)


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
def _open_look(batch: Batch, desk: Desk, n: int) -> bool:
    """Draws the world of a run; packs the run if a robot can surely reach the target there, else returns false."""
    looks, settings = batch.looks, desk.settings
    _note_world(batch, desk, n)
    if looks[n, LOOK_DISTANCE] < 0:
        return False
    _set_up(batch, desk, n)
    budget = batch.budgets[n]
    if budget <= 0:
        budget = _own_budget(looks[n, LOOK_DISTANCE], desk.scales, batch.patience)
    settings[layout.SET_STEPS] = budget
    looks[n, LOOK_BUDGET] = settings[layout.SET_STEPS]
    arena = _arena_of(desk, looks[n, LOOK_HEIGHT], looks[n, LOOK_WIDTH])
    looks[n, LOOK_SOLID] = fill_arena(desk.solid, arena)
    if arena.clearance.shape[0] > 0:
        chessboard_clearance(arena.cells, arena.clearance)
    arena.visited[settings[layout.SET_Y] // UNIT, settings[layout.SET_X] // UNIT] = 1
    return True


@rare_kernel
def next_look(batch: Batch, desk: Desk) -> int:
    """Draws worlds from run ``at`` on, up to the next in which a robot can surely reach the target, and packs that.

    Returns:
        Its number, which ``at`` is then; -1 where there is none left.
    """
    at = batch.at
    while at[0] < batch.seeds.size:
        if _open_look(batch, desk, at[0]):
            return int(at[0])
        at[0] += 1
    return -1


@rare_kernel
def close_look(batch: Batch, arena: Arena, robot: Robot, n: int) -> None:
    """Notes what came of a run that has ended."""
    looks = batch.looks
    for k in range(robot.counts.size):
        looks[n, k] = robot.counts[k]
    for k in range(robot.sums.size):
        batch.sums[n, k] = robot.sums[k]
    _note_way(arena, looks, n)
    _note_wall(arena, looks, n)


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
    looks, at = batch.looks, batch.at
    while at[0] < batch.seeds.size:
        n = at[0]
        if _open_look(batch, desk, n):
            arena = _arena_of(desk, looks[n, LOOK_HEIGHT], looks[n, LOOK_WIDTH])
            lattice_episode(arena, desk.settings, desk.scales, act, memory, room, robot, desk.nothing, desk.nothing)
            close_look(batch, arena, robot, n)
            if looks[n, layout.OUT_ENDING] == layout.LOOP or looks[n, layout.OUT_ENDING] == layout.LIMIT:
                _watch(arena, batch, desk, act, room, robot, n)
        at[0] = n + 1
