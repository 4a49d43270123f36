"""Screening runs of a Python class or a program.

It runs one world after another, and the core stops in each step.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import TypeAlias

from fuzz._core import ffi, lib
from fuzz.screening.batch import REPORT_FIELDS, Batch, Seat
from fuzz.screening.in_core import MOST_HANGS
from sim.clock.stopping import OutOfTime, is_out_of_time
from sim.controllers.answers import AnswersDiffer
from sim.controllers.controller_error import ControllerError
from sim.controllers.hidden_state import own_attributes
from sim.options.run import RunOptions
from sim.runners.controller_host import ControllerHost, Faults
from sim.runners.python_act import Stops
from sim.verdict import Verdict
from worldgen.support.results import only_results_on_stdout
from worldgen.world import World

# Bytes of attributes that can be compared before each world, which takes up to 0.1 ms. The state of
# larger controllers is only compared in the runs that prove failures.
_LIGHT = 1 << 16


SeededOptions: TypeAlias = tuple[RunOptions, int]


class OneByOne:
    """Runs a controller in the worlds of a batch, one after another.

    Args:
        host: The host of a Python class or a program; a vector class acts for a single robot.
        batch: The runs; their results are filled in.
        world: Returns the world of a run, for a controller that plans first.
        options: Returns the options of a run, and its seed.
    """

    def __init__(
        self,
        host: ControllerHost,
        batch: Batch,
        world: Callable[[int], World],
        options: Callable[[int], SeededOptions],
    ) -> None:
        self._host = host
        self._options = options
        self._faults = Faults(host)
        self._batch = batch
        self._world = world if host.plans else None
        attributes = own_attributes(host.controller)
        self._is_light = sum(map(len, attributes.values())) <= _LIGHT
        self._by_memory: dict[int, Seat] = {}
        self._seat = self._seat_for(0)
        self._hangs = 0

    def run(self, worlds: int) -> None:
        """Run in the next worlds.

        The controller's prints go to stderr, and its exceptions end a run as a crash. Once the time
        is over (:mod:`sim.clock.stopping`), the remaining worlds are not run.

        Args:
            worlds: Maximum number of worlds to run; the rest of the batch is marked as not run.
        """
        with only_results_on_stdout(), contextlib.suppress(OutOfTime):
            for _ in range(worlds):
                n = -1 if self._is_enough() else int(lib.wg_seat_next(self._seat.c))
                if n < 0:
                    break
                self._look(n)
                self._batch.at = n + 1
        self._batch.leave_out(slice(self._batch.at, None))

    def _is_enough(self) -> bool:
        return self._hangs >= MOST_HANGS or is_out_of_time()

    def _look(self, n: int) -> None:
        """Run the controller in a world, and keep watching it for a while if that reveals more."""
        while True:
            with contextlib.suppress(AnswersDiffer):
                self._run_once(n)
                return
            lib.wg_seat_open(self._seat.c, n)

    def _run_once(self, n: int) -> None:
        self._host.start()
        seat = None
        try:
            with self._host.freezing(*self._options(n)), self._faults:
                world = self._world(n) if self._world else None
                memory = self._host.begin(world, renew=self._is_light)
                seat = self._seated(n, len(memory))
                seat.memory[:] = memory
                seat.begin()
                self._host.drive(Stops(ffi, lib, "wg_seat", seat.c, seat.episode), memory)
        except OutOfTime:
            # Otherwise the ending is already known.
            if seat is None or seat.c.watch < 0:
                raise
        except ControllerError as fault:
            self._hangs += fault.verdict == Verdict.HANG
            # Nothing that it does after its budget counts as a finding.
            if seat is None or seat.c.watch < 0:
                self._fail(n, seat, fault)

    def _seat_for(self, memory: int) -> Seat:
        """Return the seat for a memory of this many numbers, made once."""
        if memory not in self._by_memory:
            self._by_memory[memory] = Seat(self._batch, (0.0,) * memory)
        return self._by_memory[memory]

    def _seated(self, n: int, memory: int) -> Seat:
        """Return a seat for a memory of this many numbers, in the world of a run."""
        seat = self._seat_for(memory)
        if seat is not self._seat:
            lib.wg_seat_open(seat.c, n)
            self._seat = seat
        return seat

    def _fail(self, n: int, seat: Seat | None, fault: ControllerError) -> None:
        """Record a run in which the controller failed; without a seat, in ``reset``."""
        ended = self._batch.looks[n : n + 1]
        # If no episode began, no step counts.
        if seat is None:
            for name in REPORT_FIELDS:
                ended[name] = 0
        else:
            self._batch.c.looks[n].report = seat.c.episode.robot.report
        self._batch.note_fault(n, fault)
