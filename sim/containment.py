"""Decide whether controllers from shared libraries run in their own process.

Campaigns turn this on, so that a crash of the controller is a verdict and does not end the
campaign.
"""

from __future__ import annotations

import os

_contained: list[bool] = []


def contain() -> None:
    """Run controllers from shared libraries in another process, if the system can fork one."""
    if os.name == "posix" and not _contained:
        _contained.append(True)


def is_contained() -> bool:
    """Return True if controllers from shared libraries run in another process."""
    return bool(_contained)
