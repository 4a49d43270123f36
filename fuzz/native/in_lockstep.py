"""First looks in lockstep: as many robots as there are places act at once, each in a world of its own."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fuzz.kernels import looks
from fuzz.kernels.fleet_looks import RIDE_RUN, RIDE_SIZE, board_fleet, next_step
from fuzz.kernels.looks import Batch, Desk, longest
from sim.controllers import ProcessController, VectorController
from sim.controllers.contract import flat_memory
from sim.controllers.program import Misbehaviour
from sim.controllers.vector import Asker
from sim.fleet_run import ControllerRaised, its_own_fault
from sim.kernels import layout
from sim.kernels.lattice_fleet import CLOCK_SIZE, CLOCK_STEP, SHAPE_SIZE, Fleet
from sim.kernels.lattice_state import new_robot
from sim.kernels.recurrence import MARKS, new_search
from sim.python_loop import hidden_state
from sim.stopping import OutOfTime, check_time

__all__ = ["look_in_batch", "look_in_lockstep"]

Floats = npt.NDArray[np.float64]

Ask = Callable[[int, Floats], None]
"""Fills in the commands of the first slots, so many, and (n, memory) their memories after the step."""

PLACES = 1_024
"""Robots of a vector class that act at once, at most.

A call of NumPy for 512 took 10 % more for each, and the worlds of 2,048 do not fit into a cache.
"""


def look_in_lockstep(controller: VectorController, batch: Batch, desk: Desk, beams: int) -> bool:
    """Run a vector class in the worlds of a batch.

    Args:
        controller: The controller.
        batch: The runs; their results are filled in.
        desk: To be used.
        beams: Range beams of the robots.

    Returns:
        False if the controller raised, or changed what is outside its memory: then no run can be trusted to be its own,
        and each must be run alone.
    """
    before = hidden_state(controller)
    if before is None:
        return False

    def asker(fleet: Fleet) -> Ask:
        return its_own_fault()(Asker(controller, fleet.observation, fleet.memory, fleet.command).ask)

    with contextlib.redirect_stdout(sys.stderr):
        try:
            with its_own_fault():
                memory = np.array(flat_memory(controller.reset()), np.float64)
            _run(asker, memory, batch, desk, beams, PLACES)
        except ControllerRaised:
            return False
    return hidden_state(controller) == before


def look_in_batch(controller: ProcessController, batch: Batch, desk: Desk, beams: int) -> bool:
    """Run a program that offers it in the worlds of a batch, many at a time.

    Args:
        controller: The program.
        batch: The runs from ``at`` on; their results are filled in.
        desk: To be used.
        beams: Range beams of the robots.

    Returns:
        False if the program offers nothing, or does anything wrong: then it must be seen alone in each world.
    """
    offer = controller.offer
    if offer is None:
        return False

    def asker(fleet: Fleet) -> Ask:
        def ask(count: int, _after: Floats) -> None:
            robots = fleet.order[:count]
            fresh = robots[fleet.clock[robots, CLOCK_STEP] == 1]
            controller.act_in_batch(offer, robots, fresh, fleet.observation[:count], fleet.command[:count])

        return ask

    controller.begin_batch(offer.robots)
    try:
        _run(asker, np.zeros(0), batch, desk, beams, offer.robots)
    except Misbehaviour:
        return False
    return True


def _run(asker: Callable[[Fleet], Ask], memory: Floats, batch: Batch, desk: Desk, beams: int, places: int) -> None:
    """Run all while there is time; a place whose robot is done takes the next world."""
    n = min(places, len(batch.seeds))
    fleet = _fleet(desk, n, memory.size, beams, longest(batch))
    rides = np.zeros((n, RIDE_SIZE), np.int64)
    ask = asker(fleet)
    count = board_fleet(batch, desk, fleet, rides, memory)
    while count:
        after = np.empty((count, memory.size))
        try:
            check_time()
            ask(count, after)
        except OutOfTime:
            cut = rides[fleet.order[:count], RIDE_RUN].tolist() + list(range(int(batch.at[0]), len(batch.seeds)))
            batch.looks[cut, looks.LOOK_DISTANCE] = -1
            batch.looks[cut, layout.OUT_ENDING] = looks.NOT_RUN
            return
        count = next_step(batch, desk, fleet, rides, memory, after, count)


def _fleet(desk: Desk, n: int, size: int, beams: int, steps: int) -> Fleet:
    """A fleet of n robots in as many worlds, none of them begun."""
    robot, cells = new_robot(size, desk.events), desk.cells.size
    search = new_search(robot.state.size, 0)
    memory = np.zeros((n, size))
    return Fleet(
        shape=np.zeros((n, SHAPE_SIZE), np.int64),
        cells=np.zeros((n, cells), np.uint8),
        near=np.zeros((n, cells), np.int32),
        clearance=np.zeros((n, cells), np.int32),
        events=desk.events,
        headings=desk.headings,
        visited=np.zeros((n, cells), np.uint8),
        page=np.arange(n),
        world=np.arange(n),
        span=np.zeros((n, 2), np.int64),
        settings=np.zeros((n, layout.SET_SIZE), np.int64),
        scales=np.zeros((n, layout.SCALE_SIZE)),
        state=np.zeros((n, robot.state.size), np.int64),
        odometry=np.zeros((n, 3)),
        chain=np.zeros((n, *robot.chain.shape), np.int64),
        counts=np.zeros((n, layout.OUT_SIZE), np.int64),
        sums=np.zeros((n, layout.SUM_SIZE)),
        known=np.zeros((n, robot.state.size), np.int64),
        prints=np.zeros((n, search.prints.size), np.uint64),
        log=np.zeros((n, steps + 1), np.uint64),
        marks=np.zeros((n, MARKS), np.int64),
        clock=np.zeros((n, CLOCK_SIZE), np.int64),
        order=np.arange(n),
        observation=np.full((n, layout.OBS_SIZE + beams), np.nan),
        memory=memory,
        words=memory.view(np.int64),
        command=np.zeros((n, layout.CMD_SIZE)),
        nothing=desk.nothing,
    )
