"""What every part of the answers is made of.

The opened folder, and the controllers that may run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzz.studio.folder import Folder

__all__ = ["Opened"]


@dataclass(frozen=True)
class Opened:
    """What was opened when the studio was started.

    Args:
        folder: What can be read and written.
        named: Controllers that were named at the start, beside the registered ones.
    """

    folder: Folder
    named: Sequence[str] = ()
