"""Worlds of robots with footprints, for tests."""

import math

import numpy as np

from worldgen.robot import Pose, Robot, Target
from worldgen.world import World


def rectangle(length, width, ahead=0.0):
    """The corners of a rectangle, m; the axle is ``ahead`` behind its middle."""
    a, b = length / 2, width / 2
    return ((-a + ahead, -b), (a + ahead, -b), (a + ahead, b), (-a + ahead, b))


def body_world(free, start, target, footprint, **goal):
    """A world of 0.1 m cells; ``free`` lists (left, low, right, high) in m, the rest is solid."""
    width, height = (math.ceil(max(box[k] for box in free) / 0.1 - 1e-9) + 2 for k in (2, 3))
    walls = np.ones((height, width), np.bool_)
    for box in free:
        left, low, right, high = (round(value / 0.1) for value in box)
        walls[low:high, left:right] = False
    robot = Robot(Pose(*start), Target(*target, **goal), footprint=footprint)
    return World(walls, robots=[robot])


def bend(footprint, gap=1.0):
    """Two aisles of equal width at a right angle, as in the case of a warehouse robot."""
    reach = max(math.hypot(x, y) for x, y in footprint)
    far = round(3.0 + 2 * reach + gap, 1)
    free = [(0.5, 0.5, far, 0.5 + gap), (round(far - gap, 1), 0.5, far, far)]
    start = (round(0.6 + reach, 2), 0.5 + gap / 2, 0.0)
    return body_world(free, start, (far - gap / 2, round(far - reach - 0.3, 2), 0.2), footprint)


def longest_in_bend(width, gap=1.0):
    """The length of the longest rectangle that gets around the bend, m.

    At 45 degrees its inner side touches the corner, and its outer corners both outer walls: half the
    length plus the width is the corner's distance along the diagonal.
    """
    return 2 * (math.sqrt(2) * gap - width)


def aisle(footprint, width=1.0):
    """Two rooms and a straight aisle between them."""
    middle = 2.0
    free = [
        (0.2, 0.2, 2.6, 3.8),
        (5.4, 0.2, 7.8, 3.8),
        (2.0, middle - width / 2, 6.0, middle + width / 2),
    ]
    return body_world(free, (1.4, middle, 0.0), (6.6, middle, 0.2), footprint)
