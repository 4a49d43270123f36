"""Make calls of the core in another process, so that a controller can crash without harm.

A controller that crashes or hangs then ends a run, not the program. Campaigns run controllers from
shared libraries this way. The other process is forked when it is first needed. It has the library
loaded and makes whole calls at full speed, such as a run, or screening runs in a thousand worlds.
Everything that a call works on is in memory that both processes share (:data:`SHARED`). If the
other process dies, the memory is in the state of the last call of the controller, and shows which
run it was. ``sim/core/runs/wg_guard.h`` is the other side.
"""

from __future__ import annotations

import atexit
import functools
import math
import mmap
import os
import select
import signal
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.controller_error import NO_ANSWER, ControllerError, how_it_ended
from sim.verdict import Verdict
from worldgen.errors import WorldgenError

DEADLINE = 1.0
"""Processor time that a controller may take for a step, s."""

# Wall-clock seconds that a step may take, if it waits or the processors are busy elsewhere.
_WAITING = 5.0

# Seconds between two checks of the other process's progress, and for Ctrl-C.
_LOOK = 0.1

# Number of bytes by which the shared memory grows.
_CHUNK = 1 << 24

# Bytes of the smallest block, a line of the processor's cache.
_SMALLEST = 64

before_start: list[Callable[[], object]] = []
"""Functions to call before the other process is forked.

They create objects that it must find in its copy of this process's memory.
"""


class ControllerDied(ControllerError):
    """Raised if the process that ran the controller has ended, or was ended because of a hang."""


class CallResult(NamedTuple):
    """The result of a call.

    Args:
        result: Return value of the core's function.
        error: ``WgReport.error`` of the last run; empty if there was no error.
    """

    result: int
    error: str


class CoreMemory:
    """Memory for the core's structs and arrays; in this class, ordinary memory of this process."""

    is_shared = False

    def new(self, kind: str, value: Any = None, ffi: Any = ffi) -> Any:
        """Return a new struct, or several, as ``ffi.new`` does.

        Args:
            kind: C type, such as ``WgArena *`` or ``WgSettings[]``.
            value: Initial value, or the length of an array.
            ffi: Of the core that declares the struct.
        """
        return ffi.new(kind, value)

    def own(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the array if it is in this memory, otherwise a copy that is."""
        return array

    def zeros(self, shape: int | tuple[int, ...], kind: Any) -> npt.NDArray[Any]:
        """Return an array of zeros."""
        return np.zeros(shape, kind)


class _SharedMemory(CoreMemory):
    """Memory that this process shares with the one that makes calls.

    It grows as needed, and never returns memory to the system.
    """

    is_shared = True

    def __init__(self) -> None:
        self._chunks: list[mmap.mmap] = []
        self._next = 0
        self._end = 0
        self._sizes: dict[int, int] = {}
        self._free: dict[int, list[int]] = {}
        self._lock = threading.Lock()

    @property
    def chunks(self) -> int:
        """How many times it has grown; a process only knows chunks from before it was forked."""
        return len(self._chunks)

    def new(self, kind: str, value: Any = None, ffi: Any = ffi) -> Any:
        """See :meth:`CoreMemory.new`."""
        return _allocator(self, ffi, clear=True)(kind, value)

    def block(self, size: int, *, clear: bool) -> Any:
        """Return a block of bytes, filled with zeros if ``clear`` is set."""
        return _allocator(self, ffi, clear=clear)("char[]", max(size, 1))

    def own(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """See :meth:`CoreMemory.own`."""
        if array.flags.c_contiguous and array.__array_interface__["data"][0] in self._sizes:
            return array
        copy = self._array(array.shape, array.dtype, clear=False)
        copy[...] = array
        return copy

    def zeros(self, shape: int | tuple[int, ...], kind: Any) -> npt.NDArray[Any]:
        """See :meth:`CoreMemory.zeros`."""
        return self._array(
            shape if isinstance(shape, tuple) else (shape,), np.dtype(kind), clear=True
        )

    def _array(
        self, shape: tuple[int, ...], kind: np.dtype[Any], *, clear: bool
    ) -> npt.NDArray[Any]:
        count = math.prod(shape)
        block = self.block(count * kind.itemsize, clear=clear)
        return np.frombuffer(ffi.buffer(block), kind, count).reshape(shape)

    def take(self, size: int) -> Any:
        """Return the address of a block for cffi; its content is arbitrary."""
        # Powers of two make freed blocks easy to reuse.
        size = max(_SMALLEST, 1 << (size - 1).bit_length())
        with self._lock:
            free = self._free.get(size)
            address = free.pop() if free else self._new_address(size)
        return ffi.cast("char *", address)

    def _new_address(self, size: int) -> int:
        if self._end - self._next < size:
            length = max(size, _CHUNK)
            chunk = mmap.mmap(-1, length)
            self._chunks.append(chunk)
            self._next = int(ffi.cast("uintptr_t", ffi.from_buffer(chunk)))
            self._end = self._next + length
        address = self._next
        self._next += size
        self._sizes[address] = size
        return address

    def give_back(self, block: Any) -> None:
        """Take a block back. Garbage collection may call this at any time, so it takes no lock."""
        address = int(ffi.cast("uintptr_t", block))
        self._free.setdefault(self._sizes[address], []).append(address)


@functools.cache
def _allocator(memory: _SharedMemory, ffi: Any, *, clear: bool) -> Any:
    """Return a function that creates a core's structs in shared memory."""
    return ffi.new_allocator(memory.take, memory.give_back, should_clear_after_alloc=clear)


PRIVATE = CoreMemory()
"""Ordinary memory of this process."""

SHARED = _SharedMemory()
"""Memory for all data of calls in the other process."""


class _Server:
    """The other process.

    Args:
        known: Addresses of the functions that it can call.
    """

    def __init__(self, known: frozenset[int]) -> None:
        self.call = SHARED.new("WgCall *")
        for prepare in before_start:
            prepare()
        asked, self._ask = os.pipe()
        self._answer, answered = os.pipe()
        self.known = known
        self.chunks = SHARED.chunks
        self.process = int(lib.wg_guard_start(self.call, asked, answered))
        os.close(asked)
        os.close(answered)
        if self.process < 0:
            self._close()
            raise WorldgenError(
                "no-process",
                "the process that would run the controller cannot be started",
                "end some others",
            )
        self._poll = select.poll()
        self._poll.register(self._answer, select.POLLIN)

    def ask(self) -> bool:
        """Begin the call; return False if the process no longer exists."""
        try:
            os.write(self._ask, b"c")
        except BrokenPipeError:
            return False
        return True

    def wait(self, progress: Sequence[Any]) -> None:
        """Wait until the call is done.

        Args:
            progress: Structs that change in each step.

        Raises:
            ControllerDied: If the process ends, or a step does not return.
        """
        seen = [b""]
        began = time.monotonic()
        used = 0.0
        while not self._poll.poll(int(_LOOK * 1000)):
            # Read the clocks before looking for progress, and again after finding some. If this
            # process is delayed in between, that time does not count against the controller.
            waited = time.monotonic() - began
            used_since = lib.wg_guard_seconds(self.process) - used
            now = [bytes(ffi.buffer(one)) for one in progress]
            if now != seen:
                seen = now
                began = time.monotonic()
                used = lib.wg_guard_seconds(self.process)
            elif self._is_stuck(waited, used_since):
                self.end()
                raise ControllerDied(Verdict.HANG, NO_ANSWER, {"deadline": DEADLINE})
        if not os.read(self._answer, 1):
            _, status = os.waitpid(self.process, 0)
            self._close()
            code = os.waitstatus_to_exitcode(status)
            raise ControllerDied(Verdict.CRASH, *how_it_ended(code))

    @staticmethod
    def _is_stuck(waited: float, used: float) -> bool:
        return used >= DEADLINE or waited >= _WAITING

    def end(self) -> None:
        """Kill the process."""
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)
        self._close()

    def _close(self) -> None:
        os.close(self._ask)
        os.close(self._answer)


class _Here:
    """This process's side, with at most one call at a time and at most one other process.

    Attributes:
        known: Addresses of all functions requested so far, which a new process knows from its
            start.
    """

    def __init__(self) -> None:
        self.one_call = threading.RLock()
        self.servers: list[_Server] = []
        self.known: frozenset[int] = frozenset()


_here = _Here()


def call(
    work: Any,
    act: int,
    objects: Sequence[Any],
    number: int,
    *,
    report: Any,
    progress: Sequence[Any] = (),
) -> CallResult:
    """Make a call of a core in the other process.

    Args:
        work: The function, a ``WgWork``.
        act: Address of the controller's function.
        objects: Arguments of the function. They, and everything that they point to, must be in
            :data:`SHARED`.
        number: The function's number argument.
        report: ``WgReport`` of the run under way, which changes in each step.
        progress: Other structs that change as the work progresses.

    Returns:
        The function's result and the controller's error.

    Raises:
        ControllerDied: If the process ended, or a step did not return; the next call starts a new
            process.
    """
    # Describe the call in the shared memory.
    function = int(ffi.cast("uintptr_t", work))
    with _here.one_call:
        server = _server_for(frozenset((function, act)))
        asked = server.call
        asked.work = ffi.cast("WgWork", function)
        for k, one in enumerate(objects):
            asked.objects[k] = ffi.cast("void *", one)
        asked.number = number
        asked.report = ffi.cast("WgReport *", report)
        # Make the call, in a new process if the old one has died.
        if not server.ask():  # The process was ended while it waited.
            renew()
            return call(work, act, objects, number, report=report, progress=progress)
        try:
            server.wait((asked.report, *progress))
        except ControllerDied:
            _here.servers.clear()
            raise
        except BaseException:
            renew()
            raise
        # Copy the controller's message, because the memory is reused.
        error = ffi.string(asked.error).decode("utf-8", "replace") if asked.has_error else ""
        return CallResult(int(asked.result), error)


def _server_for(functions: frozenset[int]) -> _Server:
    """Return a process that knows these functions and all of the shared memory."""
    _here.known |= functions
    if _here.servers:
        server = _here.servers[0]
        if functions <= server.known and server.chunks == SHARED.chunks:
            return server
        renew()
    server = _Server(_here.known)
    _here.servers.append(server)
    return server


def renew() -> None:
    """End the other process.

    The next call forks a new process, in which the library is in its original state, whatever a
    controller did to it.
    """
    with _here.one_call:
        while _here.servers:
            _here.servers.pop().end()


def _forget() -> None:
    """After a fork, leave the other process and the shared memory to the parent."""
    _here.__init__()  # type: ignore[misc] # a lock of the copied process may be held there
    SHARED.__init__()  # type: ignore[misc]


atexit.register(renew)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
