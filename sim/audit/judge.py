"""Judge whether a trajectory recorded in any simulator was possible in a world.

This is an independent referee that shares no code with the simulator. It assumes that the centre
moves on a straight line at constant speed between two samples. ``docs/howto/audit.md`` explains
each kind of finding and how exact it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.audit.path import AuditPath
from sim.audit.scan import Hits, Scan, merged, scan
from worldgen.errors import InvalidParameter, Message
from worldgen.support.arrays import Floats
from worldgen.world import World

KINDS = ("tunnel", "overlap", "outside", "jump", "burned", "start")
# Depth up to which a cut is not reported, m.
DEFAULT_TOLERANCE = 1e-6

# The audit's own precision, m.
LEAST_TOLERANCE = 1e-9

# Fraction by which a move may exceed the robot's speed, because recorded times are rounded.
SPEED_TOLERANCE = 1e-6

# Distance by which a move may be too long, in cells, because recorded positions are rounded.
_SLACK = 1 / 256

# Largest coordinate, m and also cells.
_FURTHEST = 1e9

# Largest time, s.
_LATEST = 1e12


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The recorded positions of the robot's centre.

    Args:
        times: (n,) float64, s, finite and never decreasing; at least two.
        x: (n,) float64, m, in the world's frame.
        y: (n,) float64, m, in the world's frame.

    Raises:
        InvalidParameter: If the arrays break these rules; the message names the sample, counted
            from 0.
    """

    times: Floats
    x: Floats
    y: Floats

    def __post_init__(self) -> None:
        for name in ("times", "x", "y"):
            array = np.array(getattr(self, name), np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        fault = self.fault(self.times, self.x, self.y)
        if fault is not None:
            sample, message = fault
            if sample >= 0:
                message = message.behind("trajectory: sample {sample}: ", sample=sample)
            raise InvalidParameter.of(message)

    @staticmethod
    def fault(times: Floats, x: Floats, y: Floats) -> tuple[int, Message] | None:
        """Return the first sample that breaks a rule, and a message about it.

        The sample is -1 if the fault is in the trajectory as a whole. Without a fault, return
        ``None``.
        """
        if not (times.ndim == x.ndim == y.ndim == 1 and len(times) == len(x) == len(y)):
            return -1, Message(
                "wrong-shape", "trajectory: times, x and y must be flat arrays of equal length"
            )
        if len(times) < 2:
            return -1, Message(
                "too-few-samples",
                "a trajectory needs at least two samples, not {count}",
                "use more",
                count=len(times),
            )
        for name, values, most in (("t", times, _LATEST), ("x", x, _FURTHEST), ("y", y, _FURTHEST)):
            with np.errstate(invalid="ignore"):
                wrong = np.flatnonzero(~(np.isfinite(values) & (np.abs(values) <= most)))
            if len(wrong):
                unit = "seconds" if name == "t" else "metres"
                value = float(values[wrong[0]])
                return int(wrong[0]), Message(
                    "out-of-range",
                    "{name} = {value:g} is not a number of {unit}, or is too large",
                    "remove lines like this one",
                    name=name,
                    value=value,
                    unit=unit,
                )
        falls = np.flatnonzero(times[1:] < times[:-1])
        if len(falls):
            at = int(falls[0]) + 1
            return at, Message(
                "times-fall",
                "t = {time!r} s comes after {before!r} s",
                "sort the samples by time",
                time=float(times[at]),
                before=float(times[at - 1]),
            )
        return None


@dataclass(frozen=True)
class Finding:
    """A continuous stretch of something impossible.

    Args:
        kind: ``tunnel``, ``overlap``, ``outside``, ``jump``, ``burned`` or ``start``.
        t: Time when it was worst, s; the earliest if there are several.
        x: Position of the centre at that time, m.
        y: The same, m.
        depth: Largest extent, m. For a ``tunnel``, the distance from the centre to the
            nearest face of the cell that it is in. For ``overlap`` and ``burned``, the radius minus
            the distance to the cell. For ``outside``, the distance from the centre to the grid. For
            a ``jump``, how much farther it went than possible. For ``start``, the distance from the
            first sample to the start.
        cell: Cell (ix, iy) at the worst place; -1 or the grid's width or height mean the outside.
            ``None`` for findings without a cell.
        begin: Time when it began, s.
        end: Time when it ended, s.
        sample: Number of the last sample at or before the worst place, from 0.
        speed: Largest speed of a ``jump``, m/s; ``inf`` if it took no time.
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


@dataclass(frozen=True)
class Audit:
    """The result of an audit.

    Args:
        findings: Everything impossible, in order of when it began.
        notes: Remarks that are not findings.
        samples: Number of samples.
        reached: Time when the centre was first in the target, s; ``None`` if it never was.
        path_length: Length of the path, m.
        duration: Time from the first sample to the last, s.
        clearance: Smallest distance of the centre to the outside or to anything solid or burning at
            that time, m. It is the radius of the largest disc that could have taken this path.
        nearest: Time (s) and position (m, m) of that smallest distance.
        shaved: Number of moves whose straight line cuts a corner between clear samples, which does
            not count as a finding.
        shaved_depth: Depth of the deepest such cut, m.
    """

    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    samples: int
    reached: float | None
    path_length: float
    duration: float
    clearance: float
    nearest: tuple[float, float, float]
    shaved: int
    shaved_depth: float

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
) -> Audit:
    """Judge whether a trajectory was possible in a world.

    Args:
        world: The world, including its robot's radius and speed.
        trajectory: The recorded trajectory.
        tolerance: Depth up to which a cut of the disc is not reported, m.
        slack: How much farther apart than speed and time allow two samples may be, m, because
            recorded positions are rounded; 1/256 of a cell if omitted.
        straight: True if the robot is known to move straight from sample to sample. If not, a line
            no longer than the radius whose ends are clear may cut a corner, as it does when the
            robot slides around it.
        from_start: True to report it as a finding if the first sample is not at the world's start.

    Returns:
        Findings and figures.

    Raises:
        InvalidParameter: If tolerance or slack are out of range, or a position is absurdly far
            away.
    """
    slack = world.cell_size * _SLACK if slack is None else slack
    _check("tolerance", tolerance, LEAST_TOLERANCE)
    _check("slack", slack, 0.0)
    size = world.cell_size
    _check_places(trajectory, size)

    # Collect findings along the path, of moves that are too fast, and of the start.
    way = AuditPath(world, trajectory.times, trajectory.x, trajectory.y)
    result = scan(way, world.robot_radius / size, tolerance / size, straight=straight)
    findings: list[Finding] = []
    for kind, hits in result.hits.items():
        findings += _findings(kind, hits, way, size)
    findings += _jumps(world, trajectory, slack)
    elsewhere = _elsewhere(world, trajectory, max(tolerance, slack))
    findings += elsewhere if from_start else []
    findings.sort(key=lambda finding: (finding.begin, finding.sample, KINDS.index(finding.kind)))
    return _report(world, trajectory, way, result, findings, [] if from_start else elsewhere)


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
    far = np.flatnonzero(np.maximum(np.abs(trajectory.x), np.abs(trajectory.y)) / size > _FURTHEST)
    if len(far):
        raise InvalidParameter(
            "out-of-range",
            "sample {sample} is more than 1e9 cells of {cell_size:g} m away",
            "use metres",
            sample=far[0],
            cell_size=size,
        )


def _findings(kind: str, hits: Hits, way: AuditPath, unit: float) -> list[Finding]:
    t, x, y = way.place(hits.worst)
    begin = way.place(hits.begin)[0]
    end = way.place(hits.end)[0]
    sample = np.floor(hits.worst).astype(int)
    columns = (t, x, y, hits.depth * unit, hits.ix, hits.iy, begin, end, sample)
    return [
        Finding(kind, t, x, y, depth, (ix, iy), begin, end, sample)
        for t, x, y, depth, ix, iy, begin, end, sample in zip(
            *(column.tolist() for column in columns), strict=True
        )
    ]


def _elsewhere(world: World, trajectory: Trajectory, allowed: float) -> list[Finding]:
    """Return a finding if the first sample is further than ``allowed`` m from the world's start."""
    t = float(trajectory.times[0])
    x = float(trajectory.x[0])
    y = float(trajectory.y[0])
    away = math.dist((x, y), (world.start.x, world.start.y))
    return [Finding("start", t, x, y, away, None, t, t, 0)] if away > allowed else []


def _jumps(world: World, trajectory: Trajectory, slack: float) -> list[Finding]:
    """Return the moves that are faster than the robot, each at the end of its worst move."""
    steps = np.hypot(np.diff(trajectory.x), np.diff(trajectory.y))
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
) -> Audit:
    # Collect notes: facts that may explain a finding, or the lack of one.
    size = world.cell_size
    times = trajectory.times
    notes = [
        f"the first sample ({found.x:.6g}, {found.y:.6g}) m is {found.depth:.6g} m away from the "
        f"world's start"
        for found in elsewhere
    ]
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
    return Audit(
        findings=tuple(findings),
        notes=tuple(notes),
        samples=len(times),
        reached=_reached(world, trajectory),
        path_length=float(np.sum(np.hypot(np.diff(trajectory.x), np.diff(trajectory.y)))),
        duration=float(times[-1] - times[0]),
        clearance=result.clearance * size,
        nearest=(float(nearest[0][0]), float(nearest[1][0]), float(nearest[2][0])),
        shaved=result.shaved,
        shaved_depth=depth,
    )


def _reached(world: World, trajectory: Trajectory) -> float | None:
    """Return the time when the centre first is in the target's disc, s."""
    # Find the first move that comes within the target's radius.
    x = trajectory.x - world.target.x
    y = trajectory.y - world.target.y
    ax = x[:-1]
    ay = y[:-1]
    dx = np.diff(x)
    dy = np.diff(y)
    square = dx * dx + dy * dy
    share = np.clip(-(ax * dx + ay * dy) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    gap = np.hypot(ax + share * dx, ay + share * dy)
    inside = np.flatnonzero(gap <= world.target.radius * (1.0 + 1e-9))
    if not len(inside):
        return None

    # Solve for the fraction of that move at which the centre enters the disc.
    row = int(inside[0])
    enter = float(share[row])
    along = math.sqrt(square[row])
    if math.hypot(ax[row], ay[row]) <= world.target.radius:
        enter = 0.0
    elif along > 0.0:
        across = (ax[row] * dy[row] - ay[row] * dx[row]) / along
        half = math.sqrt(max(world.target.radius**2 - across * across, 0.0))
        enter = max(-(ax[row] * dx[row] + ay[row] * dy[row]) / along - half, 0.0) / along
    begin = float(trajectory.times[row])
    end = float(trajectory.times[row + 1])
    return begin + min(enter, 1.0) * (end - begin)
