"""Confine a car that never reverses: prove that wherever it drives, it stays away from the target.

Poses are put into boxes of places and headings. In a step of fixed length, its heading changes by at
most the length divided by its turning radius; so from all poses of a box, the car gets into known
boxes of each heading, unless it is in a wall there or on the way. If the target is nowhere near,
it never arrives.

What boxes lose makes the car a little better than it is, and smaller ones lose less.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import TURN, UNIT, in_cells
from worldgen.reach.body.prove import goal_headings
from worldgen.reach.decision import CarConfinement
from worldgen.reach.still.walls import described_walls
from worldgen.robot import Corner, Robot
from worldgen.support.arrays import Bytes, Floats, Ints
from worldgen.support.ccall import check, pointer
from worldgen.world import World


class Grain(NamedTuple):
    """How finely poses are put into boxes.

    Args:
        finer: How many times smaller boxes are than the largest ones.
        headings: Parts of a turn.
        most_turn: Parts of a turn by which the heading changes in a step, at most.
    """

    finer: float
    headings: int
    most_turn: int


# Each is tried if the one before proves nothing.
GRAINS = (Grain(1, 64, 5), Grain(2, 128, 5), Grain(4, 128, 5), Grain(8, 128, 5), Grain(16, 192, 5))
# Sides of the largest boxes: shares of the turning radius, and of the radius of a disc in the body.
_OF_TURNING, _OF_BODY = 1 / 16, 1 / 3
# Limits on the boxes, a bit each; on their places, as the checker's; on the places of all discs; and on the steps
# tried from the boxes. Each takes about 1 s.
_MOST_BOXES = 450_000_000
_MOST_PLACES = 4_000_000
_MOST_DISC_PLACES = 30_000_000
_MOST_STEPS = 15_000_000
# Turning radius, cells, as the checker's.
_MOST_TURNING = 100_000
# Parts of a step after which the car must be where it has room.
_PARTS = 4
# Share of a step by which places are widened: more than legs of a simulated car differ from arcs.
_WIDER = 0.003
# Cells by which a simulated car may be off an arc, and what rounding adds to that.
_OFF = 1 / 40 + 1e-6
# Angle by which it may turn more than its way allows, rad; more than the checker grants.
_TURN = 5 * math.tau / TURN
# Factor of its curvature, for rounding.
_TIGHTER = 1.001
# A simulated car drives straight legs. On one, its heading is that of some point of its arc, and length times turn of
# a leg is at most 1/8 cell; this is their product and a bit, cells.
_LEG = 0.2
# Points of a step at which its directions are bounded, per part.
_POINTS = 16


class _Disc(NamedTuple):
    """A disc in the body: its middle ahead and to the left of the axle, and its radius, cells."""

    ahead: float
    left: float
    radius: float


class Confined(NamedTuple):
    """What came of an attempt to confine a car.

    Args:
        proof: The proof that it cannot arrive, or None.
        side: Side of the smallest boxes that were tried, m; None if there were none.
        headings: Parts of a turn of those.
    """

    proof: CarConfinement | None
    side: float | None = None
    headings: int = 0


def confine_car(world: World) -> Confined:
    """Look for a proof that the world's car, which never reverses, cannot arrive.

    Args:
        world: A world that does not change.
    """
    size = world.cell_size
    discs = _discs_of(world.robots[0], size)
    found = Confined(None)
    turning = in_cells(world.robots[0].drive.turning_radius, size)
    if discs and (turning > _MOST_TURNING or _may_leave(world, discs[0])):
        discs = []
    for grain in GRAINS if discs else ():
        flood = _Flood(world, discs, grain)
        if flood.is_too_fine:
            break
        runs = flood.runs()
        # Without a box, the body overlaps a wall at the start; that is for its own decision.
        proof = flood.proof(runs) if runs is not None and len(runs) else None
        found = Confined(proof, flood.side * size, grain.headings)
        if proof is not None:
            break
    return found


class _Flood:
    """Finds the boxes of a grain that the car cannot leave; lengths are in cells."""

    def __init__(self, world: World, discs: list[_Disc], grain: Grain) -> None:
        self._world = world
        self._discs = discs
        self._grain = grain
        robot = world.robots[0]
        self._turning = float(in_cells(robot.drive.turning_radius, world.cell_size))
        self._lean = math.sqrt(_LEG / self._turning)
        largest = max(disc.radius for disc in discs)
        self.side = min(self._turning * _OF_TURNING, largest * _OF_BODY) / grain.finer
        self._part = math.tau / grain.headings
        self._rows: int = math.ceil(len(world.walls) / self.side)
        self._columns: int = math.ceil(world.walls.shape[1] / self.side)
        # At full lock, a whole number of parts is enough for the turn of a step.
        self._step = (grain.most_turn * self._part - 1.1 * _TURN) / _TIGHTER * self._turning

    @property
    def is_too_fine(self) -> bool:
        """True if there would be too many boxes in the world."""
        places = self._rows * self._columns
        return (
            places > _MOST_PLACES
            or places * len(self._discs) > _MOST_DISC_PLACES
            or places * self._grain.headings > _MOST_BOXES
        )

    def proof(self, runs: Ints) -> CarConfinement:
        size = self._world.cell_size
        discs = tuple((a * size, b * size, radius * size) for a, b, radius in self._discs)
        headings = self._grain.headings
        return CarConfinement(self.side * size, self._step * size, headings, discs, runs)

    def runs(self) -> Ints | None:
        """Return the boxes that the car gets into; None if it may arrive, or takes too many steps."""
        grain = self._grain
        world = self._world
        size = world.cell_size
        places, may_arrive = self._steps()
        start = np.array(self._start(), np.int64)
        reaches, shifts = self._shifts()
        target = world.target
        near = target.radius / size + _OFF + (1.0 + _WIDER) * self._step / _PARTS
        asked = ffi.new(
            "WgCarFlood *",
            {
                "side": self.side,
                "columns": self._columns,
                "rows": self._rows,
                "headings": grain.headings,
                "most_turn": grain.most_turn,
                "parts": _PARTS,
                "steps": pointer(ffi, places, np.int32),
                "may_arrive": pointer(ffi, may_arrive, np.uint8),
                "discs": len(self._discs),
                "reaches": pointer(ffi, reaches, np.float64),
                "shifts": pointer(ffi, shifts, np.int32),
                "target_x": target.x / size,
                "target_y": target.y / size,
                "target_reach": near + 0.75 * self.side,
                "step": _farthest(places) * self.side,
                "start_arrives": int(self._is_goal(world.start.heading, self._passing())),
                "starts": len(start),
                "start": pointer(ffi, start, np.int64),
                "most": _MOST_STEPS,
            },
        )
        check(lib.wg_car_flood(described_walls(world.walls), asked))
        if asked.outcome != lib.WG_CAR_CONFINED:
            return None
        runs = np.frombuffer(ffi.buffer(asked.runs, 32 * asked.count), np.int64)
        runs = runs.reshape(-1, 4).copy()
        lib.wg_car_flood_free(asked)
        return runs

    def _start(self) -> list[tuple[int, int, int]]:
        """Return headings, rows and columns of the boxes that the start may be in."""
        start = self._world.start
        size = self._world.cell_size
        part = math.remainder(start.heading, math.tau) / self._part
        ranges = []
        for value, off in (
            (part + 0.5, _TURN / self._part),
            (start.y / size / self.side, 1.5 / UNIT / self.side),
            (start.x / size / self.side, 1.5 / UNIT / self.side),
        ):
            ranges.append(range(math.floor(value - off), math.floor(value + off) + 1))
        return [
            (heading % self._grain.headings, row, column)
            for heading in ranges[0]
            for row in ranges[1]
            for column in ranges[2]
            if 0 <= row < self._rows and 0 <= column < self._columns
        ]

    def _passing(self) -> float:
        """Return by how much the heading may differ where the target is met in the next part.

        The car may be in a wall at the end of that part, so that it only counts where it was before.
        """
        return self._step / _PARTS * _TIGHTER / self._turning + 2.0 * _TURN + self._lean

    def _is_goal(self, heading: float | Floats, off: float | Floats) -> Bytes:
        """Return whether headings, rad, that may be off by angles, may be the target's."""
        goal = goal_headings(self._world.target)
        if goal is None:
            return np.zeros(np.shape(heading), np.uint8)
        half = (goal.following / 2 + 4) * math.tau / TURN
        middle = (goal.first + goal.following / 2) * math.tau / TURN
        away = np.abs(np.remainder(heading - middle + math.pi, math.tau) - math.pi)
        return (away <= half + off).astype(np.uint8)

    def _shifts(self) -> tuple[Floats, Ints]:
        """Return from how near to a wall each disc meets it, and how many boxes it is ahead."""
        side = self.side
        headings = np.arange(self._grain.headings)[:, None] * self._part
        ahead, left, radii = (np.array(values) for values in zip(*self._discs, strict=True))
        shifts = np.stack(
            [
                np.rint((ahead * np.cos(headings) - left * np.sin(headings)) / side),
                np.rint((ahead * np.sin(headings) + left * np.cos(headings)) / side),
            ],
            axis=2,
        )
        away = np.hypot(ahead, left)
        # Both the place of a pose in its box and that of a disc between boxes are off by this.
        corner = side * math.sqrt(0.5)
        slack = (
            corner
            + np.where(away > 0.0, corner, 0.0)
            + away * (0.5 * self._part + _TURN + self._lean)
        )
        reaches = radii - _OFF - slack - 1e-6
        # A disc that stops nothing does not stop the car outside the world, either.
        shifts[:, reaches <= 0.0] = 0.0
        return reaches, np.ascontiguousarray(shifts, np.int32)

    def _steps(self) -> tuple[Ints, Bytes]:
        """Return where the car is after each part of a step, and if it may arrive: the core's tables."""
        turn = self._grain.most_turn
        part = self._part
        middle = np.arange(self._grain.headings)[:, None, None] * part
        turned = middle + np.arange(-turn, turn + 1)[None, :, None] * part
        # Directions between two points on the way, which both ends bound.
        count = _PARTS * _POINTS
        piece = self._step / count
        points = np.arange(count) * piece
        gone = (points + piece) * _TIGHTER / self._turning + _TURN
        left = (self._step - points) * _TIGHTER / self._turning + _TURN
        low = np.maximum(middle - gone, turned - left)
        high = np.minimum(middle + gone, turned + left)
        low, high = (np.minimum(low, high) - 0.5 * part, np.maximum(low, high) + 0.5 * part)
        # Places at the end of each part.
        ends = np.s_[:, :, _POINTS - 1 :: _POINTS]
        wider = _WIDER * self._step
        places = []
        for quarter in (0.0, math.pi / 2):
            least, most = (
                (bound(low - quarter, high - quarter) * piece).cumsum(axis=2)[ends]
                for bound in (_least, _most)
            )
            places.append(np.floor((least - wider) / self.side))
            places.append(np.floor((most + wider) / self.side) + 1)
        middles = (low[ends] + high[ends]) / 2.0
        may_arrive = self._is_goal(middles, (high[ends] - low[ends]) / 2.0 + self._passing())
        return np.ascontiguousarray(np.stack(places, axis=3), np.int32), may_arrive


def _farthest(places: Ints) -> float:
    """Return how far the corners of rectangles are, in boxes."""
    across, along = (np.abs(places[..., sides]).max(axis=-1) for sides in ([0, 1], [2, 3]))
    return float(np.hypot(across, along).max())


def _most(low: Floats, high: Floats) -> Floats:
    """Return the largest cosine of an angle in a range."""
    wraps = np.floor(high / math.tau) * math.tau >= low
    found: Floats = np.where(wraps, 1.0, np.maximum(np.cos(low), np.cos(high)))
    return found


def _least(low: Floats, high: Floats) -> Floats:
    found: Floats = -_most(low - math.pi, high - math.pi)
    return found


def _discs_of(robot: Robot, cell_size: float) -> list[_Disc]:
    """Return discs that the body holds, about the axle first; none if it is too small for any."""
    if robot.is_disc:
        radius = float(in_cells(robot.radius, cell_size))
        return [_Disc(0.0, 0.0, radius)] if radius > _OFF else []
    corners = np.array(robot.footprint) / cell_size
    middle = corners.mean(axis=0)
    places = [(0.0, 0.0)]
    # Along the axis of the car, and towards its corners.
    places += [(x, 0.0) for x in np.linspace(corners[:, 0].min(), corners[:, 0].max(), 9)[1:-1]]
    places += [(x, y) for x, y in middle + 0.7 * (corners - middle)]
    found: list[_Disc] = []
    for place in places:
        # What a body loses when its corners are rounded to the lattice.
        radius = _room_in(corners, place) - 2 / UNIT
        if radius > 2 * _OFF or not found:
            found.append(_Disc(float(place[0]), float(place[1]), max(radius, 0.0)))
    return found if any(disc.radius > _OFF for disc in found) else []


def _may_leave(world: World, axle: _Disc) -> bool:
    """Return True if the axle may be outside the world, where there are no boxes.

    The world holds the body, and with it an axle that is in it.
    """
    if axle.radius > _OFF:
        return False
    corners = np.array(world.robots[0].footprint) / world.cell_size
    # Of an axle outside the body, that to a corner is more than its distance.
    is_inside = _room_in(corners, (0.0, 0.0)) >= 0.0
    away = 0.0 if is_inside else float(np.hypot(corners[:, 0], corners[:, 1]).min())
    border = math.ceil(away + 2.0 * _OFF)
    inner = np.ones(world.walls.shape, np.bool_)
    inner[border:-border, border:-border] = False
    return bool((inner & ~world.walls).any())


def _room_in(corners: Floats, place: Corner) -> float:
    """Return the distance of a place from the outline of a body that holds it; below 0 outside."""
    sides = np.roll(corners, -1, axis=0) - corners
    away = np.array(place) - corners
    across = sides[:, 0] * away[:, 1] - sides[:, 1] * away[:, 0]
    return float((across / np.hypot(sides[:, 0], sides[:, 1])).min())
