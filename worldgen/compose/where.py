"""Find the place of one piece on another, by name or at random."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np

from worldgen.compose.marks import Mark
from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools, Floats, Ints

# Shares of the leftover space, in halves: (0, 0) is the lower left corner, (1, 1) the centre and
# (2, 2) the upper right corner.
NAMED = {
    "lower-left": (0, 0),
    "bottom": (1, 0),
    "lower-right": (2, 0),
    "left": (0, 1),
    "centre": (1, 1),
    "right": (2, 1),
    "upper-left": (0, 2),
    "top": (1, 2),
    "upper-right": (2, 2),
}
DRAWN = ("way", "anywhere")

# Random places to try before listing every possible one.
_BLIND = 32

Corner = tuple[int, int]


def named_corner(word: str, host: tuple[int, int], piece: tuple[int, int], margin: int) -> Corner:
    """Return the first cell of a piece at a named place of its host.

    Args:
        word: A key of ``NAMED``.
        host: Columns and rows of the host.
        piece: Columns and rows of the piece.
        margin: Cells to keep between the piece and the host's sides.
    """
    corner = []
    for half, of_host, of_piece in zip(NAMED[word], host, piece, strict=True):
        low = margin
        high = of_host - of_piece - margin
        corner.append((low, (of_host - of_piece) // 2, high)[half])
    return corner[0], corner[1]


def draw_corner(
    rng: RandomStream,
    host: tuple[int, int],
    piece: tuple[int, int],
    margin: int,
    keep_free: Sequence[tuple[Mark, Fraction]],
    way: Floats | None = None,
) -> Corner:
    """Draw the first cell of a piece so that it is inside the host and avoids some discs.

    Args:
        rng: The only source of randomness.
        host: Columns and rows of the host.
        piece: Columns and rows of the piece.
        margin: Minimum number of cells between the piece and the host's sides.
        keep_free: Discs that the piece must not touch, usually around start and target: centres,
            and radii in cells.
        way: (n, 2) points, in cells, of a path to centre the piece on, as closely as the sides
            allow; if omitted, the piece may go anywhere.

    Raises:
        InvalidParameter: If there is no such place.
    """
    most = [of_host - of_piece - margin for of_host, of_piece in zip(host, piece, strict=True)]

    def clear(corners: Ints) -> Ints:
        for mark, radius in keep_free:
            corners = corners[~_touches(corners, piece, mark, radius)]
        return corners

    corners = np.zeros((0, 2), np.int64)
    if min(most) >= margin and way is not None:
        # Near a side the piece cannot be centred, but the path still crosses it.
        along = _along(way, piece).clip(margin, most)
        corners = clear(np.array(list(dict.fromkeys(map(tuple, along.tolist()))), np.int64))
    elif min(most) >= margin:
        # Nearly every place is suitable, and a large host has millions of them: draw a few blindly
        # before listing all.
        for _ in range(_BLIND):
            corner = clear(np.array([[rng.between(margin, last) for last in most]]))
            if len(corner):
                return int(corner[0, 0]), int(corner[0, 1])
        columns, rows = (np.arange(margin, last + 1) for last in most)
        corners = clear(np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2))
    if not len(corners):
        where = "on the path from start to target" if way is not None else "anywhere"
        raise InvalidParameter(
            "no-room",
            "a piece of {width} x {height} cells fits nowhere {where} in {host_width} x "
            "{host_height} cells without covering start or target, with a margin of "
            "{margin}",
            "use a smaller piece or margin, or a larger host",
            width=piece[0],
            height=piece[1],
            where=where,
            host_width=host[0],
            host_height=host[1],
            margin=margin,
        )
    drawn = corners[rng.below(len(corners))]
    return int(drawn[0]), int(drawn[1])


def _along(way: Floats, piece: tuple[int, int]) -> Ints:
    """Return the first cells that centre a piece on a path, in the path's order."""
    found: list[Floats] = []
    for begin, end in pairwise(way):
        # Two samples per cell, so that no cell along the path is skipped.
        steps = max(1, int(np.ceil(2 * np.abs(end - begin).max())))
        for k in range(steps + 1):
            middle = begin + (end - begin) * (k / steps)
            found.append(np.floor(middle - np.array(piece) / 2 + 0.5))
    return np.array(found).astype(np.int64).reshape(-1, 2)


def _touches(corners: Ints, piece: tuple[int, int], mark: Mark, radius: Fraction) -> Bools:
    """Return for each corner whether the piece's box is nearer to the mark than the radius."""
    apart = []
    for axis, at in enumerate((mark.x, mark.y)):
        low = corners[:, axis]
        apart.append(np.maximum(np.maximum(low - float(at), float(at) - low - piece[axis]), 0.0))
    return np.asarray(apart[0] ** 2 + apart[1] ** 2 < float(radius) ** 2 + 1e-9)
