"""Let the C core grow a maze, and convert it to cells.

It gets a board and random words, and returns links.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.families.parts.mazes.board import Links, links_of_parents
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools, Ints, Words
from worldgen.support.ccall import check, pointer, writable

Algorithm: TypeAlias = Literal[
    "wilson", "aldous-broder", "backtracker", "hunt-and-kill", "kruskal", "prim", "growing-tree",
    "eller", "sidewinder", "binary-tree", "recursive-division",
]  # fmt: skip
# Computes a number of words from the columns and rows.
Size: TypeAlias = Callable[[int, int], int]

# Limit on the random words per call of the core. This many stay in the cache, and a call takes some
# hundredths of a second. The number must not change: a corridor continues to draw from the stream
# after a tree of up to 999 x 999 chambers, at the end of the last call's words.
MOST_WORDS = 1 << 17
# The number that represents all picks of a growing tree; shares are multiples of 1 / this.
SHARE = 1 << 16


def _few_words(columns: int, rows: int) -> int:
    return min(max(16, columns * rows // 8), MOST_WORDS)


def _places(columns: int, rows: int) -> int:
    return (columns + 2) * (rows + 2)


@dataclass(frozen=True)
class Method:
    """Describe how to run an algorithm.

    Args:
        code: Number of the algorithm in the core.
        words: Computes the number of random words for a call.
        draws_on: True if each call needs new words; other algorithms need all their words, the same
            ones, in every call.
        parents: True if the board ends up with parents instead of links.
        any_shape: True if chambers may be missing.
    """

    code: int
    words: Size = _few_words
    draws_on: bool = True
    parents: bool = True
    any_shape: bool = True


_lib = _core.lib
METHODS: dict[str, Method] = {
    "wilson": Method(_lib.WG_WILSON),
    "aldous-broder": Method(_lib.WG_ALDOUS_BRODER),
    "backtracker": Method(_lib.WG_BACKTRACKER),
    "hunt-and-kill": Method(_lib.WG_HUNT_AND_KILL),
    "kruskal": Method(_lib.WG_KRUSKAL, _places, draws_on=False, parents=False),
    "prim": Method(_lib.WG_PRIM, _places, draws_on=False),
    "growing-tree": Method(_lib.WG_GROWING_TREE),
    "eller": Method(
        _lib.WG_ELLER,
        words=lambda columns, rows: rows * ((columns + 31) >> 5),
        parents=False,
        any_shape=False,
    ),
    "sidewinder": Method(_lib.WG_SIDEWINDER, parents=False, any_shape=False),
    "binary-tree": Method(
        _lib.WG_BINARY_TREE,
        words=lambda columns, rows: rows * ((columns + 63) >> 6),
        parents=False,
        any_shape=False,
    ),
    "recursive-division": Method(_lib.WG_RECURSIVE_DIVISION, parents=False, any_shape=False),
}

FIT_ANY_SHAPE = tuple(name for name, method in METHODS.items() if method.any_shape)
# The first two algorithms draw from the caller's stream, and each later one from a child stream.
_DRAW_FROM_THE_STREAM_ITSELF = ("wilson", "backtracker")


def grow(
    rng: RandomStream, mask: Bools, algorithm: str, *, newest: float = 0.5, oldest: float = 0.0
) -> Links:
    """Return a random maze without loops in a connected shape.

    Args:
        rng: The only source of randomness.
        mask: (rows, columns) bool, True where there is a chamber.
        algorithm: One of ``METHODS``; those outside ``FIT_ANY_SHAPE`` need a full rectangle.
        newest: Share of a growing tree's picks that take the newest chamber.
        oldest: Share of its picks that take the oldest chamber; the rest take any.

    Returns:
        (rows, columns) links, without ROCK.
    """
    chambers = _grown(rng, mask, algorithm, newest, oldest)
    return links_of_parents(chambers) if METHODS[algorithm].parents else chambers.copy()


def winding_tree(rng: RandomStream, columns: int, rows: int) -> npt.NDArray[np.int8]:
    """Return a random spanning tree of a rectangle of chambers, with long winding passages.

    Args:
        rng: The only source of randomness; the tree draws directly from it.
        columns: Chambers in x.
        rows: Chambers in y.

    Returns:
        (rows, columns): from each chamber, the direction of its parent in quarter turns, or
            ``ROOT``.
    """
    return _grown(rng, np.ones((rows, columns), np.bool_), "backtracker", 0.0, 0.0)


def pitch(widths: list[int], wall: int) -> Ints:
    """Return the width of each strip of a plan, in cells.

    The strips are border, chamber, wall, chamber, ..., chamber, border.
    """
    strips = np.full(2 * len(widths) + 1, wall, dtype=np.int64)
    strips[1::2] = widths
    strips[0] = strips[-1] = 1
    return strips


def cells_of(links: Links, across: Ints, up: Ints) -> Bools:
    """Return chambers, walls and border as cells, True is solid.

    Args:
        links: (rows, columns) links.
        across: (2 columns + 1,) widths of the strips in x, cells, from :func:`pitch`.
        up: (2 rows + 1,) heights of the strips in y, cells, from :func:`pitch`.
    """
    ffi = _core.ffi
    lib = _core.lib
    rows, columns = links.shape
    walls = np.empty((int(up.sum()), int(across.sum())), dtype=np.bool_)
    strips = (pointer(ffi, across, np.int64), pointer(ffi, up, np.int64))
    chambers = pointer(ffi, np.ascontiguousarray(links), np.int8)
    check(
        lib.wg_maze_cells(
            chambers, rows, columns, *strips, writable(ffi, walls, np.bool_), walls.size
        )
    )
    return walls


def _grown(
    rng: RandomStream, mask: Bools, algorithm: str, newest: float, oldest: float
) -> npt.NDArray[np.int8]:
    """Run an algorithm to its end, and return the board's chambers as a (rows, columns) view."""
    method = METHODS[algorithm]
    rows, columns = mask.shape
    stream = rng if algorithm in _DRAW_FROM_THE_STREAM_ITSELF else rng.child(algorithm)

    # Set up the maze, its board and its work space.
    ffi = _core.ffi
    lib = _core.lib
    maze = ffi.new("WgMaze *")
    maze.algorithm = method.code
    maze.columns = columns
    maze.rows = rows
    maze.newest = round(newest * SHARE)
    maze.oldest = round(oldest * SHARE)
    board = np.empty((rows + 2, columns + 2), np.int8)
    work = np.empty(max(lib.wg_maze_work_bytes(maze), 1), np.uint8)
    buffers = (writable(ffi, board, np.int8), board.size, writable(ffi, work, np.uint8), work.size)
    chambers = pointer(ffi, np.ascontiguousarray(mask), np.bool_)
    check(lib.wg_maze_begin(maze, chambers, stream.below(int(np.count_nonzero(mask))), *buffers))

    # Supply random words until every chamber is joined; a call returns when its words run out.
    words = None
    while maze.left > 0:
        if words is None or method.draws_on:
            words = stream.bits(method.words(columns, rows))
            if algorithm == "kruskal":
                words = _edge_keys(maze, words, board)
        check(lib.wg_maze_grow(maze, pointer(ffi, words, np.uint64), len(words), *buffers))
    return board[1:-1, 1:-1]


def _edge_keys(maze: Any, words: Words, board: npt.NDArray[np.int8]) -> Words:
    """Return the keys of all edges between chambers, in ascending order of their random weights."""
    ffi = _core.ffi
    lib = _core.lib
    keys = np.empty(2 * board.size, np.int64)
    count = ffi.new("int64_t *")
    inputs = (pointer(ffi, words, np.uint64), pointer(ffi, board, np.int8), board.size)
    check(lib.wg_maze_edge_keys(maze, *inputs, writable(ffi, keys, np.int64), count))
    found = keys[: count[0]]
    found.sort()
    return found.view(np.uint64)
