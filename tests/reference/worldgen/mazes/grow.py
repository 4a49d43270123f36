"""Grow a maze in plain Python.

Does the same as worldgen/core/making in C, on lists and with the same random words.
"""

import numpy as np

from tests.reference.worldgen.mazes import edges, row_by_row, walks
from tests.reference.worldgen.mazes.board import (
    AT,
    LEFT,
    ROOT,
    STATE_SIZE,
    USED,
    blank_board,
    inner,
)
from worldgen.families.parts.mazes import METHODS
from worldgen.families.parts.mazes.board import links_of_parents

KERNELS = {
    "wilson": walks.wilson,
    "aldous-broder": walks.aldous_broder,
    "backtracker": walks.backtracker,
    "hunt-and-kill": walks.hunt_and_kill,
    "kruskal": edges.kruskal,
    "prim": edges.prim,
    "growing-tree": edges.growing_tree,
    "eller": row_by_row.eller,
    "sidewinder": row_by_row.sidewinder,
    "binary-tree": row_by_row.binary_tree,
    "recursive-division": row_by_row.recursive_division,
}


def grow(rng, mask, algorithm, *, newest=0.5, oldest=0.0):
    """Return the links of a random maze, like :func:`worldgen.families.parts.mazes.grow`."""
    method = METHODS[algorithm]
    rows, columns = mask.shape
    stream = rng if algorithm in ("wilson", "backtracker") else rng.child(algorithm)
    board, stride = (
        blank_board(mask)
        if method.any_shape
        else (np.zeros((rows + 2) * (columns + 2), np.int8), columns + 2)
    )
    board = bytearray(board)
    state = [0] * STATE_SIZE
    scratch = [0] * (2 * len(board))
    _begin(algorithm, board, stride, state, scratch, _place(mask, stream.below(int(mask.sum()))))
    state[LEFT] = int(mask.sum()) - 1
    if algorithm == "growing-tree":
        state[edges.NEWEST] = round(newest * edges.SHARE)
        state[edges.OLDEST] = round(oldest * edges.SHARE)
    while state[LEFT] > 0:
        words = stream.bits(method.words(columns, rows)).view(np.int64)
        if algorithm == "kruskal":
            words = edges.edge_keys(words, np.frombuffer(board, np.int8), stride)
        state[USED] = 0
        KERNELS[algorithm](words.tolist(), board, state, stride, scratch)
    chambers = inner(board, stride)
    return links_of_parents(chambers) if method.parents else chambers.copy()


def _begin(algorithm, board, stride, state, scratch, root):
    """Write the state that a kernel finds at its first call."""
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


def _place(mask, number):
    """Return the place on the board of a chamber, counted in rows."""
    columns = mask.shape[1]
    row, column = divmod(int(np.flatnonzero(mask)[number]), columns)
    return (row + 1) * (columns + 2) + column + 1
