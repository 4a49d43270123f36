"""Make calls of the core in another process, so that a controller can crash without harm.

A controller that crashes or hangs then ends a run, not the program. Controllers from shared
libraries always run this way where the system can fork. The other process is forked when it is
first needed. It has the library loaded and makes whole calls at full speed, such as a run, or
screening runs in a thousand worlds. Everything that a call works on is in memory that both
processes share (:data:`SHARED`). If the other process dies, the memory is in the state of the last
call of the controller, and shows which run it was. ``sim/core/runs/wg_guard.h`` is the other side.

Threads that make calls at the same time have a process each.
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
from collections.abc import Callable, Collection, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.controller_error import NO_ANSWER, ControllerError, how_it_ended
from sim.verdict import Verdict
from worldgen.errors import WorldgenError

can_fork = hasattr(os, "fork") and os.environ.get("WORLDGEN_DEBUG") != "debugger"
"""Whether calls are made in another process; a debugger needs them in its own."""

DEADLINE = 1.0
"""Processor time that a controller may take for a step, s."""

# Wall-clock seconds that a step may take, if it waits or the processors are busy elsewhere.
_WAITING = 5.0

# Seconds between two checks of the other process's progress, and for Ctrl-C.
_LOOK = 0.1

# Seconds that the process may take to end after it has closed its pipe.
_ENDING = 5.0

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


class Confined(Protocol):
    """The memory of a function from a library: :class:`sim.controllers.shared.cage.Cage`."""

    def misuse(self, address: int) -> str:
        """Return what the function did if an address could not be used; empty if not its fault."""
        ...


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
        self._other_pages = 0
        self._next = 0
        self._end = 0
        self._sizes: dict[int, int] = {}
        self._free: dict[int, list[int]] = {}
        self._lock = threading.Lock()

    @property
    def chunks(self) -> int:
        """How many times it has grown; a process only knows chunks from before it was forked."""
        return len(self._chunks) + self._other_pages

    def note_pages(self) -> None:
        """Count shared pages that were mapped elsewhere."""
        with self._lock:
            self._other_pages += 1

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
        self.era = _here.era
        self.is_open = True
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

    def wait(self, progress: Sequence[Any], cages: Sequence[Confined]) -> None:
        """Wait until the call is done.

        Args:
            progress: Structs that change in each step.
            cages: Where the controllers act.

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
                raise _hang()
        if not os.read(self._answer, 1):
            self._bury(cages)

    def _bury(self, cages: Sequence[Confined]) -> None:
        """Wait for a process that has closed its pipe, and raise its error if it ended too early.

        A controller may close the pipe, and then do its work, or never end.
        """
        until = time.monotonic() + _ENDING
        process, status = os.waitpid(self.process, os.WNOHANG)
        while not process:
            if time.monotonic() > until:
                self.end()
                raise _hang()
            time.sleep(_LOOK / 100)
            process, status = os.waitpid(self.process, os.WNOHANG)
        self._close()
        if self.call.done:
            return
        error, facts = how_it_ended(os.waitstatus_to_exitcode(status))
        fault = int(self.call.fault)
        misuse = next(filter(None, (cage.misuse(fault) for cage in cages)), "") if fault else ""
        raise ControllerDied(Verdict.CRASH, misuse or error, facts)

    @staticmethod
    def _is_stuck(waited: float, used: float) -> bool:
        return used >= DEADLINE or waited >= _WAITING

    def end(self) -> None:
        """Kill the process, unless it has ended."""
        if self.is_open:
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)
            self._close()

    def _close(self) -> None:
        self.is_open = False
        os.close(self._ask)
        os.close(self._answer)


def _hang() -> ControllerDied:
    return ControllerDied(Verdict.HANG, NO_ANSWER, {"deadline": DEADLINE})


class _Here:
    """This process's side.

    Attributes:
        lock: Held while a process is started or chosen. Two that start at the same time would
            inherit each other's ends of the pipes, and their deaths would go unnoticed.
        servers: Processes that wait for a call.
        known: Addresses of all functions requested so far, which a new process knows from its
            start.
        era: How many times all processes were ended; one that was busy then ends after its call.
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.servers: list[_Server] = []
        self.known: frozenset[int] = frozenset()
        self.era = 0


_here = _Here()


def call(
    work: Any,
    acts: Collection[int],
    objects: Sequence[Any],
    number: int = 0,
    *,
    progress: Sequence[Any] = (),
    cages: Sequence[Confined] = (),
) -> int:
    """Make a call of a core in another process.

    Args:
        work: The function, a ``WgWork``.
        acts: Addresses of the controllers' functions.
        objects: Arguments of the function. They, and everything that they point to, must be in
            :data:`SHARED`.
        number: The function's number argument.
        progress: Structs that change as the work progresses, one of them in each step.
        cages: Where the controllers act.

    Returns:
        The function's result.

    Raises:
        ControllerDied: If the process ended, or a step did not return; the next call starts a new
            process.
    """
    function = int(ffi.cast("uintptr_t", work))
    while True:
        server = _taken_server(frozenset((function, *acts)))
        # Describe the call in the shared memory.
        asked = server.call
        asked.work = ffi.cast("WgWork", function)
        for k, one in enumerate(objects):
            asked.objects[k] = ffi.cast("void *", one)
        asked.number = number
        asked.done = 0
        if server.ask():
            break
        server.end()  # it was ended while it waited
    # Wait for the result; a server that did not give one is of no more use.
    try:
        server.wait(progress, cages)
    except ControllerDied:
        raise
    except BaseException:
        server.end()
        raise
    result = int(asked.result)
    with _here.lock:
        if server.era == _here.era and server.is_open:
            _here.servers.append(server)
            return result
    server.end()
    return result


def _taken_server(functions: frozenset[int]) -> _Server:
    """Return a process that waits, and knows these functions and all of the shared memory."""
    with _here.lock:
        _here.known |= functions
        while _here.servers:
            server = _here.servers.pop()
            if functions <= server.known and server.chunks == SHARED.chunks:
                return server
            server.end()
        return _Server(_here.known)


def renew() -> None:
    """End the other processes.

    The next call forks a new process, in which the library is in its original state, whatever a
    controller did to it.
    """
    with _here.lock:
        _here.era += 1
        while _here.servers:
            _here.servers.pop().end()


def _forget() -> None:
    """After a fork, leave the other process and the shared memory to the parent."""
    _here.__init__()  # type: ignore[misc] # a lock of the copied process may be held there
    SHARED.__init__()  # type: ignore[misc]


atexit.register(renew)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
