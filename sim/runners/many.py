"""Run many episodes of one world and compiled controller in few calls of the core."""

from __future__ import annotations

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

# Runs in one call of the core.
_MANY = 64


def run_many(
    run: LatticeRun, starts: Ints, seeds: Words, *, digest: bool, stop: Ints | None = None
) -> Reports:
    """Run many episodes in few calls of the core; several threads may do so at the same time.

    Args:
        run: The world and options.
        starts: (n, 3) starts from :meth:`~sim.runners.lattice.LatticeRun.start_of`.
        seeds: (n,) uint64 seeds.
        digest: Whether to compute the traces' digests.
        stop: (1,) set to anything but 0 to make this return soon; its results are then invalid.

    Returns:
        (n,) reports of type :data:`sim.runners.core_calls.REPORT`; fewer if the controller
        failed in a run, which is then the last.
    """
    # Prepare one episode, which all runs use in turn.
    memory = run.memory
    settings = copy_of(run.settings, memory)
    settings.steps = run.options.steps
    settings.digest = int(digest)
    settings.find_loop = lib.WG_SEEK_LOOP if run.can_loop else lib.WG_NO_LOOP
    episode = run.episode(settings)
    fresh = run.arena()
    reports = memory.zeros(len(seeds), REPORT)
    own_starts = memory.own(np.ascontiguousarray(starts))
    own_seeds = memory.own(np.ascontiguousarray(seeds))
    stop = np.zeros(1, np.int64) if stop is None else stop
    own_stop = memory.own(stop)

    # Run in groups. In another process, a request to stop is noticed only between groups.
    for first in range(0, len(seeds), _MANY):
        if stop[0]:
            break
        part = slice(first, first + _MANY)
        objects = (
            episode.c,
            settings,
            fresh.c,
            pointer(ffi, own_starts[part], np.int64),
            pointer(ffi, own_seeds[part], np.uint64),
            pointer(ffi, own_stop, np.int64),
            ffi.from_buffer(reports[part], require_writable=True),
        )
        try:
            check(episode.call("wg_call_run_many", objects, len(own_seeds[part])))
        except ControllerDied:
            # Every run that has ended has visited the cell of its start.
            ended = int(np.count_nonzero(reports["cells_visited"][part]))
            reports["ending"][first + ended] = lib.WG_CRASH
        # Stop at the first crash; the caller decides whether to continue after it.
        crashed = np.flatnonzero(reports["ending"][part] == lib.WG_CRASH)
        if len(crashed):
            return reports[: first + int(crashed[0]) + 1].copy()
    return reports.copy()
