"""The types that kernels for whole episodes are compiled for, once for all compiled controllers."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numba

from sim.kernels.lattice_state import Arena, Robot, Room
from sim.kernels.recurrence import Search

__all__ = ["EpisodeTypes", "episode_types", "typed_kernel"]


class EpisodeTypes(NamedTuple):
    """Numba's types of what an episode on the lattice takes.

    Args:
        arena: An :class:`sim.kernels.lattice_state.Arena`.
        robot: A :class:`sim.kernels.lattice_state.Robot`.
        room: A :class:`sim.kernels.lattice_state.Room`.
        act: Any compiled controller's function.
    """

    arena: Any
    robot: Any
    room: Any
    act: Any


@functools.cache
def episode_types() -> EpisodeTypes:
    """The types, made once."""
    types: Any = numba.types
    ints, floats, bytes_2d = numba.int64[::1], numba.float64[::1], numba.uint8[:, ::1]
    rows, table = numba.int64[:, ::1], numba.int32[:, ::1]
    words = numba.uint64[::1]
    search = types.NamedTuple((ints, words, words, ints), Search)
    return EpisodeTypes(
        types.NamedTuple((bytes_2d, table, table, rows, ints, bytes_2d), Arena),
        types.NamedTuple((ints, floats, rows, ints, floats), Robot),
        types.NamedTuple((floats, ints, floats, floats, search), Room),
        types.FunctionType(numba.void(floats, floats, floats)),
    )


def typed_kernel(function: Any, signature: Any) -> Any:
    """The kernel, compiled for one signature and from now on for no other, whoever calls it."""
    function.compile(signature)
    function.disable_compile()
    return function
