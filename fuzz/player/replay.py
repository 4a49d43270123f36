"""Robots in one world as a self-contained page that can be sent to anyone with a browser."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from fuzz.player.one_file import one_file
from fuzz.player.sources import modules

__all__ = ["replay_page"]


def replay_page(
    title: str, world: dict[str, Any] | None, robots: Sequence[dict[str, Any]]
) -> bytes:
    """Return the page, which needs no network and no other file.

    Args:
        title: Heading.
        world: Result of ``drawn_world``.
        robots: Each with ``name``, ``verdict``, ``why``, ``steps``, ``time``, ``path``,
            ``collisions``, ``digest``, and ``run`` and ``sensors`` as the player draws them.
    """
    folder = files("fuzz.player") / "replay_page"
    body = (folder / "body.html").read_text("utf-8")
    styles = (folder / "style.css").read_text("utf-8")
    scripts = modules(folder, "#replay/")
    data = {"title": title, "world": world, "robots": list(robots)}
    return one_file(
        body, title, styles=styles, scripts=scripts, start="#replay/start.js", data=data
    )
