"""Show an episode in a notebook: the interactive player, in a frame of its own."""

from __future__ import annotations

import html

from fuzz.player.one_file import replay_page
from fuzz.player.runs import drawn_robots, sensors_of
from fuzz.player.worlds import drawn_world
from sim.outcome import Episode, Ran

_HEIGHT = 640  # pixels of the frame; it scrolls


class Shown:
    """A page that a notebook shows, such as Jupyter's or that of an editor.

    The page is in a frame that may run its own scripts but has no access to the notebook.

    Args:
        page: The page, in one file.
        title: Name of the frame.
    """

    def __init__(self, page: bytes, title: str) -> None:
        self.page = page
        self.title = title

    def _repr_html_(self) -> str:
        """Return the frame."""
        return (
            f'<iframe srcdoc="{html.escape(self.page.decode("utf-8"))}" '
            f'title="{html.escape(self.title)}" sandbox="allow-scripts allow-downloads" '
            f'style="width: 100%; height: {_HEIGHT}px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<{self.title}: shown in a notebook>"


def show(episode: Episode, ran: Ran) -> Shown:
    """Return the player of an episode's run.

    Args:
        episode: The episode, recorded.
        ran: What was run.
    """
    side = ran.world.cell_size
    robots = [
        {
            "name": str(ran.name),
            "verdict": episode.verdict,
            "why": "",
            "steps": episode.steps,
            "time": episode.time,
            "path": episode.path_length,
            "collisions": episode.collisions,
            "digest": episode.trace_digest,
            "sensors": sensors_of(ran.controller, ran.options, side),
            **drawn_robots(
                episode, side, motion=ran.options.motion_model(), controller=ran.controller
            ),
        }
    ]
    title = f"{ran.name}: {episode.verdict}"
    return Shown(replay_page(title, drawn_world(ran.world), robots), title)
