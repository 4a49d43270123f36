"""Disjoint sets, and the tree that they make of pairs."""

from __future__ import annotations

__all__ = ["joining"]


class _Sets:
    """Disjoint sets of whole numbers, joined two by two."""

    def __init__(self, count: int) -> None:
        self._above = list(range(count))

    def find(self, one: int) -> int:
        above = self._above
        while above[one] != one:
            above[one] = above[above[one]]
            one = above[one]
        return one

    def join(self, one: int, other: int) -> bool:
        """Whether they were apart."""
        one = self.find(one)
        other = self.find(other)
        self._above[one] = other
        return one != other


def joining(pairs: list[tuple[int, int]], count: int) -> list[int]:
    """Numbers of the pairs that join what those before them left apart: Kruskal's tree, in the order given."""
    sets = _Sets(count)
    return [number for number, (one, other) in enumerate(pairs) if sets.join(one, other)]
