"""Where a robot can be at most, and when: the proof that it is nowhere near the target in time."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

__all__ = ["NEVER_ENDS", "Confinement"]

NEVER_ENDS = 2**60
"""The last slab of a stay that does not end."""


@dataclass(frozen=True, eq=False)
class Confinement:
    """Stays that hold every robot, none of them in the target.

    It cannot be reached, or not by a deadline. Space is cut into square tiles, time into slabs in
    which no robot gets farther than one tile's side. A stay says that a robot may be in a tile from
    one slab to another. The stays are closed: who is in a stay in one slab is, in the next, in a
    stay of that tile or of one of its eight neighbours, or where the disc cannot be, or too far off
    to arrive in time. So each robot that begins at the start, and may arrive in time, is always in
    some stay.

    Args:
        k: Tiles per cell side.
        slab: Length of a slab, s.
        deadline: s; None if the target is never reached.
        stays: (n, 4) int64, rows (column of the tile, its row, first slab, last slab).
    """

    k: int
    slab: Fraction
    deadline: float | None
    stays: npt.NDArray[np.int64]
