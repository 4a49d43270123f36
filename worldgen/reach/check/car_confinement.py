"""Check where a car that never reverses is confined to, without any of the code that found it.

It does not search. From each box, it computes where a step can lead, and whether these places are in
boxes of the proof, or in walls. Lengths are in cells.
"""

from __future__ import annotations

import math

import numpy as np

from worldgen.reach.check.body import Mistake, footprint_of
from worldgen.reach.check.certificate import CheckReport
from worldgen.reach.decision.confinement import CarConfinement
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# The proof is about simulated cars, too, at any speed. Both ends of each of their legs are on arcs that lead to each
# other, but for rounding: the place by 1/256 of a lattice unit a leg, which is at least a lattice unit long, and the
# heading by a unit or two, however long the path is. A leg is within 1/64 of a cell of its arc, or 1.3 times that if
# it turns by half a circle.
_OFF = 1 / 40  # cells between a car on its arc and the place that the simulator tests
_WIDER = (
    0.005  # more than the share of its way by which its place is rounded: 0.002 along each axis
)
_TURN = 4 * math.tau / 65_536  # rad by which it may turn more than its way allows
_UNIT = 1 / 1024  # cells by which its start is rounded, at most
# Pieces of a step in which its directions are bounded, and the parts after which its place is.
_PIECES = 96
_PARTS = 4
# Limits on the numbers of a proof that take part in a table.
_MOST_HEADINGS = 4096
_MOST_BOXES = 50_000_000


def check_car_confinement(world: World, proof: CarConfinement) -> CheckReport:
    """Return a report that is valid if the proof holds for the world's car.

    Args:
        world: The world; only cells that are always solid count.
        proof: The proof.
    """
    try:
        _check(world, proof)
    except Mistake as mistake:
        return CheckReport(False, str(mistake), 0.0)
    count = int(proof.boxes.sum())
    reason = f"the car cannot leave {count:,} boxes of poses, and none of them is near the target"
    return CheckReport(True, reason, 0.0)


def _check(world: World, proof: CarConfinement) -> None:
    robot = world.robots[0]
    size = world.cell_size
    _require(robot.drive.is_car and not robot.drive.reverse, "the robot may reverse, or turn")
    inner = robot.radius / size if robot.is_disc else footprint_of(robot, size).inner
    inner -= _OFF
    _require(inner > 0.0, "the body holds no disc about the axle")
    boxes = proof.boxes
    side = proof.side / size
    step = proof.step / size
    turning = robot.drive.turning_radius / size
    _require(boxes.ndim == 3 and 8 <= len(boxes) <= _MOST_HEADINGS, "the boxes have no headings")
    _require(boxes.size <= _MOST_BOXES, "there are too many boxes")
    _require(side > 0.0 and 0.0 < step <= turning, "the side of a box or a step has no length")
    rows, columns = boxes.shape[1:]
    _require(
        columns * side >= world.width - 1e-9 and rows * side >= world.height - 1e-9,
        "the boxes do not cover the grid",
    )
    x: Floats = (np.arange(columns, dtype=np.float64) + 0.5) * side
    y: Floats = (np.arange(rows, dtype=np.float64) + 0.5) * side
    is_free = _gap_to_walls(world.still_walls, x, y) >= inner - side * math.sqrt(0.5)

    # All poses that the start may be rounded to are in boxes.
    part = math.tau / len(boxes)
    heading = math.remainder(world.start.heading, math.tau)
    layers = {math.floor((heading + off) / part + 0.5) for off in (-_TURN, _TURN)}
    ends = []
    for place in (world.start.y, world.start.x):
        ends.append([math.floor((place / size + off) / side) for off in (-_UNIT, _UNIT)])
    inside = ends[0][0] >= 0 and ends[1][0] >= 0 and ends[0][1] < rows and ends[1][1] < columns
    _require(inside, "the start is outside the boxes")
    area = boxes[:, ends[0][0] : ends[0][1] + 1, ends[1][0] : ends[1][1] + 1]
    _require(bool(area[[k % len(boxes) for k in layers]].all()), "the start is in no box")

    # No box is within a step of a goal; the robot has to arrive at all of its goals.
    reached = []
    for goal in robot.goals:
        away = np.hypot(x[None, :] - goal.x / size, y[:, None] - goal.y / size)
        reach = goal.radius / size + _OFF + step * (1.0 + _WIDER) + side * math.sqrt(0.5)
        reached.append(bool(boxes[:, away <= reach].any()))
    _require(not all(reached), "a box is near the target")

    # Where a step leads from each box.
    room = _Counts(is_free)
    most = math.floor((step / turning + _TURN) / part) + 1
    for k in np.flatnonzero(boxes.any(axis=(1, 2))).tolist():
        for turn in range(-most, most + 1):
            if (abs(turn) - 1) * part > step / turning + _TURN:
                continue
            places = _places(k * part, turn * part, part, step, turning, side)
            leaves = boxes[k].copy()
            for rectangle in places:
                leaves &= room.at(rectangle) > 0
            left, right, low, high = places[-1]
            # The boxes from which the rectangle reaches a box are those in the mirrored rectangle.
            gets = _Counts(leaves).at((-right, -left, -high, -low)) > 0
            missed = gets & is_free & ~boxes[(k + turn) % len(boxes)]
            _require(not missed.any(), f"a car leaves the boxes of heading {k} in one step")


def _require(holds: bool, sentence: str) -> None:
    if not holds:
        raise Mistake(f"the confinement does not hold: {sentence}")


def _gap_to_walls(solid: Bools, x: Floats, y: Floats) -> Floats:
    """Return (rows, columns) distances of places from the nearest solid cell, or outside, up to 64."""
    framed = np.pad(solid, 1, constant_values=True)
    last = len(framed) - 1
    least = np.full((len(y), len(x)), 64.0)
    for row in range(last + 1):
        # Along this row of cells: how far it is to the nearest solid one, to the left and the right.
        cells = np.append(np.flatnonzero(framed[row]) - 1, 2**40)
        at = np.searchsorted(cells, x, side="right")
        across = np.maximum(np.minimum(x - cells[at - 1] - 1.0, cells[at] - x), 0.0)
        # And up or down to the row; the first and the last one are the outside.
        above = y - row if row < last else np.zeros(len(y))
        below = row - 1.0 - y if row > 0 else np.zeros(len(y))
        along = np.maximum(np.maximum(above, below), 0.0)
        near = along < 64.0
        least[near] = np.minimum(least[near], np.hypot(across[None, :], along[near, None]))
    return least


class _Counts:
    """Counts the marked boxes in rectangles around each box."""

    def __init__(self, marked: Bools) -> None:
        self._sums: Ints = np.pad(marked.astype(np.int64), ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        self._rows, self._columns = (np.arange(count) for count in marked.shape)

    def at(self, rectangle: tuple[int, int, int, int]) -> Ints:
        """Return the number of marked boxes from left to right and low to high, relative to each."""
        left, right, low, high = rectangle
        x0 = np.clip(self._columns + left, 0, len(self._columns))
        x1 = np.maximum(np.clip(self._columns + right + 1, 0, len(self._columns)), x0)
        y0 = np.clip(self._rows + low, 0, len(self._rows))
        y1 = np.maximum(np.clip(self._rows + high + 1, 0, len(self._rows)), y0)
        bands: Ints = self._sums[y1] - self._sums[y0]
        found: Ints = bands[:, x1] - bands[:, x0]
        return found


def _places(
    heading: float, turn: float, part: float, step: float, turning: float, side: float
) -> list[tuple[int, int, int, int]]:
    """Return the boxes, relative to one, in which a step may be after each of its parts.

    Args:
        heading: Middle of the headings at its begin, rad.
        turn: From there to the middle of those at its end.
        part: Width of both ranges.
        step: Its length.
        turning: The turning radius.
        side: Side of a box.
    """
    edges = np.linspace(0.0, step, _PIECES + 1)
    # In a piece, the heading is what both ends allow, each widened by half of its range.
    since_begin = edges[1:] / turning + _TURN
    until_end = (step - edges[:-1]) / turning + _TURN
    low = np.maximum(heading - since_begin, heading + turn - until_end)
    high = np.minimum(heading + since_begin, heading + turn + until_end)
    middle = (low + high) / 2.0
    half = np.maximum((high - low) / 2.0 + part / 2.0, 0.0)
    found = []
    wider = _WIDER * step
    ranges = []
    for quarter in (0.0, math.pi / 2.0):
        off = np.abs(np.remainder(middle - quarter + math.pi, math.tau) - math.pi)
        # The cosine is largest where the direction is nearest to 0, and least where it is farthest.
        largest = np.cos(np.maximum(off - half, 0.0))
        least = np.cos(np.minimum(off + half, math.pi))
        ranges.append((least, largest))
    length = step / _PIECES
    for number in range(1, _PARTS + 1):
        end = number * _PIECES // _PARTS
        rectangle: list[int] = []
        for least, largest in ranges:
            rectangle.append(math.floor((least[:end].sum() * length - wider) / side))
            rectangle.append(math.floor((largest[:end].sum() * length + wider) / side) + 1)
        found.append((rectangle[0], rectangle[1], rectangle[2], rectangle[3]))
    return found
