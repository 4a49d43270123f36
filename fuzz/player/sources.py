"""The scripts and the style of the player as text, for a page that holds everything itself."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

__all__ = ["modules", "player_modules", "style"]


def modules(folder: Traversable, prefix: str) -> dict[str, str]:
    """Return the text of each JavaScript module of a folder under the name that others import it by.

    Args:
        folder: Where the ``.js`` files are.
        prefix: What stands before a file's name in an import, such as ``#report/``.
    """
    parts = sorted(
        (part for part in folder.iterdir() if part.name.endswith(".js")), key=lambda part: part.name
    )
    return {f"{prefix}{part.name}": part.read_text("utf-8") for part in parts}


def player_modules() -> dict[str, str]:
    """Return the modules of the player."""
    return modules(files("fuzz.player") / "page", "#player/")


def style() -> str:
    """Return colours, buttons, and what the player is made of."""
    return (files("fuzz.player") / "page" / "player.css").read_text("utf-8")
