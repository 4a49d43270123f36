"""Edited copies of a world, run one after the other: which is the first that ends as it should?"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import rare_kernel
from sim.kernels.geometry import chessboard_clearance, near_masks, pose_is_clear
from sim.kernels.lattice_episode import lattice_episode
from sim.kernels.lattice_flood import surely_reaches
from sim.kernels.lattice_state import Arena, Robot, Room
from sim.kernels.layout import SOLID, UNIT

__all__ = [
    "ANY_ENDING",
    "ASK_ENDING",
    "ASK_OVERLAP",
    "ASK_SIZE",
    "ASK_STEPS",
    "ASK_WAY",
    "DONE_NEXT",
    "DONE_SIZE",
    "DONE_TRIALS",
    "DROP_COLUMNS",
    "DROP_ROWS",
    "EDIT_SIZE",
    "FREE_BOX",
    "FREE_RIM",
    "FREE_RUN",
    "first_edit",
]

# One edit (int64): its kind, then its numbers.
FREE_BOX = 0  # ix, iy, width, height: what is solid in this box of cells becomes free
FREE_RUN = 1  # first, count: so many of the solid cells, in order of rows
FREE_RIM = 2  # the outermost cells
DROP_ROWS = 3  # first, count; what lies above moves down
DROP_COLUMNS = 4  # first, count; what lies right of them moves left
EDIT_SIZE = 5

# What is asked of the edited worlds (int64).
ASK_ENDING = 0  # how the run is to end; ANY_ENDING: as LIMIT, REACHED or LOOP
ASK_OVERLAP = 1  # 1: with an overlap; 0: without; -1: it does not matter
ASK_WAY = 2  # 1: the target is surely to be reached after an edit that moves cells
ASK_STEPS = 3  # steps after which to come back even if nothing was found, so that a clock or Ctrl-C is heard
ASK_SIZE = 4
ANY_ENDING = -1

DONE_NEXT, DONE_TRIALS = 0, 1  # what was done: index of the edit at which to go on; runs
DONE_SIZE = 2

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


@rare_kernel
def _edit(old: npt.NDArray[np.uint8], new: npt.NDArray[np.uint8], edit: Ints, which: int) -> bool:
    """Writes the edited cells; whether they are others."""
    kind, a, b = edit[which, 0], edit[which, 1], edit[which, 2]
    height, width = new.shape
    changed, solid = bool(kind >= DROP_ROWS), 0
    for iy in range(height):
        for ix in range(width):
            jy = iy + b if kind == DROP_ROWS and iy >= a else iy
            jx = ix + b if kind == DROP_COLUMNS and ix >= a else ix
            state = old[jy, jx]
            gone = False
            if kind == FREE_BOX:
                gone = a <= ix < a + edit[which, 3] and b <= iy < b + edit[which, 4]
            elif kind == FREE_RUN:
                gone = a <= solid < a + b
            elif kind == FREE_RIM:
                gone = ix == 0 or iy == 0 or ix == width - 1 or iy == height - 1
            if state == SOLID:
                solid += 1
                if gone:
                    state, changed = 0, True
            new[iy, ix] = state
    return changed


@rare_kernel
def _stand(cells: npt.NDArray[np.uint8], settings: Ints) -> bool:
    """Moves the start to the nearest clear point of the nine around it, as every run does; False if there is none."""
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    x, y = settings[layout.SET_X], settings[layout.SET_Y]
    for away in range(3):  # squared distance
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                if dx * dx + dy * dy == away and pose_is_clear(cells, SOLID, clear_sq, reach, x + dx, y + dy):
                    settings[layout.SET_X], settings[layout.SET_Y] = x + dx, y + dy
                    return True
    return False


@rare_kernel
def _has_way(
    work: Arena, settings: Ints, ever: npt.NDArray[np.uint8], seen: npt.NDArray[np.uint8], stack: Ints
) -> bool:
    """Whether the target is surely reached without touching a cell that is ever not free."""
    for iy in range(ever.shape[0]):
        for ix in range(ever.shape[1]):
            ever[iy, ix] = work.cells[iy, ix]
    for k in range(work.events.shape[0]):
        if work.events[k, layout.EVENT_STATE] != 0:
            ever[work.events[k, layout.EVENT_IY], work.events[k, layout.EVENT_IX]] = SOLID
    disc = (settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH])
    ends = (
        settings[layout.SET_X], settings[layout.SET_Y], settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y],
    )  # fmt: skip
    return surely_reaches(ever, disc, ends, settings[layout.SET_TARGET_SQ], seen, stack)


@rare_kernel
def _survey(work: Arena, settings: Ints, ever: npt.NDArray[np.uint8]) -> None:
    """Fills what an episode looks up in the cells."""
    near_masks(work.cells, work.near)
    for iy in range(work.visited.shape[0]):
        for ix in range(work.visited.shape[1]):
            work.visited[iy, ix] = 0
            ever[iy, ix] = work.cells[iy, ix]
    row = min(settings[layout.SET_Y] // UNIT, work.visited.shape[0] - 1)
    work.visited[row, min(settings[layout.SET_X] // UNIT, work.visited.shape[1] - 1)] = 1
    if work.clearance.shape[0] > 0:
        for k in range(work.events.shape[0]):
            iy, ix = work.events[k, layout.EVENT_IY], work.events[k, layout.EVENT_IX]
            ever[iy, ix] = max(ever[iy, ix], work.events[k, layout.EVENT_STATE])
        chessboard_clearance(ever, work.clearance)


@rare_kernel
def _moved(settings: Ints, edit: Ints, which: int) -> None:
    """Moves start and target with the cells that an edit moves."""
    kind, first, count = edit[which, 0], edit[which, 1], edit[which, 2]
    if kind < DROP_ROWS:
        return
    axis = 1 if kind == DROP_ROWS else 0
    for place in range(2):
        k = (layout.SET_X if place == 0 else layout.SET_TARGET_X) + axis
        if settings[k] >= (first + count) * UNIT:
            settings[k] -= count * UNIT


@rare_kernel
def _is_wanted(counts: Ints, asked: Ints) -> bool:
    """Whether a run has ended as asked."""
    ending, overlaps = int(counts[layout.OUT_ENDING]), bool(counts[layout.OUT_OVERLAP_STEP] >= 0)
    if asked[ASK_OVERLAP] >= 0 and overlaps != (asked[ASK_OVERLAP] == 1):
        return False
    if asked[ASK_ENDING] == ANY_ENDING:
        return ending in (layout.LIMIT, layout.REACHED, layout.LOOP)
    return ending == int(asked[ASK_ENDING])


@rare_kernel
def first_edit(
    old: npt.NDArray[np.uint8],
    work: Arena,
    places: tuple[Ints, Ints],
    scales: Floats,
    act: Any,
    memory: Floats,
    room: Room,
    robot: Robot,
    edits: Ints,
    asked: Ints,
    flood: tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8], Ints],
    done: Ints,
    nothing: Ints,
) -> bool:
    """Tries edits from ``done[DONE_NEXT]`` on, until one is found or ``asked[ASK_STEPS]`` steps are done.

    Args:
        old: (height, width) uint8, cells before the edit, at time 0.
        work: Surroundings of the edited world's shape, to be used; its events are the edited world's.
        places: ``SET_`` of the world before the edit, with the start as the world says it; and as many, to be used.
        scales: ``SCALE_``.
        act: Compiled controller.
        memory: Its memory at reset.
        room: To be used.
        robot: Likewise.
        edits: (n, EDIT_SIZE), all of which lead to the same shape.
        asked: ``ASK_``.
        flood: (height, width) and (2 height + 1, 2 width + 1) uint8 and as many int64, to be used.
        done: ``DONE_``, changed.
        nothing: (0, 1) int64.

    Returns:
        Whether the edit before ``done[DONE_NEXT]`` is one.
    """
    settings, begin = places[1], done[DONE_NEXT]
    ever, seen, stack = flood
    steps = 0
    for which in range(begin, edits.shape[0]):
        if steps >= asked[ASK_STEPS]:
            return False
        done[DONE_NEXT] = which + 1
        if not _edit(old, work.cells, edits, which):
            continue
        for k in range(settings.size):
            settings[k] = places[0][k]
        _moved(settings, edits, which)
        x, y = settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y]
        if x > work.cells.shape[1] * UNIT or y > work.cells.shape[0] * UNIT or not _stand(work.cells, settings):
            continue
        moves = edits[which, 0] >= DROP_ROWS
        if moves and asked[ASK_WAY] != 0 and not _has_way(work, settings, ever, seen, stack):
            continue
        _survey(work, settings, ever)
        done[DONE_TRIALS] += 1
        lattice_episode(work, settings, scales, act, memory, room, robot, nothing, nothing)
        steps += robot.counts[layout.OUT_STEPS]
        if _is_wanted(robot.counts, asked):
            return True
    return False
