"""Doors of a floor plan: a tree of them joins all boxes, some more close loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from worldgen.families.parts.disjoint_sets import joining
from worldgen.families.parts.floor_plan import FloorPlan, Joints, Sizes
from worldgen.random_streams import RandomStream

__all__ = ["Doors", "hang_doors", "shut_doors"]


@dataclass(frozen=True)
class Doors:
    """Openings in the walls of a plan.

    Args:
        walls: (size, size) bool, doors open.
        joints: Where each opening is, a number of the plan's joints; junctions of corridors are
            among them.
        openings: Rows and columns of each.
    """

    walls: npt.NDArray[np.bool_]
    joints: list[int]
    openings: list[tuple[slice, slice]]


def _shuffled(rng: RandomStream, rank: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Positions in order of their rank, in random order within one."""
    return np.lexsort((rng.bits(len(rank)), rank))


def hang_doors(
    rng: RandomStream, plan: FloorPlan, joints: Joints, sizes: Sizes, shared: float
) -> Doors:
    """Opens doors until all boxes are joined, then a share of the other walls between two of them.

    Corridors are joined first, over their whole width, then rooms to corridors, rooms to rooms
    where they must be.
    """
    ranks = (joints.pairs >= plan.corridors).sum(axis=1)  # 0: two corridors, 2: two rooms
    order = _shuffled(rng.child("order"), ranks)
    tree = order[joining([(int(a), int(b)) for a, b in joints.pairs[order]], len(plan.boxes))]
    chosen = ranks == 0
    chosen[tree] = True
    chosen |= rng.child("shared").floats(len(ranks)) < shared
    walls = plan.owner < 0
    opened: list[int] = np.flatnonzero(chosen).tolist()
    openings = []
    for joint in opened:
        length = int(joints.length[joint])
        width = length if ranks[joint] == 0 else sizes.door
        openings.append(joints.opening(joint, rng.between(0, length - width), width, sizes.wall))
        walls[openings[-1]] = False
    return Doors(walls, opened, openings)


def shut_doors(
    rng: RandomStream,
    plan: FloorPlan,
    joints: Joints,
    doors: Doors,
    share: float,
    ends: tuple[int, int],
) -> int:
    """Shuts a share of the doors, in place, but none on one way between two boxes; how many.

    The way is the one in a random spanning tree, rarely the shortest. Junctions of corridors are no
    doors.
    """
    pairs = [(int(a), int(b)) for a, b in joints.pairs[doors.joints]]
    order = _shuffled(rng.child("way"), np.zeros(len(pairs), dtype=np.int64)).tolist()
    tree = [order[k] for k in joining([pairs[number] for number in order], len(plan.boxes))]
    kept = set(_way(pairs, tree, *ends))
    movable = [number for number, pair in enumerate(pairs) if max(pair) >= plan.corridors]
    loose = [number for number in movable if number not in kept]
    rng.shuffle(loose)
    shut = loose[: round(share * len(movable))]
    for number in shut:
        doors.walls[doors.openings[number]] = True
    return len(shut)


def _way(pairs: list[tuple[int, int]], tree: list[int], start: int, target: int) -> list[int]:
    """The tree's edges between two boxes."""
    around: dict[int, list[tuple[int, int]]] = {}
    for number in tree:
        one, other = pairs[number]
        around.setdefault(one, []).append((other, number))
        around.setdefault(other, []).append((one, number))
    came: dict[int, tuple[int, int]] = {start: (start, -1)}
    pending = [start]
    while pending and target not in came:
        box = pending.pop()
        for other, number in around.get(box, ()):
            if other not in came:
                came[other] = (box, number)
                pending.append(other)
    way = []
    while target != start:
        target, number = came[target]
        way.append(number)
    return way
