"""Keeps a file for one process at a time, however that process ends."""

from __future__ import annotations

try:
    import fcntl
except ImportError:  # Windows, where nothing keeps a second command out
    fcntl = None  # type: ignore[assignment]

__all__ = ["lock"]


def lock(descriptor: int) -> bool:
    """Keeps an open file from every other process that asks, until it is closed or this process ends, killed maybe.

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
