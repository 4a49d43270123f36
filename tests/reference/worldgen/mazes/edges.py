"""Mazes by choosing edges or chambers: Kruskal's and Prim's algorithms, and the growing tree.

``kruskal`` and ``prim`` find the tree of least total weight, where each edge of the lattice has a
random weight of 32 bits: the low half of a chamber's word is the weight of its edge to the east,
the high half is the weight of its edge to the north. Equal weights, one pair in four thousand
million, are ordered by the edge's number. So with the same words both find the same tree; they only
grow it in a different order.

A key is a weight followed by the number of an edge, in one number of 63 bits; an edge's number is
twice the place of its lower or left chamber, plus one if it leads north.
"""

import numpy as np

from tests.reference.worldgen.mazes.board import AT, FREE, LEFT, USED

EDGE = (1 << 31) - 1  # the edge's number in a key
WEIGHT_BITS = 32
LOW_HALF = (1 << WEIGHT_BITS) - 1

# state of the growing tree
NEWEST, OLDEST = 3, 4  # shares of the picks, of SHARE
TAIL, HEAD = 5, 6  # the list of active chambers is scratch[HEAD:TAIL]
ALIVE = 7  # entries that are still active
SHARE = 1 << 16


def edge_keys(words, board, stride):
    """Keys of all edges between chambers, the lightest first.

    Args:
        words: (n,) random 64 bits, one word for each place on the board.
        board: (n,) the board, blank.
        stride: From a chamber to the one above it.
    """
    free = np.flatnonzero(board == FREE)
    parts = []
    for north, step in ((0, 1), (1, stride)):
        low = free[board[free + step] == FREE]
        weights = (words[low] >> (WEIGHT_BITS * north)) & LOW_HALF
        parts.append((weights << 31) | (2 * low + north))
    keys = np.concatenate(parts)
    keys.sort()
    return keys


def kruskal(keys, board, state, stride, scratch):
    """Takes the edges in order of weight, and keeps those that join separate parts.

    Args:
        keys: (m,) sorted keys of edges.
        board: (n,) becomes the links.
        state: LEFT.
        stride: From a chamber to the one above it.
        scratch: (n,) the sets of joined chambers: each points to one with a lower place, or to
            itself.

    Sources: Joseph B. Kruskal, "On the shortest spanning subtree of a graph and the traveling
        salesman
    problem", Proceedings of the American Mathematical Society, 1956; the sets are M. Rem's, in
    Edsger W. Dijkstra, "A Discipline of Programming", 1976, chapter 23: two searches climb at once
    and splice.
    """
    for at in range(len(board)):
        board[at] = 0
        scratch[at] = at
    left = state[LEFT]
    edge = 0
    while left > 0:
        number = keys[edge] & EDGE
        edge += 1
        low = number >> 1
        first, second = low, low + (stride if number & 1 else 1)
        above, beside = scratch[first], scratch[second]
        while above != beside:
            if above < beside:
                first, second, above, beside = second, first, beside, above
            scratch[first] = beside
            if first == above:
                board[low] += 1 + (number & 1)  # EAST or NORTH
                left -= 1
                break
            first, above = above, scratch[above]
    state[LEFT] = 0


def prim(words, board, state, stride, scratch):
    """Grows from one chamber along the lightest edge that leads out of the maze so far.

    Args:
        words: (n,) random 64 bits, one word for each place on the board.
        board: (n,) the board; in the end each chamber names its parent.
        state: LEFT, and AT, the chamber to start with.
        stride: From a chamber to the one above it.
        scratch: (2 n,) a heap of the keys of edges at the rim; each has four children.

    Sources: Robert C. Prim, "Shortest connection networks and some generalizations", Bell System
        Technical
    Journal, 1957; the heap: Donald B. Johnson, "Priority queues with update and finding minimum
    spanning trees", Information Processing Letters, 1975.
    """
    at, left, size = state[AT], state[LEFT], 0
    while left > 0:
        for direction in range(4):
            beyond = at + (1 - (direction & 2)) * (stride if direction & 1 else 1)
            if board[beyond] == FREE:
                low = at if direction < 2 else beyond
                weight = (words[low] >> (WEIGHT_BITS * (direction & 1))) & LOW_HALF
                key = (weight << 31) | (2 * low + (direction & 1))
                hole = size
                size += 1
                while hole > 0 and scratch[(hole - 1) >> 2] > key:
                    scratch[hole] = scratch[(hole - 1) >> 2]
                    hole = (hole - 1) >> 2
                scratch[hole] = key
        grown = False
        while not grown:
            number = scratch[0] & EDGE
            size -= 1
            key, hole = scratch[size], 0
            while 4 * hole + 1 < size:
                child = 4 * hole + 1
                for other in range(child + 1, min(child + 4, size)):
                    if scratch[other] < scratch[child]:
                        child = other
                if scratch[child] >= key:
                    break
                scratch[hole] = scratch[child]
                hole = child
            scratch[hole] = key
            low, north = number >> 1, number & 1
            high = low + (stride if north else 1)
            if board[high] == FREE:
                at, grown = high, True
                board[at] = 2 + north
            elif board[low] == FREE:
                at, grown = low, True
                board[at] = north
        left -= 1
    state[LEFT] = 0


def growing_tree(words, board, state, stride, scratch):
    """Digs from the newest, the oldest or any chamber of a list.

    A chamber without a free neighbour leaves the list. Each word is one try: 16 bits choose the
    rule, 16 the neighbour, 32 the entry. A number that would favour some choice, and an entry that
    has left the list, are drawn again with the next word.

    Args:
        words: (n,) random 64 bits as int64.
        board: The board; in the end each chamber names its parent.
        state: LEFT, USED (words), NEWEST, OLDEST, TAIL, HEAD, ALIVE; AT is 1 while an entry has to
            be drawn again.
        stride: From a chamber to the one above it.
        scratch: (chambers,) the list in order of age; -1 where an entry has left it.

    Source: Jamis Buck, "Mazes for Programmers", 2015, "The Growing Tree Algorithm".
    """
    used, left, again = state[USED], state[LEFT], state[AT]
    newest, oldest = state[NEWEST], state[NEWEST] + state[OLDEST]
    tail, head, alive = state[TAIL], state[HEAD], state[ALIVE]
    count = len(words)
    while left > 0 and used < count:
        word = words[used]
        used += 1
        rule, lot, entry = word & 0xFFFF, (word >> 16) & 0xFFFF, tail - 1
        if again == 0 and newest <= rule < oldest:
            entry = head
        elif again != 0 or rule >= oldest:
            scaled = ((word >> 32) & LOW_HALF) * (tail - head)
            entry = head + (scaled >> 32)
            again = 1
            if (scaled & LOW_HALF) < (1 << 32) % (tail - head) or scratch[entry] < 0:
                continue
        if lot >= 65532:  # 12 goes into 65532: the rest is even for 1, 2, 3 and 4 neighbours
            continue
        again = 0
        at = scratch[entry]
        ways = (
            (board[at + 1] >> 3)
            + (board[at + stride] >> 3)
            + (board[at - 1] >> 3)
            + (board[at - stride] >> 3)
        )
        if ways > 0:
            lot = lot % ways
            direction = 0
            beyond = at + 1
            while board[beyond] != FREE or lot > 0:
                lot -= board[beyond] >> 3
                direction += 1
                beyond = at + (1 - (direction & 2)) * (stride if direction & 1 else 1)
            board[beyond] = direction ^ 2
            scratch[tail] = beyond
            tail += 1
            alive += 1
            left -= 1
            continue
        scratch[entry] = -1
        alive -= 1
        while scratch[tail - 1] < 0:
            tail -= 1
        while scratch[head] < 0:
            head += 1
        if (
            2 * alive < tail - head
        ):  # so a random draw hits an active one at least every second time
            kept = head
            for entry in range(head, tail):
                if scratch[entry] >= 0:
                    scratch[kept] = scratch[entry]
                    kept += 1
            tail = kept
    state[USED], state[LEFT], state[AT] = used, left, again
    state[TAIL], state[HEAD], state[ALIVE] = tail, head, alive
