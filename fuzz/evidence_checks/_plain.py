"""Helpers of the evidence checks: cells over time and parts of a path, in plain Python."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from sim.evidence import BudgetEvidence
from sim.trace import Trace
from worldgen.support.arrays import Floats
from worldgen.timeline import CellState
from worldgen.world import Witness, World

_HEADING = 2.0 * math.pi / 65_536  # rad between two headings of the simulator


def cell_box(world: World, ix: int, iy: int) -> shapely.Polygon:
    """Return a cell as a shapely box, in metres."""
    side = world.cell_size
    return shapely.box(ix * side, iy * side, (ix + 1) * side, (iy + 1) * side)


def is_solid_at(world: World, ix: int, iy: int, earliest: float, latest: float) -> bool:
    """Return True if a cell is solid at some time in [earliest, latest] s, or outside the grid."""
    if not (0 <= ix < world.width and 0 <= iy < world.height):
        return True
    # Follow the events of this cell up to the end of the interval.
    state = CellState.SOLID if world.walls[iy, ix] else CellState.FREE
    for event in world.timeline.until(latest).in_cell(ix, iy):
        if state == CellState.SOLID and event.time > earliest:
            return True
        state = event.state
    return state == CellState.SOLID


def step_path(trace: Trace, step: int, since: float = 0.0) -> shapely.LineString:
    """Return the path of one step, in metres.

    Args:
        trace: The recording.
        step: The step.
        since: Fraction of the step to skip, 0 to 1; the path begins at the last point before its
            end.
    """
    first = int(np.searchsorted(trace.path_step, step, side="left"))
    last = int(np.searchsorted(trace.path_step, step, side="right"))
    first += int(np.searchsorted(trace.path_share[first:last], since + 1e-9, side="right"))
    points = np.stack([trace.path_x[first - 1 : last], trace.path_y[first - 1 : last]], axis=1)
    return shapely.LineString(points if len(points) > 1 else np.repeat(points, 2, axis=0))


def step_gap(
    world: World, trace: Trace, step: int, cell: tuple[int, int], since: float = 0.0
) -> float:
    """Return how near the robot comes to a cell in a step, m; negative if it cuts the cell.

    Of a disc, only the path counts; a body counts with its turn after the path, too.

    Args:
        world: World of the run.
        trace: The recording.
        step: The step.
        cell: ix and iy.
        since: Fraction of the step to skip, as for :func:`step_path`.
    """
    box = cell_box(world, *cell)
    path = step_path(trace, step, since)
    if not world.robots[0].footprint:
        return float(path.distance(box)) - world.robot_radius

    # The heading on the way to each point of the path.
    last = int(np.searchsorted(trace.path_step, step, side="right"))
    places = np.array(path.coords)
    headings = trace.path_heading[last - len(places) + 1 : last]
    gaps = []
    for before, after, heading in zip(places[:-1], places[1:], headings, strict=True):
        corners = [corners_at(world, x, y, heading) for x, y in (before, after)]
        gaps.append(convex_gap(np.concatenate(corners), box))
    gaps.append(turn_gap(world, trace, step, box))
    return min(gaps)


def turn_gap(world: World, trace: Trace, step: int, box: shapely.Polygon) -> float:
    """Return how near a body comes to a box while it turns at the end of a step, m."""
    here = (float(trace.x[step]), float(trace.y[step]))
    last = int(np.searchsorted(trace.path_step, step, side="right"))
    heading = float(trace.path_heading[last - 1])
    turn = math.remainder(float(trace.heading[step]) - heading, 2.0 * math.pi)
    # One pose for each heading of the simulator, and none of them far from the box.
    count = math.ceil(abs(turn) / _HEADING) + 1
    if box.distance(shapely.Point(here)) > 1.1 * world.robot_radius:
        count = 1
    headings = heading + np.linspace(0.0, turn, count)
    return min(convex_gap(corners_at(world, *here, one), box) for one in headings.tolist())


def corners_at(world: World, x: float, y: float, heading: float) -> Floats:
    """Return (k, 2) corners of the robot's body at a pose, m."""
    corners = np.array(world.robots[0].footprint)
    cos, sin = math.cos(heading), math.sin(heading)
    turned: Floats = corners @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
    return turned


def convex_gap(points: Floats, box: shapely.Polygon) -> float:
    """Return the distance of a box from the convex hull of points, m.

    If they overlap, it is negative: the shortest way by which the hull could be moved out.
    """
    hull: Any = shapely.MultiPoint(points).convex_hull
    apart = float(hull.distance(box))
    if apart > 0.0:
        return apart
    corners, sides = shapely.get_coordinates(hull), shapely.get_coordinates(box)
    edges = np.concatenate([np.diff(corners, axis=0), np.diff(sides, axis=0)])
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    own = corners @ normals.T
    others = sides @ normals.T
    depths = np.minimum(own.max(axis=0) - others.min(axis=0), others.max(axis=0) - own.min(axis=0))
    return -float(depths.min())


def first_new_cell_of_second_half(
    world: World, trace: Trace, half: int | None = None
) -> tuple[int, int] | None:
    """Return a cell (ix, iy) that a state enters only in the second half, or ``None``.

    Args:
        world: World of the run.
        trace: The recording.
        half: Last step of the first half; half of the recording's steps if omitted.
    """
    columns = lattice_cell(trace.x / world.cell_size)
    rows = lattice_cell(trace.y / world.cell_size)
    cells = columns.astype(np.int64) + rows.astype(np.int64) * (world.width + 2)
    half = trace.steps // 2 if half is None else half
    fresh = np.setdiff1d(cells[half + 1 :], cells[: half + 1])
    return (
        (int(fresh[0]) % (world.width + 2), int(fresh[0]) // (world.width + 2))
        if len(fresh)
        else None
    )


def check_budget(world: World, trace: Trace, evidence: BudgetEvidence) -> str:
    """Check that the run took ``witness_multiple`` times the witness's time, to three decimals."""
    if not isinstance(world.certificate, Witness) or world.certificate.duration <= 0:
        return ""
    if trace.task == "cover":  # its budget follows from the cells, not from the witness
        return ""
    spent = (
        trace.steps * Fraction(repr(trace.time_step)) / Fraction(repr(world.certificate.duration))
    )
    claimed = evidence.witness_multiple
    if claimed is not None and abs(Fraction(claimed) - spent) <= Fraction(1, 1999):
        return ""
    return f"the budget is {float(spent):.3f} times the witness's time, not {claimed}"


def lattice_cell(places: npt.ArrayLike) -> Floats:
    """Return the cells of coordinates in cells, treating near-integers as integers."""
    places = np.asarray(places, np.float64)
    whole = np.rint(places)
    cells: Floats = np.where(np.abs(places - whole) < 1e-9, whole, np.floor(places))
    return cells


def set_speed(world: World, trace: Trace, step: int) -> float:
    """Return the speed, m/s, that is set after a step; the next step drives at it.

    The fourth number of a state is the speed in 1/65536 of 1/1024 of a cell per step.
    """
    units = int(trace.states[step, 3].astype(np.int64))
    return units / (65536 * 1024) * world.cell_size / trace.time_step


def off_goal(world: World, headings: Floats) -> Floats:
    """Return by how much headings exceed the tolerance of the goal's, rad; negative within it."""
    goal = world.target
    if goal.heading is None:
        return np.full(headings.shape, -np.inf)
    # A difference from a huge heading would be rounded.
    wanted = math.remainder(goal.heading, 2 * np.pi)
    off = np.abs((headings - wanted + np.pi) % (2 * np.pi) - np.pi)
    exceeded: Floats = off - goal.heading_tolerance
    return exceeded


def target_gap(world: World, x: Floats, y: Floats) -> float:
    """Return the smallest distance, m, from a path to the target's disc; negative inside."""
    points = np.stack([x, y], axis=1)
    path = shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])
    return float(path.distance(shapely.Point(world.target.x, world.target.y))) - world.target.radius


def places_gap(world: World, x: Floats, y: Floats) -> float:
    """Return the smallest distance, m, from any place to the target's disc; negative inside."""
    return float(np.min(place_gaps(world, x, y)))


def place_gaps(world: World, x: Floats, y: Floats) -> Floats:
    """Return the distance, m, from each place to the target's disc; negative inside."""
    goal = world.target
    gaps: Floats = np.array(shapely.distance(shapely.points(x, y), shapely.Point(goal.x, goal.y)))
    gaps -= goal.radius
    return gaps
