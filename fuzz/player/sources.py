"""Read the player's scripts and style as text, for a self-contained page."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

__all__ = ["modules", "player_modules", "style"]


def modules(folder: Traversable, prefix: str) -> dict[str, str]:
    """Return the text of each JavaScript module of a folder, by the name used in imports.

    Args:
        folder: Folder of the ``.js`` files.
        prefix: Prefix of a file's name in imports, such as ``#report/``.
    """
    parts = sorted(
        (part for part in folder.iterdir() if part.name.endswith(".js")), key=lambda part: part.name
    )
    return {f"{prefix}{part.name}": part.read_text("utf-8") for part in parts}


def player_modules() -> dict[str, str]:
    """Return the player's modules."""
    return modules(files("fuzz.player") / "page", "#player/")


def style() -> str:
    """Return the player's style, which includes colours and buttons."""
    return (files("fuzz.player") / "page" / "player.css").read_text("utf-8")
