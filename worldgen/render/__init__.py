"""Pictures of worlds and runs: PNG, SVG, HTML, animated GIF and the terminal.

Contents, each imported when it is first used, so that Pillow is loaded only for a PNG:
    Trail, EventMark, WallPenetration: What a robot did, as plain data to draw over a world.
    draw_png, draw_svg, draw_html, draw_terminal: The pictures.
    Drive, draw_gif: Moving robots, as an animated GIF.
    Panel, draw_sheet: Many worlds with the paths of several robots.
    wants_color: Whether a stream should get colours.
    Frame: Converts metres to pixels, for drawing over a picture or reading one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from worldgen.render.animation import draw_gif
    from worldgen.render.frame import Frame
    from worldgen.render.html import draw_html
    from worldgen.render.overlay import Drive, EventMark, Trail, WallPenetration
    from worldgen.render.png import draw_png
    from worldgen.render.sheet import Panel, draw_sheet
    from worldgen.render.svg import draw_svg
    from worldgen.render.terminal import draw_terminal, wants_color

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "animation": ("draw_gif",),
        "frame": ("Frame",),
        "html": ("draw_html",),
        "overlay": ("Drive", "EventMark", "WallPenetration", "Trail"),
        "png": ("draw_png",),
        "sheet": ("Panel", "draw_sheet"),
        "svg": ("draw_svg",),
        "terminal": ("draw_terminal", "wants_color"),
    },
)

__all__ = [
    "Drive",
    "EventMark",
    "Frame",
    "Panel",
    "Trail",
    "WallPenetration",
    "draw_gif",
    "draw_html",
    "draw_png",
    "draw_sheet",
    "draw_svg",
    "draw_terminal",
    "wants_color",
]
