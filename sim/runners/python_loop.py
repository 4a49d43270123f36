"""The episode loop for a Python controller or a program.

The core stops in each step to let the controller act.
"""

from __future__ import annotations

import functools
import re
from bdb import BdbQuit
from collections.abc import Callable
from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.clock.controller_time import timed
from sim.clock.stopping import OutOfTime, breakable, in_time
from sim.controllers.base import Memory, PythonController, VectorController, wants_world
from sim.controllers.catalogue.renewal import has_shared_state_changed, reset_anew
from sim.controllers.contract import flat_memory
from sim.controllers.controller_error import ControllerError
from sim.controllers.crash_frames import crash_facts
from sim.controllers.hidden_state import HiddenState, hidden_state
from sim.controllers.programs.process import ProcessController
from sim.controllers.programs.program import WantsMemory
from sim.controllers.timeline_reads import world_to_read
from sim.controllers.vector import Asker
from sim.runners.core_calls import CoreArena, CoreEpisode, Driver, Workspace, most_points
from sim.runners.python_act import Stops, act_in_core
from sim.verdict import Verdict
from worldgen.plugins.user_modules import without_private_names
from worldgen.support.arrays import Ints
from worldgen.support.progress import working
from worldgen.support.results import only_results_on_stdout
from worldgen.world import World

# Characters of a controller's exception that are kept.
_LONGEST_ERROR = 500


class PythonLoop:
    """One episode; after :meth:`run`, read its attributes and :meth:`recording`.

    Args:
        controller: The controller.
        arena: Surroundings at the start.
        settings: WgSettings, as for a compiled controller.
        world: The world, for a controller that plans first.

    Attributes:
        episode: The core's episode; ``None`` if the controller failed in ``reset``.
        complete: Whether all of the controller's state was in its memory.
        fault: The controller's fault, if any.
    """

    def __init__(
        self,
        controller: PythonController | VectorController,
        arena: CoreArena,
        settings: Any,
        world: World,
    ) -> None:
        self._world = world
        self._controller = controller
        self._arena = arena
        self._settings = settings
        self.episode: CoreEpisode | None = None
        self.complete = True
        self.fault: ControllerError | None = None
        self._begun: HiddenState | None = None
        self._rows = np.zeros((0, 1), np.int64)
        self._path = np.zeros((0, 1), np.int64)

    def run(self, steps: int, *, record: bool) -> None:
        """Run the episode; whatever the controller raises ends it as a crash, even SystemExit.

        The controller's prints go to stderr, so that stdout stays data. A program's memory
        cannot be seen, so its run is not complete, and no recurrence ends it.
        """
        if isinstance(self._controller, ProcessController):
            self.complete = False
            # Not guarded: if the program does not exist, that is not the controller's crash.
            self._controller.start()
            self._settings.find_loop = lib.WG_NO_LOOP
            self._guarded(steps, record)
            return
        with only_results_on_stdout():
            self._guarded(steps, record)
        begun = self._begun
        self.complete = begun is not None and hidden_state(self._controller) == begun

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

    def _guarded(self, steps: int, record: bool) -> None:
        try:
            world = self._world if plans(self._controller) else None
            self._controller, memory = begun_anew(self._controller, world)
            if not isinstance(self._controller, ProcessController):
                self._begun = hidden_state(self._controller)
                if has_shared_state_changed(self._controller, self._begun):
                    self._begun = None
            self._episode(memory, steps, record)
        except ControllerError as fault:
            self.fault = fault
        except (KeyboardInterrupt, OutOfTime, WantsMemory):
            raise
        except BaseException as error:  # noqa: BLE001 - anything may be raised; it is the finding
            self.fault = crash_of(error, self._controller)

    def _episode(self, memory: Memory, steps: int, record: bool) -> None:
        """Let the core stop in each step and the controller act."""
        self._settings.steps = steps
        self.episode = episode = CoreEpisode(self._arena, self._settings, Driver(None, memory))
        if record:
            self._rows = np.zeros((steps + 1, 1 + episode.words), np.int64)
            self._path = np.zeros((most_points(self._arena, self._settings, steps), 4), np.int64)
            self._rows[0, 1:] = episode.state_words()
            episode.record(self._rows[1:], self._path)
        with working("running the controller", often=True) as work:
            work.say(lambda: f"step {episode.report.steps:,} of at most {steps:,}")
            driver_of(self._controller)(Stops(ffi, lib, "wg_episode", episode.c, episode), memory)


def crash_of(error: BaseException, controller: object) -> ControllerError:
    """Return the error for a controller that raised, with the place where it did.

    Raises:
        KeyboardInterrupt: If the user left the debugger in it, which says nothing about it.
    """
    if isinstance(error, BdbQuit):
        raise KeyboardInterrupt from None
    name = type(error).__name__
    facts = {"exception": _in_short(name), **crash_facts(error, controller)}
    return ControllerError(Verdict.CRASH, _in_short(f"{name}: {error}"), facts)


def _in_short(text: str) -> str:
    """Return a text on one line, and in every run the same: addresses differ from run to run."""
    text = re.sub(r"0x[0-9a-fA-F]+", "0x...", " ".join(without_private_names(text).split()))
    return text[:_LONGEST_ERROR].encode("utf-8", "replace").decode()


def plans(controller: PythonController | VectorController) -> bool:
    """Return True if a controller's ``reset`` takes the world."""
    return not isinstance(controller, VectorController) and wants_world(controller)


def begun_anew(controller: Any, world: World | None) -> tuple[Any, Memory]:
    """Reset a controller for a run; see :func:`sim.controllers.catalogue.renewal.reset_anew`.

    Args:
        controller: The controller.
        world: The world of the run, for a controller that plans.
    """
    return reset_anew(controller, lambda one: memory_at_start(one, world), plans=world is not None)


@breakable
def memory_at_start(controller: PythonController | VectorController, world: World | None) -> Memory:
    """Reset a controller and return its memory as floats.

    Args:
        controller: The controller.
        world: The world of the episode, for a controller that plans; it is passed without its
            certificate, which contains a solution.

    Raises:
        TypeError: If the memory is not a tuple of numbers.
    """
    resetting: Any = controller
    if world is None:
        return flat_memory(timed(resetting.reset)())
    return flat_memory(timed(resetting.reset)(world_to_read(world.bare)))


def driver_of(controller: PythonController | VectorController) -> Callable[[Stops, Memory], Memory]:
    """Return the function that lets a controller act wherever a run stops.

    It takes the run and the controller's memory, and returns the memory after the last step.
    """
    if isinstance(controller, VectorController):
        return functools.partial(_act_as_one_of_many, controller)
    # For a program, the code that waits for its answer measures the time.
    is_program = isinstance(controller, ProcessController)
    return functools.partial(act_in_core, controller.act, is_measured=not is_program)


def _act_as_one_of_many(controller: VectorController, stops: Stops, memory: Memory) -> Memory:
    """Do the same for a controller of many robots; there is one, whose memory the core keeps."""
    workspace = Workspace(stops.episode)
    seen = workspace.observation[np.newaxis]
    kept = workspace.memory[np.newaxis]
    command = workspace.command[np.newaxis]
    after = kept.copy()
    asker = Asker(controller, seen, kept, command)
    for _ in in_time(stops):
        asker.ask(1, after)
        kept[...] = after
    return memory
