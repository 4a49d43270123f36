"""Random spanning trees of a rectangle of rooms: Wilson's algorithm and the recursive backtracker.

Both walk with two random bits a step and have no recursion. Each is one function over indexable
buffers: small trees run it as plain Python on bytearrays, large ones compiled on arrays over the same
memory. It sees only small integers, so both give the same bytes. When its draws run out, it keeps its
place in ``state`` and is called again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.jit import lazy_kernel
from worldgen.random_streams import RandomStream

__all__ = ["ROOT", "Algorithm", "open_sides", "spanning_tree", "tree_from"]

Algorithm: TypeAlias = Literal["wilson", "backtracker"]
Walk: TypeAlias = Callable[[Any, Any, Any, Any, int, int], None]

ROOT = 4  # in a tree: the room that leads nowhere; below it, the direction to the parent in quarter turns

# Rooms from which compiling pays: loading numba and a compiled walk took 0.38 s; plain Python took 0.08 s
# (backtracker) and 0.06 to 0.23 s (wilson) for 90,000 rooms, compiled code 0.004 s and 0.01 s.
COMPILE_FROM = 100_000


def wilson_walk(draws: Any, towards: Any, joined: Any, state: Any, columns: int, rows: int) -> None:
    """Grows a uniform spanning tree by loop-erased random walks until it is whole or the draws run out.

    Args:
        draws: (n,) numbers 0 to 3, each a random direction.
        towards: (rows * columns,) the last exit taken from each room; in the tree, the way to the root.
        joined: (rows * columns,) 1 where a room is in the tree.
        state: Where the walk began, where it stands; the first is rows * columns when all is done.
        columns: Rooms in x.
        rows: Rooms in y.

    Source: David B. Wilson, "Generating random spanning trees more quickly than the cover time", STOC 1996.
    """
    begin, at = state[0], state[1]
    rooms = rows * columns
    used, count = 0, len(draws)
    while begin < rooms:
        while joined[at] == 0:
            if used == count:
                state[0], state[1] = begin, at
                return
            direction = draws[used]
            used += 1
            column = at % columns
            step = 0
            if direction == 0 and column + 1 < columns:
                step = 1
            elif direction == 1 and at + columns < rooms:
                step = columns
            elif direction == 2 and column > 0:
                step = -1
            elif direction == 3 and at >= columns:
                step = -columns
            if step != 0:  # a draw that points out of the rectangle is drawn again: the choice stays uniform
                towards[at] = direction
                at += step
        at = begin
        while joined[at] == 0:
            joined[at] = 1
            direction = towards[at]
            if direction == 0:
                at += 1
            elif direction == 1:
                at += columns
            elif direction == 2:
                at -= 1
            else:
                at -= columns
        begin += 1
        at = begin
    state[0], state[1] = begin, at


def backtracker_walk(draws: Any, towards: Any, joined: Any, state: Any, columns: int, rows: int) -> None:
    """Digs to random new neighbours and goes back along its own way where there is none.

    Args and behaviour as :func:`wilson_walk`; ``state`` holds where the digger stands and the rooms left.
    The way back is in ``towards``, so no stack is needed.
    """
    at, left = state[0], state[1]
    rooms = rows * columns
    used, count = 0, len(draws)
    while left > 0:
        column = at % columns
        east = column + 1 < columns and joined[at + 1] == 0
        north = at + columns < rooms and joined[at + columns] == 0
        west = column > 0 and joined[at - 1] == 0
        south = at >= columns and joined[at - columns] == 0
        if east or north or west or south:
            if used == count:
                break
            direction = draws[used]
            used += 1
            if direction == 0 and east:
                at += 1
            elif direction == 1 and north:
                at += columns
            elif direction == 2 and west:
                at -= 1
            elif direction == 3 and south:
                at -= columns
            else:
                continue
            joined[at] = 1
            towards[at] = (direction + 2) % 4
            left -= 1
        else:
            direction = towards[at]
            if direction == 0:
                at += 1
            elif direction == 1:
                at += columns
            elif direction == 2:
                at -= 1
            else:
                at -= columns
    state[0], state[1] = at, left


_COMPILED: dict[str, Walk] = {
    "wilson": lazy_kernel(wilson_walk),
    "backtracker": lazy_kernel(backtracker_walk),
}
_PLAIN: dict[str, Walk] = {"wilson": wilson_walk, "backtracker": backtracker_walk}


def spanning_tree(rng: RandomStream, columns: int, rows: int, algorithm: Algorithm) -> npt.NDArray[np.uint8]:
    """A random spanning tree of a rectangle of rooms.

    Args:
        rng: The only source of chance.
        columns: Rooms in x.
        rows: Rooms in y.
        algorithm: ``wilson``: every tree equally likely. ``backtracker``: long winding ways.

    Returns:
        (rows, columns) uint8: from each room, the direction of its parent in quarter turns, or ``ROOT``.
    """
    return tree_from(rng, columns, rows, algorithm, compiled=columns * rows >= COMPILE_FROM)


def tree_from(
    rng: RandomStream, columns: int, rows: int, algorithm: Algorithm, *, compiled: bool
) -> npt.NDArray[np.uint8]:
    """As :func:`spanning_tree`, compiled or not: the tree is the same."""
    rooms = rows * columns
    root = rng.below(rooms)
    towards, joined = bytearray(rooms), bytearray(rooms)
    joined[root] = 1
    backtracking = algorithm == "backtracker"
    state = [root, rooms - 1] if backtracking else [0, 0]
    done = (1, 0) if backtracking else (0, rooms)  # which of the state's numbers ends at what
    words = max(16, rooms // 8)  # 32 draws a word; both algorithms take a few draws a room
    if compiled:
        views = (np.frombuffer(towards, np.uint8), np.frombuffer(joined, np.uint8))
        counters = np.array(state, dtype=np.int64)
        while counters[done[0]] != done[1]:
            _COMPILED[algorithm](_directions(rng, words), *views, counters, columns, rows)
    else:
        while state[done[0]] != done[1]:
            _PLAIN[algorithm](_directions(rng, words).tobytes(), towards, joined, state, columns, rows)
    towards[root] = ROOT
    return np.frombuffer(towards, np.uint8).reshape(rows, columns)


def _directions(rng: RandomStream, words: int) -> npt.NDArray[np.uint8]:
    """32 numbers from 0 to 3 of each 64 bits, lowest bits first."""
    packed = rng.bits(words).astype("<u8").view(np.uint8)
    return ((packed[:, np.newaxis] >> np.array([0, 2, 4, 6], np.uint8)) & np.uint8(3)).ravel()


def open_sides(tree: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    """Which neighbours a tree joins: (rows, columns, 4) bool, the last axis in quarter turns."""
    joined = np.zeros((*tree.shape, 4), dtype=np.bool_)
    joined[:, :-1, 0] = joined[:, 1:, 2] = (tree[:, :-1] == 0) | (tree[:, 1:] == 2)
    joined[:-1, :, 1] = joined[1:, :, 3] = (tree[:-1, :] == 1) | (tree[1:, :] == 3)
    return joined
