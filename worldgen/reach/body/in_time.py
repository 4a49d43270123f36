"""Time a body's path through walls that change: it waits where it is clear, and goes on.

The path itself comes from the search for a body, or a car, among walls that don't change: those of some moment.
Then its moves and turns are timed, each as early as nothing blocks it. All is exact, but a body that
would have to go out of the way of a change and come back finds no path.

Source: path-velocity decomposition, Kamal Kant and Steven Zucker, "Toward efficient trajectory planning",
    1986.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from worldgen.lattice import (
    TURN,
    UNIT,
    heading_from_lattice,
    heading_to_lattice,
    in_cells,
    lattice_to_metres,
    lattice_units,
    metres_to_lattice,
)
from worldgen.reach.body.core_calls import Body, BodyPose
from worldgen.reach.still.path import travel_ticks
from worldgen.reach.still.walls import Walls
from worldgen.reach.timed.spans import FOREVER, Spans
from worldgen.support.arrays import Bools, Floats
from worldgen.timeline import Timeline
from worldgen.world import Witness, World

# Stretches of time in which the walls count as unchanging; changes that are too many share one.
_MOST_STRETCHES = 64
# Limit on the sets of walls among which a path is searched, each of which may take a second.
_MOST_PATHS = 8


class _Stay(NamedTuple):
    """A stretch of time in which a pose is clear, and when the body first gets there in it.

    Args:
        begin: Tick at which it begins.
        end: Tick at which it ends.
        arrival: Tick.
        before: Index of the stay at the pose before, which the body leaves for this one.
        departure: Tick at which it does.
    """

    begin: int
    end: int
    arrival: int
    before: int
    departure: int


def timed_witness(
    world: World, margin: float, path_among: Callable[[World], Witness | None]
) -> Witness | None:
    """Return a path of the world's body that waits for changes; None if none is found.

    Args:
        world: A world that changes, of one robot with a footprint, or a car.
        margin: s; see :func:`worldgen.reach.decide`.
        path_among: Returns a path in a world that does not change, or None.
    """
    start = world.start
    places = [lattice_units(value, world.cell_size) for value in (start.x, start.y)]
    if world.robots[0].is_disc and any(place.denominator > 1 for place in places):
        return None  # a disc's path begins exactly at its start
    times = _Times(world, margin)
    still = replace(world.bare, timeline=Timeline())
    for walls in itertools.islice(times.candidates(), _MOST_PATHS):
        path = path_among(replace(still, walls=walls))
        witness = None if path is None else times.along(path)
        if witness is not None:
            return witness
    return None


class _Times:
    """A world's stretches of time, each with the cells that are blocked at some time in it."""

    def __init__(self, world: World, margin: float) -> None:
        self._world = world
        self._spans = Spans(world, margin)
        spans = self._spans
        moments = np.unique(np.concatenate([spans.begin, spans.end]))
        inner = moments[(moments > 0) & (moments < FOREVER)].tolist()
        every = math.ceil((len(inner) + 1) / _MOST_STRETCHES)
        self._moments = [0, *inner[every - 1 :: every], FOREVER]
        self._walls = [self._blocked(*pair) for pair in itertools.pairwise(self._moments)]
        self._tests = [_test_among(world, walls) for walls in self._walls]

    def _blocked(self, begin: int, end: int) -> Bools:
        spans = self._spans
        counts = np.diff(spans.first)
        cell = np.repeat(np.arange(len(counts)), counts)
        walls: Bools = spans.fixed.copy()
        walls.reshape(-1)[cell[(spans.begin < end) & (spans.end > begin)]] = True
        return walls

    def candidates(self) -> Iterator[Bools]:
        """Yield walls that a path may avoid: those that stay, and those of each stretch, late ones first."""
        seen = set()
        for walls in (self._spans.always, *reversed(self._walls)):
            if walls.tobytes() not in seen:
                seen.add(walls.tobytes())
                yield walls

    def along(self, path: Witness) -> Witness | None:
        """Return the earliest timing of a path; None if it is blocked for good."""
        world = self._world
        poses, waits = self._fine(path)
        stays = [[_Stay(*run, run[0], 0, 0) for run in self._clear_of(poses[0], None)]]
        stays[0] = [stay for stay in stays[0] if stay.begin == 0]
        for (p, q), wait in zip(itertools.pairwise(poses), waits, strict=True):
            takes = wait or travel_ticks(
                (p.x, p.y), (q.x, q.y), world.cell_size, world.robot_speed, self._spans.ticks
            )
            found = self._next(stays[-1], self._clear_of(p, q), self._clear_of(q, None), takes)
            if not found:
                return None
            stays.append(found)
        return self._witness(poses, stays)

    def _next(
        self,
        stays: Sequence[_Stay],
        moves: Sequence[tuple[int, int]],
        runs: Sequence[tuple[int, int]],
        takes: int,
    ) -> list[_Stay]:
        """Return the stays at a pose, each with the earliest arrival from those at the one before."""
        best: dict[tuple[int, int], _Stay] = {}
        for number, stay in enumerate(stays):
            for begin, end in moves:
                departure = max(stay.arrival, begin)
                arrival = departure + takes
                if departure > stay.end or arrival > end or end <= stay.begin:
                    continue
                # While the move is clear, so are both of its ends.
                run = next(run for run in runs if run[0] <= begin and end <= run[1])
                if run not in best or arrival < best[run].arrival:
                    best[run] = _Stay(*run, arrival, number, departure)
        return sorted(best.values())

    def _clear_of(self, p: BodyPose, q: BodyPose | None) -> list[tuple[int, int]]:
        """Return the longest stretches of time in which the body may stand at a pose, or go to another."""
        clear = [may_go(p, q) for may_go in self._tests]
        runs = []
        first = 0
        for is_clear, group in itertools.groupby(clear):
            last = first + sum(1 for _ in group)
            if is_clear:
                runs.append((self._moments[first], self._moments[last]))
            first = last
        return runs

    def _fine(self, path: Witness) -> tuple[list[BodyPose], list[int]]:
        """Return a path's poses, and the ticks for which a car steers between them.

        There are more of them on its moves where they are clear of walls that stay.
        """
        size = self._world.cell_size
        headings = () if path.headings is None else path.headings.tolist()
        poses = [
            BodyPose(
                metres_to_lattice(x, size), metres_to_lattice(y, size), heading_to_lattice(heading)
            )
            for x, y, heading in zip(path.x.tolist(), path.y.tolist(), headings, strict=True)
        ]
        may_go = _test_among(self._world, self._spans.always)
        found = poses[:1]
        waits = []
        for (p, q), lasts in zip(itertools.pairwise(poses), np.diff(path.times), strict=True):
            waits.append(math.ceil(lasts * self._spans.ticks - 1e-6) if p == q else 0)
            count = math.ceil(math.hypot(q.x - p.x, q.y - p.y) / UNIT)
            if p.heading != q.heading or count < 2:
                found.append(q)
                continue
            between = [
                p._replace(x=p.x + (q.x - p.x) * k // count, y=p.y + (q.y - p.y) * k // count)
                for k in range(1, count)
            ]
            parts = [p, *between, q]
            if all(may_go(a, b) for a, b in itertools.pairwise(parts)):
                found += between
                waits += [0] * len(between)
            found.append(q)
        return found, waits

    def _witness(self, poses: Sequence[BodyPose], stays: Sequence[Sequence[_Stay]]) -> Witness:
        # From the earliest arrival back to the start.
        number = min(range(len(stays[-1])), key=lambda k: stays[-1][k].arrival)
        rows: list[tuple[int, BodyPose]] = []
        for at in range(len(poses) - 1, -1, -1):
            stay = stays[at][number]
            rows.append((stay.arrival, poses[at]))
            if at > 0 and stay.departure > stays[at - 1][stay.before].arrival:
                rows.append((stay.departure, poses[at - 1]))
            number = stay.before
        rows.reverse()
        size = self._world.cell_size
        ticks = self._spans.ticks
        values: Floats = np.array(
            [
                (
                    tick / ticks,
                    lattice_to_metres(pose.x, size),
                    lattice_to_metres(pose.y, size),
                    heading_from_lattice(pose.heading),
                )
                for tick, pose in rows
            ]
        )
        times, x, y, headings = values.T.copy()
        robot = self._world.robots[0]
        return Witness(times, x, y, robot.radius if robot.is_disc else 0.0, headings)


def _test_among(world: World, walls: Bools) -> Callable[[BodyPose, BodyPose | None], bool]:
    """Return a test whether the robot may stand at a pose, or go from there to the next of a path."""
    robot = world.robots[0]
    if robot.is_disc:
        disc = Walls(walls, in_cells(robot.radius, world.cell_size))
        return lambda p, q: disc.is_clear((p.x, p.y), (p.x, p.y) if q is None else (q.x, q.y))
    body = Body(walls, robot.footprint, world.cell_size)
    if robot.drive.is_car:
        return lambda p, q: _may_drive(body, p, q)
    return lambda p, q: _may_go(body, p, q)


def _may_drive(body: Body, p: BodyPose, q: BodyPose | None) -> bool:
    """Return True if a car may drive a leg: it turns by half, rounded towards zero, before it, and then by the rest."""
    if q is None or p.heading == q.heading:
        return _may_go(body, p, q)
    turn = (q.heading - p.heading + TURN // 2) % TURN - TURN // 2
    before = p._replace(heading=(p.heading + int(turn / 2)) % TURN)
    after = q._replace(heading=before.heading)
    return all(_may_go(body, a, b) for a, b in ((p, before), (before, after), (after, q)))


def _may_go(body: Body, p: BodyPose, q: BodyPose | None) -> bool:
    """Return True if a body may stand at a pose, or turn or move from there to another."""
    if q is None or p == q:
        return body.is_clear(p)
    if (p.x, p.y) != (q.x, q.y):
        return body.may_move(p, q.x, q.y)
    return body.may_turn(p, (q.heading - p.heading + TURN // 2) % TURN - TURN // 2)
