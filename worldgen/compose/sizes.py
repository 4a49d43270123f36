"""Limits on the size of pieces, and the checks that enforce them."""

from __future__ import annotations

import numpy as np

from worldgen.domain import MAX_SIDE
from worldgen.errors import InvalidParameter

# Limit per piece, 4000 x 4000 cells: each of its index arrays then takes 128 MB.
MAX_CELLS = 16_000_000


def whole(name: str, value: object, low: int, high: int) -> int:
    """Check that a value is a whole number in a range, and return it as an int.

    Raises:
        InvalidParameter: If it is not a whole number, or out of range.
    """
    if (
        isinstance(value, bool)
        or not isinstance(value, int | np.integer)
        or not low <= value <= high
    ):
        raise InvalidParameter(
            "not-a-number",
            "{name}={value!r} is not a whole number from {low} to {high}",
            "use one",
            name=name,
            value=value,
            low=low,
            high=high,
        )
    return int(value)


def check_size(what: str, width: int, height: int) -> None:
    """Reject a size that a piece cannot have.

    Raises:
        InvalidParameter: If a side is 0 or too long, or there are too many cells.
    """
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE and width * height <= MAX_CELLS):
        raise InvalidParameter(
            "too-large",
            "{what} gives {width} x {height} cells; a piece has sides of 1 to {max_side} and at "
            "most {max_cells} cells",
            "take a smaller one",
            what=what,
            width=width,
            height=height,
            max_side=MAX_SIDE,
            max_cells=MAX_CELLS,
        )
