"""Controllers of the C core: their functions by name, and the layout of their memories.

``sim/core/controllers/wg_controllers.h`` declares each memory as a struct. Python reads the places
of its fields from there, so they are listed only once.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.controllers.controller_error import ControllerError
from sim.kernels.layout import OBS_SIZE, place
from sim.verdict import Verdict
from worldgen.support.arrays import Floats
from worldgen.world import Value

# Bytes of a number.
_NUMBER = 8


@dataclass(frozen=True)
class CoreAct:
    """The act function of a controller, written in C.

    Args:
        name: Name by which ``wg_library_act`` knows it.
    """

    name: str

    @property
    def address(self) -> int:
        """Address of the function, a ``WgAct``."""
        return _address(self.name)

    @property
    def is_guarded(self) -> bool:
        """True if it runs in another process, because it may crash or hang."""
        return False

    def fault_of(self, error: Any) -> ControllerError:
        """Return the error of a controller that has failed.

        Args:
            error: ``WgCommand.error``.
        """
        return controller_error_of(ffi.string(error).decode("utf-8", "replace"))

    def __call__(self, observation: Floats, memory: Floats, command: Floats) -> None:
        """Act once, changing ``memory`` and ``command`` in place.

        Args:
            observation: (17 + beams,) the robot's observation.
            memory: (m,) its memory.
            command: (3,) zeros; receives the command.

        Raises:
            ControllerError: If the controller reports that it cannot continue.
        """
        # The struct holds the numbers in the array's order, so one copy of bytes fills it.
        beams = np.ascontiguousarray(observation[OBS_SIZE:], np.float64)
        seen = ffi.new("WgObservation *")
        plain = np.ascontiguousarray(observation[:OBS_SIZE], np.float64)
        ffi.buffer(seen, OBS_SIZE * _NUMBER)[:] = plain.tobytes()
        seen.beams = ffi.from_buffer("double[]", beams) if beams.size else ffi.NULL
        seen.beam_count = beams.size
        seen.goal_heading = math.nan
        asked = ffi.new("WgCommand *")
        own = (
            ffi.from_buffer("double[]", memory, require_writable=True) if memory.size else ffi.NULL
        )
        ffi.cast("WgAct", self.address)(seen, own, asked)
        command[:] = (asked.speed, asked.turn_rate, asked.used_random)
        if asked.error != ffi.NULL:
            raise self.fault_of(asked.error)


@functools.cache
def _address(name: str) -> int:
    act = lib.wg_library_act(name.encode())
    if act == ffi.NULL:
        raise LookupError(f"the core has no controller {name!r}")
    return int(ffi.cast("uintptr_t", act))


def controller_error_of(error: str) -> ControllerError:
    """Return the error for a controller in C that failed.

    Args:
        error: ``WgCommand.error``, by its contract ``Name: sentence`` or just a sentence.
    """
    name, _, _ = error.partition(":")
    _, colon, message = error.partition(": ")
    facts: dict[str, Value] = {"exception": name} if name.isidentifier() else {}
    return ControllerError(Verdict.CRASH, error, facts | ({"message": message} if colon else {}))


def fields_of(struct: str) -> Any:
    """Return the indices in a memory of all fields of its struct, as attributes."""
    names = (name for name, _ in ffi.typeof(struct).fields)
    return SimpleNamespace(**{name: place(struct, name) for name in names})


def size_of(struct: str) -> int:
    """Return the number of numbers in a struct, not counting an array at its end."""
    return int(ffi.sizeof(struct)) // _NUMBER


def memory_at_reset(size: int, numbers: Mapping[int, float]) -> tuple[float, ...]:
    """Return a memory of zeros, except for some numbers given by index."""
    memory = [0.0] * size
    for at, number in numbers.items():
        memory[at] = number
    return tuple(memory)


def default_of(name: str) -> dict[str, float]:
    """Return the fields of a constant struct of the core, such as ``wg_vfh_default``."""
    struct = getattr(lib, name)
    return {field: getattr(struct, field) for field, _ in ffi.typeof(struct).fields}
