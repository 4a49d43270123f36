"""Lines that are copied from the page and pasted at a terminal, wherever that stands."""

from __future__ import annotations

import shlex
from pathlib import Path

__all__ = ["from_anywhere"]


def from_anywhere(line: str, code: str, registered: list[str]) -> str:
    """A line that needs code.

    That of a file may be named as seen from the folder in which the studio was started.

    Args:
        line: The command, in a shell's words.
        code: What it needs, with variations if it has some; empty for nothing.
        registered: Names that mean the same everywhere.
    """
    if code in ("", *registered) or any(code.startswith(f"{name}+") for name in registered):
        return line
    return f"cd {shlex.quote(str(Path.cwd()))} && {line}"
