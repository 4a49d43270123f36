"""Draw frames of an episode, with the code that draws all pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.render import EventMark, Trail, draw_terminal
from worldgen.world import World

__all__ = ["RENDER_MODES", "check_render_mode", "frame_of"]

RENDER_MODES = ("rgb_array", "ansi")
# Pixels along the longer side of a map, and characters along a line of text.
_PIXELS = 480
_COLUMNS = 200


def check_render_mode(mode: object) -> str | None:
    """Return a render mode after checking it; ``None`` for no pictures.

    Raises:
        InvalidParameter: If it is unknown.
    """
    if mode is None or mode in RENDER_MODES:
        return None if mode is None else str(mode)
    raise InvalidParameter(
        "unknown-name",
        "render_mode={render_mode!r} is unknown",
        "the modes are {known!l}, and None",
        render_mode=mode,
        known=list(RENDER_MODES),
    )


Points = Sequence[tuple[float, float]]


def frame_of(world: World, places: Sequence[Points], mode: str) -> Any:
    """Return a frame: (height, width, 3) uint8 for ``rgb_array``, text for ``ansi``.

    Args:
        world: The world of the episode.
        places: Positions of each robot so far, m, the latest one last.
        mode: One of :data:`RENDER_MODES`.
    """
    trails = [_trail(one) for one in places]

    if mode == "ansi":
        return draw_terminal(world, trail=trails[0], width=_COLUMNS, color=False)
    from worldgen.render.png import draw_parts
    from worldgen.render.scene import compose

    scene = compose(world, trails, signal=True, witness=False, title="", pixels=_PIXELS)
    return np.array(draw_parts(scene.primitives, scene.frame, (scene.width, scene.height)))


def _trail(places: Points) -> Trail:
    x, y = np.array(places, np.float64).T
    return Trail(x, y, None, [EventMark(float(x[-1]), float(y[-1]), "end")])
