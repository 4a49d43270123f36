"""Was a trajectory, recorded in any simulator, possible in this world?

An independent referee: it shares no code with the simulator. Between two samples the centre moves
    on a straight line at
constant speed. ``docs/audit.md`` says what each finding means and how exact it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.audit.path import AuditPath
from sim.audit.scan import Hits, Scan, merged, scan
from worldgen.errors import InvalidParameter, Message
from worldgen.world import World

__all__ = [
    "DEFAULT_TOLERANCE",
    "KINDS",
    "LEAST_TOLERANCE",
    "Audit",
    "Finding",
    "Trajectory",
    "audit",
]

Floats = npt.NDArray[np.float64]

KINDS = ("tunnel", "overlap", "outside", "jump", "burned", "start")
DEFAULT_TOLERANCE = 1e-6  # m
LEAST_TOLERANCE = 1e-9  # m: the audit's own precision
SPEED_TOLERANCE = 1e-6  # share of the speed by which a move may be too fast
_SLACK = 1 / 256  # of a cell
_FURTHEST = 1e9  # m, and cells
_LATEST = 1e12  # s


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Where the centre of the robot was.

    Args:
        times: (n,) float64, s, finite, never falling; at least two.
        x: (n,) float64, m, in the world's frame.
        y: (n,) float64, m.

    Raises:
        InvalidParameter: If that does not hold; the message names the sample, counted from 0.
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
        """The first sample that breaks a rule, -1 for the whole, and what is wrong.

        ``None`` if all is well.
        """
        if not (times.ndim == x.ndim == y.ndim == 1 and len(times) == len(x) == len(y)):
            return -1, Message(
                "wrong-shape", "trajectory: times, x and y must be flat arrays of one length"
            )
        if len(times) < 2:
            return -1, Message(
                "too-few-samples",
                "a trajectory has at least two samples, not {count}",
                "give more",
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
                    "{name} = {value:g} is no number of {unit}, or too large",
                    "leave such lines out",
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
    """Something that was not possible, from its begin to its end without a break.

    Args:
        kind: ``tunnel``, ``overlap``, ``outside``, ``jump``, ``burned`` or ``start``.
        t: s; when it was worst, the first time if it was so several times.
        x: m; where the centre was then.
        y: m.
        depth: m, at worst. Of a ``tunnel``: from the centre to the nearest face of the cell that it
            is in. Of ``overlap`` and ``burned``: radius minus distance to the cell. Of ``outside``:
                from the centre to the grid.
            Of a ``jump``: how much further it went than it could. Of ``start``: from the first
                sample to the start.
        cell: (ix, iy) of the cell, at worst; -1 or the grid's side stand for the outside. ``None``
            where it has none.
        begin: s.
        end: s.
        sample: Number of the last sample at or before the worst place, from 0.
        speed: m/s; of a ``jump``, at worst: ``inf`` if it took no time.
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
    """What an audit found.

    Args:
        findings: In order of their begin.
        notes: Sentences about what is worth knowing, but no fault.
        samples: Number of samples.
        reached: When the centre first was in the target, s; ``None`` if it never was.
        path_length: m.
        duration: s.
        clearance: m: least distance of the centre to anything solid or burning at that time, or to
            the outside: the radius of the largest disc that could have gone this way.
        nearest: Time (s) and place (m, m) of it.
        shaved: Moves whose straight line cuts a corner between clear samples, which is not held
            against them.
        shaved_depth: m: the deepest such cut.
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
        """Whether nothing was found."""
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
    """Looks whether a trajectory was possible in a world.

    Args:
        world: The world; its robot's radius and speed count.
        trajectory: What was recorded.
        tolerance: Cut of the disc, m, that is not reported.
        slack: How much further, m, two samples may be apart than speed and time allow: recorded
            places are rounded. 1/256 of a cell if left out.
        straight: Whether the robot surely went straight from sample to sample. If not, a line no
            longer than the radius whose ends are clear may cut a corner, as it does when the robot
            slides round it.
        from_start: Whether a first sample away from the world's start is a finding.

    Returns:
        Findings and figures.

    Raises:
        InvalidParameter: If tolerance or slack are out of range, or a place is absurdly far away.
    """
    slack = world.cell_size * _SLACK if slack is None else slack
    _check("tolerance", tolerance, LEAST_TOLERANCE)
    _check("slack", slack, 0.0)
    size = world.cell_size
    _check_places(trajectory, size)
    way = AuditPath(world, trajectory.times, trajectory.x, trajectory.y)
    result = scan(way, world.robot_radius / size, tolerance / size, straight=straight)
    findings = [
        finding
        for kind, hits in result.hits.items()
        for finding in _findings(kind, hits, way, size)
    ]
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
            "give metres, at least {least:g}",
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
            "give metres",
            sample=far[0],
            cell_size=size,
        )


def _findings(kind: str, hits: Hits, way: AuditPath, unit: float) -> list[Finding]:
    t, x, y = way.place(hits.worst)
    begin = way.place(hits.begin)[0]
    end = way.place(hits.end)[0]
    columns = (
        t,
        x,
        y,
        hits.depth * unit,
        hits.ix,
        hits.iy,
        begin,
        end,
        np.floor(hits.worst).astype(int),
    )
    return [
        Finding(kind, t, x, y, depth, (ix, iy), begin, end, sample)
        for t, x, y, depth, ix, iy, begin, end, sample in zip(
            *(column.tolist() for column in columns), strict=True
        )
    ]


def _elsewhere(world: World, trajectory: Trajectory, allowed: float) -> list[Finding]:
    """The first sample, if it is further than ``allowed`` m from the world's start."""
    t = float(trajectory.times[0])
    x = float(trajectory.x[0])
    y = float(trajectory.y[0])
    away = math.dist((x, y), (world.start.x, world.start.y))
    return [Finding("start", t, x, y, away, None, t, t, 0)] if away > allowed else []


def _jumps(world: World, trajectory: Trajectory, slack: float) -> list[Finding]:
    """Moves that are faster than the robot; the place is where the worst of them ends."""
    steps = np.hypot(np.diff(trajectory.x), np.diff(trajectory.y))
    allowed = world.robot_speed * np.diff(trajectory.times) * (1.0 + SPEED_TOLERANCE)
    rows = np.flatnonzero(steps > allowed + slack)
    excess: Floats = steps[rows] - world.robot_speed * np.diff(trajectory.times)[rows]
    nowhere = np.zeros(len(rows), np.int64)
    found = merged(Hits.at(rows, 0.0, 1.0, excess, 1.0, nowhere, nowhere), grain=LEAST_TOLERANCE)
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
    size = world.cell_size
    times = trajectory.times
    notes = [
        f"the first sample ({found.x:.6g}, {found.y:.6g}) m is {found.depth:.6g} m away from the "
        f"world's start"
        for found in elsewhere
    ]
    if world.is_dynamic and times[0] != 0.0:
        notes.append(
            f"the first sample is at {times[0]:.9g} s, and the world changes in seconds from 0 on"
        )
    depth = result.shaved_depth * size
    if result.shaved:
        notes.append(
            f"{result.shaved} straight line{'s' if result.shaved > 1 else ''} between clear "
            f"samples cut a corner, by "
            f"up to {depth:.3g} m; --straight counts them"
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
    """When the centre first is in the target's disc, s."""
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
