"""Run many episodes of one world and compiled controller in few calls of the core."""

from __future__ import annotations

from threading import Event
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.shared.guarded import ControllerDied
from sim.runners.core_calls import REPORT, copy_of
from sim.runners.lattice import LatticeRun
from worldgen.support.arrays import Ints, Words
from worldgen.support.ccall import check, pointer

Reports = npt.NDArray[Any]

# Most steps in one call of the core, which returns after a quarter of a second anyway.
_PORTION = 1 << 40


def run_many(
    run: LatticeRun, starts: Ints, seeds: Words, *, digest: bool, stop: Event | None = None
) -> Reports:
    """Run many episodes in few calls of the core; several threads may do so at the same time.

    Args:
        run: The world, controller and options.
        starts: (n, 3) starts from :meth:`~sim.runners.lattice.LatticeRun.start_of`.
        seeds: (n,) uint64 seeds.
        digest: Whether to compute the traces' digests.
        stop: Makes this return soon once another thread sets it.

    Returns:
        (n,) reports of type :data:`sim.runners.core_calls.REPORT`; fewer if the controller failed
        in a run, which is then the last, or after ``stop``.
    """
    # One episode makes all runs in turn.
    memory = run.memory
    settings = copy_of(run.settings, memory)
    settings.steps = run.options.steps
    settings.digest = int(digest)
    settings.find_loop = run.search
    episode = run.episode(settings)
    fresh = run.arena()
    own_starts = memory.own(np.ascontiguousarray(starts))
    own_seeds = memory.own(np.ascontiguousarray(seeds))
    reports = memory.zeros(len(seeds), REPORT)
    batch = memory.new("WgBatch *")
    batch.run = (episode.c, settings, fresh.c, run.options.steps, run.search)
    batch.starts = ffi.cast("WgStart *", pointer(ffi, own_starts, np.int64))
    batch.seeds = pointer(ffi, own_seeds, np.uint64)
    batch.reports = ffi.cast("WgReport *", ffi.from_buffer(reports, require_writable=True))
    batch.count = len(seeds)
    try:
        while not (stop is not None and stop.is_set()):
            if episode.call("wg_call_batch", (batch,), _PORTION, (batch,)) == lib.WG_OVER:
                break
        check(batch.status)
    except ControllerDied:
        reports["ending"][batch.at] = lib.WG_CRASH
        batch.at += 1
    return reports[: batch.at].copy()
