"""Keeps a file for one process at a time, however that process ends."""

from __future__ import annotations

import contextlib
import os
import socket
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows, where nothing keeps a second command out
    fcntl = None  # type: ignore[assignment]

__all__ = ["holder", "lock", "sign"]

_LONGEST = 400  # bytes of what a locked file says


def lock(descriptor: int) -> bool:
    """Lock an open file against other processes until it is closed or this process ends.

    On another host it is kept only as far as the file system carries locks there, as NFS 4 does.

    Returns:
        Whether it is ours; not if another process has it.
    """
    if fcntl is not None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


def sign(descriptor: int) -> None:
    """Write into a file that is ours, and that holds nothing else, which process has it.

    :func:`holder` reads it.
    """
    if fcntl is not None:
        with contextlib.suppress(OSError):  # a full disk: then nobody is told whose it is
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"{os.getpid()} {socket.gethostname()}\n".encode(), 0)


def holder(path: Path) -> int | None:
    """Return the process of this machine that keeps a signed file.

    ``None`` if none does, or that cannot be known here.
    """
    if fcntl is not None:
        try:
            with path.open("rb") as stream:
                number, _, host = (
                    stream.read(_LONGEST).decode("ascii", "replace").strip().partition(" ")
                )
                if (
                    host != socket.gethostname()
                    or not number.isdecimal()
                    or not 1 < int(number) < 1 << 31
                ):
                    return None
                os.kill(
                    int(number), 0
                )  # so that a file that nobody has is not kept from a process that wants it
                fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return int(number)
        except OSError:
            return None
    return None
