"""Controllers of the C core: their functions by name, and what stands where in their memories.

``sim/core/controllers/wg_controllers.h`` declares each memory as a struct; its fields are named
there and nowhere else.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi as _ffi
from sim._core import lib as _lib
from sim.controllers.programs.program import ControllerError
from sim.controllers.shared.guarded import DEADLINE, HANG
from sim.verdict import Verdict

__all__ = ["CoreAct", "controller_error_of", "default_of", "memory_at_reset", "place", "size_of"]

Floats = npt.NDArray[np.float64]

ffi: Any = _ffi
lib: Any = _lib

SENSES = 17  # numbers of an observation before its beams
_NUMBER = 8  # bytes


@dataclass(frozen=True)
class CoreAct:
    """The act of a controller, a function of the C core.

    Args:
        name: As ``wg_library_act`` has it.
    """

    name: str

    @property
    def address(self) -> int:
        """Where the function is: a ``WgAct``."""
        return _address(self.name)

    @property
    def is_guarded(self) -> bool:
        """Whether it is run in another process, because it may crash or hang."""
        return False

    def __call__(self, observation: Floats, memory: Floats, command: Floats) -> None:
        """Act once; changes ``memory`` and ``command`` in place.

        Args:
            observation: (17 + beams,).
            memory: Its memory.
            command: (3,) zeros.

        Raises:
            Misbehaviour: If the controller says that it cannot go on.
        """
        beams = np.ascontiguousarray(observation[SENSES:], np.float64)
        seen = ffi.new("WgObservation *")
        ffi.buffer(seen, SENSES * _NUMBER)[:] = np.ascontiguousarray(
            observation[:SENSES], np.float64
        ).tobytes()
        seen.beams = ffi.from_buffer("double[]", beams) if beams.size else ffi.NULL
        seen.beam_count = beams.size
        asked = ffi.new("WgCommand *")
        own = (
            ffi.from_buffer("double[]", memory, require_writable=True) if memory.size else ffi.NULL
        )
        ffi.cast("WgAct", self.address)(seen, own, asked)
        command[:] = (asked.speed, asked.turn_rate, asked.used_random)
        if asked.error != ffi.NULL:
            raise controller_error_of(ffi.string(asked.error).decode("utf-8", "replace"))


@functools.cache
def _address(name: str) -> int:
    act = lib.wg_library_act(name.encode())
    if act == ffi.NULL:
        raise LookupError(f"the core has no controller {name!r}")
    return int(ffi.cast("uintptr_t", act))


def controller_error_of(error: str) -> ControllerError:
    """Return what a function of C did wrong.

    Args:
        error: ``WgReport.error``.
    """
    if error == HANG:
        return ControllerError(Verdict.HANG, error, {"deadline": DEADLINE})
    _, colon, message = error.partition(": ")
    return ControllerError(Verdict.CRASH, error, {"message": message} if colon else {})


def place(struct: str, *fields: str | int) -> int:
    """Return the index in a memory of a field of its struct.

    Of a field of a field where several are named.
    """
    return int(ffi.offsetof(struct, *fields)) // _NUMBER


def size_of(struct: str) -> int:
    """Return the numbers that a struct takes of a memory, without those of an array at its end."""
    return int(ffi.sizeof(struct)) // _NUMBER


def memory_at_reset(size: int, numbers: Mapping[int, float]) -> tuple[float, ...]:
    """Return a memory of zeros but for some numbers, given by their places."""
    memory = [0.0] * size
    for at, number in numbers.items():
        memory[at] = number
    return tuple(memory)


def default_of(name: str) -> dict[str, float]:
    """Return the fields of a constant struct of the core, such as ``wg_vfh_default``."""
    struct = getattr(lib, name)
    return {field: getattr(struct, field) for field, _ in ffi.typeof(struct).fields}
