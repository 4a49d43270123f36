"""Check a certificate without any of the code that made it: shapely, numpy, plain Python.

A witness is checked in cells with a tolerance of 1e-8, which is 1e-9 m at the usual 0.1 m per cell.
A cut's gaps and winding are multiples of half cells, so they are checked exactly. If the target's
disc overlaps the chain, its decisive poses are computed to 180 digits, and doubtful ones count
against the certificate.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import numpy.typing as npt
import shapely

from worldgen.reach.check.body import (
    LATTICE,
    BlockedSpans,
    BodyPath,
    Footprint,
    Mistake,
    body_clearance,
    check_ends,
    footprint_of,
    timed_body_clearance,
)
from worldgen.reach.check.body_cut import check_boxes
from worldgen.reach.check.car import car_fault
from worldgen.reach.check.joint import nearest_pair, nearest_to_zero
from worldgen.reach.check.target import TooMuch, poses_to_part
from worldgen.support.arrays import Bools, Floats, Indices, Ints
from worldgen.timeline import CellState
from worldgen.world import Certificate, Cut, JointWitness, Witness, World

# Cells by which a path may be closer to a wall than the radius.
TOLERANCE = 1e-8
# Fraction of the speed by which a piece may be too fast.
SPEED_TOLERANCE = 1e-9


@dataclass(frozen=True)
class CheckReport:
    """The result of a check.

    Args:
        valid: True if the certificate proves its claim for the requested radius.
        reason: One sentence about the proof, or about the error in it.
        clearance: Length, m: the measured radius of the largest disc that a witness lets through,
            or half the widest gap of a cut. It is 0 if the check failed before it was measured.
    """

    valid: bool
    reason: str
    clearance: float


class _Refused(Exception):
    """Raised if the certificate is invalid; the message gives the reason."""


def check_certificate(
    world: World, certificate: Certificate | None = None, *, radius: float | None = None
) -> CheckReport:
    """Return True if a certificate proves that a disc can, or cannot, get from start to target.

    In a world of several robots, a joint witness proves that all of them can, and a cut that one of
    them cannot.

    A certificate claims that its own path is safe if the robot keeps to its times. That it may
    also begin later, up to a ``margin`` that a family guarantees, is not part of the claim and is
    not checked here: :func:`worldgen.reach.witness_margin` measures it.

    Args:
        world: The world.
        certificate: The proof; the world's own if omitted.
        radius: Radius of the disc, m; the robot's, or each robot's, if omitted.
    """
    certificate = world.certificate if certificate is None else certificate
    if certificate is None:
        return CheckReport(False, "the world has no certificate", 0.0)
    if isinstance(certificate, JointWitness):
        return _check_joint(world, certificate, radius)
    if world.is_fleet:
        return _check_one_of_several(world, certificate, radius)
    if isinstance(certificate, Cut) and world.robots[0].waypoints:
        return _check_cut_of_waypoint(world, certificate, radius)
    robot = world.robots[0]
    is_about_robot = radius is None
    radius = robot.radius if radius is None else radius
    measured = [0.0]
    try:
        # A hostile file may contain times whose difference overflows.
        with np.errstate(all="ignore"):
            if is_about_robot and not robot.is_plain:
                reason = _check_for_robot(world, certificate, measured)
            elif isinstance(certificate, Witness):
                _check_witness(world, certificate, radius, measured)
                reason = f"the path is clear for discs of up to {measured[0]:.6g} m"
            else:
                reason = _check_cut(world, certificate, radius, measured)
            if isinstance(certificate, Witness) and robot.waypoints:
                reason += _check_waypoints(world, certificate, is_about_robot)
    except (_Refused, Mistake) as refusal:
        return CheckReport(False, str(refusal), measured[0])
    return CheckReport(True, reason, measured[0])


def _check_cut_of_waypoint(world: World, cut: Cut, radius: float | None) -> CheckReport:
    """Check a cut between the start and one goal, as if that were the only one."""
    robot = world.robots[0]
    if not 0 <= cut.waypoint <= len(robot.waypoints):
        return CheckReport(False, f"the robot has no waypoint {cut.waypoint}", 0.0)
    goal = robot.goals[cut.waypoint - 1]
    alone = replace(world.bare, robots=(replace(robot, target=goal, waypoints=()),))
    report = check_certificate(alone, replace(cut, waypoint=0), radius=radius)
    name = "the target"
    if cut.waypoint:
        name = f"waypoint {cut.waypoint} of {len(robot.waypoints)}, at ({goal.x:g}, {goal.y:g})"
    return CheckReport(report.valid, f"{name}: {report.reason}", report.clearance)


def _check_waypoints(world: World, witness: Witness, is_about_robot: bool) -> str:
    """Check that points of a path are in all waypoints, in order; return this as words.

    Args:
        world: The world.
        witness: The path, whose end is checked elsewhere.
        is_about_robot: Whether its headings count; those of a disc that turns on the spot do not.
    """
    robot = world.robots[0]
    after = 0
    for number, goal in enumerate(robot.waypoints, start=1):
        away = np.hypot(witness.x - goal.x, witness.y - goal.y)
        is_there = away <= goal.radius + TOLERANCE * world.cell_size
        if goal.heading is not None and witness.headings is not None and is_about_robot:
            wanted = math.remainder(goal.heading, math.tau)
            off = np.abs((witness.headings - wanted + math.pi) % math.tau - math.pi)
            is_there &= off <= goal.heading_tolerance + 1e-9
        # A later goal is met at the same point at the earliest.
        found = np.flatnonzero(is_there[after:])
        after += _first(found)
        where = f"at ({goal.x:g}, {goal.y:g})"
        _require(
            len(found) > 0,
            f"no point of the witness is in waypoint {number} of {len(robot.waypoints)}, {where}, "
            f"after the goals before it",
        )
    count = len(robot.waypoints)
    which = {1: "the waypoint", 2: "both waypoints"}.get(count, f"all {count} waypoints")
    return f" and leads through {which}"


def _check_for_robot(world: World, certificate: Witness | Cut, measured: list[float]) -> str:
    """Check a proof about a robot with a footprint, a car's drive, or a goal of its own."""
    robot = world.robots[0]
    size = world.cell_size
    body = None if robot.is_disc else footprint_of(robot, size)
    if isinstance(certificate, Cut) and certificate.boxes is not None:
        _require(body is not None, "the cut is about a footprint, and the robot is a disc")
        reason = check_boxes(world, certificate.boxes, certificate.clearance)
        measured[0] = certificate.clearance
        return reason
    if isinstance(certificate, Cut):
        # A chain that stops the disc inside a body stops the body.
        # Floats may have made the disc inside larger than it is; one that just fits is not stopped.
        radius = robot.radius if body is None else body.inner * size * (1.0 - 1e-9)
        _require(radius > 0.0, "the footprint holds no disc about the axle that a chain could stop")
        return _check_cut(world, certificate, radius, measured)
    if robot.drive.is_car:
        fault = car_fault(world, certificate)
        _require(fault is None, str(fault))
    headings = certificate.headings
    if body is None:
        _check_witness(world, certificate, robot.radius, measured)
        return f"the path is clear for discs of up to {measured[0]:.6g} m"
    if headings is None:
        raise _Refused("a footprint's witness needs headings")
    _check_body_path(world, certificate, headings, body, measured)
    return f"the path is clear for the footprint padded by {measured[0]:.6g} m"


def _check_body_path(
    world: World, witness: Witness, headings: Floats, body: Footprint, measured: list[float]
) -> None:
    """Check the poses of a footprint's path, its times, and its clearance."""
    size = world.cell_size
    out = body.outer if body.inner < 0 else 0.0
    # The path begins at the pose of the lattice that is nearest to the start.
    path = path_of(world, witness, off=LATTICE, out=out)
    _require(bool(np.isfinite(headings).all()), "the witness has a heading that is not finite")
    check_ends(world, headings)
    turns = np.repeat(headings, 2) if len(headings) == 1 else headings
    if world.robots[0].drive.is_car:
        path, turns = _half_turns(path, turns)
    # In a world that changes, the disc around the body may be what the times are made for.
    if world.is_dynamic:
        around, _ = _static_clearance(world, path)
        around, _ = _timed_clearance(world, path, around, "", body.outer + witness.clearance / size)
        if around >= body.outer + witness.clearance / size - TOLERANCE:
            measured[0] = max(0.0, (around - body.outer) * size)
            return
    claim = witness.clearance / size
    poses = BodyPath(path.x, path.y, turns)
    try:
        measured[0] = body_clearance(world, poses, claim) * size
    except Mistake:
        if not world.is_dynamic:
            raise
        # Some cell on the path is blocked at another time.
        spans = blocked_spans(world)
        measured[0] = timed_body_clearance(world, poses, path.times, spans, claim) * size


def _half_turns(path: WitnessPoints, turns: Floats) -> tuple[WitnessPoints, Floats]:
    """Return a car's path with each leg as it is driven: half of its turn, straight, and the rest.

    Half a turn is rounded towards zero to a heading of the lattice.

    Args:
        path: n points.
        turns: (n,) float64, rad, the headings at them.

    Returns:
        The path of 3 n - 2 points, and their headings.
    """
    unit = 2 * np.pi / 65536
    units = np.round(turns / unit)
    halves = np.trunc((np.remainder(np.diff(units) + 32768, 65536) - 32768) / 2)
    middle = (units[:-1] + halves) * unit
    legs = np.arange(len(middle))
    order = np.concatenate(([0], np.column_stack((legs, legs + 1, legs + 1)).ravel()))
    headings = np.column_stack((middle, middle, turns[1:])).ravel()
    points = WitnessPoints(path.times[order], path.x[order], path.y[order])
    return points, np.concatenate((turns[:1], headings))


def _check_joint(world: World, joint: JointWitness, radius: float | None) -> CheckReport:
    """Check the path of each robot alone, and then the distances between the robots."""
    # There must be a path for every robot.
    count = len(world.robots)
    if len(joint.paths) != count:
        return CheckReport(False, f"{len(joint.paths)} paths for {count} robots", 0.0)
    clearance = math.inf
    # Check each path alone.
    for number, path in enumerate(joint.paths, start=1):
        alone = world.alone(number)
        # The place where it parks has to be safe until the last robot arrives.
        report = check_certificate(alone, _waiting(path, joint.duration), radius=radius)
        if report.valid and _leaves_target(alone, path):
            report = CheckReport(False, "the path leaves the target again", report.clearance)
        if not report.valid:
            return CheckReport(False, f"robot {number}: {report.reason}", report.clearance)
        clearance = min(clearance, report.clearance)
    # Check that the robots stay apart.
    radii = [robot.radius if radius is None else radius for robot in world.robots]
    pair, half = nearest_pair(world, joint.paths, radii)
    clearance = min(clearance, half)
    if pair is not None:
        needed = radii[pair.first - 1] + radii[pair.second - 1]
        if not pair.distance >= needed - TOLERANCE * world.cell_size:
            reason = (
                f"robots {pair.first} and {pair.second} overlap at {pair.time:.6g} s: their "
                f"centres are {pair.distance:.9g} m apart, and their radii add up to {needed:.9g} m"
            )
            return CheckReport(False, reason, clearance)
    reason = f"the paths of all {count} robots are clear of walls and of each other"
    return CheckReport(True, reason, clearance)


def _waiting(path: Witness, until: float) -> Witness:
    """Return a path with a wait at its end."""
    if not path.times[-1] < until:
        return path
    times = np.append(path.times, until)
    x = np.append(path.x, path.x[-1])
    y = np.append(path.y, path.y[-1])
    return Witness(times, x, y, path.clearance)


def _leaves_target(world: World, path: Witness) -> bool:
    """Return True if a path leads into or across the target and ends a later piece outside it.

    A robot parks as soon as its centre is in its target, even in the middle of a step, so it could
    not drive such a path. Whole pieces count, not only their ends: a piece between two points
    outside can cross the target. Once a path has entered the target, the ends of its pieces are
    enough, because a disc is convex.
    """
    # Find the first piece that comes nearer than the target's radius.
    target = world.target
    x = path.x - target.x
    y = path.y - target.y
    nearest, _ = nearest_to_zero(x, y)
    enters = nearest < target.radius - TOLERANCE * world.cell_size
    if not enters.any():
        return False
    # The ends of that piece and of all later ones must be in the target.
    first = int(np.argmax(enters))
    ends = np.hypot(x, y)[min(first + 1, len(x) - 1) :]
    return not bool((ends <= target.radius * (1 + 1e-9)).all())


def _check_one_of_several(
    world: World, certificate: Witness | Cut, radius: float | None
) -> CheckReport:
    """Check a cut of one of several robots; if that robot cannot arrive, not all of them can."""
    if not isinstance(certificate, Cut):
        return CheckReport(False, "the witness covers one robot, but there are several", 0.0)
    if not 1 <= certificate.robot <= len(world.robots):
        return CheckReport(False, f"there is no robot {certificate.robot}", 0.0)
    report = check_certificate(world.alone(certificate.robot), certificate, radius=radius)
    return CheckReport(
        report.valid, f"robot {certificate.robot}: {report.reason}", report.clearance
    )


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise _Refused(otherwise)


def blocked_spans(world: World) -> BlockedSpans:
    """Return one row per uninterrupted state of each cell that changes."""
    # Sort the events by cell, then by time.
    line = world.timeline
    order = np.lexsort((np.arange(len(line)), line.times, line.iy, line.ix))
    ix = line.ix[order]
    iy = line.iy[order]
    begin = line.times[order]
    state = line.states[order].astype(np.int64)
    changes = (np.diff(ix) != 0) | (np.diff(iy) != 0)
    first = np.ones(len(ix), np.bool_)
    last = np.ones(len(ix), np.bool_)
    first[1:] = changes
    last[:-1] = changes
    # A state lasts until the cell's next event.
    end = np.full(len(ix), math.inf)
    end[:-1][~changes] = begin[1:][~changes]
    # Add each changing cell's state before its first event.
    ix = np.concatenate([ix, ix[first]])
    iy = np.concatenate([iy, iy[first]])
    begin, end = (
        np.concatenate([begin, np.zeros(int(first.sum()))]),
        np.concatenate([end, begin[first]]),
    )
    wall = np.where(
        world.walls[iy[len(state) :], ix[len(state) :]], int(CellState.SOLID), int(CellState.FREE)
    )
    state = np.concatenate([state, wall])
    kept = (state != int(CellState.FREE)) & (begin < end)
    return BlockedSpans(ix[kept], iy[kept], begin[kept], end[kept])


def _always_blocked(world: World, spans: BlockedSpans) -> Bools:
    """Return a (height, width) bool array: solid or burning at every time from 0 on."""
    blocked = world.still_walls
    order = np.lexsort((spans.begin, spans.iy, spans.ix))
    until: dict[tuple[int, int], float] = {}
    for ix, iy, begin, end in zip(
        spans.ix[order].tolist(),
        spans.iy[order].tolist(),
        spans.begin[order].tolist(),
        spans.end[order].tolist(),
        strict=True,
    ):
        if begin <= until.get((ix, iy), 0.0):
            until[ix, iy] = end
    for (ix, iy), end in until.items():
        blocked[iy, ix] = end == math.inf
    return blocked


@dataclass(frozen=True)
class WitnessPoints:
    """A witness in cells and seconds, with at least two points."""

    times: Floats
    x: Floats
    y: Floats

    def shapes(self) -> npt.NDArray[np.object_]:
        """Return one shape per piece: a line, or a point where the robot stands still."""
        points = np.stack([self.x, self.y], axis=1)
        return _lines(points[:-1], points[1:])

    def parts(self, piece: Ints, low: Floats, high: Floats) -> npt.NDArray[np.object_]:
        """Return the part of each piece that the robot drives between ``low`` and ``high``."""
        begin = self.times[piece]
        length = np.diff(self.times)[piece]
        length = np.where(length > 0, length, 1.0)
        ends = []
        for share in ((low - begin) / length, (high - begin) / length):
            ends.append(
                np.stack([v[piece] + share * np.diff(v)[piece] for v in (self.x, self.y)], axis=1)
            )
        return _lines(ends[0], ends[1])


def _lines(a: Floats, b: Floats) -> npt.NDArray[np.object_]:
    shapes = np.asarray(shapely.linestrings(np.stack([a, b], axis=1)))
    # GEOS fails on lines of almost no length.
    still = np.abs(a - b).max(axis=1) < 1e-12
    shapes[still] = shapely.points(a[still])
    return shapes


def _check_witness(world: World, witness: Witness, radius: float, measured: list[float]) -> None:
    size = world.cell_size
    path = path_of(world, witness)
    clearance, where = _static_clearance(world, path)
    if world.is_dynamic:
        clearance, where = _timed_clearance(
            world, path, clearance, where, max(radius, witness.clearance) / size
        )
    measured[0] = max(clearance * size, 0.0)
    _require(
        clearance >= radius / size - TOLERANCE,
        f"the witness comes within {clearance * size:.9g} m of {where}; the radius is {radius} m",
    )
    _require(
        clearance >= witness.clearance / size - TOLERANCE,
        f"the witness claims {witness.clearance} m of clearance but has {clearance * size:.9g} m, "
        f"at {where}",
    )


def path_of(
    world: World, witness: Witness, *, off: float = TOLERANCE, out: float = 0.0
) -> WitnessPoints:
    """Return the witness if its ends are right, it stays in the grid, and it keeps to the speed.

    Args:
        world: The world.
        witness: The path.
        off: Cells by which it may begin next to the start.
        out: Cells by which it may leave the grid.
    """
    # The times must begin at 0 and never go back.
    times = witness.times
    x = witness.x
    y = witness.y
    size = world.cell_size
    finite = all(np.isfinite(values).all() for values in (times, x, y))
    _require(
        len(times) > 0 and finite, "the witness has no points, or has a number that is not finite"
    )
    _require(bool(times[0] == 0.0), f"the witness starts at {times[0]} s, not at 0 s")
    falls = np.nonzero(times[1:] < times[:-1])[0]
    _require(not len(falls), f"the witness goes back in time after point {_first(falls)}")
    # The path must stay in the grid, and lead from the start into the target.
    x = x / size
    y = y / size
    most = out + TOLERANCE
    inside = (x >= -out) & (y >= -out) & (x <= world.width + most) & (y <= world.height + most)
    _require(
        bool(inside.all()), f"the witness leaves the grid at point {_first(np.nonzero(~inside)[0])}"
    )
    away = math.dist((x[0], y[0]), (world.start.x / size, world.start.y / size))
    _require(away <= off, f"the witness starts {away * size:.3g} m from the start")
    missed = (
        math.dist((x[-1], y[-1]), (world.target.x / size, world.target.y / size))
        - world.target.radius / size
    )
    _require(
        missed <= TOLERANCE, f"the witness ends {missed * size:.3g} m outside the target's disc"
    )
    # The robot must be able to drive that fast.
    steps = np.sqrt(np.diff(x) ** 2 + np.diff(y) ** 2)
    waits = np.diff(times)
    fast = np.nonzero(steps > world.robot_speed / size * waits * (1 + SPEED_TOLERANCE) + 1e-11)[0]
    _require(
        not len(fast),
        f"the witness is faster than {world.robot_speed} m/s after point {_first(fast)}",
    )
    if len(times) == 1:
        return WitnessPoints(np.repeat(times, 2), np.repeat(x, 2), np.repeat(y, 2))
    return WitnessPoints(times, x, y)


def _first(found: Indices) -> int:
    return int(found[0]) if len(found) else 0


def _static_clearance(world: World, path: WitnessPoints) -> tuple[float, str]:
    """Return the distance, cells, from a path to the nearest permanent wall or the outside."""
    # The outside is the complement of a convex box, so the path is nearest to it at one of its
    # points.
    rim = min(path.x.min(), path.y.min(), world.width - path.x.max(), world.height - path.y.max())
    clearance = float(rim)
    where = "the outside of the grid"
    runs = np.diff(np.pad(world.still_walls, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    iy, begin = np.nonzero(runs == 1)
    # Boxes of runs of solid cells in a row are far fewer than cells.
    end = np.nonzero(runs == -1)[1]
    if len(iy):
        tree = shapely.STRtree(shapely.box(begin, iy, end, iy + 1))
        (_, boxes), distances = tree.query_nearest(
            path.shapes(), all_matches=False, return_distance=True
        )
        nearest = int(np.argmin(distances))
        if distances[nearest] < clearance:
            box = boxes[nearest]
            clearance = float(distances[nearest])
            where = f"cells {begin[box]} to {end[box] - 1} of row {iy[box]}"
    return clearance, where


def _timed_clearance(
    world: World, path: WitnessPoints, clearance: float, where: str, claim: float
) -> tuple[float, str]:
    """Return the same for changing cells, while they are solid or burning.

    The result is at most the claim plus one cell.
    """
    # Spans that begin after the arrival do not matter.
    spans = blocked_spans(world)
    begin = path.times[:-1]
    end = path.times[1:]
    early = spans.begin <= end[-1]
    ix = spans.ix[early]
    iy = spans.iy[early]
    since = spans.begin[early]
    until = spans.end[early]
    # Find the pieces that come near a blocked cell while it is blocked.
    reach = max(0.0, min(clearance, claim + 1.0))
    boxes = shapely.box(ix, iy, ix + 1, iy + 1)
    cell, piece = shapely.STRtree(path.shapes()).query(boxes, predicate="dwithin", distance=reach)
    meet = (since[cell] <= end[piece]) & (until[cell] > begin[piece])
    cell = cell[meet]
    piece = piece[meet]
    if not len(cell):
        return reach, where
    # Measure the parts driven in that time.
    low = np.maximum(since[cell], begin[piece])
    high = np.minimum(until[cell], end[piece])
    distances = shapely.distance(path.parts(piece, low, high), boxes[cell])
    at = int(np.argmin(distances))
    if distances[at] >= reach:
        return reach, where
    named = (
        f"cell ({ix[cell[at]]}, {iy[cell[at]]}), blocked at that time, between {low[at]:.6g} s "
        f"and {high[at]:.6g} s"
    )
    return float(distances[at]), named


def _check_cut(world: World, cut: Cut, radius: float, measured: list[float]) -> str:
    # Measure the gaps, and compare them with the claim and the disc.
    cells = [(int(ix), int(iy)) for ix, iy in cut.cells]
    _require(len(cells) > 0, "the cut has no cells")
    gaps = [_gap_sq(a, b) for a, b in zip(cells, [*cells[1:], cells[0]], strict=True)]
    wide = max(gaps)
    measured[0] = math.sqrt(wide) / 2 * world.cell_size
    _require(
        cut.clearance < radius,
        f"the cut stops discs above {cut.clearance} m; the radius is {radius} m",
    )
    _require(
        cut.clearance * (1 + 1e-12) >= measured[0],
        f"the cut claims to stop discs above {cut.clearance} m but has a gap of twice "
        f"{measured[0]:.9g} m",
    )
    # Cells must be in the grid or just outside it.
    for ix, iy in cells:
        near = -1 <= ix <= world.width and -1 <= iy <= world.height
        _require(near, f"cell ({ix}, {iy}) of the cut is beyond the ring of cells around the grid")
    in_cells = _decimal(radius) / _decimal(world.cell_size)
    at = gaps.index(wide)
    _require(
        wide < (2 * in_cells) ** 2,
        f"the gap between cells {cells[at]} and {cells[(at + 1) % len(cells)]} is not too narrow "
        f"to pass",
    )
    # The start or the grid may rule out the disc immediately.
    spans = blocked_spans(world)
    if _start_is_covered(world, cells, in_cells, spans):
        return "the start is closer to a solid cell than the radius"
    if 2 * in_cells > min(world.width, world.height):
        return "the robot is wider than the grid"
    # Every cell must be blocked at all times.
    blocked = _always_blocked(world, spans)
    for ix, iy in cells:
        outside = not (0 <= ix < world.width and 0 <= iy < world.height)
        _require(
            outside or bool(blocked[iy, ix]), f"cell ({ix}, {iy}) of the cut is free at some time"
        )
    return _check_sides(world, cells, in_cells, blocked)


def _decimal(value: float) -> Fraction:
    """Return the number given by the shortest decimal of a float."""
    return Fraction(repr(float(value)))


def _gap_sq(a: tuple[int, int], b: tuple[int, int]) -> int:
    return max(abs(a[0] - b[0]) - 1, 0) ** 2 + max(abs(a[1] - b[1]) - 1, 0) ** 2


def _start_is_covered(
    world: World, cells: list[tuple[int, int]], radius: Fraction, spans: BlockedSpans
) -> bool:
    """Return True if a chain cell solid or burning at time 0 is too near to the start."""
    now = world.still_walls
    at_once = spans.begin == 0.0
    now[spans.iy[at_once], spans.ix[at_once]] = True
    x, y = (_decimal(value) / _decimal(world.cell_size) for value in (world.start.x, world.start.y))
    for ix, iy in cells:
        solid = not (0 <= ix < world.width and 0 <= iy < world.height) or bool(now[iy, ix])
        dx = max(ix - x, Fraction(0), x - ix - 1)
        dy = max(iy - y, Fraction(0), y - iy - 1)
        if solid and dx * dx + dy * dy < radius * radius:
            return True
    return False


def _check_sides(
    world: World, cells: list[tuple[int, int]], radius: Fraction, blocked: Bools
) -> str:
    """Check that the chain separates every clear pose in the target's disc from the start."""
    size = _decimal(world.cell_size)
    start = (_decimal(world.start.x) / size, _decimal(world.start.y) / size)
    target = (_decimal(world.target.x) / size, _decimal(world.target.y) / size)
    line = _closed_line(cells)
    reach = _decimal(world.target.radius) / size
    home = _winds_round(line, start)
    if home != _winds_round(line, target) and len(cells) > 1:
        ring = shapely.LineString([(float(px), float(py)) for px, py in line])
        if (
            shapely.Point(float(target[0]), float(target[1])).distance(ring)
            > float(reach) + TOLERANCE
        ):
            return "the chain separates the start from the whole target"
    try:
        poses = poses_to_part(blocked, radius, target, reach)
    except TooMuch:
        raise _Refused("the target's disc is too large to examine all of its poses") from None
    left = sum(_winds_round(line, pose) == home for pose in poses)
    _require(left == 0, "the chain does not separate the start from every clear pose of the target")
    if not poses:
        return "no pose in the target's disc is clear"
    return "the chain separates the start from every clear pose of the target"


def _closed_line(cells: list[tuple[int, int]]) -> list[tuple[Fraction, Fraction]]:
    """Return the chain as points: each cell's centre and the closest points to the next cell.

    Points are in cells.
    """
    half = Fraction(1, 2)
    line = []
    for a, b in zip(cells, [*cells[1:], cells[0]], strict=True):
        toward = [(b[k] > a[k]) - (b[k] < a[k]) for k in (0, 1)]
        line.append((a[0] + half, a[1] + half))
        line.append((a[0] + half + half * toward[0], a[1] + half + half * toward[1]))
        line.append((b[0] + half - half * toward[0], b[1] + half - half * toward[1]))
    return [*line, line[0]]


def _winds_round(line: list[tuple[Fraction, Fraction]], point: tuple[Fraction, Fraction]) -> bool:
    """Return True if a closed line winds around a point an odd number of times, exactly."""
    x, y = point
    odd = False
    for (ax, ay), (bx, by) in itertools.pairwise(line):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            odd = not odd
    return odd
