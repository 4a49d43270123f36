"""Robots in one world as a page of their own, to be sent to anybody who has a browser."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from fuzz.player.one_file import one_file

__all__ = ["replay_page"]


def replay_page(title: str, world: dict[str, Any] | None, robots: Sequence[dict[str, Any]]) -> bytes:
    """The page, which needs no network and no other file.

    Args:
        title: Its heading.
        world: Of ``drawn_world``.
        robots: Each with ``name``, ``verdict``, ``words``, ``steps``, ``time``, ``path``, ``collisions``, ``digest``,
            and ``run`` and ``sensors`` as the player draws them.
    """
    folder = files("fuzz.player") / "replay_page"
    body, styles, scripts = ((folder / name).read_text("utf-8") for name in ("body.html", "style.css", "start.js"))
    data = {"title": title, "world": world, "robots": list(robots)}
    return one_file(body, title, styles=styles, scripts=scripts, data=data)
