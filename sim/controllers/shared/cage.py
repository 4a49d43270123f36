"""The memory in which a controller from a shared library acts, away from the simulator's data.

``sim/core/episode/cage.c`` is the other side: it lets the function act there, and compares the
words around its memory after each step. The pages around a cage cannot be touched at all, so a
function that misses its memory by more ends its process, and this module tells by how much.
"""

from __future__ import annotations

import os
import threading
from typing import Any

from sim._core import ffi, lib
from sim.controllers.shared.guarded import SHARED
from worldgen.support.ccall import check, kept

# Bytes on each side of a cage's pages that nobody can touch.
_FENCE = 1 << 20

_WORD = 8


class _Pages:
    """Pages that no cage uses any more, by their sizes, so that few new ones are needed."""

    def __init__(self) -> None:
        self._free: dict[tuple[int, int], list[int]] = {}
        self._lock = threading.Lock()

    def free(self, sizes: tuple[int, int]) -> list[int]:
        """Return the list of unused pages of these sizes, which a cage's pages join at its end."""
        with self._lock:
            return self._free.setdefault(sizes, [])

    def take(self, sizes: tuple[int, int]) -> int:
        """Return the address of the first part of some pages.

        Raises:
            MemoryError: If there is not enough memory.
        """
        free = self.free(sizes)
        with self._lock:
            if free:
                return free.pop()
        made = lib.wg_map_fenced(_FENCE, *sizes)
        if made == ffi.NULL:
            raise MemoryError("not enough memory for a controller")
        SHARED.note_pages()
        return int(ffi.cast("uintptr_t", made))


_pages = _Pages()
# After a fork the pages are the parent's.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pages.__init__)  # type: ignore[misc]


class Cage:
    """The memory of one controller, for as long as it is driven.

    Args:
        act: Address of its function, a ``WgAct``.
        memory_size: Numbers in its memory.
        beams: Range beams that it observes.
        neighbours: Other robots that it observes, at most.

    Attributes:
        c: The WgCage.
    """

    def __init__(self, act: int, memory_size: int, beams: int = 0, neighbours: int = 0) -> None:
        needed = ffi.new("int64_t[2]")
        lib.wg_cage_sizes(memory_size, beams, neighbours, needed)
        page = int(lib.wg_page_size())
        self._sizes = (-(-needed[0] // page) * page, -(-needed[1] // page) * page)
        sizes = self._sizes
        first = _pages.take(sizes)
        # Garbage collection may end a cage at any time, so that takes no lock.
        unused = _pages.free(sizes)
        made = SHARED.new("WgCage *")
        self.c: Any = kept(ffi, made, free=lambda _: unused.append(first))
        self.c.act = ffi.cast("WgAct", act)
        self.c.memory_size = memory_size
        self.c.beam_room = beams
        self.c.neighbour_room = neighbours
        self.c.first = ffi.cast("uint64_t *", first)
        self.c.second = ffi.cast("uint64_t *", first + sizes[0] + _FENCE)
        check(lib.wg_cage_begin(self.c, *sizes))

    def misuse(self, address: int) -> str:
        """Return what the function did if it is acting and an address could not be used.

        Returns:
            A sentence; empty if the address is not next to the cage.
        """
        first = int(ffi.cast("uintptr_t", self.c.first))
        second = int(ffi.cast("uintptr_t", self.c.second))
        if not self.c.acts or not first - _FENCE <= address < second + self._sizes[1] + _FENCE:
            return ""
        if address < first:
            memory = int(ffi.cast("uintptr_t", self.c.memory))
            return f"it reached {memory - _in_words(address)} bytes before its memory"
        if address < second:
            end = first + self._sizes[0]
            return f"it reached {_in_words(address) + _WORD - end} bytes after its memory"
        return "it reached past the end of what it observes"


def _in_words(address: int) -> int:
    return address // _WORD * _WORD
