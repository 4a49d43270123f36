"""Makes calls of the core in another process.

So that a controller that crashes or hangs ends a run, not the program. A campaign runs controllers
of shared libraries this way. The other process is forked when it is first needed. It has the
    library loaded and makes whole calls at full speed: a run, or first looks at a thousand worlds.
        Everything that a
call works on is in memory that both processes share (:data:`SHARED`). So when the other one dies,
everything is as it was when the controller was asked, and the run in which that was is known.
``sim/core/wg_guard.h`` is the other side.
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

from sim._core import ffi as _ffi
from sim._core import lib as _lib
from worldgen.errors import WorldgenError

__all__ = [
    "DEADLINE",
    "HANG",
    "PRIVATE",
    "SHARED",
    "CallResult",
    "ControllerDied",
    "CoreMemory",
    "before_start",
    "call",
    "renew",
]

ffi: Any = _ffi
lib: Any = _lib

HANG = "no answer"
"""What is said of a controller whose step does not come back."""

DEADLINE = 1.0
"""s of processor time that a controller can take for a step."""

# S that a step can take on the clock: it may wait for something, or the processors have other work.
_WAITING = 5.0
_LOOK = 0.1  # s between two looks whether the other process gets on; Ctrl-C is heard as often
_CHUNK = 1 << 24  # bytes by which the shared memory grows
_SMALLEST = 64  # bytes of a block: a line of the processor's cache

before_start: list[Callable[[], object]] = []
"""Called before the other process is forked.

They make what it is to find in its copy of this one's memory.
"""


class ControllerDied(Exception):
    """The process that ran the controller has ended.

    Args:
        error: ``killed by SIGSEGV``, ``exit code 3``, or :data:`HANG`.
    """

    def __init__(self, error: str) -> None:
        super().__init__(error)
        self.error = error

    @property
    def is_hang(self) -> bool:
        """Whether a step did not come back."""
        return self.error == HANG


class CallResult(NamedTuple):
    """What a call came back with.

    Args:
        result: What the core's function returned.
        error: What the controller of the last run said is wrong; empty if nothing is.
    """

    result: int
    error: str


class CoreMemory:
    """Where the core's structs and arrays are: here, in memory of this process alone."""

    is_shared = False

    def new(self, kind: str, value: Any = None, ffi: Any = ffi) -> Any:
        """Return a new struct, or several, as ``ffi.new`` does.

        Args:
            kind: ``WgArena *``, ``WgSettings[]``.
            value: What is in it at first; for an array also how many.
            ffi: Of the core that has the struct.
        """
        return ffi.new(kind, value)

    def own(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return an array of the same content in this memory.

        The array itself where it can be seen.
        """
        return array

    def zeros(self, shape: int | tuple[int, ...], kind: Any) -> npt.NDArray[Any]:
        """Return an array of zeros."""
        return np.zeros(shape, kind)


class _SharedMemory(CoreMemory):
    """Memory that this process shares with the one that makes calls.

    It grows, and gives nothing back to the system.
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
        """How often it has grown: a process knows what was there when it was forked."""
        return len(self._chunks)

    def new(self, kind: str, value: Any = None, ffi: Any = ffi) -> Any:
        """As :meth:`Memory.new`."""
        return _allocator(self, ffi, clear=True)(kind, value)

    def block(self, size: int, *, clear: bool) -> Any:
        """Return a block, all zero if it is to be cleared."""
        return _allocator(self, ffi, clear=clear)("char[]", max(size, 1))

    def own(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """As :meth:`Memory.own`."""
        if array.flags.c_contiguous and array.__array_interface__["data"][0] in self._sizes:
            return array
        copy = self._array(array.shape, array.dtype, clear=False)
        copy[...] = array
        return copy

    def zeros(self, shape: int | tuple[int, ...], kind: Any) -> npt.NDArray[Any]:
        """As :meth:`Memory.zeros`."""
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
        """Return the address of a block for cffi, with anything in it."""
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
        """Take a block back; it may be called wherever an object goes, so it takes no lock."""
        address = int(ffi.cast("uintptr_t", block))
        self._free.setdefault(self._sizes[address], []).append(address)


@functools.cache
def _allocator(memory: _SharedMemory, ffi: Any, *, clear: bool) -> Any:
    """Return what makes a core's structs in shared memory."""
    return ffi.new_allocator(memory.take, memory.give_back, should_clear_after_alloc=clear)


PRIVATE = CoreMemory()
"""Memory of this process."""

SHARED = _SharedMemory()
"""Memory for what calls in the other process work on."""


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
                "no process can be started to run the controller in",
                "end some others",
            )
        self._poll = select.poll()
        self._poll.register(self._answer, select.POLLIN)

    def ask(self) -> bool:
        """Begin the call; return whether somebody is there to make it."""
        try:
            os.write(self._ask, b"c")
        except BrokenPipeError:
            return False
        return True

    def wait(self, progress: Sequence[Any]) -> None:
        """Wait until the call is made.

        Args:
            progress: Structs of which something changes in each step.

        Raises:
            ControllerDied: If the process ends, or a step does not come back.
        """
        seen = [b""]
        began = time.monotonic()
        used = 0.0
        while not self._poll.poll(int(_LOOK * 1000)):
            # The clocks are read before the progress, and again after it if there is any: so if
            # this process is kept waiting in between, that time does not count against the
            # controller.
            waited = time.monotonic() - began
            used_since = lib.wg_guard_seconds(self.process) - used
            now = [bytes(ffi.buffer(one)) for one in progress]
            if now != seen:
                seen = now
                began = time.monotonic()
                used = lib.wg_guard_seconds(self.process)
            elif self._is_stuck(waited, used_since):
                self.end()
                raise ControllerDied(HANG)
        if not os.read(self._answer, 1):
            raise ControllerDied(self._how_it_ended())

    @staticmethod
    def _is_stuck(waited: float, used: float) -> bool:
        return used >= DEADLINE or waited >= _WAITING

    def _how_it_ended(self) -> str:
        _, status = os.waitpid(self.process, 0)
        self._close()
        code = os.waitstatus_to_exitcode(status)
        if code >= 0:
            return f"exit code {code}"
        try:
            return f"killed by {signal.Signals(-code).name}"
        except ValueError:
            return f"killed by signal {-code}"

    def end(self) -> None:
        """End the process, whatever it does."""
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)
        self._close()

    def _close(self) -> None:
        os.close(self._ask)
        os.close(self._answer)


class _Here:
    """What this process has of the other one: one call at a time, and one process at most.

    Attributes:
        known: Addresses of all functions asked for so far: a new process knows them from its start.
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
        objects: What the function takes; all of it, and all that it points to, in :data:`SHARED`.
        number: The number that it takes.
        report: ``WgReport`` of the run under way, which changes in each step.
        progress: What else changes as the work goes on.

    Raises:
        ControllerDied: If the process ended, or a step did not come back; the next call has a new
            one.
    """
    function = int(ffi.cast("uintptr_t", work))
    with _here.one_call:
        server = _server_for(frozenset((function, act)))
        asked = server.call
        asked.work = ffi.cast("WgWork", function)
        for k, one in enumerate(objects):
            asked.objects[k] = ffi.cast("void *", one)
        asked.number = number
        asked.report = ffi.cast("WgReport *", report)
        if not server.ask():  # somebody has ended it while it waited
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
        error = ffi.string(asked.error).decode("utf-8", "replace") if asked.has_error else ""
        return CallResult(int(asked.result), error)


def _server_for(functions: frozenset[int]) -> _Server:
    """Return a process that knows these functions, and all of the shared memory."""
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

    The next call finds the library as it was loaded, whatever a controller did to it.
    """
    with _here.one_call:
        while _here.servers:
            _here.servers.pop().end()


def _forget() -> None:
    """Leave the other process, and what it shares, to the process of which this one is a copy."""
    _here.__init__()  # type: ignore[misc] # a lock of the copied process may be held there
    SHARED.__init__()  # type: ignore[misc]


atexit.register(renew)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
