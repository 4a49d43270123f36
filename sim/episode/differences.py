"""Find what makes equal runs of a Python class differ: a clock, or a generator without a seed."""

from __future__ import annotations

from dataclasses import replace

from sim.clock.controller_time import UNKNOWN_SOURCE, count_differences
from sim.controllers.catalogue.renewal import as_loaded
from sim.episode.run import simulate
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.runners.controller_host import host_of
from sim.runners.lattice import LatticeRun
from worldgen.errors import WorldgenError
from worldgen.world import World

# The controllers that were examined in this process, because each costs some runs, and how many
# pairs of runs were compared.
_examined: dict[str, int] = {}
_MOST_PAIRS = 3


def note_difference(world: World, controller: str, options: RunOptions) -> None:
    """Run a controller twice; if the runs differ, note what it reads that differs.

    Args:
        world: A world in which it did not behave in the same way twice.
        controller: Its name; only a few pairs of runs are compared for each.
        options: Options of the runs.
    """
    if _examined.get(controller, 0) >= _MOST_PAIRS or not _is_in_python(world, controller, options):
        return
    _examined[controller] = _examined.get(controller, 0) + 1
    try:
        digests = {_digest(world, controller, options) for _ in range(2)}
    except WorldgenError:
        return
    if len(digests) > 1:
        count_sources(world, controller, options)


def count_sources(world: World, controller: str, options: RunOptions) -> None:
    """Note what a controller whose equal runs differ reads that differs.

    Args:
        world: The world of the runs.
        controller: Its name.
        options: Options of the runs.
    """
    _examined[controller] = _MOST_PAIRS
    sources: tuple[str, ...] = ()
    frozen = replace(options, frozen_time=True)
    if _is_in_python(world, controller, options):
        try:
            host = host_of(as_loaded(controller))
            run = LatticeRun(world, host, frozen)
            run.run(frozen.steps, find_loop=False, record=False)
            sources = host.sources
            is_cured = len({_digest(world, controller, frozen) for _ in range(2)}) == 1
        except WorldgenError:
            is_cured = False
        if not is_cured:
            sources += (UNKNOWN_SOURCE,)
    count_differences(sources or (UNKNOWN_SOURCE,))


def _digest(world: World, controller: str, options: RunOptions) -> str:
    as_loaded(controller)
    return simulate(world, controller, options).trace_digest


def _is_in_python(world: World, controller: str, options: RunOptions) -> bool:
    """Return True for a class whose runs a frozen clock can change."""
    if world.is_fleet or options.frozen_time or not MOTIONS.get(options.motion).on_lattice:
        return False
    host = host_of(as_loaded(controller))
    return host.in_python and not host.acts_for_many
