"""Check a confinement without any of the code that made it: fractions, numpy, plain Python.

It does not search. For each stay it checks that every place a robot can reach within the next slab
is in some stay.
"""

from __future__ import annotations

import bisect
import math
from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction
from typing import TypeAlias

from worldgen.reach.check.certificate import CheckReport, blocked_spans
from worldgen.reach.decision.confinement import NEVER_ENDS, Confinement
from worldgen.world import World

# Tolerance in tiles: a robot that is late by less than this counts as in time, and a tile that is
# farther from the target by less than this counts as at the target.
SLACK = 1e-9

Tile: TypeAlias = tuple[int, int]
Slabs: TypeAlias = tuple[int, int]


class _ConfinementRefused(Exception):
    """Raised if the confinement is invalid; the message gives the reason."""


def check_confinement(
    world: World, proof: Confinement, *, radius: float | None = None
) -> CheckReport:
    """Return True if a confinement proves that a disc never reaches the target, or too late.

    Args:
        world: The world.
        proof: The confinement.
        radius: Radius of the disc, m; the robot's if omitted.
    """
    radius = world.robot_radius if radius is None else radius
    try:
        _Check(world, proof, radius).run()
    except _ConfinementRefused as refusal:
        return CheckReport(False, str(refusal), 0.0)
    within = "" if proof.deadline is None else f" within {proof.deadline:g} s"
    if not len(proof.stays):
        return CheckReport(True, f"no robot gets that far{within}", 0.0)
    return CheckReport(
        True,
        f"no robot can leave the {len(proof.stays)} stays{within}, and none of the stays is at "
        "the target",
        0.0,
    )


def _decimal(value: float) -> Fraction:
    return Fraction(repr(float(value)))


class _Check:
    def __init__(self, world: World, proof: Confinement, radius: float) -> None:
        # The slab must be short enough for the robot to stay within one tile of where it was.
        self.world = world
        self.proof = proof
        self.k = proof.k
        if not (isinstance(proof.k, int) and proof.k >= 1 and proof.slab > 0):
            raise _ConfinementRefused("a tile or a time slab has size 0")
        size = _decimal(world.cell_size)
        speed = _decimal(world.robot_speed)
        if proof.slab * speed > size / proof.k:
            raise _ConfinementRefused(
                f"in a slab of {float(proof.slab):g} s the robot can move farther than one tile's "
                f"side"
            )
        # Convert the robot, its start and its target to tiles.
        self.radius = _decimal(radius) / size
        # Tiles per slab.
        self.pace = float(proof.slab * speed * proof.k / size)
        self.way = (
            math.inf
            if proof.deadline is None
            else float(_decimal(proof.deadline) * speed * proof.k / size)
        )
        self.last = (
            NEVER_ENDS
            if proof.deadline is None
            else math.floor(_decimal(proof.deadline) / proof.slab)
        )
        self.home = math.floor(self._tiles(world.start.x)), math.floor(self._tiles(world.start.y))
        self.start = float(self._tiles(world.start.x)), float(self._tiles(world.start.y))
        self.target = float(self._tiles(world.target.x)), float(self._tiles(world.target.y))
        self.reach = float(self._tiles(world.target.radius))
        # Sort the blocked spans by cell.
        self.fixed = world.still_walls
        self.spans: dict[Tile, list[tuple[Fraction | float, Fraction | float]]] = defaultdict(list)
        spans = blocked_spans(world)
        for ix, iy, begin, end in zip(
            spans.ix.tolist(),
            spans.iy.tolist(),
            spans.begin.tolist(),
            spans.end.tolist(),
            strict=True,
        ):
            self.spans[ix, iy].append(
                (_decimal(begin), math.inf if end == math.inf else _decimal(end))
            )
        self.offsets: dict[Tile, list[Tile]] = {}
        self.alive: dict[Tile, list[Slabs]] = {}
        self.stays: dict[Tile, list[Slabs]] = defaultdict(list)

    def _tiles(self, metres: float) -> Fraction:
        return _decimal(metres) / _decimal(self.world.cell_size) * self.k

    def run(self) -> None:
        """Raise _Refused if the confinement does not hold."""
        for ix, iy, first, last in self.proof.stays.tolist():
            inside = 0 <= ix < self.world.width * self.k and 0 <= iy < self.world.height * self.k
            if not (inside and 0 <= first <= last):
                raise _ConfinementRefused(
                    f"tile ({ix}, {iy}) from slab {first} to {last} is not a valid stay"
                )
            self.stays[ix, iy].append((first, last))
            if first <= self.last and self._apart((ix, iy), self.target) <= self.reach + SLACK:
                raise _ConfinementRefused(f"the stay in tile ({ix}, {iy}) is at the target")
        for stays in self.stays.values():
            stays.sort()
        for tile in self._around(self.home):
            for first, last in self._where_in_time(tile):
                if first == 0:
                    self._require(tile, 0, min(last, 0))
        for here, stays in list(self.stays.items()):
            for tile in self._around(here):
                for first, last in self._where_in_time(tile):
                    for begin, end in stays:
                        self._require(tile, max(begin + 1, first), min(end + 1, last))

    def _around(self, tile: Tile) -> Iterator[Tile]:
        width = self.world.width * self.k
        height = self.world.height * self.k
        for iy in range(max(tile[1] - 1, 0), min(tile[1] + 2, height)):
            for ix in range(max(tile[0] - 1, 0), min(tile[0] + 2, width)):
                yield ix, iy

    def _require(self, tile: Tile, first: int, last: int) -> None:
        """Require that some stay in the tile lasts from the first to the last of these slabs."""
        if first > last:
            return
        stays = self.stays.get(tile, [])
        at = bisect.bisect_right(stays, (first, 2 * NEVER_ENDS)) - 1
        if not any(begin <= first and end >= last for begin, end in stays[: at + 1]):
            raise _ConfinementRefused(f"a robot leaves its stay into tile {tile} in slab {first}")

    @staticmethod
    def _apart(tile: Tile, point: tuple[float, float]) -> float:
        """Return the distance of a point from a tile, in sides of a tile."""
        dx = max(tile[0] - point[0], point[0] - tile[0] - 1.0, 0.0)
        dy = max(tile[1] - point[1], point[1] - tile[1] - 1.0, 0.0)
        return math.sqrt(dx * dx + dy * dy)

    def _where_in_time(self, tile: Tile) -> list[Slabs]:
        """Return the slabs in which a pose of the tile may be clear, reachable, and in time."""
        if tile not in self.alive:
            soonest = (self._apart(tile, self.start) - SLACK) / self.pace - 1
            to_go = max(self._apart(tile, self.target) - self.reach, 0.0)
            latest = (self.way - to_go + SLACK) / self.pace if self.way < math.inf else math.inf
            low = math.ceil(soonest)
            high = NEVER_ENDS if latest == math.inf else math.floor(latest)
            high = min(high, self.last)
            kept = ((max(first, low), min(last, high)) for first, last in self._clear(tile))
            self.alive[tile] = [(first, last) for first, last in kept if first <= last]
        return self.alive[tile]

    def _clear(self, tile: Tile) -> list[Slabs]:
        """Return the slabs in which no single blocked cell covers the whole tile."""
        blocked: list[tuple[Fraction | float, Fraction | float]] = []
        for cell in self._covering(tile):
            outside = not (0 <= cell[0] < self.world.width and 0 <= cell[1] < self.world.height)
            if outside or self.fixed[cell[1], cell[0]]:
                return []
            blocked += self.spans.get(cell, [])
        found: list[Slabs] = []
        free: Fraction | float = Fraction(0)
        for begin, end in [*sorted(blocked), (math.inf, math.inf)]:
            if begin > free:
                last = NEVER_ENDS if begin == math.inf else math.ceil(begin / self.proof.slab) - 1
                found.append((math.floor(free / self.proof.slab), last))
            free = max(free, end)
        return found

    def _covering(self, tile: Tile) -> Iterator[Tile]:
        """Yield the cells within the radius of every point of the tile."""
        x = tile[0] // self.k
        y = tile[1] // self.k
        place = tile[0] % self.k, tile[1] % self.k
        if place not in self.offsets:
            reach = math.ceil(self.radius) + 1
            span = range(-reach, reach + 1)
            self.offsets[place] = [
                (dx, dy)
                for dx in span
                for dy in span
                if self._farthest(place[0], dx) ** 2 + self._farthest(place[1], dy) ** 2
                < self.radius**2
            ]
        for dx, dy in self.offsets[place]:
            yield x + dx, y + dy

    def _farthest(self, tile: int, cell: int) -> Fraction:
        """Return how far, along one axis, a point of a tile can be from a cell.

        Both are counted from the same cell.
        """
        return max(
            Fraction(cell * self.k - tile, self.k),
            Fraction(tile + 1, self.k) - cell - 1,
            Fraction(0),
        )
