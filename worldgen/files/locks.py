"""Lock a file for one process at a time; the lock ends with the process, however it ends."""

from __future__ import annotations

import contextlib
import os
import socket
from pathlib import Path

try:
    import fcntl
# On Windows, nothing locks out a second command.
except ImportError:
    fcntl = None  # type: ignore[assignment]

# Bytes of a locked file's contents.
_LONGEST = 400


def lock(descriptor: int) -> bool:
    """Lock an open file against other processes until it is closed or this process ends.

    On another host, the lock only holds if the file system supports that, as NFS 4 does.

    Returns:
        True if the lock is ours; False if another process has it.
    """
    if fcntl is not None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


def sign(descriptor: int) -> None:
    """Write our process into a locked file that contains nothing else.

    :func:`holder` reads it.
    """
    if fcntl is not None:
        # The disk is full, so nobody can find out which process it is.
        with contextlib.suppress(OSError):
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"{os.getpid()} {socket.gethostname()}\n".encode(), 0)


def holder(path: Path) -> int | None:
    """Return the process of this machine that holds a signed file.

    Return ``None`` if there is none, or it cannot be determined here.
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
                # This frees an abandoned file for a process that wants it.
                os.kill(int(number), 0)
                fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return int(number)
        except OSError:
            return None
    return None
