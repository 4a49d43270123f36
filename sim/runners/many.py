"""Run many episodes of one world and controller in few calls of the core."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.base import CompiledController
from sim.controllers.shared.guarded import ControllerDied, call
from sim.runners.core_calls import REPORT, CoreEpisode, Driver, copy_of
from sim.runners.lattice import LatticeRun
from worldgen.support.arrays import Ints, Words
from worldgen.support.ccall import check, pointer

__all__ = ["run_many"]

Reports = npt.NDArray[Any]

# Runs in one call of the core.
_MANY = 64


def run_many(
    run: LatticeRun,
    controller: CompiledController,
    starts: Ints,
    seeds: Words,
    *,
    digest: bool,
    stop: Ints | None = None,
) -> Reports:
    """Run many episodes in few calls of the core; several threads may do so at the same time.

    Args:
        run: The world and options.
        controller: The controller of the run.
        starts: (n, 3) starts from :meth:`~sim.runners.lattice.LatticeRun.start_of`.
        seeds: (n,) uint64 seeds.
        digest: Whether to compute the traces' digests.
        stop: (1,) set to anything but 0 to make this return soon; its results are then invalid.

    Returns:
        (n,) reports of type :data:`sim.runners.core_calls.REPORT`; fewer if the controller
        failed in a run, which is then the last.
    """
    # Prepare one episode, which all runs use in turn.
    settings = copy_of(run.settings, run.memory)
    settings.steps = run.options.steps
    settings.digest = int(digest)
    settings.find_loop = lib.WG_SEEK_LOOP if run.can_loop else lib.WG_NO_LOOP
    episode = CoreEpisode(run.arena(), settings, Driver(controller, controller.memory))
    reports = np.zeros(len(seeds), REPORT)
    stop = np.zeros(1, np.int64) if stop is None else stop
    if episode.guarded:
        return _run_many_guarded(run, episode, settings, starts, seeds, stop)

    fresh = run.arena()
    # Run in groups; the arrays that a call gets must stay alive until it returns.
    stop_at = pointer(ffi, stop, np.int64)
    for first in range(0, len(seeds), _MANY):
        part = slice(first, first + _MANY)
        into = ffi.cast("WgReport *", ffi.from_buffer(reports[part], require_writable=True))
        own = np.ascontiguousarray(starts[part])
        numbers = np.ascontiguousarray(seeds[part])
        places = ffi.cast("WgStart *", pointer(ffi, own, np.int64))
        check(
            lib.wg_run_many(
                episode.c,
                settings,
                fresh.c,
                places,
                pointer(ffi, numbers, np.uint64),
                len(numbers),
                stop_at,
                into,
            )
        )
        if (reports["ending"][part] == lib.WG_CRASH).any():
            return reports[: first + int((reports["ending"][part] == lib.WG_CRASH).argmax()) + 1]
    return reports


def _run_many_guarded(
    run: LatticeRun,
    episode: CoreEpisode,
    settings: Any,
    starts: Ints,
    seeds: Words,
    stop: Ints,
) -> Reports:
    """Do the same in another process, one run at a time, to notice a request to stop."""
    memory = run.memory
    fresh = run.arena()
    reports = memory.zeros(len(seeds), REPORT)
    own_starts = memory.own(starts)
    own_seeds = memory.own(seeds)
    goes_on = memory.zeros(1, np.int64)
    # One run per call: a crash then belongs to the run that caused it.
    for n in range(len(seeds)):
        if stop[0]:
            break
        one = slice(n, n + 1)
        objects = (
            episode.c,
            settings,
            fresh.c,
            pointer(ffi, own_starts[one], np.int64),
            pointer(ffi, own_seeds[one], np.uint64),
            pointer(ffi, goes_on, np.int64),
            ffi.from_buffer(reports[one], require_writable=True),
        )
        report = ffi.addressof(episode.report)
        try:
            check(
                call(
                    ffi.addressof(lib, "wg_call_run_many"),
                    episode.guarded,
                    objects,
                    1,
                    report=report,
                ).result
            )
        except ControllerDied:
            reports["ending"][n] = lib.WG_CRASH
        # Stop at the first crash; the caller decides whether to continue after it.
        if reports["ending"][n] == lib.WG_CRASH:
            return reports[: n + 1].copy()
    return reports.copy()
