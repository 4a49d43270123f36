"""Screening runs in lockstep.

As many robots as there are slots act together, each in its own world.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fuzz._core import ffi, lib
from fuzz.screening.batch import Batch, Seat
from sim.clock.stopping import OutOfTime, check_time
from sim.controllers.controller_error import ControllerError
from sim.controllers.hidden_state import hidden_state
from sim.controllers.vector import Asker
from sim.kernels.layout import OBS_SIZE, OBS_TAIL
from sim.runners.controller_host import ControllerHost, Faults
from worldgen.support.arrays import Floats
from worldgen.support.ccall import writable
from worldgen.support.results import only_results_on_stdout

PLACES = 1_024
"""Maximum number of robots of a vector class that act together.

With 512, a NumPy call took 10 % more for each robot, and the worlds of 2,048 do not fit into a
cache.
"""


class _Seats:
    """Robots that act together; those whose controller must act come first in every array.

    Args:
        batch: The runs.
        memory: The controller's memory at reset.
        count: Number of slots.
    """

    def __init__(self, batch: Batch, memory: Floats, count: int) -> None:
        self.observation = np.full((count, OBS_SIZE + batch.beams + OBS_TAIL), np.nan)
        self.memory = np.zeros((count, memory.size))
        self.after = np.zeros((count, memory.size))
        # Speed, turn rate, whether the random number was used.
        self.command = np.zeros((count, 3))
        self.numbers = np.zeros(count, np.int64)
        self.fresh = np.zeros(count, np.uint8)
        self._kept = [Seat(batch, memory.tolist(), number=k) for k in range(count)]
        self._seats = ffi.new("WgSeat *[]", [seat.c for seat in self._kept])
        self.taken = int(lib.wg_seats_board(self._seats, count))

    def sense(self) -> None:
        """Fill in what the robots sense, and their memories."""
        lib.wg_seats_sense(
            self._seats,
            self.taken,
            writable(ffi, self.observation, np.float64),
            writable(ffi, self.memory, np.float64),
            writable(ffi, self.numbers, np.int64),
            writable(ffi, self.fresh, np.uint8),
        )
        self.command[:] = 0.0

    def act(self) -> None:
        """Let each robot continue until its controller must act again."""
        commands = writable(ffi, self.command, np.float64)
        self.taken = int(
            lib.wg_seats_act(
                self._seats, self.taken, commands, writable(ffi, self.after, np.float64)
            )
        )

    def runs(self) -> list[int]:
        """Return the runs in progress."""
        return [int(self._seats[k].run) for k in range(self.taken)]


Ask = Callable[[], None]
"""Fills in commands and memories of the occupied slots."""


def screen_in_lockstep(host: ControllerHost, batch: Batch) -> bool:
    """Run a vector class in the worlds of a batch.

    Args:
        host: The host of the controller.
        batch: The runs; their results are filled in.

    Returns:
        False if the controller raised, or changed something outside its memory; then no run can be
        trusted, and each must be run alone.
    """

    def asker(places: _Seats) -> Ask:
        faults = Faults(host)
        one = Asker(host.controller, places.observation, places.memory, places.command)

        def ask() -> None:
            with faults:
                one.ask(places.taken, places.after[: places.taken])

        return ask

    with only_results_on_stdout():
        try:
            with Faults(host):
                memory = np.array(host.begin(None), np.float64)
            # If state outside the memory can't be compared, it might differ between robots.
            before = hidden_state(host.controller)
            if before is None:
                return False
            _run(asker, memory, batch, PLACES)
        except ControllerError:
            return False
    return hidden_state(host.controller) == before


def screen_in_batch(host: ControllerHost, batch: Batch) -> bool:
    """Run a program that supports it in the worlds of a batch, many at a time.

    Args:
        host: The host of the program.
        batch: The runs, starting at ``at``; their results are filled in.

    Returns:
        False if the program does not support it, or does anything wrong; then it must be run alone
            in each world.
    """
    controller = host.controller
    offer = controller.offer
    if offer is None:
        return False

    def asker(places: _Seats) -> Ask:
        def ask() -> None:
            robots = places.numbers[: places.taken]
            fresh = robots[places.fresh[: places.taken] != 0]
            observation = places.observation[: places.taken]
            controller.act_in_batch(
                offer, robots, fresh, observation, places.command[: places.taken]
            )

        return ask

    controller.begin_batch(offer.robots)
    try:
        _run(asker, np.zeros(0), batch, offer.robots)
    except ControllerError:
        return False
    return True


def _run(asker: Callable[[_Seats], Ask], memory: Floats, batch: Batch, most: int) -> None:
    """Run everything while there is time; a slot whose robot is done takes the next world."""
    places = _Seats(batch, memory, min(most, len(batch)))
    ask = asker(places)
    while places.taken:
        places.sense()
        try:
            check_time()
            ask()
        except OutOfTime:
            batch.leave_out(places.runs() + list(range(batch.at, len(batch))))
            return
        places.act()
