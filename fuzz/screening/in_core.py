"""Screening runs of a compiled controller: the core runs whole batches.

A shared library's controller runs in another process, which may die.
"""

from __future__ import annotations

from fuzz._core import ffi, lib
from fuzz.screening.batch import Batch, Seat
from sim.controllers.shared.guarded import ControllerDied, call
from sim.runners.core_calls import Driver
from sim.verdict import Verdict
from worldgen.errors import WorldgenError

MOST_HANGS = 2
"""Limit on the hangs of a batch: each takes a whole deadline, and no unit proves more."""

# Most steps of a call, which returns after a quarter of a second anyway; Ctrl-C is noticed between
# calls.
_PORTION = 1 << 24


def screen_in_core(driver: Driver, seat: Seat, batch: Batch) -> None:
    """Run a controller in the worlds of a batch.

    After a death, the batch continues with the run after the one that caused it.

    Args:
        driver: The controller.
        seat: Its seat.
        batch: The runs; their results are filled in.
    """
    work = ffi.addressof(lib, "wg_call_looks")
    report = ffi.addressof(seat.c.episode.robot.report)
    hangs = 0
    # Each hang costs seconds, so after a few of them the rest of the batch is skipped.
    while hangs < MOST_HANGS:
        try:
            if driver.cage is None:
                result = lib.wg_looks_run(seat.c, _PORTION)
            else:
                acts = (driver.guarded,)
                watched = {"progress": (report, batch.c), "cages": (driver.cage,)}
                result = call(work, acts, (seat.c,), _PORTION, **watched)
            if result == lib.WG_OVER:
                return
        except ControllerDied as death:
            n = batch.at
            if not lib.wg_looks_fail(seat.c):
                raise WorldgenError(
                    "ended-between-runs",
                    "the process that runs the controller ended between runs: {how}",
                    "run the controller alone, under a debugger",
                    how=death.error,
                ) from None
            batch.deaths += 1
            hangs += death.verdict == Verdict.HANG
            batch.note_fault(n, death)
    batch.leave_out(slice(batch.at, None))
