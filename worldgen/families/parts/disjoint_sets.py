"""Disjoint sets, and Kruskal's spanning tree built with them."""

from __future__ import annotations


class _Sets:
    """Keep disjoint sets of whole numbers, and join two of them at a time."""

    def __init__(self, count: int) -> None:
        self._above = list(range(count))

    def find(self, one: int) -> int:
        above = self._above
        while above[one] != one:
            above[one] = above[above[one]]
            one = above[one]
        return one

    def join(self, one: int, other: int) -> bool:
        """Join the sets of two numbers; return True if these were different sets."""
        one = self.find(one)
        other = self.find(other)
        self._above[one] = other
        return one != other


def joining(pairs: list[tuple[int, int]], count: int) -> list[int]:
    """Return the positions of the pairs that form a spanning tree.

    Each returned pair joins two sets that the pairs before it left separate.

    Args:
        pairs: Pairs of numbers below ``count``, the preferred ones first.
        count: Number of elements.

    Source: Kruskal, "On the shortest spanning subtree of a graph", 1956.
    """
    sets = _Sets(count)
    return [number for number, (one, other) in enumerate(pairs) if sets.join(one, other)]
