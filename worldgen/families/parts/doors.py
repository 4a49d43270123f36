"""Doors of a floor plan: a tree of doors joins all boxes, and extra doors close loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from worldgen.families.parts.disjoint_sets import joining
from worldgen.families.parts.floor_plan import FloorPlan, Joints, Sizes
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools, Ints


@dataclass(frozen=True)
class Doors:
    """Hold the openings in the walls of a plan.

    Args:
        walls: (size, size) bool, with the openings free.
        joints: Index of each opening in the plan's joints; includes junctions of corridors.
        openings: Rows and columns of each opening.
    """

    walls: Bools
    joints: list[int]
    openings: list[tuple[slice, slice]]


def _shuffled(rng: RandomStream, rank: Ints) -> Ints:
    """Return positions sorted by rank, in random order within each rank."""
    return np.lexsort((rng.bits(len(rank)), rank))


def hang_doors(
    rng: RandomStream, plan: FloorPlan, joints: Joints, sizes: Sizes, shared: float
) -> Doors:
    """Open doors until all boxes are joined, then a share of the remaining walls.

    Corridors are joined first and over their whole width, then rooms to corridors. Two rooms are
    joined only if nothing else connects them.

    Args:
        rng: The only source of randomness.
        plan: The floor plan.
        joints: Stretches of wall that a door fits into.
        sizes: Widths of doors and walls.
        shared: Probability of a door where none is needed.
    """
    # Rank 0 is between two corridors, 1 between a room and a corridor, 2 between two rooms.
    ranks = (joints.pairs >= plan.corridors).sum(axis=1)
    order = _shuffled(rng.child("order"), ranks)
    tree = order[joining([(int(a), int(b)) for a, b in joints.pairs[order]], len(plan.boxes))]
    chosen = ranks == 0
    chosen[tree] = True
    chosen |= rng.child("shared").floats(len(ranks)) < shared

    # Open each chosen joint at a random position along it.
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
    """Shut a share of the doors, in place, but keep one path between two boxes open.

    The path is taken from a random spanning tree, so it is rarely the shortest. Junctions of
    corridors are not doors and stay open.

    Args:
        rng: The only source of randomness.
        plan: The floor plan.
        joints: Stretches of wall of the plan.
        doors: The plan's doors; its walls are changed.
        share: Share of the doors to shut.
        ends: The two boxes that stay connected.

    Returns:
        Number of doors that were shut.
    """
    # Find the doors to keep.
    pairs = [(int(a), int(b)) for a, b in joints.pairs[doors.joints]]
    order = _shuffled(rng.child("way"), np.zeros(len(pairs), dtype=np.int64)).tolist()
    tree = [order[k] for k in joining([pairs[number] for number in order], len(plan.boxes))]
    kept = set(_way(pairs, tree, *ends))

    # Shut a random selection of the others.
    movable = [number for number, pair in enumerate(pairs) if max(pair) >= plan.corridors]
    loose = [number for number in movable if number not in kept]
    rng.shuffle(loose)
    shut = loose[: round(share * len(movable))]
    for number in shut:
        doors.walls[doors.openings[number]] = True
    return len(shut)


def _way(pairs: list[tuple[int, int]], tree: list[int], start: int, target: int) -> list[int]:
    """Return the tree's edges on the path between two boxes."""
    # List each box's neighbours in the tree, and search from the start until the target is found.
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

    # Walk back along the boxes that each was reached from.
    way = []
    while target != start:
        target, number = came[target]
        way.append(number)
    return way
