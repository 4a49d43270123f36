"""The studio's limits, in one place.

The server refuses anything above them, and its first message sends them to the page
(``protocol.Limits``). So the page needs no copy of these numbers.
"""

from __future__ import annotations

from fuzz.player import MOST_CELLS
from fuzz.unit.options import CampaignOptions
from sim.options.run import TIME_STEPS
from worldgen.domain import MAX_SIDE

__all__ = ["MAX_SIDE", "MOST_CELLS", "TIME_STEPS"]

MOST_MESSAGE = 32 << 20
"""Bytes of a message to the server: dropped files, or the largest world with its text."""
MOST_FILES = 20
"""Files that can be dropped on the page at once."""
MOST_DROPPED = 16 << 20
"""Bytes of all files that are dropped on the page together."""
MOST_EVENTS = 1_000_000
"""Changes of cells in a world."""
LENGTHS = (0.0001, 10_000)
"""Smallest and largest side of a cell, m: the page writes lengths with nine decimals."""
MOST_ROBOTS = 6
"""Robots at the same time: nobody could distinguish more colours."""
MOST_COMPARED = 12
"""Controllers in a comparison: more columns would not fit on a screen."""
MOST_WORLDS = 500
"""Worlds in a comparison."""
MOST_SEEDS = 1_000
"""Runs of a controller that uses chance, in each cell of a comparison."""
MOST_STEPS = 1_000_000
"""Steps of a run that is played: its recording takes 300 MB."""
MOST_DRIVEN = 20_000
"""Steps of a drive by hand, which is simulated again from the start several times a second: 5
minutes at 15 ms, half a second of work."""
FASTEST_TURN = 20.0
"""The fastest turn that a key can command, rad/s."""
MOST_SECONDS = 7 * 86_400
MOST_UNITS = 1_000_000
MOST_WORKERS = 256


def most(name: str) -> int:
    """Return the largest value of a campaign's option."""
    bounds = CampaignOptions.named(name).bounds
    if bounds is None or bounds.high is None:
        raise ValueError(f"{name} has no largest value")
    return int(bounds.high)
