"""The episode loop for a Python controller or a program.

The core stops in each step to let the controller act.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.controllers.base import Memory
from sim.controllers.controller_error import ControllerError
from sim.controllers.hidden_state import HiddenState, hidden_state
from sim.runners.controller_host import ControllerHost, Faults
from sim.runners.core_calls import CoreArena, CoreEpisode, most_points
from sim.runners.python_act import Stops
from worldgen.support.arrays import Ints
from worldgen.support.progress import working
from worldgen.support.results import only_results_on_stdout
from worldgen.world import World


class PythonLoop:
    """One episode; after :meth:`run`, read its attributes and :meth:`recording`.

    Args:
        host: The controller's host.
        arena: Surroundings at the start.
        settings: WgSettings, as for a compiled controller.
        world: The world, for a controller that plans first.

    Attributes:
        episode: The core's episode; ``None`` if the controller failed in ``reset``.
        complete: Whether all of the controller's state was in its memory.
        fault: The controller's fault, if any.
    """

    def __init__(self, host: ControllerHost, arena: CoreArena, settings: Any, world: World) -> None:
        self._world = world
        self._host = host
        self._arena = arena
        self._settings = settings
        self.episode: CoreEpisode | None = None
        self.complete = True
        self.fault: ControllerError | None = None
        self._rows = np.zeros((0, 1), np.int64)
        self._path = np.zeros((0, 1), np.int64)

    def run(self, steps: int, *, record: bool) -> None:
        """Run the episode; whatever the controller raises ends it as a crash.

        The controller's prints go to stderr, so that stdout stays data.
        """
        self._host.start()
        begun: HiddenState | None = None
        with only_results_on_stdout():
            try:
                with Faults(self._host):
                    memory = self._host.begin(self._world)
                    begun = self._host.hidden()
                    self._episode(memory, steps, record)
            except ControllerError as fault:
                self.fault = fault
        self.complete = begun is not None and hidden_state(self._host.controller) == begun

    def recording(self) -> tuple[Ints, Ints] | None:
        """Return the states as rows, and the points of the path, as the core writes them.

        ``None`` if the run was not recorded, or the controller failed in ``reset``.
        """
        if self.episode is None or not len(self._rows):
            return None
        report = self.episode.report
        done = int(report.steps) - (self.fault is not None)
        written = self._path[: int(report.points)]
        return self._rows[: max(done, 0) + 1], written[written[:, 0] > 0]

    def _episode(self, memory: Memory, steps: int, record: bool) -> None:
        """Let the core stop in each step and the controller act."""
        self._settings.steps = steps
        self.episode = episode = CoreEpisode(
            self._arena, self._settings, self._host.driver(memory, self._settings)
        )
        if record:
            self._rows = np.zeros((steps + 1, 1 + episode.words), np.int64)
            self._path = np.zeros((most_points(self._arena, self._settings, steps), 4), np.int64)
            self._rows[0, 1:] = episode.state_words()
            episode.record(self._rows[1:], self._path)
        with working("running the controller", often=True) as work:
            work.say(lambda: f"step {episode.report.steps:,} of at most {steps:,}")
            self._host.drive(Stops(ffi, lib, "wg_episode", episode.c, episode), memory)
