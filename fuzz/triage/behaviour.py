"""Measure what a robot does in the part of its run that repeats.

Everything is in cells, radii and whole turns, so the numbers stay the same if a world is shifted,
turned, mirrored, or drawn at another scale. Causes are decided from them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fuzz.facts.contacts import walls_at_the_end, winding_number
from fuzz.triage.repeated_moves import SAME_PLACE, lap_of, last_part
from sim.episode import Episode
from sim.evidence import LoopEvidence
from sim.trace import Trace
from worldgen.reach.still.grid_search import components
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# Radians in one step: more than 160 degrees turns the robot around.
_ABOUT_FACE = 0.45 * 2 * math.pi

# Share of the radius. A robot that never gets farther from its start than this does not drive.
_PARKED = 0.1

# Area that a path encloses, divided by the square of its length: 0.08 for a circle, and 0.02 for a
# rectangle twelve times as long as wide.
_HARDLY = 0.02

# Cells from the edges of robot and target: the closest it gets, and the farthest away it ever is.
_CLOSE = 1.0
_NEARBY = 3.0

# Share of a cell by which the lattice may round the distance to the target.
_LATTICE = 1.0 / 1024

# Places on a straight line that are tested for walls, per cell.
_SAMPLES = 8


@dataclass(frozen=True)
class RepeatedPart:
    """The repeated part of a run: a loop's period, the moves that recur at its end, or its second half.

    Args:
        steps: Its length in steps.
        recurs: True if the robot comes back to where the part began, at least nearly.
        extent: Longer side of the box around its path, cells.
        length: Length of its path, cells.
        turning: Mean absolute turn per step, in whole turns.
        about_faces: Share of its steps that turn the robot around.
        reversals: Share of its steps that change between driving forwards and backwards.
        is_retraced: True if its path encloses hardly anything: the robot comes back the way it went.
        touching: Share of its steps that touch a wall.
        around_island: Largest number of times that the path goes around an island of walls.
        around_target: Number of times that it goes around the target.
        off_wall: Longest path between two touches, cells; infinite if it touches nothing.
        closest: The place (x, y) in its path that is nearest to the target's centre, cells.
        nearest: Smallest distance from the target's centre, cells.
        farthest: Largest distance from the target's centre, cells.
        is_blocked: True if a wall is between that place and the target.
        radius: The robot's radius, cells.
        reach: The robot's radius plus the target's, cells.
        is_parked: True if the robot hardly leaves its start in the whole run, so that nothing on
            its way explains it.
        ends_in_target: True if one of its steps ends in the target's disc.
    """

    steps: int
    recurs: bool
    extent: float
    length: float
    turning: float
    about_faces: float
    reversals: float
    is_retraced: bool
    touching: float
    around_island: int
    around_target: int
    off_wall: float
    closest: tuple[float, float]
    nearest: float
    farthest: float
    is_blocked: bool
    radius: float
    reach: float
    is_parked: bool
    ends_in_target: bool

    @property
    def is_near(self) -> bool:
        """True if the robot stays next to the target, with a clear path to it."""
        near = self.nearest <= self.reach + _CLOSE and self.farthest <= self.reach + _NEARBY
        return near and not self.is_blocked


def behaviour_of(world: World, episode: Episode) -> RepeatedPart | None:
    """Return the behaviour of a recorded run; ``None`` without a recording.

    Args:
        world: World of the run; walls count as they are after the last event.
        episode: The run, recorded.
    """
    trace = episode.trace
    if trace is None or trace.steps == 0:
        return None
    loop = episode.evidence
    if isinstance(loop, LoopEvidence):
        return _measured(world, trace, loop.entry, loop.entry + loop.period, recurs=True)
    # If a run only used up its budget, its end is the best guess of what repeats. Moves that recur
    # while the robot gets farther and farther, such as driving straight on, are not a repetition.
    part = last_part(episode)
    if part is not None and part.period:
        before = part.last - part.period
        moved = math.hypot(trace.x[-1] - trace.x[before], trace.y[-1] - trace.y[before])
        if moved <= SAME_PLACE * world.robot_radius:
            return _measured(world, trace, part.first, part.last, recurs=True)
        if lap := lap_of(world, trace, part.period):
            return _measured(world, trace, trace.steps - lap, trace.steps, recurs=True)
    return _measured(world, trace, trace.steps // 2, trace.steps, recurs=False)


def _measured(world: World, trace: Trace, first: int, last: int, *, recurs: bool) -> RepeatedPart:
    side = world.cell_size
    x = trace.x[first : last + 1] / side
    y = trace.y[first : last + 1] / side
    heading = trace.heading[first : last + 1]
    bump = trace.bump[first + 1 : last + 1]
    target = (world.target.x / side, world.target.y / side)
    walls = _SolidCells(world)

    # Describe each step.
    turns = _wrapped(np.diff(heading))
    turn = np.abs(turns)
    stride = np.hypot(np.diff(x), np.diff(y))
    # Each lap of a circle encloses its area again, and adds to the length. One period has one lap.
    laps = 1.0 if recurs else max(1.0, abs(float(turns[stride > 0.0].sum())) / math.tau)
    length = float(stride.sum())
    ahead = np.diff(x) * np.cos(heading[:-1]) + np.diff(y) * np.sin(heading[:-1])
    direction = np.sign(ahead[stride > 0.0])

    # The path around islands and the target, and how close it gets to the target.
    apart = np.hypot(x - target[0], y - target[1])
    closest = int(np.argmin(np.round(apart, 6)))
    place = (float(x[closest]), float(y[closest]))
    radius = world.robot_radius / side
    return RepeatedPart(
        steps=last - first,
        recurs=recurs,
        extent=max(float(np.ptp(x)), float(np.ptp(y))),
        length=length,
        turning=float(turn.mean()) / (2 * math.pi),
        about_faces=float((turn >= _ABOUT_FACE).mean()),
        reversals=float((np.diff(direction) != 0.0).sum()) / (last - first),
        is_retraced=laps * abs(_area(x, y)) <= _HARDLY * length * length,
        touching=float(bump.mean()),
        around_island=winding_number(x, y, walls.islands(x, y)),
        around_target=abs(_around(x, y, target)),
        off_wall=_longest_between(stride, bump),
        closest=place,
        nearest=float(apart.min()),
        farthest=float(apart.max()),
        is_blocked=walls.between(place, _edge_of(world, place), radius),
        radius=radius,
        reach=radius + world.target.radius / side,
        is_parked=float(np.hypot(trace.x - trace.x[0], trace.y - trace.y[0]).max())
        < _PARKED * world.robot_radius,
        ends_in_target=float(apart[1:].min()) <= world.target.radius / side + _LATTICE,
    )


def passes_target(world: World, trace: Trace) -> bool:
    """Return True if a run's path leads through the target's disc, but no step ends there."""
    goal = world.target
    within = goal.radius + _LATTICE * world.cell_size
    if np.hypot(trace.x - goal.x, trace.y - goal.y).min() <= within:
        return False
    # The nearest point of each piece of the path.
    x = trace.path_x - goal.x
    y = trace.path_y - goal.y
    dx = np.diff(x)
    dy = np.diff(y)
    length_sq = np.maximum(dx * dx + dy * dy, np.finfo(np.float64).tiny)
    share = np.clip(-(x[:-1] * dx + y[:-1] * dy) / length_sq, 0.0, 1.0)
    apart = np.hypot(x[:-1] + share * dx, y[:-1] + share * dy)
    return bool((apart <= goal.radius).any())


def _edge_of(world: World, place: tuple[float, float]) -> tuple[float, float]:
    """Return where a robot ends up that drives straight from a place to the target, in cells.

    It need not fit at the target's centre.
    """
    x = world.target.x / world.cell_size
    y = world.target.y / world.cell_size
    radius = world.target.radius / world.cell_size
    share = radius / max(math.dist(place, (x, y)), radius)
    return x + share * (place[0] - x), y + share * (place[1] - y)


class _SolidCells:
    """A world's walls after its last event, with a border of solid cells."""

    def __init__(self, world: World) -> None:
        self._walls: Bools = np.pad(walls_at_the_end(world), 1, constant_values=True)

    def islands(self, x: Floats, y: Floats) -> list[tuple[int, int]]:
        """Return a cell (ix, iy) of each obstacle that a path may go around.

        Cells that touch at a corner are one obstacle: a disc does not fit between them, so a path
        goes around all of it or none. The outer wall is not an island.
        """
        numbers = _obstacles(self._walls)
        found, first = np.unique(numbers, return_index=True)
        outer = int(numbers[0, 0])
        rows, columns = np.unravel_index(first, numbers.shape)
        cells = [
            (int(ix) - 1, int(iy) - 1)
            for number, iy, ix in zip(found.tolist(), rows, columns, strict=True)
            if number not in (-1, outer)
        ]
        # A path cannot go around anything outside its bounding box.
        return [
            (ix, iy)
            for ix, iy in cells
            if x.min() < ix + 0.5 < x.max() and y.min() < iy + 0.5 < y.max()
        ]

    def between(self, one: tuple[float, float], other: tuple[float, float], radius: float) -> bool:
        """Return True if a disc meets a wall on the straight line between two places, in cells.

        The line is sampled; a wall that a disc only grazes at the tested places may be missed.
        """
        count = 2 + math.ceil(math.dist(one, other) * _SAMPLES)
        # A robot that touches a wall is not blocked by that wall.
        within = radius - 0.05
        return any(
            self._has_wall(x, y, within)
            for x, y in zip(
                np.linspace(one[0], other[0], count).tolist(),
                np.linspace(one[1], other[1], count).tolist(),
                strict=True,
            )
        )

    def _has_wall(self, x: float, y: float, within: float) -> bool:
        height, width = self._walls.shape
        left = max(math.floor(x - within) + 1, 0)
        right = min(math.floor(x + within) + 1, width - 1)
        low = max(math.floor(y - within) + 1, 0)
        high = min(math.floor(y + within) + 1, height - 1)
        for iy in range(low, high + 1):
            for ix in range(left, right + 1):
                if not self._walls[iy, ix]:
                    continue
                dx = x - min(max(x, ix - 1), ix)
                dy = y - min(max(y, iy - 1), iy)
                if dx * dx + dy * dy < within * within:
                    return True
        return False


def _obstacles(solid: Bools) -> Ints:
    """Return the number of each solid cell's obstacle, -1 for free cells.

    Solid cells that touch, across an edge or at a corner, are one obstacle.
    """
    # The core expects grids with a free edge.
    framed = np.pad(solid, 1)
    numbers = components(framed)[0].reshape(framed.shape)[1:-1, 1:-1].astype(np.int64)
    # The core joins cells across edges; the remaining pairs touch only at a corner.
    pairs: set[tuple[int, int]] = set()
    for one, other in ((numbers[1:, 1:], numbers[:-1, :-1]), (numbers[1:, :-1], numbers[:-1, 1:])):
        touch = (one >= 0) & (other >= 0) & (one != other)
        pairs.update(zip(one[touch].tolist(), other[touch].tolist(), strict=True))
    joined = np.arange(int(numbers.max()) + 1)
    for first, second in sorted(pairs):
        joined[joined == joined[first]] = joined[second]
    return np.where(numbers >= 0, joined[np.maximum(numbers, 0)], -1)


def _area(x: Floats, y: Floats) -> float:
    """Return the area that a closed path goes around, with sign."""
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def _wrapped(angles: Floats) -> Floats:
    wrapped: Floats = (angles + math.pi) % (2 * math.pi) - math.pi
    return wrapped


def _around(x: Floats, y: Floats, place: tuple[float, float]) -> int:
    """Return the whole turns that a path makes around a place, with sign."""
    bearing = np.arctan2(y - place[1], x - place[0])
    return round(float(_wrapped(np.diff(bearing)).sum()) / (2 * math.pi))


def _longest_between(stride: Floats, bump: Bools) -> float:
    """Return the longest path between two touches of a period; infinite if there is no touch.

    Args:
        stride: (n,) length of each step.
        bump: (n,) True if the step touches a wall.
    """
    touches = np.flatnonzero(bump)
    if len(touches) == 0:
        return math.inf
    # The period recurs, so what follows the last touch continues before the first.
    driven = np.concatenate([[0.0], np.cumsum(stride)])
    at = driven[touches + 1]
    between = np.diff(np.append(at, at[0] + driven[-1]))
    return float(between.max())
