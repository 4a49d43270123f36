"""The board that every maze grows on, and the state that a kernel keeps between two calls."""

import numpy as np

# A growing board: 0 to 3, the direction to the parent, in the maze; FREE and more, not yet in it.
ROOT = 4  # in the maze, and leads nowhere
OUTSIDE = 5  # no chamber
FREE = 8  # Wilson's walk adds the direction that it left by

# links
EAST = 1
NORTH = 2

# state: the state that a kernel keeps between two calls. From AT on, each kernel uses it in its own
# way.
LEFT = 0  # chambers still to be joined; 0: done
USED = 1  # number of draws, or words, used so far
AT = 2  # its place on the board
STATE_SIZE = 8


def blank_board(mask):
    """Return a board with every chamber free, flat, and its stride."""
    rows, columns = mask.shape
    board = np.full((rows + 2, columns + 2), OUTSIDE, dtype=np.int8)
    board[1:-1, 1:-1][mask] = FREE
    return board.ravel(), columns + 2


def inner(board, stride):
    """Return the chambers of a flat board, without the ring."""
    return np.frombuffer(board, np.int8).reshape(-1, stride)[1:-1, 1:-1]
