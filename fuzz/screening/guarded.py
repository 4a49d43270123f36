"""Screening runs of a controller in a shared library.

Whole batches run in another process, which may die.
"""

from __future__ import annotations

from fuzz._core import ffi, lib
from fuzz.screening.batch import Batch, Seat
from sim.controllers.shared.cage import Cage
from sim.controllers.shared.guarded import ControllerDied, call
from sim.verdict import Verdict
from worldgen.errors import WorldgenError

MOST_HANGS = 2
"""Limit on the hangs of a batch: each takes a whole deadline, and no unit proves more."""

# Steps of a call, about a second.
_PORTION = 1 << 24


def look_guarded(batch: Batch, seat: Seat, act: int, cage: Cage) -> None:
    """Run a controller in the worlds of a batch.

    After a death, the batch continues with the run after the one that caused it.

    Args:
        batch: The runs; their results are filled in.
        seat: The seat to run them in.
        act: Address of the controller's function.
        cage: Where it acts.
    """
    work = ffi.addressof(lib, "wg_call_looks")
    report = ffi.addressof(seat.c.episode.robot.report)
    hangs = 0
    # Each hang costs seconds, so after a few of them the rest of the batch is skipped.
    while hangs < MOST_HANGS:
        try:
            progress = (report, batch.c)
            result = call(work, (act,), (seat.c,), _PORTION, progress=progress, cages=(cage,))
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
