"""The player: a world and runs in it, packed for a browser, and the scripts that draw and play them.

The report carries it inside its one file, the studio serves it. ``page/`` holds its JavaScript modules and its style.

Contents:
    drawn_world, drawn_run: a world, a run, as the scripts want them (``worlds``, ``runs``, ``streams``).
    sensors_of: which beams and signal are drawn with a run.
    script, style: the page's parts, for pages that hold everything themselves.
"""

from fuzz.player.runs import drawn_run
from fuzz.player.sensors import sensors_of
from fuzz.player.sources import script, style
from fuzz.player.worlds import MOST_CELLS, drawn_world

__all__ = ["MOST_CELLS", "drawn_run", "drawn_world", "script", "sensors_of", "style"]
