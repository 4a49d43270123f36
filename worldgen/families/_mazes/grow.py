"""Grows a maze by a named algorithm: sets up its board, feeds it random words, hands back links.

Small mazes grow in plain Python on lists and bytearrays, large ones compiled on arrays. It is the same function on
the same words, and it sees only small integers, so both give the same bytes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.families._mazes import edges, row_by_row, walks
from worldgen.families._mazes.board import (
    AT,
    LEFT,
    ROOT,
    STATE_SIZE,
    USED,
    Links,
    Mask,
    blank_board,
    inner,
    links_of_parents,
)
from worldgen.jit import lazy_kernel
from worldgen.random_streams import RandomStream

__all__ = ["FIT_ANY_SHAPE", "METHODS", "Algorithm", "grow", "spanning_tree", "worth_compiling"]

Algorithm: TypeAlias = Literal[
    "wilson", "aldous-broder", "backtracker", "hunt-and-kill", "kruskal", "prim", "growing-tree",
    "eller", "sidewinder", "binary-tree", "recursive-division",
]  # fmt: skip
Kernel: TypeAlias = Callable[[Any, Any, Any, int, Any], None]
Size: TypeAlias = Callable[[int, int], int]  # of the columns and rows

# Words that a kernel gets in one call; those of a larger maze stay in the cache. A corridor draws on after a tree of
# up to 999 x 999 chambers, from where the last call's words end.
MOST_WORDS = 1 << 17

COMPILE_FROM_LOADED = 5_000  # chambers; a kernel is loaded in 5 ms where numba is loaded already


def _few_words(columns: int, rows: int) -> int:
    return min(max(16, columns * rows // 8), MOST_WORDS)


def _places(columns: int, rows: int) -> int:
    return (columns + 2) * (rows + 2)


def _room_for_cuts(columns: int, rows: int) -> int:
    """Numbers for the rectangles that wait to be cut."""
    return 4 * ((columns * rows).bit_length() + 2)


@dataclass(frozen=True)
class Method:
    """How an algorithm is run.

    Args:
        kernel: Called with fresh words until it says that nothing is left.
        words: How many words each call gets.
        scratch: How many numbers of work space.
        wide: Whether these need 64 bits.
        parents: Whether it leaves parents on the board, not links.
        any_shape: Whether chambers may be missing.
        compile_from: Chambers from which it takes longer in plain Python than loading numba, 0.4 s.
    """

    kernel: Kernel
    words: Size = _few_words
    scratch: Size = lambda columns, rows: 1
    wide: bool = False
    parents: bool = True
    any_shape: bool = True
    compile_from: int = 100_000


METHODS: dict[str, Method] = {
    "wilson": Method(walks.wilson),
    "aldous-broder": Method(walks.aldous_broder, compile_from=8_000),
    "backtracker": Method(walks.backtracker),
    "hunt-and-kill": Method(walks.hunt_and_kill),
    "kruskal": Method(edges.kruskal, _places, _places, parents=False),
    "prim": Method(edges.prim, _places, lambda columns, rows: 2 * columns * rows, wide=True, compile_from=40_000),
    "growing-tree": Method(edges.growing_tree, scratch=lambda columns, rows: columns * rows, compile_from=60_000),
    "eller": Method(
        row_by_row.eller,
        words=lambda columns, rows: rows * ((columns + 31) >> 5),
        scratch=lambda columns, rows: 2 * columns + 2,
        parents=False,
        any_shape=False,
    ),
    "sidewinder": Method(row_by_row.sidewinder, parents=False, any_shape=False),
    "binary-tree": Method(
        row_by_row.binary_tree, lambda columns, rows: rows * ((columns + 63) >> 6), parents=False, any_shape=False
    ),
    "recursive-division": Method(row_by_row.recursive_division, scratch=_room_for_cuts, parents=False, any_shape=False),
}


FIT_ANY_SHAPE = tuple(name for name, method in METHODS.items() if method.any_shape)
_COMPILED = {name: lazy_kernel(method.kernel) for name, method in METHODS.items()}
_DRAW_FROM_THE_STREAM_ITSELF = ("wilson", "backtracker")  # the first two; each later one has a stream of its own


def worth_compiling(chambers: int, compile_from: int) -> bool:
    """Whether compiled code makes a maze sooner; the maze is the same."""
    return chambers >= (min(compile_from, COMPILE_FROM_LOADED) if "numba" in sys.modules else compile_from)


def grow(
    rng: RandomStream,
    mask: Mask,
    algorithm: str,
    *,
    newest: float = 0.5,
    oldest: float = 0.0,
    compiled: bool | None = None,
) -> Links:
    """A random maze without loops in a connected shape.

    Args:
        rng: The only source of chance.
        mask: Where there are chambers.
        algorithm: One of ``METHODS``; those outside ``FIT_ANY_SHAPE`` need a full rectangle.
        newest: Share of a growing tree's picks that take the newest chamber.
        oldest: Share that take the oldest; the rest take any.
        compiled: Whether to run compiled code; ``None``: where it is worth it.

    Returns:
        (rows, columns) links, without ROCK.
    """
    board, stride = _grown(rng, mask, algorithm, newest, oldest, compiled)
    chambers = inner(board, stride)
    return links_of_parents(chambers) if METHODS[algorithm].parents else chambers.copy()


def spanning_tree(
    rng: RandomStream,
    columns: int,
    rows: int,
    algorithm: Literal["wilson", "backtracker"],
    compiled: bool | None = None,
) -> npt.NDArray[np.int8]:
    """A random spanning tree of a rectangle of chambers.

    Args:
        rng: The only source of chance; the tree's draws are its own.
        columns: Chambers in x.
        rows: Chambers in y.
        algorithm: ``wilson``: every tree equally likely. ``backtracker``: long winding ways.
        compiled: As for :func:`grow`.

    Returns:
        (rows, columns): from each chamber, the direction of its parent in quarter turns, or ``ROOT``.
    """
    return inner(*_grown(rng, np.ones((rows, columns), np.bool_), algorithm, 0.0, 0.0, compiled))


def _grown(
    rng: RandomStream, mask: Mask, algorithm: str, newest: float, oldest: float, compiled: bool | None
) -> tuple[Any, int]:
    """The board when all is done, and its stride."""
    method = METHODS[algorithm]
    rows, columns = mask.shape
    chambers = int(np.count_nonzero(mask))
    if compiled is None:
        compiled = worth_compiling(chambers, method.compile_from)
    stream = rng if algorithm in _DRAW_FROM_THE_STREAM_ITSELF else rng.child(algorithm)
    board: Any
    board, stride = blank_board(mask) if method.any_shape else (np.zeros(_places(columns, rows), np.int8), columns + 2)
    state: Any = np.zeros(STATE_SIZE, np.int64)
    scratch: Any = np.zeros(method.scratch(columns, rows), np.int64 if method.wide else np.int32)
    _begin(algorithm, board, stride, state, scratch, _place(mask, stream.below(chambers)))
    state[LEFT] = chambers - 1
    if algorithm == "growing-tree":
        state[edges.NEWEST], state[edges.OLDEST] = round(newest * edges.SHARE), round(oldest * edges.SHARE)
    if not compiled:
        board, state, scratch = bytearray(board), state.tolist(), scratch.tolist()
    run = _COMPILED[algorithm] if compiled else method.kernel
    while state[LEFT] > 0:
        words = stream.bits(method.words(columns, rows)).view(np.int64)
        if algorithm == "kruskal":
            words = edges.edge_keys(words, np.frombuffer(board, np.int8), stride)
        state[USED] = 0
        run(words if compiled else words.tolist(), board, state, stride, scratch)
    return board, stride


def _begin(algorithm: str, board: Any, stride: int, state: Any, scratch: Any, root: int) -> None:
    """Puts down what a kernel finds at its first call."""
    first = stride + 1
    if not METHODS[algorithm].parents:
        state[AT] = first
        if algorithm == "recursive-division":
            state[row_by_row.STACKED] = 1
            scratch[:3] = first, stride - 2, len(board) // stride - 2
        return
    board[root] = ROOT
    state[AT], state[walks.FIRST], state[walks.LOWEST] = root, first, root
    if algorithm == "wilson":
        state[AT] = first
    elif algorithm == "growing-tree":
        scratch[0] = root
        state[AT], state[edges.HEAD], state[edges.TAIL], state[edges.ALIVE] = 0, 0, 1, 1


def _place(mask: Mask, number: int) -> int:
    """Where a chamber, counted in rows, lies on the board."""
    columns = int(mask.shape[1])
    row, column = divmod(number if mask.all() else int(np.flatnonzero(mask)[number]), columns)
    return (row + 1) * (columns + 2) + column + 1
