"""The studio's limits, in one place.

The server refuses anything above them, and its first message sends them to the page. So the page
needs no copy of these numbers, and its fields can show immediately what the server would refuse.
"""

from __future__ import annotations

from typing import Any

from fuzz.player import MOST_CELLS
from fuzz.unit.options import CampaignOptions
from sim.options.run import TIME_STEPS
from worldgen.domain import MASK64, MAX_SIDE

MOST_MESSAGE = 32 << 20
"""Bytes of a message to the server: dropped files, or the largest world with its text."""
MOST_DROPPED = 16 << 20
"""Bytes of all files that are dropped on the page together."""
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
MOST_SECONDS = 7 * 86_400
MOST_UNITS = 1_000_000
MOST_WORKERS = 256


def limits() -> dict[str, Any]:
    """Return every limit that a field of the page needs; ``Limits`` in ``page/types.d.ts``.

    A list holds the smallest and the largest value. The largest seed is text, because a browser's
    numbers cannot hold it.
    """
    return {
        "message": MOST_MESSAGE,
        "dropped": MOST_DROPPED,
        "side": MAX_SIDE,
        "cells": MOST_CELLS,
        "lengths": list(LENGTHS),
        "robots": MOST_ROBOTS,
        "compared": MOST_COMPARED,
        "compared_worlds": MOST_WORLDS,
        "compared_seeds": MOST_SEEDS,
        "steps": MOST_STEPS,
        "time_steps": list(TIME_STEPS),
        "seconds": MOST_SECONDS,
        "units": MOST_UNITS,
        "workers": MOST_WORKERS,
        "examples": _most("examples"),
        "epoch": _most("epoch"),
        "fleet": _most("robots"),
        "seed": str(MASK64),
    }


def _most(name: str) -> int:
    """Return the largest value of a campaign's option."""
    bounds = CampaignOptions.named(name).bounds
    if bounds is None or bounds.high is None:
        raise ValueError(f"{name} has no largest value")
    return int(bounds.high)
