"""Small worlds for controllers: a hall with a border of walls, and obstacles in it."""

import numpy as np

from worldgen import Pose, Target, World


def hall(*blocks, side=30, start=(0.5, 0.5, 0.0), target=(2.5, 2.5), speed=2.0):
    """A square hall of 0.1 m cells.

    Each block is (first column, first row, columns, rows) of walls.
    """
    walls = np.zeros((side, side), bool)
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    for ix, iy, width, height in blocks:
        walls[iy : iy + height, ix : ix + width] = True
    return World(walls, Pose(*start), Target(*target, 0.05), robot_speed=speed)


def cup(depth=8):
    """A cup that is open to the left, with the robot inside and the target behind its bottom."""
    blocks = [(20, 8, 1, 14), (20 - depth, 8, depth, 1), (20 - depth, 21, depth, 1)]
    return hall(*blocks, start=(1.05, 1.55, 0.0), target=(2.55, 1.45))
