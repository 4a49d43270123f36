"""``tunnel``: the centre entered a solid cell. ``overlap``: the disc cut a wall too deeply.

The thesis's motion has three causes of an overlap, which its evidence names.

In each step of the thesis's motion the disc moves along its heading pixel by pixel, each a tenth
of a cell. The first pixel move that a wall stops becomes a *slide* (forward on one axis, part of a
pixel back on the other) or a *back-off* (one pixel back on both). If the disc touches only the
corner of a cell, it continues: a *corner*.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fuzz.evidence_checks._plain import cell_box, is_solid_at, step_gap, step_path
from sim.evidence import WallEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

LEAST_OVERLAP = 1e-7  # cells, a millionth of a pixel: less than this is rounding
_SLACK = 1e-10  # cells by which recorded metres may differ from the simulator's pixels
_PIXELS = 10  # pixels per cell
_SAME = 1e-6  # px by which a displacement may differ from what its cause predicts


def check_tunnel(world: World, trace: Trace, evidence: WallEvidence, motion: Motion) -> str:
    """Check that the path of the named step enters the named cell while that is solid.

    If the evidence names the move that let the robot into the wall, check that too.
    """
    wrong = _check_solid(world, trace, evidence)
    if wrong:
        return wrong
    inside = cell_box(world, *evidence.cell).buffer(-1e-9 * world.cell_size)
    if not step_path(trace, evidence.step).intersects(inside):
        return f"the path of step {evidence.step} does not meet cell {evidence.cell}"
    return check_cause(world, trace, evidence)


def check_overlap(world: World, trace: Trace, evidence: WallEvidence, motion: Motion) -> str:
    """Check that the disc, on the path of the named step, cuts the named solid cell deeply enough.

    If the evidence names the move that let the robot into the wall, check that too.
    """
    wrong = _check_solid(world, trace, evidence)
    if wrong:
        return wrong
    # The deepest cut along the path, measured with shapely.
    depth = -step_gap(world, trace, evidence.step, evidence.cell)
    allowed = motion.overlap_tolerance * world.cell_size
    # The corners of a body are rounded to 1/1024 of a cell.
    slack = 1e-9 if world.robots[0].is_disc else world.cell_size / 1024
    if depth <= allowed - slack:
        return f"the robot cuts cell {evidence.cell} by {depth:g} m, but up to {allowed:g} m is allowed"
    return check_cause(world, trace, evidence)


def _check_solid(world: World, trace: Trace, evidence: WallEvidence) -> str:
    """Check that the run has the named step, and that the named cell is solid in it."""
    step = evidence.step
    if not 1 <= step <= trace.steps:
        return f"the run has no step {step}"
    if not is_solid_at(world, *evidence.cell, (step - 1) * trace.time_step, step * trace.time_step):
        return f"cell {evidence.cell} is not solid in step {step}"
    return ""


def check_cause(world: World, trace: Trace, evidence: WallEvidence) -> str:
    """Check that the overlap lasts from step ``since`` to ``step`` and begins with move ``cause``.

    Before step ``since`` the disc must be clear of walls, and the displacement of that step must
    be what the cause predicts. If the disc had already entered a corner when a wall bent or
    stopped its move, the cause is ``corner``.

    Args:
        world: World of the run.
        trace: A recording up to at least ``step``.
        evidence: ``step``, ``cause``, ``since``; without ``cause`` there is nothing to check.
    """
    cause = evidence.cause
    since = evidence.since
    step = evidence.step
    if cause is None:
        return ""
    if since is None or not 1 <= since <= step <= trace.steps:
        return (
            f"an overlap that begins in step {since} and meets a wall in step {step} is not within "
            "the run"
        )

    # The disc is clear before step `since`, and in a wall after each later step.
    states = np.arange(since - 1, step + 1)
    depths = _depths(
        world, trace.x[states], trace.y[states], trace.time_step * states.astype(np.float64)
    )
    if depths[0] > LEAST_OVERLAP + _SLACK:
        return f"the disc overlaps a wall even before step {since}"
    clear = np.flatnonzero(depths[1:] < LEAST_OVERLAP - _SLACK)
    if len(clear):
        return f"after step {since + int(clear[0])} the disc is clear of walls again"

    moves = set(_moves(world, trace, since))
    return "" if cause in moves else f"the move of step {since} is not a {cause}" + _instead(moves)


def _instead(moves: set[str]) -> str:
    return f" but a {' or a '.join(sorted(moves))}" if moves else ""


def _depths(world: World, x: Floats, y: Floats, times: Floats) -> Floats:
    """Return how far the disc cuts into the deepest wall at each place and time, in cells.

    Everything outside the grid is solid.
    """
    side = world.cell_size
    radius = world.robot_radius / side
    x = x / side
    y = y / side
    reach = math.ceil(radius) + 1

    # For walls that never change, compare all places with the cells around each of them.
    steady = np.pad(world.still_walls, reach, constant_values=True)
    columns = np.floor(x).astype(np.int64)
    rows = np.floor(y).astype(np.int64)
    deepest = np.zeros(len(x))
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            ix = columns + dx
            iy = rows + dy
            inner_x = np.clip(ix + reach, 0, steady.shape[1] - 1)
            inner_y = np.clip(iy + reach, 0, steady.shape[0] - 1)
            depth = radius - _gap(x, y, ix, iy)
            deepest = np.where(steady[inner_y, inner_x], np.maximum(deepest, depth), deepest)
    # For cells of the timeline, only those that would be the deepest need their state at that time.
    for row, column in np.argwhere(world.changing_cells).tolist():
        depth = radius - _gap(x, y, np.full(len(x), column), np.full(len(x), row))
        for k in np.flatnonzero(depth > deepest):
            time = float(times[k]) + 1e-9
            if is_solid_at(world, column, row, time, time):
                deepest[k] = depth[k]
    return deepest


def _gap(x: Floats, y: Floats, ix: Ints, iy: Ints) -> Floats:
    """Return distances from points to cells, in cells; 0 inside."""
    dx = np.maximum(np.maximum(ix - x, x - ix - 1), 0.0)
    dy = np.maximum(np.maximum(iy - y, y - iy - 1), 0.0)
    distance: Floats = np.sqrt(dx * dx + dy * dy)
    return distance


def _moves(world: World, trace: Trace, step: int) -> Iterator[str]:
    """Yield every cause that could explain the displacement of a step."""
    here = np.array([trace.x[step - 1], trace.y[step - 1]])
    end = np.array([trace.x[step], trace.y[step]])
    heading = float(trace.heading[step - 1])
    unit = np.array([math.cos(heading), math.sin(heading)])
    pixel = world.cell_size / _PIXELS
    moved = (end - here) / pixel
    loose = _at_the_edge(world, end)

    # Try each number of pixels that the disc may have moved before a wall stopped it.
    time = np.array([step * trace.time_step])
    for gone in range(math.ceil(float(np.hypot(*moved))) + 3):
        before = here + gone * pixel * unit
        inside = float(_depths(world, before[:1], before[1:], time)[0])
        # Within the tolerance of the limit, a place counts as both free and caught.
        free = inside <= LEAST_OVERLAP + _SLACK
        caught = inside >= LEAST_OVERLAP - _SLACK
        stays = _same(moved, gone * unit, loose)
        backs = _same(moved, (gone - 1) * unit, loose)
        slides = any(_slides(moved, unit, gone, axis, loose) for axis in (0, 1))
        if not trace.bump[step]:
            if stays and gone > 0:
                yield "corner"
            continue
        if caught and (stays or backs or slides):
            yield "corner"
        if free and backs:
            yield "back-off"
        if free and slides:
            yield "slide"


def _same(moved: Floats, wanted: Floats, loose: Bools) -> bool:
    return bool(((np.abs(moved - wanted) < _SAME) | loose).all())


def _slides(moved: Floats, unit: Floats, gone: int, axis: int, loose: Bools) -> bool:
    """Return True if the move advanced on the axis by part of a pixel, and moved back on the other.

    Friction may shorten the forward part.
    """
    other = 1 - axis
    back = loose[other] or abs(moved[other] - (gone - 1) * unit[other]) < _SAME
    low, high = sorted((gone * unit[axis], (gone + 1) * unit[axis]))
    return bool(back and (loose[axis] or low - _SAME < moved[axis] < high + _SAME))


def _at_the_edge(world: World, place: Floats) -> Bools:
    """Return, per axis, whether the place is at the motion model's limit next to the grid's edge.

    A move may end early there.
    """
    radius = world.robot_radius
    side = world.cell_size
    ends = np.array([world.width, world.height]) * side
    gap = np.minimum(place, ends - place) - radius
    loose: Bools = (np.abs(gap) < _SAME * side) | (np.abs(gap - side) < _SAME * side)
    return loose
