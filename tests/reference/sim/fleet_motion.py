"""How several robots move together, in plain Python: the specification of ``sim/core/fleet``.

Robots that cannot meet any other move as if alone. The others form clusters, which move in phases,
as ``docs/reference/fleets.md`` describes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tests.reference.sim.geometry import _corner_is_clear as corner_is_clear
from tests.reference.sim.geometry import pose_is_clear, segment_first_not_clear
from tests.reference.sim.lattice_motion import _contact_with_corner as touch_time
from tests.reference.sim.lattice_motion import endpoint_move, first_contact, round_away, swept_move
from tests.reference.sim.layout import SOLID, TIME_UNIT

Cells = npt.NDArray[np.uint8]
Corner = tuple[int, int, int]

PHASES = 12
TRIES = 3
ASIDE = 4
STAND = 16
SLACK = 32
GRAZE = 1e-6


@dataclass
class Disc:
    """A robot in a move: its place and displacement, lattice units, and the results."""

    x: int
    y: int
    dx: int
    dy: int
    clear_sq: int
    reach: int
    chain: list[Corner] = field(default_factory=list)
    contact: tuple[float, float] = (0.0, 0.0)
    goal: tuple[int, int] = (0, 0)
    candidate: int = 0
    normal: tuple[float, float] = (0.0, 0.0)
    touch: tuple[float, float] = (0.0, 0.0)
    touching: int = 0
    contacts: int = 0
    violated: bool = False

    @property
    def moves(self) -> bool:
        return self.dx != 0 or self.dy != 0

    @property
    def far(self) -> int:
        if not self.moves:
            return self.reach
        return self.reach + math.ceil(math.sqrt(float(self.dx) ** 2 + float(self.dy) ** 2)) + SLACK

    @property
    def last_normal(self) -> tuple[float, float]:
        return self.touch if self.touching else self.normal

    def set_goal(self, share: float) -> None:
        length = math.sqrt(float(self.dx) * self.dx + float(self.dy) * self.dy)
        part = (share * length - self.candidate // ASIDE) / length if length > 0.0 else 0.0
        x = self.x + round_away(part * self.dx)
        y = self.y + round_away(part * self.dy)
        if self.candidate >= STAND or part <= 0.0 or (x, y) == (self.x, self.y):
            self.candidate = STAND
            self.goal = (self.x, self.y)
            return
        nx, ny = self.last_normal
        sx = (nx > 0.0) - (nx < 0.0)
        sy = (ny > 0.0) - (ny < 0.0)
        away = self.candidate % ASIDE
        if away == ASIDE - 1:
            self.goal = (x + sx, y + sy)
        else:
            self.goal = (
                x + away * (sx if abs(nx) >= abs(ny) else 0),
                y + away * (sy if abs(ny) >= abs(nx) else 0),
            )

    @property
    def can_step_aside(self) -> bool:
        return self.last_normal != (0.0, 0.0) and self.candidate % ASIDE < ASIDE - 1

    def has_another_goal(self, back: bool) -> bool:
        return self.moves and self.candidate < STAND and (self.can_step_aside or back)

    def try_another_goal(self, share: float) -> None:
        if self.can_step_aside:
            self.candidate += 1
        else:
            self.candidate = (self.candidate // ASIDE + 1) * ASIDE
        self.set_goal(share)

    def touches(self, normal: tuple[float, float]) -> None:
        if not self.touching or normal > self.touch:
            self.touch = normal
        self.touching += 1


def joint_move(
    cells: Cells,
    discs: Sequence[Disc],
    clear_sq: Mapping[tuple[int, int], int],
    friction: float,
    *,
    swept: bool,
) -> set[tuple[int, int]]:
    """Move all discs for a step in which the world does not change.

    Args:
        cells: (height, width) cell states.
        discs: The robots; their chains and contacts are filled.
        clear_sq: Squared distance that two robots keep, by their indices, the smaller first.
        friction: Share of a slide that is lost to walls.
        swept: Whether under ``swept``, else under ``endpoint``.

    Returns:
        Pairs of indices that drive through each other; empty under ``swept``.
    """
    clusters = _clusters(discs)
    collided: set[tuple[int, int]] = set()
    for members in clusters:
        near = [
            (one, other)
            for one, other in itertools.combinations(members, 2)
            if _may_meet(discs[one], discs[other])
        ]
        if not near:
            _alone(cells, discs[members[0]], friction, swept)
        elif swept:
            _sweep(cells, discs, members, near, clear_sq, friction)
        else:
            collided |= _jump(cells, discs, members, near, clear_sq)
    return collided


def _may_meet(one: Disc, other: Disc) -> bool:
    away_sq = (one.x - other.x) ** 2 + (one.y - other.y) ** 2
    return (one.moves or other.moves) and away_sq < (one.far + other.far) ** 2


def _clusters(discs: Sequence[Disc]) -> list[list[int]]:
    """Return the indices of robots that may meet, directly or through others."""
    left = set(range(len(discs)))
    found = []
    while left:
        members = [left.pop()]
        for one in members:
            near = {other for other in left if _may_meet(discs[one], discs[other])}
            left -= near
            members += near
        found.append(sorted(members))
    return found


def _alone(cells: Cells, disc: Disc, friction: float, swept: bool) -> None:
    chain = np.zeros((8, 3), np.int64)
    ends = (disc.x, disc.y, disc.dx, disc.dy)
    if swept:
        count, nx, ny = swept_move(
            cells, disc.clear_sq, disc.reach, ends, (0.0, 1.0), friction, chain, 0
        )
    else:
        count, nx, ny = endpoint_move(cells, disc.clear_sq, disc.reach, ends, chain, 0)
    disc.chain = [tuple(row) for row in chain[:count].tolist()]
    disc.contact = (nx, ny)


def _clear_of_walls(cells: Cells, disc: Disc) -> bool:
    ends = (disc.x, disc.y, *disc.goal)
    return (
        disc.goal == (disc.x, disc.y)
        or not segment_first_not_clear(cells, SOLID, disc.clear_sq, disc.reach, ends)[0]
    )


def _clear_of_each_other(one: Disc, other: Disc, clear_sq: int) -> bool:
    px = one.x - other.x
    py = one.y - other.y
    qx = one.goal[0] - other.goal[0]
    qy = one.goal[1] - other.goal[1]
    if qx * qx + qy * qy < clear_sq:
        return False
    dx = qx - px
    dy = qy - py
    along = -dx * px - dy * py
    across = -dx * py + dy * px
    return corner_is_clear(clear_sq, along, across, dx * dx + dy * dy)


def _find_goals(cells, discs, members, near, clear_sq, share, *, back):
    for k in members:
        discs[k].candidate = 0
        discs[k].set_goal(share)
    while True:
        for k in members:
            discs[k].violated = not _clear_of_walls(cells, discs[k])
            if discs[k].violated and not discs[k].has_another_goal(back):
                return False
        for pair in near:
            one, other = discs[pair[0]], discs[pair[1]]
            if not _clear_of_each_other(one, other, clear_sq[pair]):
                one.violated = other.violated = True
                if not one.has_another_goal(back) and not other.has_another_goal(back):
                    return False
        if not any(discs[k].violated for k in members):
            return True
        for k in members:
            if discs[k].violated and discs[k].has_another_goal(back):
                discs[k].try_another_goal(share)


def _wall_contact(cells: Cells, disc: Disc) -> tuple[float, float, float]:
    radius = math.sqrt(float(disc.clear_sq))
    for graze in (GRAZE, 0.0):
        found = first_contact(cells, radius, disc.reach, disc.x, disc.y, disc.dx, disc.dy, graze)
        if found[0] <= 1.0:
            return found
    return 1.0, -float(disc.dx), -float(disc.dy)


def _between(one: Disc, other: Disc, share: float) -> tuple[float, float]:
    return (
        float(one.x - other.x) + share * float(one.dx - other.dx),
        float(one.y - other.y) + share * float(one.dy - other.dy),
    )


def _first_contact(cells, discs, members, near, clear_sq):
    for k in members:
        discs[k].candidate = 0
        discs[k].set_goal(1.0)
        while not _clear_of_walls(cells, discs[k]) and discs[k].has_another_goal(False):
            discs[k].try_another_goal(1.0)
    walls = {
        k: _wall_contact(cells, discs[k]) for k in members if not _clear_of_walls(cells, discs[k])
    }
    times = {}
    for pair in near:
        one, other = discs[pair[0]], discs[pair[1]]
        if not _clear_of_each_other(one, other, clear_sq[pair]):
            time = touch_time(
                float(clear_sq[pair]),
                float(one.x - other.x),
                float(one.y - other.y),
                float(one.dx - other.dx),
                float(one.dy - other.dy),
                0.0,
            )
            times[pair] = min(1.0, time)
    first = min([1.0, *(wall[0] for wall in walls.values()), *times.values()])
    for k in members:
        discs[k].touching = 0
        if k in walls and walls[k][0] <= first:
            discs[k].touches(walls[k][1:])
    for pair, time in times.items():
        if time <= first:
            one, other = discs[pair[0]], discs[pair[1]]
            nx, ny = _between(one, other, first)
            one.touches((nx, ny))
            other.touches((-nx, -ny))
    return first


def _go_to_goals(discs: Sequence[Disc], members: Sequence[int], begin: float, end: float) -> None:
    from_time, to_time = (math.floor(time * TIME_UNIT + 0.5) for time in (begin, end))
    for k in members:
        disc = discs[k]
        if disc.goal != (disc.x, disc.y):
            since = disc.chain[-1][2] if disc.chain else 0
            if since < from_time:
                disc.chain.append((disc.x, disc.y, from_time))
            disc.chain.append((*disc.goal, to_time))


def _slide(disc: Disc, share: float, friction: float) -> None:
    dx = (1.0 - share) * disc.dx
    dy = (1.0 - share) * disc.dy
    if not disc.touching:
        stood = disc.goal == (disc.x, disc.y)
        disc.dx = round_away(dx) if stood else disc.dx - (disc.goal[0] - disc.x)
        disc.dy = round_away(dy) if stood else disc.dy - (disc.goal[1] - disc.y)
        return
    before = disc.normal
    nx, ny = disc.normal = disc.touch
    disc.contacts += 1
    into = (dx * nx + dy * ny) / (nx * nx + ny * ny)
    if into < 0.0:
        dx = dx - into * nx
        dy = dy - into * ny
    wedged = disc.contacts > 1 and dx * before[0] + dy * before[1] < 0.0
    stops = disc.touching > 1 or wedged or disc.contacts >= TRIES
    disc.dx = 0 if stops else round_away((1.0 - friction) * dx)
    disc.dy = 0 if stops else round_away((1.0 - friction) * dy)


def _sweep(cells, discs, members, near, clear_sq, friction):
    now = 0.0
    for _ in range(PHASES):
        for k in members:
            discs[k].touching = 0
        if _find_goals(cells, discs, members, near, clear_sq, 1.0, back=False):
            _go_to_goals(discs, members, now, 1.0)
            break
        share = _first_contact(cells, discs, members, near, clear_sq)
        _find_goals(cells, discs, members, near, clear_sq, share, back=True)
        until = now + (1.0 - now) * share
        _go_to_goals(discs, members, now, until)
        now = until
        for k in members:
            _slide(discs[k], share, friction)
            discs[k].x, discs[k].y = discs[k].goal
    for k in members:
        discs[k].contact = discs[k].normal


def _jump(cells, discs, members, near, clear_sq):
    for k in members:
        disc = discs[k]
        disc.goal = (disc.x + disc.dx, disc.y + disc.dy)
        if disc.moves and not pose_is_clear(cells, SOLID, disc.clear_sq, disc.reach, *disc.goal):
            disc.touches((-float(disc.dx), -float(disc.dy)))
            disc.goal = (disc.x, disc.y)
    found = True
    while found:
        inside = []
        for pair in near:
            one, other = discs[pair[0]], discs[pair[1]]
            dx = one.goal[0] - other.goal[0]
            dy = one.goal[1] - other.goal[1]
            if dx * dx + dy * dy < clear_sq[pair]:
                inside += [one, other]
                normal = (float(one.x - other.x), float(one.y - other.y))
                one.touches(normal)
                other.touches((-normal[0], -normal[1]))
        for disc in inside:
            disc.goal = (disc.x, disc.y)
        found = bool(inside)
    collided = {
        pair
        for pair in near
        if not _clear_of_each_other(discs[pair[0]], discs[pair[1]], clear_sq[pair])
    }
    _go_to_goals(discs, members, 0.0, 1.0)
    for k in members:
        discs[k].contact = discs[k].touch if discs[k].touching else (0.0, 0.0)
    return collided
