"""Whether controllers of shared libraries run in another process.

In campaigns, where a crash is a verdict.
"""

from __future__ import annotations

import os

__all__ = ["contain", "is_contained"]

_contained: list[bool] = []


def contain() -> None:
    """From now on run controllers of shared libraries in another process, where the system can fork one."""
    if os.name == "posix" and not _contained:
        _contained.append(True)


def is_contained() -> bool:
    """Return whether controllers of shared libraries run in another process."""
    return bool(_contained)
