"""Check the distances between the robots of a joint witness, without any of the code that made it.

Between two points in time at which neither path bends, two robots move uniformly along straight
lines, so each moves along a straight line relative to the other. Their distance there is a
segment's distance from the origin. Distances are in metres, with the tolerance of a witness.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from worldgen.support.arrays import Floats
from worldgen.world import Witness, World


class PairDistance(NamedTuple):
    """The smallest distance between two robots.

    Args:
        first: Number of one robot, from 1.
        second: Number of the other robot.
        distance: Smallest distance of their centres, m.
        time: Time of that distance, s.
    """

    first: int
    second: int
    distance: float
    time: float


def pair_distances(paths: Sequence[Witness], within: Floats) -> Iterator[PairDistance]:
    """Yield the smallest distance of each pair of robots that may come close enough to matter.

    Args:
        paths: A path of each robot; a robot waits at the end of its path.
        within: (n, n) float64, m. Pairs whose paths are farther apart everywhere are skipped.
    """
    boxes = np.array([(p.x.min(), p.y.min(), p.x.max(), p.y.max()) for p in paths])
    low = boxes[:, :2]
    high = boxes[:, 2:]
    for first, second in itertools.combinations(range(len(paths)), 2):
        gap = np.maximum(low[first] - high[second], low[second] - high[first]).max()
        if gap <= within[first, second]:
            distance, time = _distance(paths[first], paths[second])
            yield PairDistance(first + 1, second + 1, distance, time)


def _distance(one: Witness, two: Witness) -> tuple[float, float]:
    """Return the smallest distance of two robots, m, and its time, s."""
    times = np.union1d(one.times, two.times)
    # Beyond its end, interpolation keeps the last point of a path: the robot waits there.
    x = np.interp(times, one.times, one.x) - np.interp(times, two.times, two.x)
    y = np.interp(times, one.times, one.y) - np.interp(times, two.times, two.y)
    gaps, share = nearest_to_zero(x, y)
    k = int(np.argmin(gaps))
    length = float(np.diff(times, append=times[-1])[k])
    return float(gaps[k]), float(times[k] + share[k] * length)


def nearest_to_zero(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return how near each piece of a path comes to (0, 0), and at which share of its length.

    The last point counts as a piece of its own.
    """
    dx = np.diff(x, append=x[-1])
    dy = np.diff(y, append=y[-1])
    length_sq = dx * dx + dy * dy
    with np.errstate(all="ignore"):
        share = np.clip(-(x * dx + y * dy) / length_sq, 0.0, 1.0)
    share = np.where(length_sq > 0.0, share, 0.0)
    return np.hypot(x + share * dx, y + share * dy), share


def nearest_pair(
    world: World, paths: Sequence[Witness], radii: Sequence[float]
) -> tuple[PairDistance | None, float]:
    """Return the pair that overlaps most, if any, and the largest equal radius that fits.

    Args:
        world: The world, whose cells give the unit of the tolerance.
        paths: A path of each robot.
        radii: Radius of each robot, m.

    Returns:
        The pair whose centres come closest to each other, compared with the sum of their radii, or
        None if no two robots come close to each other; and half the smallest distance of two
        centres, m.
    """
    sums = np.add.outer(np.asarray(radii, float), np.asarray(radii, float))
    # Half the smallest distance is needed too, and it may belong to two small robots.
    reach = np.full_like(sums, max(sums.max(), 2.0 * max(path.clearance for path in paths)))
    worst: PairDistance | None = None
    worst_room = np.inf
    half = np.inf
    for pair in pair_distances(paths, reach + world.cell_size):
        half = min(half, pair.distance / 2.0)
        room = pair.distance - sums[pair.first - 1, pair.second - 1]
        if room < worst_room:
            worst_room = room
            worst = pair
    return worst, float(half)
