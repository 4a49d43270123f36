"""Judge whether a trajectory recorded in any simulator, or a plan, is possible in a world.

This is an independent referee that shares no code with the simulator. It assumes that the centre
moves on a straight line or an arc at constant speed between two samples. ``docs/howto/audit.md``
explains each kind of finding and how exact it is.
"""

from __future__ import annotations

import math
import typing
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from sim.audit.arrival import arrival_times, ends_in_target
from sim.audit.bodies import scan_body
from sim.audit.path import AuditPath, Samples, along_arcs
from sim.audit.polygon import Body
from sim.audit.scan import Hits, Scan, merged, scan
from worldgen.errors import InvalidParameter
from worldgen.lattice import UNIT
from worldgen.logs.trajectory import FURTHEST, Trajectory
from worldgen.robot_overrides import describe_waypoint
from worldgen.support.arrays import Floats
from worldgen.timeline import Timeline
from worldgen.world import World

Interpolation: TypeAlias = Literal["line", "arc"]
INTERPOLATIONS: tuple[Interpolation, ...] = typing.get_args(Interpolation)

KINDS = ("tunnel", "overlap", "outside", "jump", "burned", "start")
# Depth up to which a cut is not reported, m.
DEFAULT_TOLERANCE = 1e-6

# The audit's own precision, m.
LEAST_TOLERANCE = 1e-9

# Fraction by which a move may exceed the robot's speed, because recorded times are rounded.
SPEED_TOLERANCE = 1e-6

# Distance by which a move may be too long, in cells, because recorded positions are rounded.
_SLACK = 1 / 256


@dataclass(frozen=True)
class Finding:
    """A continuous stretch of something impossible.

    Args:
        kind: ``tunnel``, ``overlap``, ``outside``, ``jump``, ``burned`` or ``start``.
        t: Time when it was worst, s; the earliest if there are several. In a plan, times are
            numbers of poses, from 0: 3.25 is a quarter of the way from pose 3 to pose 4.
        x: Position of the centre, or of a body's axle, at that time, m.
        y: The same, m.
        depth: Largest extent, m. For a ``tunnel``, the distance from the centre to the
            nearest face of the cell that it is in. For ``overlap`` and ``burned``, the radius minus
            the distance to the cell; for a body with a footprint, the distance from the cell's
            deepest point to the body's nearest side. For ``outside``, the distance from the centre
            to the grid. For a ``jump``, how much farther it went than possible. For ``start``, the
            distance from the first sample to the start.
        cell: Cell (ix, iy) at the worst place; -1 or the grid's width or height mean the outside.
            ``None`` for findings without a cell.
        begin: Time when it began, s.
        end: Time when it ended, s.
        sample: Number of the last sample at or before the worst place, from 0.
        speed: Largest speed of a ``jump``, m/s; ``inf`` if it took no time.
        heading: Heading at that time, rad, for an overlap of a body with a footprint.
    """

    kind: str
    t: float
    x: float
    y: float
    depth: float
    cell: tuple[int, int] | None
    begin: float
    end: float
    sample: int
    speed: float = 0.0
    heading: float | None = None


@dataclass(frozen=True)
class Audit:
    """The result of an audit.

    Args:
        findings: Everything impossible, in order of when it began.
        notes: Remarks that are not findings.
        samples: Number of samples.
        reached: Time when the robot first arrived as the world's goal asks, s; ``None`` if it never
            did. In a plan, the number of the pose.
        path_length: Length of the path, m.
        duration: Time from the first sample to the last, s; ``None`` for a plan.
        clearance: Smallest distance of the centre to the outside or to anything solid or burning at
            that time, m. It is the radius of the largest disc that could have taken this path. For
            a body with a footprint, the smallest distance of the body, 0 if it overlapped.
        nearest: Time (s) and position (m, m) of that smallest distance.
        shaved: Number of moves whose straight line cuts a corner between clear samples, which does
            not count as a finding.
        shaved_depth: Depth of the deepest such cut, m.
        is_plan: Whether it was a plan without times.
    """

    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    samples: int
    reached: float | None
    path_length: float
    duration: float | None
    clearance: float
    nearest: tuple[float, float, float]
    shaved: int
    shaved_depth: float
    is_plan: bool = False

    @property
    def ok(self) -> bool:
        """True if the trajectory was possible."""
        return not self.findings


def audit(
    world: World,
    trajectory: Trajectory,
    *,
    tolerance: float = DEFAULT_TOLERANCE,
    slack: float | None = None,
    straight: bool = False,
    from_start: bool = False,
    interpolate: Interpolation | None = None,
) -> Audit:
    """Judge whether a trajectory was possible in a world.

    Args:
        world: The world, including its robot's body and speed.
        trajectory: The recorded trajectory, or a plan.
        tolerance: Depth up to which a cut of the body is not reported, m.
        slack: How much farther apart than speed and time allow two samples may be, m, because
            recorded positions are rounded; 1/256 of a cell if omitted.
        straight: True if the robot is known to move as interpolated from sample to sample. If not,
            a short line whose ends are clear may cut a corner, as it does when the robot slides
            around it. Plans are always taken at their word.
        from_start: True to report it as a finding if the first sample is not at the world's start.
        interpolate: ``line``: between two samples, the robot drives straight and, if it has a
            footprint, turns on the spot before or after that, whichever fits better. ``arc``: it
            drives with constant speed, turn rate and direction in its own frame. By default, a car
            whose headings are recorded drives arcs, and all others lines.

    Returns:
        Findings and figures.

    Raises:
        InvalidParameter: If tolerance or slack are out of range, a position is absurdly far away,
            or headings are missing that are needed.
    """
    slack = world.cell_size * _SLACK if slack is None else slack
    _check("tolerance", tolerance, LEAST_TOLERANCE)
    _check("slack", slack, 0.0)
    size = world.cell_size
    _check_places(trajectory, size)
    robot = world.robots[0]
    if interpolate is None:
        is_known = trajectory.headings is not None
        interpolate = "arc" if robot.drive.is_car and is_known else "line"
    _check_headings(trajectory, interpolate, is_disc=robot.is_disc)

    # A plan without times is judged in the world as it is at first.
    notes = []
    if trajectory.is_plan and world.is_dynamic:
        world = replace(world, timeline=Timeline())
        notes.append("the plan has no times, so it is judged in the world as it is at 0 s")
    samples = Samples(trajectory.times, trajectory.x, trajectory.y, trajectory.headings)
    is_literal = straight or trajectory.is_plan
    if interpolate == "arc":
        grain = tolerance if robot.is_disc else size / UNIT
        samples = along_arcs(samples, grain)

    # Collect findings along the path, of moves that are too fast, and of the start.
    way = AuditPath(world, samples)
    result = scan(way, robot.radius / size, tolerance / size, straight=is_literal)
    if not robot.is_disc:
        body = Body.of(robot, size)
        result = _of_body(result, way, body, tolerance / size, interpolate, literal=is_literal)
        if not body.holds_axle:
            notes.append("the axle is outside the footprint, so only overlaps of the body count")
    findings: list[Finding] = []
    for kind, hits in result.hits.items():
        findings += _findings(kind, hits, way, size)
    if not trajectory.is_plan:
        findings += _jumps(world, trajectory, way.lengths, slack)
    elsewhere = _elsewhere(world, trajectory, max(tolerance, slack))
    findings += elsewhere if from_start else []
    findings.sort(key=lambda finding: (finding.begin, finding.sample, KINDS.index(finding.kind)))
    return _report(world, trajectory, way, result, findings, [] if from_start else elsewhere, notes)


def _of_body(
    result: Scan,
    way: AuditPath,
    body: Body,
    tolerance: float,
    interpolate: Interpolation,
    *,
    literal: bool,
) -> Scan:
    """Return the scan of a body, with the tunnels and ways outside of its axle."""
    own = scan_body(way, body, tolerance, arcs=interpolate == "arc", literal=literal)
    if body.holds_axle:
        own.hits |= {kind: result.hits[kind] for kind in ("tunnel", "outside")}
    return own


def _check(name: str, value: float, least: float) -> None:
    if not least <= value < math.inf:
        raise InvalidParameter(
            "out-of-range",
            "{name}={value} m is out of range",
            "use metres, at least {least:g}",
            name=name,
            value=value,
            least=least,
        )


def _check_places(trajectory: Trajectory, size: float) -> None:
    far = np.flatnonzero(np.maximum(np.abs(trajectory.x), np.abs(trajectory.y)) / size > FURTHEST)
    if len(far):
        raise InvalidParameter(
            "out-of-range",
            "sample {sample} is more than 1e9 cells of {cell_size:g} m away",
            "use metres",
            sample=far[0],
            cell_size=size,
        )


def _check_headings(trajectory: Trajectory, interpolate: Interpolation, *, is_disc: bool) -> None:
    if trajectory.headings is None and (interpolate == "arc" or not is_disc):
        raise InvalidParameter(
            "no-headings",
            "the trajectory has no headings, and {why}",
            "give them in rad, in a log as a column heading, yaw or theta",
            why="an arc needs them" if is_disc else "the robot's body is not a disc",
        )


def _findings(kind: str, hits: Hits, way: AuditPath, unit: float) -> list[Finding]:
    t, x, y = way.place(hits.worst)
    begin = way.place(hits.begin)[0]
    end = way.place(hits.end)[0]
    sample = np.floor(way.recorded(hits.worst)).astype(int)
    columns = (t, x, y, hits.depth * unit, hits.ix, hits.iy, begin, end, sample, hits.heading)
    return [
        Finding(
            kind, t, x, y, depth, (ix, iy), begin, end, sample,
            heading=None if math.isnan(heading) else math.remainder(heading, 2.0 * math.pi),
        )
        for t, x, y, depth, ix, iy, begin, end, sample, heading in zip(
            *(column.tolist() for column in columns), strict=True
        )
    ]  # fmt: skip


def _elsewhere(world: World, trajectory: Trajectory, allowed: float) -> list[Finding]:
    """Return a finding if the first sample is further than ``allowed`` m from the world's start."""
    t = float(trajectory.times[0])
    x = float(trajectory.x[0])
    y = float(trajectory.y[0])
    away = math.dist((x, y), (world.start.x, world.start.y))
    return [Finding("start", t, x, y, away, None, t, t, 0)] if away > allowed else []


def _jumps(world: World, trajectory: Trajectory, steps: Floats, slack: float) -> list[Finding]:
    """Return the moves that are faster than the robot, each at the end of its worst move.

    Args:
        world: The world.
        trajectory: The trajectory.
        steps: (n - 1,) Length of each move, m.
        slack: How much longer it may be, m.
    """
    allowed = world.robot_speed * np.diff(trajectory.times) * (1.0 + SPEED_TOLERANCE)
    rows = np.flatnonzero(steps > allowed + slack)
    excess: Floats = steps[rows] - world.robot_speed * np.diff(trajectory.times)[rows]
    # Treat each move as a stretch of the path, so that consecutive ones merge into one finding.
    nowhere = np.zeros(len(rows), np.int64)
    ones = np.ones(len(rows))
    moves = Hits(0.0 * ones, ones, excess, ones, nowhere, nowhere).of_moves(rows)
    found = merged(moves, grain=LEAST_TOLERANCE)
    jumps = []
    for begin, end, worst, depth in zip(
        found.begin, found.end, found.worst, found.depth, strict=True
    ):
        at = int(worst)
        t = float(trajectory.times[at])
        x = float(trajectory.x[at])
        y = float(trajectory.y[at])
        span = float(trajectory.times[int(begin)]), float(trajectory.times[int(end)])
        lasts = t - float(trajectory.times[at - 1])
        speed = float(steps[at - 1]) / lasts if lasts > 0.0 else math.inf
        jumps.append(Finding("jump", t, x, y, float(depth), None, *span, at, speed))
    return jumps


def _report(
    world: World,
    trajectory: Trajectory,
    way: AuditPath,
    result: Scan,
    findings: list[Finding],
    elsewhere: list[Finding],
    remarks: list[str],
) -> Audit:
    # Collect notes: facts that may explain a finding, or the lack of one.
    size = world.cell_size
    times = trajectory.times
    notes = [
        f"the first sample ({found.x:.6g}, {found.y:.6g}) m is {found.depth:.6g} m away from the "
        f"world's start"
        for found in elsewhere
    ]
    notes += remarks
    if world.is_dynamic and times[0] != 0.0:
        notes.append(
            f"the first sample is at {times[0]:.9g} s, but the world's changes are timed from 0 s"
        )
    depth = result.shaved_depth * size
    if result.shaved:
        notes.append(
            f"{result.shaved} straight line{'s' if result.shaved > 1 else ''} between clear "
            f"samples cut a corner, by up to {depth:.3g} m; --straight counts them"
        )
    nearest = way.place(np.array([result.nearest]))
    robot = world.robots[0]
    arrivals = arrival_times(robot.goals, way, is_plan=trajectory.is_plan)
    reached = arrivals[-1] if len(arrivals) == len(robot.goals) else None
    if robot.waypoints and reached is None:
        notes.append(f"never reaches {describe_waypoint(robot, len(arrivals))}")
    elif reached is None and not trajectory.is_plan and ends_in_target(world.target, way):
        notes.append("the path ends in the target, but nothing shows that the robot stood there")
    return Audit(
        findings=tuple(findings),
        notes=tuple(notes),
        samples=len(times),
        reached=reached,
        path_length=float(np.sum(way.lengths)),
        duration=None if trajectory.is_plan else float(times[-1] - times[0]),
        clearance=result.clearance * size,
        nearest=(float(nearest[0][0]), float(nearest[1][0]), float(nearest[2][0])),
        shaved=result.shaved,
        shaved_depth=depth,
        is_plan=trajectory.is_plan,
    )
