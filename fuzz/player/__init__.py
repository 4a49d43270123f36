"""The player: a world and runs in it, packed for a browser, and the scripts that draw and play them.

The report carries it inside its one file, the studio serves it. ``page/`` holds its JavaScript
modules and its style.

Contents:
    drawn_world, drawn_run: a world, a run, as the scripts want them (``worlds``, ``runs``,
        ``streams``).
    sensors_of: which beams and signal are drawn with a run.
    one_file: a page that holds everything itself, the player's script and style among it.
    replay_page: such a page of robots in one world.
"""

from fuzz.player.one_file import one_file
from fuzz.player.replay import replay_page
from fuzz.player.runs import drawn_run
from fuzz.player.sensors import sensors_of
from fuzz.player.worlds import MOST_CELLS, drawn_world

__all__ = ["MOST_CELLS", "drawn_run", "drawn_world", "one_file", "replay_page", "sensors_of"]
