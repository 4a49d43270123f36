"""Masks over a maze's chambers, by name of their shape."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.support.arrays import Bools

Shape: TypeAlias = Literal["square", "disc", "ring", "cross", "diamond"]

# Minimum chambers per side for each shape. From this size on, the shape is recognisable and
# connected, and no single chamber sticks out.
LEAST = {"square": 2, "disc": 4, "ring": 6, "cross": 6, "diamond": 4}


def shape_mask(shape: str, side: int) -> Bools:
    """Return where a maze of a shape has chambers: (side, side) bool.

    Raises:
        InvalidParameter: If ``side`` is below the shape's ``LEAST``.
    """
    if side < LEAST[shape]:
        raise InvalidParameter(
            "no-room",
            "mask={shape} needs {least} x {least} chambers, but there are {side} x {side}",
            "use a larger size, or narrower passages and walls",
            shape=shape,
            least=LEAST[shape],
            side=side,
        )
    # Use twice the distance from the middle, which is a whole number for odd and even sides.
    doubled = np.abs(2 * np.arange(side, dtype=np.int64) - (side - 1))
    across = doubled[np.newaxis, :]
    up = doubled[:, np.newaxis]
    from_middle_sq = across**2 + up**2
    mask: Bools = np.ones((side, side), dtype=np.bool_)
    if shape in ("disc", "ring"):
        mask &= from_middle_sq <= side**2
    if shape == "ring":
        mask &= 9 * from_middle_sq > side**2
    elif shape == "cross":
        mask &= 3 * np.minimum(across, up) <= side
    elif shape == "diamond":
        mask &= across + up <= side + 1
    return mask
