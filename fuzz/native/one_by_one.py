"""First looks at runs of a Python class or a program: one world after the other, the kernel stopping in each step."""

from __future__ import annotations

import contextlib
import sys
import zlib
from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from fuzz.crash_bucket import crash_bucket
from fuzz.kernels import looks
from fuzz.kernels.looks import Batch, Desk, close_look, masks_do, next_look, watch_steps
from sim.controllers import ProcessController, PythonController, VectorController
from sim.controllers.base import Memory
from sim.controllers.program import Misbehaviour, WantsMemory
from sim.kernels import layout
from sim.kernels.lattice_episode import lattice_steps
from sim.kernels.lattice_state import Arena, Robot, Room, new_robot, new_room
from sim.python_loop import crash_of, driver_of, memory_at_start, plans
from sim.stopping import OutOfTime, in_time, is_out_of_time
from worldgen.world import World

__all__ = ["CRASH", "HANG", "OneByOne"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

CRASH = layout.INVALID_COMMAND + 1
"""An ending that kernels do not know: the controller raised, or its program ended."""

HANG = CRASH + 1
"""The same for a program that gave no answer in time."""

_ENDINGS = {"crash": CRASH, "hang": HANG, "invalid-command": layout.INVALID_COMMAND}
_NUMBERS = (1 << 24) - 1  # that a crash can have
_MOST_HANGS = 2  # of a batch: each takes a whole deadline, and no door proves more of a unit


class OneByOne:
    """Runs a controller in one world of a batch after the other.

    Args:
        controller: A Python class or a program; a vector class acts for a single robot.
        batch: The runs; their results are filled in.
        desk: To be used.
        beams: Range beams of the robot.
        world: Returns the world of a run, for a controller that plans first.
    """

    def __init__(
        self,
        controller: PythonController | VectorController,
        batch: Batch,
        desk: Desk,
        beams: int,
        world: Callable[[int], World],
    ) -> None:
        self._controller, self._batch, self._desk, self._beams = controller, batch, desk, beams
        self._world = world if plans(controller) else None
        self._drive = driver_of(controller)
        self._by_memory: dict[int, tuple[Robot, Room]] = {}
        self._robot, self._room = self._made(0)
        self._hangs = 0

    def run(self, worlds: int) -> None:
        """Run in the next worlds; what the controller prints goes to stderr, and what it raises ends a run as a crash.

        Once the time is over (:mod:`sim.stopping`), the rest is not run.

        Args:
            worlds: How many, at most; what is left of the batch is marked as not run.
        """
        with contextlib.redirect_stdout(sys.stderr), contextlib.suppress(OutOfTime):
            for _ in range(worlds):
                n = -1 if self._is_enough() else next_look(self._batch, self._desk)
                if n < 0:
                    break
                self._look(n)
                self._batch.at[0] = n + 1
        left = self._batch.looks[self._batch.at[0] :]
        left[:, looks.LOOK_DISTANCE], left[:, layout.OUT_ENDING] = -1, looks.NOT_RUN

    def _is_enough(self) -> bool:
        return self._hangs >= _MOST_HANGS or is_out_of_time()

    def _look(self, n: int) -> None:
        """Run the controller in the world that the desk holds, and watch it for a while where that says more."""
        if isinstance(self._controller, ProcessController):
            self._controller.start()  # outside the guard: a program that is not there is nobody's crash
        self._robot.counts[:] = 0  # what it reports if ``reset`` raises
        self._robot.sums[:] = 0.0
        try:
            memory = memory_at_start(self._controller, self._world(n) if self._world else None)
            self._robot, self._room = self._made(len(memory))
            surroundings = (self._arena(n), self._desk.settings, self._desk.scales)
            memory = self._drive(self._steps(surroundings, memory), self._room, memory)
        except (KeyboardInterrupt, OutOfTime, WantsMemory):
            raise
        except BaseException as error:  # noqa: BLE001 - a controller may raise anything; it is the finding
            self._fail(n, error)
            return
        close_look(self._batch, surroundings[0], self._robot, n)
        if self._batch.looks[n, layout.OUT_ENDING] not in (layout.LOOP, layout.LIMIT):
            return
        try:
            stops = in_time(watch_steps(*surroundings, self._room, self._robot, self._batch, n))
            self._drive(stops, self._room, memory)
        except OutOfTime:  # how it ended is known already
            return
        except (KeyboardInterrupt, WantsMemory):
            raise
        except BaseException as error:  # noqa: BLE001 - what it does after its budget is no finding
            self._hangs += _ending_of(error) == HANG

    def _steps(self, surroundings: tuple[Arena, Ints, Floats], memory: Memory) -> Iterable[int]:
        """The run, step by step."""
        nothing = self._desk.nothing
        start = np.array(memory, np.float64)
        return in_time(lattice_steps(*surroundings, start, self._room, self._robot, nothing, nothing))

    def _fail(self, n: int, error: BaseException) -> None:
        """Note a run in which the controller failed."""
        ended = self._batch.looks[n]
        ending = _ending_of(error)
        ended[: layout.OUT_SIZE] = self._robot.counts
        ended[layout.OUT_ENDING] = ending
        ended[layout.OUT_OVERLAP_STEP] = -1
        if ending == CRASH:
            ended[layout.OUT_HIT_IX] = self._number_of(error)
        self._batch.sums[n] = self._robot.sums
        self._hangs += ending == HANG

    def _number_of(self, error: BaseException) -> int:
        """Return a number for what crashed, so that a frequent one does not keep others from being proved."""
        fault = error if isinstance(error, Misbehaviour) else crash_of(error, self._controller)
        step = int(self._robot.counts[layout.OUT_STEPS])
        bucket = crash_bucket({"error": fault.error, **fault.evidence, "step": step})
        return zlib.crc32(bucket.encode()) & _NUMBERS

    def _made(self, memory: int) -> tuple[Robot, Room]:
        """A robot and a room for so many numbers of memory, made once."""
        if memory not in self._by_memory:
            room = new_room(memory, self._beams, looks.longest(self._batch))
            self._by_memory[memory] = new_robot(memory, self._desk.events), room
        return self._by_memory[memory]

    def _arena(self, n: int) -> Arena:
        """Surroundings of a run, in the arrays of the desk."""
        desk = self._desk
        height, width = self._batch.looks[n, [looks.LOOK_HEIGHT, looks.LOOK_WIDTH]].tolist()
        cells = height * width
        rows = (0, 0) if masks_do(desk.settings, desk.scales) else (height, width)
        return Arena(
            desk.cells[:cells].reshape(height, width),
            desk.near[:cells].reshape(height, width),
            desk.clearance[: rows[0] * rows[1]].reshape(rows),
            desk.events,
            desk.headings,
            desk.visited[:cells].reshape(height, width),
        )


def _ending_of(error: BaseException) -> int:
    return _ENDINGS[error.verdict if isinstance(error, Misbehaviour) else "crash"]
