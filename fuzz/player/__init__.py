"""The player: packs a world and runs for a browser, with the scripts that draw and play them.

A report embeds it in its single file, and the studio serves it. ``page/`` holds its JavaScript
modules and its style.

Contents:
    drawn_world, drawn_run: A world and a run in the form that the scripts expect (``worlds``,
        ``runs``, ``streams``).
    drawn_robots: The same of a run of one robot or several, with the colours of each.
    sensors_of: The beams and the signal to draw with a run.
    one_file: Builds a self-contained page that includes the player's scripts and style.
    replay_page: Such a page of robots in one world.

``notebook`` shows such a page in a notebook, for ``Episode.show``.
"""

from fuzz.player.one_file import one_file, replay_page
from fuzz.player.runs import drawn_robots, drawn_run, sensors_of
from fuzz.player.worlds import MOST_CELLS, drawn_world

__all__ = [
    "MOST_CELLS",
    "drawn_robots",
    "drawn_run",
    "drawn_world",
    "one_file",
    "replay_page",
    "sensors_of",
]
