"""Worlds of several robots, and how close the robots of a run got to each other."""

import math

import numpy as np

from sim.controllers import Command
from worldgen.world import Pose, Robot, Target, World

EAST = 0.0
WEST = math.pi


def hall(width=40, height=20):
    """Return walls around an empty hall, (height, width) bool."""
    walls = np.ones((height, width), bool)
    walls[1:-1, 1:-1] = False
    return walls


def fleet_world(walls, *robots, **fields):
    """Return a world with the given robots."""
    return World(walls, robots=robots, **fields)


def passage():
    """Return a passage too narrow for two robots, which start at its ends and want to swap."""
    walls = np.ones((4, 30), bool)
    walls[1:3, 1:-1] = False
    return fleet_world(
        walls,
        Robot(Pose(0.3, 0.2, EAST), Target(2.7, 0.2, 0.05)),
        Robot(Pose(2.7, 0.2, WEST), Target(0.3, 0.2, 0.05)),
    )


class Ahead:
    """Turns to its target and drives straight there."""

    def reset(self):
        return ()

    def act(self, seen, memory):
        turn = math.remainder(seen.target_heading - seen.heading, math.tau)
        return Command(seen.top_speed, turn / seen.time_step), memory


class Counting(Ahead):
    """Does the same, with a counter in its memory that only grows, as priorities do."""

    def reset(self):
        return (0.0,)

    def act(self, seen, memory):
        return super().act(seen, ())[0], (memory[0] + 1.0,)


def crowd(rng, most=8):
    """Return a small hall with some cells filled and up to ``most`` robots of several sizes and
    speeds.
    """
    width, height = rng.integers(10, 18, 2)
    walls = hall(width, height) | (rng.random((height, width)) < 0.06)
    rows, columns = np.nonzero(walls)
    robots = []
    for _ in range(200):
        if len(robots) == rng.integers(2, most + 1):
            break
        radius = float(rng.choice([0.05, 0.07, 0.12]))
        x, y = rng.uniform(0.15, [width * 0.1 - 0.15, height * 0.1 - 0.15]).round(3).tolist()
        wide = np.maximum(np.maximum(columns * 0.1 - x, x - columns * 0.1 - 0.1), 0.0)
        high = np.maximum(np.maximum(rows * 0.1 - y, y - rows * 0.1 - 0.1), 0.0)
        free = all(
            math.hypot(x - one.start.x, y - one.start.y) > radius + one.radius for one in robots
        )
        if free and np.hypot(wide, high).min() > radius + 0.001:
            start = Pose(x, y, float(rng.uniform(-3.0, 3.0)))
            speed = float(rng.choice([0.5, 2.0, 7.0]))
            target = Target(*rng.uniform(0.15, [width * 0.1 - 0.15, 0.3]).round(3).tolist(), 0.3)
            robots.append(Robot(start, target, radius, speed))
    return fleet_world(walls, *robots)


def at_times(times, values, wanted):
    """Return a piecewise linear quantity just before and just after some times.

    They differ if a robot steps aside in no time, so that a time occurs twice.

    Args:
        times: (n,) in ascending order.
        values: (n, 2) at these times.
        wanted: (m,) times.
    """
    sides = []
    for side in ("left", "right"):
        found = np.stack([np.interp(wanted, times, values[:, k]) for k in (0, 1)], axis=1)
        index = np.searchsorted(times, wanted, side=side) - (side == "right")
        exact = (index < len(times)) & (times[np.clip(index, 0, len(times) - 1)] == wanted)
        found[exact] = values[index[exact]]
        sides.append(found)
    return sides


def nearest_to_origin(begin, end):
    """Return how near the segments from ``begin`` to ``end``, (n, 2) each, come to the origin."""
    way = end - begin
    length_sq = (way * way).sum(axis=1)
    share = -(begin * way).sum(axis=1) / np.where(length_sq > 0.0, length_sq, 1.0)
    place = begin + np.clip(share, 0.0, 1.0)[:, None] * way
    return np.hypot(place[:, 0], place[:, 1])


def closest(one, other):
    """Return the least distance of two robots' centres in a run, m, from their traces."""
    times = []
    places = []
    for trace in (one, other):
        times.append(np.maximum(trace.path_step - 1 + trace.path_share, 0.0))
        places.append(np.column_stack([trace.path_x, trace.path_y]))
    both = np.union1d(*times)
    before = at_times(times[0], places[0], both)[0] - at_times(times[1], places[1], both)[0]
    after = at_times(times[0], places[0], both)[1] - at_times(times[1], places[1], both)[1]
    between = nearest_to_origin(after[:-1], before[1:])
    return float(min(between.min(initial=np.inf), nearest_to_origin(before, after).min()))
