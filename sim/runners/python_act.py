"""Let a Python controller act in the core's loop (``sim/core/runs/python_act.c``)."""

from __future__ import annotations

import ctypes
import math
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

from sim._core import ffi, lib
from sim.clock.controller_time import MEASURED_EVERY, count_hang, own_seconds, timed
from sim.clock.stopping import OutOfTime, breakable, portions
from sim.controllers.base import Command, Memory, Observation
from sim.controllers.contract import flat_memory, no_command, no_memory

# Speed, turn rate, and whether the random number was used.
_COMMAND = struct.Struct("3d")


def _address(of: Any, thing: Any) -> int:
    return int(of.cast("uintptr_t", thing))


# cffi would release Python's lock in this call. ctypes keeps it, and passes on the controller's
# exceptions.
_act_in_python: Any = ctypes.PYFUNCTYPE(
    ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.py_object, ctypes.c_int64
)(_address(ffi, ffi.addressof(lib, "wg_act_in_python")))


class Stops:
    """A run that stops wherever its controller must act; iterating runs it from stop to stop.

    Args:
        of: ``ffi`` of the core that runs it.
        core: ``lib`` of that core.
        name: ``wg_episode`` or ``wg_seat``: the functions NAME_step and NAME_stop run it.
        subject: The struct that those functions take.
        episode: Where the controller observes and answers; its ``c`` is a WgEpisode.
    """

    def __init__(self, of: Any, core: Any, name: str, subject: Any, episode: Any) -> None:
        self.episode = episode
        self._step = getattr(core, f"{name}_step")
        self._subject = subject
        self.acting: Any = ffi.new("WgActing *")
        self.acting.stop = ffi.cast("WgStop", _address(of, of.addressof(core, f"{name}_stop")))
        self.acting.subject = ffi.cast("void *", _address(of, subject))
        self.acting.episode = ffi.cast("WgEpisode *", _address(of, episode.c))
        self.acting.every = MEASURED_EVERY

    def __iter__(self) -> Iterator[int]:
        return iter(lambda: self._step(self._subject), lib.WG_OVER)


@breakable
def act_in_core(
    act: Callable[..., Any], stops: Stops, memory: Memory, *, is_measured: bool
) -> Memory:
    """Let a controller act wherever a run stops, until the run is over.

    Args:
        act: The controller's method.
        stops: The run.
        memory: The controller's memory at the start, as floats.
        is_measured: Whether its time counts as the controller's own
            (:mod:`sim.clock.controller_time`).

    Returns:
        The memory after the last step.

    Raises:
        ContractBroken: If the controller returns anything but a command and a memory.
    """
    first = timed(act) if is_measured else act
    measured = timed(act, MEASURED_EVERY) if is_measured else act
    tools = (act, first, measured, tuple.__new__, Observation, Command, tuple, float, settled)
    address = _address(ffi, stops.acting)
    for most in portions():
        before = own_seconds()
        began = time.perf_counter()
        try:
            memory = _act_in_python(address, tools, memory, most)
        except OutOfTime:
            # Few steps are measured, and hardly ever the one that hangs.
            if is_measured:
                count_hang(before, began)
            raise
        if stops.acting.over:
            break
    return memory


def settled(answer: Any, size: int) -> tuple[float, ...]:
    """Read an answer that is not in the usual form, which C reads itself.

    Args:
        answer: The controller's return value.
        size: The length that its memory must have.

    Returns:
        Speed, turn rate, whether the random number was used, and the memory.

    Raises:
        ContractBroken: If it is not a command and a memory.
    """
    try:
        asked, after = answer
    except (TypeError, ValueError):
        raise no_memory(answer) from None
    if type(after) is not tuple or len(after) != size:
        after = flat_memory(after, size)
    try:
        command = asked if type(asked) is Command else Command(*asked)
    except TypeError:
        flat_memory(after, size)  # If command and memory are both invalid, report the memory.
        raise no_command(asked) from None
    speed, turn_rate, used_random = command[:3]
    numbers = struct.Struct(f"{3 + size}d")
    try:
        return numbers.unpack(numbers.pack(speed, turn_rate, 1.0 if used_random else 0.0, *after))
    except (struct.error, OverflowError):
        kept = flat_memory(after, size)
        return (*_numbers(speed, turn_rate, used_random), *kept)


def _numbers(speed: Any, turn_rate: Any, used_random: Any) -> tuple[float, float, float]:
    """Return a command as floats; anything but a number becomes nan, which the core refuses."""
    try:
        numbers = _COMMAND.unpack(_COMMAND.pack(speed, turn_rate, bool(used_random)))
    except (struct.error, OverflowError):
        return math.nan, 0.0, 0.0
    return numbers[0], numbers[1], numbers[2]
