"""Reverse rows: arrays go up from y = 0, text and images go down. No other module does this."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

T = TypeVar("T", bound=np.generic)


def flip_rows(array: npt.NDArray[T]) -> npt.NDArray[T]:
    """Turn lowest-row-first into top-row-first, and back; it is its own inverse.

    Args:
        array: (height, ...) cells, pixels or rows of anything.

    Returns:
        A view of the same values with the first axis reversed.
    """
    return array[::-1]
