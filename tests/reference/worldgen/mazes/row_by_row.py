"""Mazes of whole rectangles: Eller's algorithm, sidewinder, binary tree, recursive division.

They go through the rows in order without looking at the neighbours above, or split rectangles, so
no chamber may be missing. Each writes links to the board directly.

Args of each:
    words: (n,) random 64 bits as int64.
    board: A board; its chambers become links.
    state: LEFT, and any others that the kernel names.
    stride: From a chamber to the one above it, two more than there are columns.
    scratch: Workspace, as described by each kernel.
"""

from tests.reference.worldgen.mazes.board import AT, EAST, LEFT, NORTH, USED

COLUMN = 3  # state of the sidewinder: how far it is in its row, which begins at AT
STACKED = 3  # state of the recursive division: how many rectangles are waiting


def eller(words, board, state, stride, scratch):
    """Joins neighbours in a row at random unless already joined, then goes up from each set.

    Two bits a chamber: whether to join it to the next, and whether to go up. The sets of a row
    never cross, so each is a ring in the order of columns, and the next column is in the same set
    if it is next in the ring.

    ``scratch`` is (2 columns + 2,): the next and the previous chamber of each in its set.

    Sources: Marlin Eller's algorithm of 1982, as described in Jamis Buck, "Mazes for Programmers",
        2015; the rings are John Tromp's, in Don Libes, "Obfuscated C and Other Mysteries", 1993.
    """
    columns, rows = stride - 2, len(board) // stride - 2
    before = (
        columns + 1
    )  # scratch[column]: the next one in the ring; scratch[before + column]: the previous one
    for column in range(columns + 1):  # the last one is not a chamber; it is only written unchanged
        scratch[column] = scratch[before + column] = column
    words_a_row = (columns + 31) >> 5
    for row in range(rows - 1):
        base, first_word = (row + 1) * stride + 1, row * words_a_row
        for column in range(columns):
            bits = (words[first_word + (column >> 5)] >> (2 * (column & 31))) & 3
            after, far = scratch[column], scratch[before + column + 1]
            joined = bits & 1 if after != column + 1 else 0
            if column + 1 == columns:
                joined = 0
            # All four are written in both cases, because a branch on a random bit is mispredicted
            # every second time. 1.8 x.
            if joined != 0:
                far_next, after_last, here_next, beside_last = after, far, column + 1, column
            else:
                far_next, after_last, here_next, beside_last = column + 1, column, after, far
            scratch[far] = far_next
            scratch[before + after] = after_last
            scratch[column] = here_next
            scratch[before + column + 1] = beside_last
            after, previous = scratch[column], scratch[before + column]
            up = 1 if previous == column else bits >> 1
            if up != 0:
                far_next, after_last, here_next, beside_last = column, column, after, previous
            else:  # it leaves its ring: the chamber above it is alone
                far_next, after_last, here_next, beside_last = after, previous, column, column
            scratch[previous] = far_next
            scratch[before + after] = after_last
            scratch[column] = here_next
            scratch[before + column] = beside_last
            board[base + column] = joined + 2 * up
    base = rows * stride + 1
    for column in range(columns - 1):
        after, far = scratch[column], scratch[before + column + 1]
        board[base + column] = 0
        if after != column + 1:
            scratch[far], scratch[before + after] = after, far
            scratch[column], scratch[before + column + 1] = column + 1, column
            board[base + column] = EAST
    state[LEFT] = 0


def sidewinder(words, board, state, stride, scratch):
    """Cuts each row into runs and opens one chamber of each run upwards; the last row is one run.

    Each word is one run: after each chamber a bit decides whether the run ends, and the upper half
    chooses the opening, uniformly to one part in ten million. A run of 32 chambers always ends.

    ``state`` holds AT, where the row begins, COLUMN and USED (words). ``scratch`` is not used.

    Source: Jamis Buck, "Mazes for Programmers", 2015, chapter 1.
    """
    base, column, used, count = state[AT], state[COLUMN], 0, len(words)
    columns, last_row = stride - 2, len(board) - 2 * stride + 1
    while base < last_row and used < count:
        word = words[used]
        used += 1
        end, begin = column, column
        while end + 1 < columns and end < begin + 31 and (word >> (end - begin)) & 1 == 0:
            board[base + end] = EAST
            end += 1
        board[base + end] = 0
        chosen = ((word >> 32) & 0xFFFFFFFF) * (end + 1 - begin) >> 32
        board[base + begin + chosen] += NORTH
        column = end + 1
        if column == columns:
            base += stride
            column = 0
    state[AT], state[COLUMN], state[USED] = base, column, used
    if base >= last_row:
        for column in range(columns):
            board[last_row + column] = EAST if column + 1 < columns else 0
        state[LEFT] = 0


def binary_tree(words, board, state, stride, scratch):
    """Opens each chamber east or up with equal probability; ``scratch`` is not used.

    Source: Jamis Buck, "Mazes for Programmers", 2015, chapter 1.
    """
    columns, rows = stride - 2, len(board) // stride - 2
    words_a_row = (columns + 63) >> 6
    for row in range(rows):
        base = (row + 1) * stride + 1
        for number in range(words_a_row):
            word = 0 if row == rows - 1 else words[row * words_a_row + number]
            for column in range(64 * number, min(64 * number + 64, columns)):
                board[base + column] = EAST + ((word >> (column - 64 * number)) & 1)
        board[base + columns - 1] = 0 if row == rows - 1 else NORTH
    state[LEFT] = 0


def recursive_division(words, board, state, stride, scratch):
    """Cuts a rectangle in two across its longer side, by a wall with one door, and then its parts.

    A part that is one chamber wide is a corridor. Each word is one cut: a bit for the side, if the
    sides are equal, 31 bits for the wall, 32 for the door; numbers that would favour some choice
    are drawn again.

    ``state`` holds STACKED and USED (words). ``scratch`` has four numbers for each waiting
    rectangle: place of its first chamber, columns, rows, 0. The smaller part goes first, so the
    number of waiting rectangles is at most the number of bits of its size.

    Source: Jamis Buck, "Mazes for Programmers", 2015, "Recursive Division".
    """
    top, used, count = state[STACKED], 0, len(words)
    while top > 0:
        base, columns, rows = scratch[4 * top - 4], scratch[4 * top - 3], scratch[4 * top - 2]
        if columns == 1 or rows == 1:
            along, step = (NORTH, stride) if columns == 1 else (EAST, 1)
            for number in range(columns * rows - 1):
                board[base + number * step] |= along
            top -= 1
            continue
        if used == count:
            break
        word = words[used]
        used += 1
        upright = columns > rows or (columns == rows and word & 1 == 1)
        length, door_places = (columns, rows) if upright else (rows, columns)
        wall = ((word >> 1) & 0x7FFFFFFF) * (length - 1)
        door = ((word >> 32) & 0xFFFFFFFF) * door_places
        if (wall & 0x7FFFFFFF) < (1 << 31) % (length - 1) or (door & 0xFFFFFFFF) < (
            1 << 32
        ) % door_places:
            continue
        first, door = (wall >> 31) + 1, door >> 32  # chambers on this side of the wall
        across, along = (1, stride) if upright else (stride, 1)
        board[base + (first - 1) * across + door * along] |= EAST if upright else NORTH
        beyond, rest = base + first * across, length - first
        if 2 * first >= length:  # the larger part waits below the smaller one
            scratch[4 * top - 4], scratch[4 * top] = base, beyond
        else:
            scratch[4 * top - 4], scratch[4 * top], first, rest = beyond, base, rest, first
        scratch[4 * top - 3], scratch[4 * top - 2] = (first, rows) if upright else (columns, first)
        scratch[4 * top + 1], scratch[4 * top + 2] = (rest, rows) if upright else (columns, rest)
        top += 1
    state[STACKED], state[USED] = top, used
    if top == 0:
        state[LEFT] = 0
