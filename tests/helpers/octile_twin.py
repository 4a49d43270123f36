"""Shortest octile paths by Dijkstra's algorithm over counts of moves.

Slow and plain, and shares no code with the product.
"""

import heapq
from fractions import Fraction

_MOVES = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if (dx, dy) != (0, 0)]
_ROOT_TWO = Fraction(1414213562373095048801688724209698078569671875376948, 10**51)


def octile_length(walls, start, goal):
    """(straight, diagonal) moves from (column, row) to another, or (-1, -1)."""
    height, width = walls.shape

    def free(x, y):
        return 0 <= x < width and 0 <= y < height and not walls[y, x]

    if not (free(*start) and free(*goal)):
        return -1, -1
    best, heap, done = {start: (0, 0)}, [(Fraction(0), start)], set()
    while heap:
        _, (x, y) = heapq.heappop(heap)
        if (x, y) in done:
            continue
        done.add((x, y))
        for dx, dy in _MOVES:
            after = (x + dx, y + dy)
            if free(*after) and free(x + dx, y) and free(x, y + dy):
                straight, diagonal = best[x, y]
                counts = (straight, diagonal + 1) if dx and dy else (straight + 1, diagonal)
                if after not in best or _length(counts) < _length(best[after]):
                    best[after] = counts
                    heapq.heappush(heap, (_length(counts), after))
    return best.get(goal, (-1, -1))


def _length(counts):
    return counts[0] + counts[1] * _ROOT_TWO
