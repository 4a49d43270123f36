"""Runs a controller of a shared library in a process of its own, so that its crash ends a run and not the program.

``sim/core/controllers/guard.h`` says how the two processes hand a step over. ``python -m sim.guarded FD BYTES NAME`` is
the other one.
"""

from __future__ import annotations

import atexit
import functools
import mmap
import os
import signal
import subprocess
import sys
import tempfile
import time
from typing import Any

from sim._core import ffi as _ffi
from sim._core import lib as _lib
from sim.shared_object import info_of
from worldgen.errors import InvalidParameter

__all__ = ["guarded_address"]

ffi: Any = _ffi
lib: Any = _lib

_TO_START = 30.0  # s in which a library must be loaded
_LOOK = 0.002  # s between two looks whether it is

_open: list[Any] = []  # guards of this process: slots are places in it


def guarded_address(name: str, memory_size: int) -> int:
    """Return the address of a ``WgAct`` that has the controller run in another process, which is started if need be.

    Args:
        name: ``lib:./robot.so:act``.
        memory_size: Numbers of its memory.

    Raises:
        InvalidParameter: If it cannot be started, or there are too many.
    """
    return _guarded_address(name, memory_size, os.getpid())


@functools.cache
def _guarded_address(name: str, memory_size: int, owner: int) -> int:
    if len(_open) == lib.WG_GUARDS:
        raise InvalidParameter(
            "too-many",
            "controller {name!r}: a campaign runs at most {most} shared controllers",
            "compare fewer",
            name=name,
            most=lib.WG_GUARDS,
        )
    size = int(lib.wg_guard_bytes(memory_size))
    with tempfile.TemporaryFile() as file:
        file.truncate(size)
        shared = mmap.mmap(file.fileno(), size)
        guard = _guard_in(shared)
        slot = len(_open)
        lib.wg_guard_open(guard, slot, memory_size, owner)
        program = [sys.executable, "-P", "-m", "sim.guarded", str(file.fileno()), str(size), name]
        server = subprocess.Popen(
            program,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=(file.fileno(),),
            start_new_session=True,  # Ctrl-C is ours
        )
    _open.append((shared, guard, server))
    atexit.register(_end, guard, server)
    _wait_until_ready(name, guard, server)
    return int(ffi.cast("uintptr_t", lib.wg_guarded_act(slot)))


def _guard_in(shared: mmap.mmap) -> Any:
    """Return the guard at the start of shared memory, which must outlive it."""
    return ffi.cast("WgGuard *", ffi.from_buffer("char[]", shared, require_writable=True))


def _wait_until_ready(name: str, guard: Any, server: subprocess.Popen[bytes]) -> None:
    """Wait until a worker waits for its first step.

    Raises:
        InvalidParameter: If the process ends instead, or takes too long.
    """
    until = time.monotonic() + _TO_START
    while not lib.wg_guard_is_ready(guard):
        code = server.poll()
        if code is not None:
            how = f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
            raise InvalidParameter(
                "ended-while-loading",
                "controller {name!r}: its process ended while it was loaded ({how})",
                "run it alone",
                name=name,
                how=how,
            )
        if time.monotonic() > until:
            server.kill()
            raise InvalidParameter(
                "slow-to-load",
                "controller {name!r} is not loaded after {seconds:g} s",
                "look at its constructors",
                name=name,
                seconds=_TO_START,
            )
        time.sleep(_LOOK)


def _end(guard: Any, server: subprocess.Popen[bytes]) -> None:
    """End the server and its worker."""
    server.kill()
    server.wait()
    lib.wg_guard_end(guard)


def main() -> None:
    """Serve a guard until its owner is gone."""
    descriptor = int(sys.argv[1])
    size = int(sys.argv[2])
    name = sys.argv[3]
    shared = mmap.mmap(descriptor, size)
    os.close(descriptor)
    lib.wg_guard_serve(_guard_in(shared), info_of(name).act)


if __name__ == "__main__":
    main()
