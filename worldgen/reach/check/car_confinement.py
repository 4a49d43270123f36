"""Check where a car that never reverses is confined to, without any of the code that found it.

It does not search. From each box, it computes where a step can lead, and whether these places are in
boxes of the proof, or in walls. Lengths are in cells. The boxes of a heading are the bits of one
integer, so that a few operations on integers do a step from all of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import shapely

from worldgen.reach.check.body import Mistake, footprint_of
from worldgen.reach.check.certificate import CheckReport
from worldgen.reach.decision.confinement import CarConfinement
from worldgen.robot import Robot, Target
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# The proof is about simulated cars, too, at any speed. Both ends of each of their legs are on arcs that lead to each
# other, but for rounding: the place by 1/256 of a lattice unit a leg, which is at least a lattice unit long, and the
# heading by a unit or two, however long the path is. A leg is within 1/64 of a cell of its arc, or 1.3 times that if
# it turns by half a circle.
_OFF = 1 / 40  # cells between a car on its arc and the place that the simulator tests
# More than the share of its way by which its place is rounded: sqrt(2) / 512.
_WIDER = 0.0028
_TURN = 4 * math.tau / 65_536  # rad by which it may turn more than its way allows
_UNIT = 1 / 1024  # cells by which its start is rounded, at most
# On a leg, its heading is that of some point of the leg's arc. A leg's length times its turn is at most 8/64 of a cell,
# and again a bit more if it turns by half a circle.
_LEG = 0.18
# Pieces of a step in which its directions are bounded, and the parts after which its place is.
_PIECES = 96
_PARTS = 4
# Limits on the numbers of a proof that take part in a table.
_MOST_HEADINGS = 4096
_MOST_PLACES = 4_000_000
_MOST_MARGIN = 2000
_MOST_FRAMED = 16_000_000
# Turning radius, cells. On a larger circle, a leg may be so long that the unit of its rounded turn matters.
_MOST_TURNING = 100_000


def check_car_confinement(world: World, proof: CarConfinement) -> CheckReport:
    """Return a report that is valid if the proof holds for the world's car.

    Args:
        world: The world; only cells that are always solid count.
        proof: The proof.
    """
    try:
        _Check(world, proof).run()
    except Mistake as mistake:
        return CheckReport(False, str(mistake), 0.0)
    reason = (
        f"the car cannot leave {proof.count:,} boxes of poses, and does not arrive in any of them"
    )
    return CheckReport(True, reason, 0.0)


def _require(holds: bool, sentence: str) -> None:
    if not holds:
        raise Mistake(f"the confinement does not hold: {sentence}")


class _Check:
    """The check of one proof."""

    def __init__(self, world: World, proof: CarConfinement) -> None:
        self._world = world
        self._robot = world.robots[0]
        drive = self._robot.drive
        _require(drive.is_car and not drive.reverse, "the robot may reverse, or turn")
        size = world.cell_size
        self._turning = drive.turning_radius / size
        _require(self._turning <= _MOST_TURNING, "the turning circle is too large")
        self._side, self._step = proof.side / size, proof.step / size
        self._headings = proof.headings
        _require(1 < proof.headings <= _MOST_HEADINGS, f"it has {proof.headings} headings")
        is_sized = 0.0 < self._side < math.inf and 0.0 < self._step <= math.pi * self._turning
        _require(is_sized, "a box or a step has no size, or a step is half a turn or more")
        self._part = math.tau / proof.headings
        # A pose may be this much farther ahead in a leg than on its arc, measured by its heading.
        self._lean = math.sqrt(_LEG / self._turning)
        discs = np.array(proof.discs, np.float64).reshape(-1, 3) / size
        _check_discs(self._robot, size, discs)
        _check_axle(world, discs)
        # No step leads farther, and no disc is farther away, in boxes.
        farthest = max(self._step, float(np.hypot(discs[:, 0], discs[:, 1]).max()))
        margin = math.ceil(farthest * (1.0 + _WIDER) / self._side) + 4
        _require(margin <= _MOST_MARGIN, "a step is as long as too many boxes")
        runs = self._runs(proof.boxes, margin)
        # The margin on each side of a row takes the boxes that are shifted out of it.
        self._width = self._shape[1] + 2 * margin
        self._layers = self._layers_of(runs)
        self._mark_room(discs)
        self._near = [self._near_goal(goal) for goal in self._robot.goals]

    def _runs(self, runs: Ints, margin: int) -> Ints:
        """Return the runs of boxes in a window of the world, which holds all that a step leads to."""
        _require(runs.ndim == 2 and runs.shape[1] == 4 and len(runs) > 0, "it has no runs of boxes")
        shape = [math.ceil(cells / self._side - 1e-9) for cells in self._world.walls.shape]
        most = np.array([self._headings, *shape, shape[1]]) - 1
        is_inside = (runs >= 0).all() and (runs <= most).all() and (runs[:, 2] <= runs[:, 3]).all()
        _require(bool(is_inside), "a run of boxes is not in the world")
        self._first = [max(0, int(runs[:, column].min()) - margin) for column in (1, 2)]
        ends = [int(runs[:, column].max()) + margin + 1 for column in (1, 3)]
        self._shape = tuple(
            min(end, count) - first
            for end, count, first in zip(ends, shape, self._first, strict=True)
        )
        framed = self._shape[0] * (self._shape[1] + 2 * margin)
        is_small = math.prod(self._shape) <= _MOST_PLACES and framed <= _MOST_FRAMED
        _require(is_small, f"its boxes are {self._side} cells wide")
        self._y, self._x = (
            (first + np.arange(count) + 0.5) * self._side
            for first, count in zip(self._first, self._shape, strict=True)
        )
        within: Ints = runs - np.array([0, self._first[0], self._first[1], self._first[1]])
        return within

    def _bits(self, marked: Bools) -> int:
        """Return (rows, columns) bools as bits."""
        framed = np.pad(marked, ((0, 0), (0, self._width - marked.shape[1])))
        return int.from_bytes(np.packbits(framed, bitorder="little").tobytes(), "little")

    def _layers_of(self, runs: Ints) -> dict[int, int]:
        """Return the boxes of each heading."""
        runs = runs[np.argsort(runs[:, 0], kind="stable")]
        headings, first = np.unique(runs[:, 0], return_index=True)
        layers = {}
        for heading, part in zip(headings.tolist(), np.split(runs, first[1:]), strict=True):
            boxes = np.zeros(self._shape, np.bool_)
            for _, row, left, right in part.tolist():
                boxes[row, left : right + 1] = True
            layers[heading] = self._bits(boxes)
        return layers

    def _mark_room(self, discs: Floats) -> None:
        """Find where the disc about the axle may be; and the others, from their own places."""
        # All poses of a box, and all places between two boxes, are this near to a middle.
        corner = self._side * math.sqrt(0.5)
        gaps = _gap_to_walls(self._world.still_walls, self._x, self._y, float(discs[:, 2].max()))
        self._room = self._bits(gaps >= discs[0, 2] - _OFF - corner)
        self._others = []
        for ahead, left, radius in discs[1:].tolist():
            away = math.hypot(ahead, left)
            slack = 2.0 * corner + away * (self._part / 2.0 + _TURN + self._lean)
            # One that stops nothing does not stop the car outside the world, either.
            if radius - _OFF - slack > 0.0:
                self._others.append((ahead, left, self._bits(gaps >= radius - _OFF - slack)))

    def _free(self, heading: int) -> int:
        """Return the boxes of a heading in which the body may be."""
        free = self._room
        cosine, sine = math.cos(heading * self._part), math.sin(heading * self._part)
        for ahead, left, room in self._others:
            right = round((ahead * cosine - left * sine) / self._side)
            up = round((ahead * sine + left * cosine) / self._side)
            free &= _shifted(room, -right - up * self._width)
        return free

    def run(self) -> None:
        """Check all boxes.

        Raises:
            Mistake: If the proof does not hold.
        """
        self._check_start()
        met = [self._starts_near(goal) for goal in self._robot.goals]
        for heading in self._layers:
            self._check_layer(heading, met)
        # The robot has to arrive at all of its goals.
        _require(not all(met), "the car may arrive at the target")

    def _check_start(self) -> None:
        """Check that all poses that the start may be rounded to are in boxes."""
        size = self._world.cell_size
        start = self._world.start
        heading = math.remainder(start.heading, math.tau)
        ends = []
        for place, first in zip((start.y, start.x), self._first, strict=True):
            least, most = (math.floor((place / size + off) / self._side) for off in (-_UNIT, _UNIT))
            ends.append((least - first, most - first))
        rows, columns = self._shape
        (bottom, top), (left, right) = ends
        inside = 0 <= bottom <= top < rows and 0 <= left <= right < columns
        inside = inside and top - bottom <= 1 and right - left <= 1
        _require(inside, "the start is outside the boxes")
        for off in (-_TURN, _TURN):
            layer = math.floor((heading + off) / self._part + 0.5) % self._headings
            boxes = self._layers.get(layer, 0)
            places = ((row, column) for row in (bottom, top) for column in (left, right))
            holds = all(boxes >> (row * self._width + column) & 1 for row, column in places)
            _require(holds, "the start is in no box")

    def _starts_near(self, goal: Target) -> bool:
        """Return True if the car may be at a goal within the first part of its first step."""
        size = self._world.cell_size
        start = self._world.start
        away = math.hypot(goal.x - start.x, goal.y - start.y) / size
        part = self._step / _PARTS
        may_turn = part / self._turning + _TURN + self._lean
        near = goal.radius / size + _OFF + part * (1.0 + _WIDER) + 2.0 * _UNIT
        return away <= near and _may_face(goal, start.heading, may_turn)

    def _near_goal(self, goal: Target) -> int:
        """Return the places from which a part of a step may lead to a goal.

        A whole part, because the car may be in a wall at its end.
        """
        size = self._world.cell_size
        away = np.hypot(self._x[None, :] - goal.x / size, self._y[:, None] - goal.y / size)
        reach = goal.radius / size + _OFF + self._step / _PARTS * (1.0 + _WIDER)
        return self._bits(away <= reach + self._side * math.sqrt(0.5)) & self._room

    def _check_layer(self, heading: int, met: list[bool]) -> None:
        """Check where steps lead from the boxes of one heading."""
        most = math.ceil((self._step / self._turning + _TURN) / self._part)
        more = self._step / _PARTS / self._turning + 2.0 * _TURN + self._lean
        for turn in range(-most, most + 1):
            passing = self._layers[heading]
            for place, low, high in self._parts(heading * self._part, turn * self._part):
                left, right, below, above = place
                # The boxes from which the rectangle reaches a place are those in the mirrored one.
                mirrored = (-right, -left, -above, -below)
                passing &= self._spread(self._room, mirrored)
                for number, goal in enumerate(self._robot.goals):
                    faces = _may_face(goal, (low + high) / 2.0, (high - low) / 2.0 + more)
                    if faces and not met[number]:
                        near = self._spread(self._near[number], mirrored)
                        met[number] = passing & near != 0
            after = (heading + turn) % self._headings
            missed = self._spread(passing, place) & self._free(after) & ~self._layers.get(after, 0)
            _require(missed == 0, f"a car leaves the boxes of heading {heading} in one step")

    def _spread(self, boxes: int, rectangle: tuple[int, int, int, int]) -> int:
        """Return all boxes from left to right and low to high of some boxes."""
        left, right, low, high = rectangle
        for count, stride in ((right - left + 1, 1), (high - low + 1, self._width)):
            covered = 1
            while covered < count:
                more = min(covered, count - covered)
                boxes |= boxes << more * stride
                covered += more
        return _shifted(boxes, left + low * self._width)

    def _parts(
        self, heading: float, turn: float
    ) -> Iterator[tuple[tuple[int, int, int, int], float, float]]:
        """Yield the boxes, relative to one, in which a step may be after each of its parts.

        Each comes as left, right, low, high, with the least and the greatest heading there.

        Args:
            heading: Middle of the headings at its begin, rad.
            turn: From there to the middle of those at its end.
        """
        edges = np.linspace(0.0, self._step, _PIECES + 1)
        # In a piece, the heading is what both ends allow, each widened by half of its range.
        since_begin = edges[1:] / self._turning + _TURN
        until_end = (self._step - edges[:-1]) / self._turning + _TURN
        low = np.maximum(heading - since_begin, heading + turn - until_end)
        high = np.minimum(heading + since_begin, heading + turn + until_end)
        middle = (low + high) / 2.0
        half = np.maximum((high - low) / 2.0, 0.0) + self._part / 2.0
        wider = _WIDER * self._step
        length = self._step / _PIECES
        bounds: list[tuple[Floats, Floats]] = []
        for quarter in (0.0, math.pi / 2.0):
            off = np.abs(np.remainder(middle - quarter + math.pi, math.tau) - math.pi)
            # The cosine is largest where the direction is nearest to 0, and least where it is farthest.
            largest = np.cos(np.maximum(off - half, 0.0)).cumsum() * length
            least = np.cos(np.minimum(off + half, math.pi)).cumsum() * length
            bounds.append((least - wider, largest + wider))
        for number in range(1, _PARTS + 1):
            last = number * _PIECES // _PARTS - 1
            place: list[int] = []
            for least, largest in bounds:
                place.append(math.floor(least[last] / self._side))
                place.append(math.floor(largest[last] / self._side) + 1)
            yield (
                (place[0], place[1], place[2], place[3]),
                float(middle[last] - half[last]),
                float(middle[last] + half[last]),
            )


def _check_discs(robot: Robot, cell_size: float, discs: Floats) -> None:
    """Check that a body holds some discs: ahead, left and radius, cells."""
    _require(len(discs) > 0 and bool(np.isfinite(discs).all()), "it names no discs in the body")
    _require(not discs[0, :2].any(), "its first disc is not about the axle")
    if robot.is_disc:
        room = robot.radius / cell_size - np.hypot(discs[:, 0], discs[:, 1])
    else:
        body = shapely.Polygon(footprint_of(robot, cell_size).corners)
        middles = shapely.points(discs[:, :2])
        away = shapely.distance(body.exterior, middles)
        room = np.where(shapely.covers(body, middles), away, -away)
    # A disc without a radius stops nothing.
    is_held = (discs[:, 2] <= np.maximum(room, 0.0) + 1e-9).all()
    _require(bool(is_held), "a disc is not in the body")


def _check_axle(world: World, discs: Floats) -> None:
    """Check that the axle cannot leave the world, which has the boxes: only the body has to be inside."""
    if discs[0, 2] > _OFF:
        return
    robot = world.robots[0]
    away = 0.0
    if not robot.is_disc:
        body = shapely.Polygon(footprint_of(robot, world.cell_size).corners)
        away = float(shapely.distance(body, shapely.Point(0.0, 0.0)))
    border = math.ceil(away + _OFF)
    rows, columns = np.nonzero(~world.still_walls)
    height, width = world.walls.shape
    is_inside = (
        (rows >= border)
        & (rows < height - border)
        & (columns >= border)
        & (columns < width - border)
    )
    _require(bool(is_inside.all()), "the axle may leave the world")


def _may_face(goal: Target, heading: float, off: float) -> bool:
    """Return True if a heading that may be off by an angle may be that of a goal."""
    if goal.heading is None:
        return True
    away = abs(math.remainder(math.remainder(goal.heading, math.tau) - heading, math.tau))
    return away <= goal.heading_tolerance + off


def _shifted(boxes: int, by: int) -> int:
    return boxes << by if by >= 0 else boxes >> -by


def _gap_to_walls(solid: Bools, x: Floats, y: Floats, most: float) -> Floats:
    """Return (rows, columns) distances of places from the nearest solid cell, or outside, up to one."""
    framed = np.pad(solid, 1, constant_values=True)
    last = len(framed) - 1
    least = np.full((len(y), len(x)), most * most)
    for row in range(last + 1):
        # And up or down to the row; the first and the last one are the outside.
        above = y - row if row < last else np.zeros(len(y))
        below = row - 1.0 - y if row > 0 else np.zeros(len(y))
        along = np.maximum(np.maximum(above, below), 0.0)
        near = np.flatnonzero(along < most)
        if len(near) == 0:
            continue
        # Along this row of cells: how far it is to the nearest solid one, to the left and the right.
        cells = np.append(np.flatnonzero(framed[row]) - 1, 2**40)
        at = np.searchsorted(cells, x, side="right")
        across = np.maximum(np.minimum(x - cells[at - 1] - 1.0, cells[at] - x), 0.0)
        rows = slice(near[0], near[-1] + 1)
        squares = np.square(along[rows])[:, None] + np.square(across)
        np.minimum(least[rows], squares, out=least[rows])
    gaps: Floats = np.sqrt(least)
    return gaps
