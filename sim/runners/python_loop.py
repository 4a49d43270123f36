"""The episode loop for a Python controller or a program.

The core stops in each step to let the controller act.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from sim._core import ffi, lib
from sim.controllers.answers import AnswersDiffer
from sim.controllers.controller_error import ControllerError
from sim.controllers.hidden_state import HiddenState
from sim.options.run import RunOptions
from sim.runners.controller_host import ControllerHost, Faults
from sim.runners.core_calls import CoreArena, CoreEpisode, most_points
from sim.runners.python_act import Stops
from worldgen.support.arrays import Ints
from worldgen.support.progress import working
from worldgen.support.results import only_results_on_stdout
from worldgen.world import World


class PythonRun(NamedTuple):
    """An episode that is over.

    Args:
        episode: The core's episode; ``None`` if the controller failed in ``reset``.
        recording: The states as rows, and the points of the path, as the core writes them; ``None``
            if there is no episode, or it was not recorded.
        complete: Whether all of the controller's state was in its memory.
        fault: The controller's fault, if any.
    """

    episode: CoreEpisode | None
    recording: tuple[Ints, Ints] | None
    complete: bool
    fault: ControllerError | None


def run_in_python(
    host: ControllerHost,
    arena: Callable[[], CoreArena],
    settings: Any,
    world: World,
    options: RunOptions,
    *,
    record: bool,
    watches: int | None = None,
) -> PythonRun:
    """Run an episode; whatever the controller raises ends it as a crash.

    The controller's prints go to stderr, so that stdout stays data.

    Args:
        host: The controller's host.
        arena: Returns the surroundings at the start.
        settings: WgSettings, as for a compiled controller.
        world: The world, for a controller that plans first.
        options: Options of the run.
        record: Whether to keep every state.
        watches: See :meth:`ControllerHost.freezing`.
    """
    while True:
        with contextlib.suppress(AnswersDiffer):
            return _run(host, arena(), settings, world, options, record=record, watches=watches)


def _run(
    host: ControllerHost,
    arena: CoreArena,
    settings: Any,
    world: World,
    options: RunOptions,
    *,
    record: bool,
    watches: int | None,
) -> PythonRun:
    episode: CoreEpisode | None = None
    rows = path = np.zeros((0, 1), np.int64)
    begun: HiddenState | None = None
    fault: ControllerError | None = None
    host.start()
    with only_results_on_stdout(), host.freezing(options, watches=watches):
        try:
            with Faults(host), working("running the controller", often=True) as work:
                memory = host.begin(world)
                begun = host.hidden()
                episode = CoreEpisode(arena, settings, host.driver(memory, settings))
                if record:
                    steps = int(settings.steps)
                    rows = np.zeros((steps + 1, 1 + episode.words), np.int64)
                    path = np.zeros((most_points(arena, settings, steps), 4), np.int64)
                    rows[0, 1:] = episode.state_words()
                    episode.record(rows[1:], path)
                report = episode.report
                work.say(lambda: f"step {report.steps:,} of at most {settings.steps:,}")
                stops = Stops(ffi, lib, "wg_episode", episode.c, episode)
                host.drive(stops, memory)
        except ControllerError as error:
            fault = error
        complete = begun is not None and host.is_unchanged(begun)
    if episode is None or not len(rows):
        return PythonRun(episode, None, complete, fault)

    # A step in which the controller fails is not part of the recording.
    done = max(int(episode.report.steps) - (fault is not None), 0)
    written = episode.with_headings(path)[: int(episode.report.points)]
    return PythonRun(episode, (rows[: done + 1], written[written[:, 0] > 0]), complete, fault)
