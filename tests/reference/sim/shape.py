"""A robot's shape against cells: a disc's squared clear distance, or the corners of a placed body."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from tests.reference.sim import geometry, polygon

Cells = npt.NDArray[np.uint8]
Shape: TypeAlias = int | polygon.Corners


def pose_is_clear(cells: Cells, state: int, shape: Shape, reach: int, x: int, y: int) -> bool:
    """Whether the robot at (x, y) is clear of every cell in ``state``."""
    if isinstance(shape, tuple):
        return not polygon.first_not_clear(cells, state, shape, (x, y, x, y))[0]
    return geometry.pose_is_clear(cells, state, shape, reach, x, y)


def segment_first_not_clear(
    cells: Cells, state: int, shape: Shape, reach: int, ends: tuple[int, int, int, int]
) -> tuple[bool, int, int]:
    """The first cell in ``state``, in order of rows, that the robot cuts on its way from p to q."""
    if isinstance(shape, tuple):
        return polygon.first_not_clear(cells, state, shape, ends)
    return geometry.segment_first_not_clear(cells, state, shape, reach, ends)


def segment_box_depth(shape: Shape, ends: tuple[int, int, int, int], ix: int, iy: int) -> float:
    """How deep the robot cuts a cell on its way from p to q, lattice units."""
    if isinstance(shape, tuple):
        return polygon.depth(shape, ends, ix, iy)
    return geometry.segment_box_depth(math.sqrt(float(shape)), *ends, ix, iy)
