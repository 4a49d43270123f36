"""Commands that are copied from the page and pasted at a terminal in any folder."""

from __future__ import annotations

import shlex
from pathlib import Path

__all__ = ["from_anywhere"]


def from_anywhere(line: str, code: str, registered: list[str]) -> str:
    """Return a command that also works in another folder.

    Code in a file may be named relative to the folder in which the studio was started.

    Args:
        line: The command, quoted for a shell.
        code: The controller that it needs, possibly with variations; empty if there is none.
        registered: Names that mean the same everywhere.
    """
    if code in ("", *registered) or any(code.startswith(f"{name}+") for name in registered):
        return line
    return f"cd {shlex.quote(str(Path.cwd()))} && {line}"
