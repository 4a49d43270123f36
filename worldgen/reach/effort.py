"""When compiled code pays: numba and its kernels take half a second to load, which one small world does not."""

from __future__ import annotations

__all__ = ["Effort", "effort"]

SMALL = 200_000  # nodes of a graph that plain Python searches in less time than loading numba takes
PATIENCE = 2_000_000  # nodes of small graphs, one after the other: about a second of plain Python


class Effort:
    """What this process has spent on small worlds; the answers do not depend on it, only their speed."""

    def __init__(self) -> None:
        self.spent = 0

    def pays_to_compile(self, nodes: int) -> bool:
        """Whether compiled code is the quicker way for one more graph of so many nodes, loading included.

        Plain Python goes on until it has cost as much as loading would: so neither one small world waits for numba,
        nor do thousands go without it.
        """
        if nodes > SMALL:
            self.spent = PATIENCE  # loaded now, it is there for the small ones too
        self.spent += nodes
        return self.is_loaded

    def expect(self, nodes: int) -> None:
        """Makes ready for graphs of so many nodes in all."""
        if self.spent + nodes > PATIENCE:
            self.spent = PATIENCE

    @property
    def is_loaded(self) -> bool:
        """Whether the kernels are, or are about to be."""
        return self.spent > PATIENCE


effort = Effort()
