"""The base of all answers: the opened folder, and the controllers that may run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzz.studio.folder import Folder

__all__ = ["Opened"]


@dataclass(frozen=True)
class Opened:
    """The folder and the controllers with which the studio was started.

    Args:
        folder: The folder that can be read and written.
        named: Controllers that were named at the start, in addition to the registered ones.
    """

    folder: Folder
    named: Sequence[str] = ()
