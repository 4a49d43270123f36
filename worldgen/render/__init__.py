"""Pictures of worlds and runs: PNG, SVG, HTML, animated GIF and the terminal.

Contents, each imported when it is first used, so that Pillow loads for a PNG only:
    Trail, Mark: what a robot did, as plain data to draw over a world.
    draw_png, draw_svg, draw_html, draw_terminal: the pictures.
    Drive, draw_gif: robots that drive, as an animated GIF.
    Panel, draw_sheet: many worlds with the ways of several robots.
    wants_color: whether a stream should get colours.
    Frame: metres to pixels, for those who draw over a picture or read one.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from worldgen.render.animation import draw_gif
    from worldgen.render.frame import Frame
    from worldgen.render.html import draw_html
    from worldgen.render.overlay import Drive, Mark, Pierced, Trail
    from worldgen.render.png import draw_png
    from worldgen.render.sheet import Panel, draw_sheet
    from worldgen.render.svg import draw_svg
    from worldgen.render.terminal import draw_terminal, wants_color

_HOME = {
    "Drive": "overlay",
    "Frame": "frame",
    "Mark": "overlay",
    "Panel": "sheet",
    "Pierced": "overlay",
    "Trail": "overlay",
    "draw_gif": "animation",
    "draw_html": "html",
    "draw_png": "png",
    "draw_sheet": "sheet",
    "draw_svg": "svg",
    "draw_terminal": "terminal",
    "wants_color": "terminal",
}

__all__ = [
    "Drive",
    "Frame",
    "Mark",
    "Panel",
    "Pierced",
    "Trail",
    "draw_gif",
    "draw_html",
    "draw_png",
    "draw_sheet",
    "draw_svg",
    "draw_terminal",
    "wants_color",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'worldgen.render' has no attribute {name!r}")
    return getattr(importlib.import_module(f"worldgen.render.{_HOME[name]}"), name)
