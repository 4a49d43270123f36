"""Straight pieces of a path against solid cells, in numbers that a machine holds; what is doubtful is asked for.

All lengths are whole lu. Whether a piece meets a box, and every distance between boxes, is exact in 64 bits. The
distance of a slanted piece from a corner is ``side / length``, both whole; only its comparison with the radius is one
of floats, which are right to 1e-15. Where the two are within 1e-13 of each other the answer is "ask", and the caller
compares fractions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from worldgen.jit import lazy_kernel

__all__ = [
    "CLEAR",
    "MEETS",
    "UNSURE",
    "shorten_pieces",
    "shorten_pieces_compiled",
    "sweep_least",
    "sweep_least_compiled",
]

CLEAR, MEETS, UNSURE = 0, 1, 2


def scan_piece(
    px: Any, py: Any, qx: Any, qy: Any, solid: Any, reach: Any, radius_sq: Any, limit: Any, stop: Any
) -> Any:
    """Distances from piece pq to the solid cells within ``reach`` lu of it.

    Args:
        px: The piece begins here.
        py: Likewise.
        qx: It ends here.
        qy: Likewise.
        solid: (height + 2, width + 2) uint8, 1 is solid; the outermost cells lie outside the grid.
        reach: No nearer cell is left out.
        radius_sq: Square of the distance asked about.
        limit: The same for whole numbers: squares below it are nearer.
        stop: Whether the first cell that is nearer ends the scan.

    Returns:
        Least whole square found, at most ``limit``; then ``side`` and squared length, of the corner nearest to the line
        beside it, if that is nearer than that or in doubt, else 0 and 0; then whether a slanted piece is surely nearer.
    """
    if py > qy:
        px, py, qx, qy = qx, qy, px, py
    ex, ey = qx - px, qy - py
    slanted = ex != 0 and ey != 0
    length_sq = ex * ex + ey * ey
    least, nearest_side, nearer = limit, np.int64(-1), False
    last = min(solid.shape[0] - 2, ((qy + reach) >> 10) + 1)
    for iy in range(max(-1, ((py - reach) >> 10) - 1), last + 1):
        low, high = min(px, qx), max(px, qx)
        if ey > 0:
            below = min(max(iy * 1024 - reach - py, 0), ey)
            above = min(max((iy + 1) * 1024 + reach - py, 0), ey)
            one, two = px + ex * below // ey, px + ex * above // ey
            low, high = min(one, two), max(one, two)
        y0 = iy * 1024
        end = min(solid.shape[1] - 2, ((high + 1 + reach) >> 10) + 1)
        for ix in range(max(-1, ((low - 1 - reach) >> 10) - 1), end + 1):
            if solid[iy + 1, ix + 1] == 0:
                continue
            x0 = ix * 1024
            if not slanted:
                dx, dy = max(x0 - max(px, qx), min(px, qx) - x0 - 1024, 0), max(y0 - qy, py - y0 - 1024, 0)
                least = min(least, dx * dx + dy * dy)
            else:
                dx, dy = max(x0 - px, 0, px - x0 - 1024), max(y0 - py, 0, py - y0 - 1024)
                least = min(least, dx * dx + dy * dy)
                dx, dy = max(x0 - qx, 0, qx - x0 - 1024), max(y0 - qy, 0, qy - y0 - 1024)
                least = min(least, dx * dx + dy * dy)
                below_one, beyond_one, zero = False, False, False
                for corner in range(4):
                    ux, uy = x0 + 1024 * (corner & 1) - px, y0 + 1024 * (corner >> 1) - py
                    side = ex * uy - ey * ux
                    below_one, beyond_one, zero = below_one or side < 0, beyond_one or side > 0, zero or side == 0
                    if 0 < ex * ux + ey * uy < length_sq and (nearest_side < 0 or abs(side) < nearest_side):
                        nearest_side = abs(side)
                level = max(px, qx) >= x0 and min(px, qx) <= x0 + 1024 and qy >= y0 and py <= y0 + 1024
                if level and (zero or (below_one and beyond_one)):
                    least = 0
            if stop and least < limit:
                return least, np.int64(0), np.int64(0), True
        if stop and nearest_side >= 0:
            square = float(nearest_side) * float(nearest_side)
            if square < radius_sq * float(length_sq) * (1.0 - 1e-13):
                return least, np.int64(0), np.int64(0), True
    nearer = least < limit
    if nearest_side < 0:
        return least, np.int64(0), np.int64(0), nearer
    square, bound = float(nearest_side) * float(nearest_side), min(radius_sq, float(least)) * float(length_sq)
    if square > bound * (1.0 + 1e-13):
        return least, np.int64(0), np.int64(0), nearer
    return least, nearest_side, length_sq, nearer or square < bound * (1.0 - 1e-13)


def shorten_pieces(
    x: Any, y: Any, whole: Any, solid: Any, reach: Any, radius_sq: Any, limit: Any, patience: Any, state: Any,
    kept: Any,
) -> Any:  # fmt: skip
    """Goes from corner to corner as far as the disc may sweep; stops where it has to ask.

    Args:
        x: (n,) corners of a path.
        y: (n,) likewise.
        whole: (n,) uint8, 0 where a corner is no whole point: each piece there is asked about.
        solid: As for :func:`scan_piece`.
        reach: At least the radius.
        radius_sq: Its square.
        limit: The same for whole numbers.
        patience: Corners in a row that may be out of sight.
        state: (5,) index of the corner gone from, of the farthest one seen, of the one looked at; number of corners
            kept; the answer to what was asked: CLEAR, MEETS, or UNSURE for none. First [0, 1, 2, 1, UNSURE].
        kept: (n,) gets the indices of the corners kept; the first is 0.

    Returns:
        Whether it is done; if not, the piece from ``state[0]`` to ``state[2]`` is asked about.
    """
    at, seen, far, count, answer = state[0], state[1], state[2], state[3], state[4]
    while at < len(x) - 1:
        while far < len(x) and far <= seen + patience:
            if answer == UNSURE:
                if whole[at] == 0 or whole[far] == 0:
                    answer = UNSURE
                else:
                    _, _, length_sq, nearer = scan_piece(
                        x[at], y[at], x[far], y[far], solid, reach, radius_sq, limit, True
                    )
                    answer = MEETS if nearer else (UNSURE if length_sq > 0 else CLEAR)
                if answer == UNSURE:
                    state[0], state[1], state[2], state[3] = at, seen, far, count
                    return False
            if answer == CLEAR:
                seen = far
            answer = UNSURE
            far += 1
        kept[count] = seen
        count += 1
        at, far = seen, seen + 2
        seen += 1
    state[3] = count
    return True


def sweep_least(x: Any, y: Any, solid: Any, reach: Any, best: Any, sides: Any, lengths_sq: Any) -> Any:
    """Least distance from a path to a solid cell.

    Args:
        x: (n,) corners of a path, two or more.
        y: (n,) likewise.
        solid: As for :func:`scan_piece`.
        reach: How far to look, at first.
        best: Its square.
        sides: (n - 1,) zeros; gets ``side`` of the pieces that may be the nearest by a corner beside them.
        lengths_sq: (n - 1,) zeros; gets the squared lengths of these.

    Returns:
        The least whole square, at most ``best``.
    """
    bound = float(best)
    for i in range(len(x) - 1):
        whole, side, length_sq, _ = scan_piece(x[i], y[i], x[i + 1], y[i + 1], solid, reach, bound, best, False)
        best = min(best, whole)
        bound = min(bound, float(whole))
        if length_sq > 0:
            sides[i], lengths_sq[i] = side, length_sq
            bound = min(bound, float(side) * float(side) / float(length_sq))
        reach = min(reach, np.int64(np.sqrt(bound)) + 2)
    return best


shorten_pieces_compiled = lazy_kernel(shorten_pieces, scan_piece)
sweep_least_compiled = lazy_kernel(sweep_least, scan_piece)
