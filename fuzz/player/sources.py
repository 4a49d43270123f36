"""The player's scripts and style as text, for a page that holds everything itself."""

from __future__ import annotations

import re
from importlib.resources import files

__all__ = ["script", "style"]

_IMPORT = re.compile(r"^import\b[^;]*;\n", re.MULTILINE)
_EXPORT = re.compile(r"^export (?=async |function |const |class )", re.MULTILINE)


def script() -> str:
    """All modules of the player in one scope: without their imports and exports, for no name is there twice."""
    folder = files("fuzz.player") / "page"
    names = sorted(part.name for part in folder.iterdir() if part.name.endswith(".js"))
    parts = ((folder / name).read_text("utf-8") for name in names)
    return "\n".join(_EXPORT.sub("", _IMPORT.sub("", part)) for part in parts)


def style() -> str:
    """Colours, buttons, and what the player is made of."""
    return (files("fuzz.player") / "page" / "player.css").read_text("utf-8")
