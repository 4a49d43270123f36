"""Run a compiled controller portion by portion, holding the states of only one portion.

The states of a run that is too long to hold them all are restored this way whenever they are
needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from sim._core import lib
from sim.controllers.base import CompiledController
from sim.runners.core_calls import CoreArena, CoreEpisode, Driver, copy_of, most_points
from worldgen.support.arrays import Ints

MOST_HELD = 1 << 26
"""Bytes of states. A run that needs less is recorded in whole."""

# Rows of a portion.
_MOST_ROWS = 1 << 16


class Portion(NamedTuple):
    """Some consecutive steps of a run; the next portion overwrites its arrays.

    Args:
        first: Number of the first of these steps; the start is step 0.
        rows: (n, 1 + words) int64, whether a wall was touched, then the state.
        path: (m, 4) int64, WgPathPoint; a fifth column for a body or a car has the headings.
    """

    first: int
    rows: Ints
    path: Ints


def portions(
    controller: CompiledController, arena: CoreArena, settings: Any, steps: int
) -> Iterator[Portion]:
    """Yield the portions of a run, from its start to a step that it is known to reach.

    Args:
        controller: The controller.
        arena: The world before the first event; it is changed.
        settings: WgSettings, without a search for a recurrence.
        steps: How many steps to run.
    """
    # A portion takes at most a quarter of the limit, because recordings are copied and viewed.
    memory = arena.memory
    settings = copy_of(settings, memory)
    settings.digest = 0
    settings.steps = steps
    driver = Driver(controller, controller.memory, settings)
    episode = CoreEpisode(arena, settings, driver)
    width = 1 + episode.words
    most = min(_MOST_ROWS, max(1, MOST_HELD // 4 // (8 * width)))
    rows = memory.zeros((min(most, steps) + 1, width), np.int64)
    path = memory.zeros((most_points(arena, settings, len(rows)), 4), np.int64)
    rows[0, 1:] = episode.state_words()
    yield Portion(0, rows[:1], path[:0])
    # The next portion overwrites the arrays of this one.
    while not episode.c.over:
        done = int(episode.report.steps)
        points = int(episode.report.points)
        episode.record(rows[: min(most, steps - done)], path)
        episode.run(most)
        count = int(episode.report.steps) - done
        points = int(episode.report.points) - points
        if episode.report.ending == lib.WG_CRASH:
            count -= 1  # The failed step is not part of the recording.
            points -= int(episode.c.robot.corners)
        yield Portion(done + 1, rows[:count], episode.with_headings(path)[:points])
