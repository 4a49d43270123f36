"""Read the player's scripts and style as text, for a self-contained page."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

__all__ = ["modules", "player_modules", "style"]


def modules(folder: Traversable, prefix: str) -> dict[str, str]:
    """Return the text of each JavaScript module in and below a folder, by the name used in imports.

    Args:
        folder: Folder of the ``.js`` files.
        prefix: Prefix of a file's name in imports, such as ``#report/``.
    """
    found: dict[str, str] = {}
    for part in sorted(folder.iterdir(), key=lambda part: part.name):
        if part.is_dir():
            found |= modules(part, f"{prefix}{part.name}/")
        elif part.name.endswith(".js"):
            found[f"{prefix}{part.name}"] = part.read_text("utf-8")
    return found


def player_modules() -> dict[str, str]:
    """Return the player's modules."""
    return modules(files("fuzz.player") / "page", "#player/")


def style() -> str:
    """Return the player's style, which includes colours and buttons."""
    return (files("fuzz.player") / "page" / "player.css").read_text("utf-8")
