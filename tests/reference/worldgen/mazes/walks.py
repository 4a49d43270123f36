"""Mazes by walking: Wilson's, Aldous and Broder's, the recursive backtracker, hunt-and-kill.

Every kernel here draws directions of two bits, the lowest bits of a word first, and stops when its
words run out; called again with the next words and the state that it left, it continues. A draw
that cannot be used is drawn again, so the choice stays uniform. All values are small integers, so
plain Python and compiled code agree.

Args of each:
    words: (n,) random 64 bits as int64.
    board: The board; in the end each chamber names its parent.
    state: LEFT, USED (draws) and AT, and any others that the kernel names.
    stride: From a chamber to the one above it.
    scratch: Not used here.
"""

from tests.reference.worldgen.mazes.board import AT, FREE, LEFT, OUTSIDE, USED

LOWEST = 4  # state of the hunt: no chamber of the maze comes before it
FIRST = 3  # state: before it, every chamber is in the maze (hunt), or every walk is done (Wilson)


def wilson(words, board, state, stride, scratch):
    """Loop-erased random walks from each chamber to the maze so far.

    Every spanning tree equally likely. ``state[FIRST]`` is where the current walk began.

    Source: David B. Wilson, "Generating random spanning trees more quickly than the cover time",
        STOC 1996.
    """
    begin, at, used, left = state[FIRST], state[AT], state[USED], state[LEFT]
    count = 32 * len(words)
    while left > 0:
        here = board[at]
        while here >= FREE:
            if used == count:
                state[FIRST], state[AT], state[USED], state[LEFT] = begin, at, used, left
                return
            direction = (words[used >> 5] >> (2 * (used & 31))) & 3
            used += 1
            beyond = at + (1 - (direction & 2)) * (stride if direction & 1 else 1)
            there = board[beyond]
            if there != OUTSIDE:
                board[at] = FREE + direction  # the last exit counts, which erases the loops
                at = beyond
                here = there
        at = begin
        while board[at] >= FREE:
            direction = board[at] & 3
            board[at] = direction
            at += (1 - (direction & 2)) * (stride if direction & 1 else 1)
            left -= 1
        begin += 1
        at = begin
    state[LEFT] = 0


def aldous_broder(words, board, state, stride, scratch):
    """One random walk; each chamber keeps the direction from which it was first entered.

    Every tree equally likely.

    Sources: David J. Aldous, "The random walk construction of uniform spanning trees and uniform
        labelled
    trees", SIAM Journal on Discrete Mathematics, 1990; Andrei Broder, "Generating random spanning
    trees", FOCS 1989.
    """
    at, used, left = state[AT], state[USED], state[LEFT]
    count = 32 * len(words)
    while left > 0 and used < count:
        direction = (words[used >> 5] >> (2 * (used & 31))) & 3
        used += 1
        beyond = at + (1 - (direction & 2)) * (stride if direction & 1 else 1)
        there = board[beyond]
        if there != OUTSIDE:
            at = beyond
            if there == FREE:
                board[at] = direction ^ 2
                left -= 1
    state[AT], state[USED], state[LEFT] = at, used, left


def backtracker(words, board, state, stride, scratch):
    """Digs to random free neighbours; if there is none, goes back along its own path.

    The way back is on the board, so there is neither recursion nor a stack.

    Source: Robert Tarjan, "Depth-first search and linear graph algorithms", SIAM Journal on
        Computing, 1972,
    with a random choice of the next edge.
    """
    at, used, left = state[AT], state[USED], state[LEFT]
    count = 32 * len(words)
    while left > 0:
        free = (
            (board[at + 1] >> 3)
            + ((board[at + stride] >> 3) << 1)
            + ((board[at - 1] >> 3) << 2)
            + ((board[at - stride] >> 3) << 3)
        )
        if free == 0:
            direction = board[at]
            at += (1 - (direction & 2)) * (stride if direction & 1 else 1)
            continue
        direction = 4  # no direction, until one is drawn
        while used < count and (free >> direction) & 1 == 0:
            direction = (words[used >> 5] >> (2 * (used & 31))) & 3
            used += 1
        if (free >> direction) & 1 == 0:
            break
        at += (1 - (direction & 2)) * (stride if direction & 1 else 1)
        board[at] = direction ^ 2
        left -= 1
    state[AT], state[USED], state[LEFT] = at, used, left


def hunt_and_kill(words, board, state, stride, scratch):
    """Digs at random until it is stuck, then hunts, row by row, for a free chamber next to the
    maze.

    ``state[FIRST]``: no free chamber comes before it. ``state[LOWEST]``: no chamber of the maze
    comes before this.

    Source: Jamis Buck, "Mazes for Programmers", 2015, chapter 5.
    """
    at, used, left, first, lowest = state[AT], state[USED], state[LEFT], state[FIRST], state[LOWEST]
    count = 32 * len(words)
    while left > 0:
        free = (
            (board[at + 1] >> 3)
            + ((board[at + stride] >> 3) << 1)
            + ((board[at - 1] >> 3) << 2)
            + ((board[at - stride] >> 3) << 3)
        )
        ways, spot, stuck = free, at, free == 0
        if stuck:
            while board[first] != FREE:
                first += 1
            spot, ways = max(first, lowest - stride) - 1, 0
            while ways == 0:
                spot += 1
                if board[spot] == FREE:
                    ways = (
                        (1 if board[spot + 1] < OUTSIDE else 0)
                        + (2 if board[spot + stride] < OUTSIDE else 0)
                        + (4 if board[spot - 1] < OUTSIDE else 0)
                        + (8 if board[spot - stride] < OUTSIDE else 0)
                    )
        direction = 4  # no direction, until one is drawn
        while used < count and (ways >> direction) & 1 == 0:
            direction = (words[used >> 5] >> (2 * (used & 31))) & 3
            used += 1
        if (ways >> direction) & 1 == 0:
            break  # a hunt begins again with the next words, and ends at the same chamber
        if stuck:
            at = spot
            board[at] = direction
        else:
            at += (1 - (direction & 2)) * (stride if direction & 1 else 1)
            board[at] = direction ^ 2
        lowest = min(lowest, at)
        left -= 1
    state[AT], state[USED], state[LEFT], state[FIRST], state[LOWEST] = at, used, left, first, lowest
