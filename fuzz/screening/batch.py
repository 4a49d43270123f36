"""Runs as arrays for the core, and the seats in which robots run."""

from __future__ import annotations

import functools
import math
import zlib
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from fuzz._core import ffi, lib
from fuzz.facts.crash_bucket import crash_bucket
from fuzz.layouts import layout_bytes
from fuzz.layouts.features import decode_world, target_radii
from sim._core import ffi as sim_ffi
from sim.controllers.controller_error import ControllerError
from sim.controllers.shared.guarded import PRIVATE, CoreMemory
from sim.runners.core_calls import Driver, headings, ray_table
from sim.runners.packing import disc_numbers
from sim.verdict import Verdict
from worldgen.lattice import UNIT, in_cells
from worldgen.support.arrays import Bytes, Ints, Words
from worldgen.support.ccall import check, kept, pointer, writable

Columns = npt.NDArray[np.void]

NOT_RUN: int = lib.WG_NOT_RUN
"""An ending: the flood found no path, so nothing was simulated."""

CRASH: int = lib.WG_CRASH
"""An ending: the controller raised, or its program ended."""

HANG = CRASH + 1
"""An ending that the core does not know: a program gave no answer in time."""

_OF_FAULTS = {
    Verdict.CRASH: CRASH,
    Verdict.HANG: HANG,
    Verdict.INVALID_COMMAND: int(lib.WG_INVALID_COMMAND),
}
# Numbers that identify crashes.
_CRASH_NUMBERS = (1 << 24) - 1

_KINDS = {"int64_t": "<i8", "uint64_t": "<u8", "double": "<f8"}


def _numbers_of(name: str) -> list[tuple[str, str, int]]:
    """Yield the name, type and offset of a struct's numbers, including those of nested structs."""
    found = []
    for field_name, field in ffi.typeof(name).fields:
        if field.type.kind == "struct":
            inner = _numbers_of(field.type.cname)
            found += [(part, kind, field.offset + offset) for part, kind, offset in inner]
        elif field.type.cname in _KINDS:
            found.append((field_name, _KINDS[field.type.cname], field.offset))
    return found


def _type_of(name: str) -> np.dtype[Any]:
    names, formats, offsets = zip(*_numbers_of(name), strict=True)
    return np.dtype(
        {"names": names, "formats": formats, "offsets": offsets, "itemsize": ffi.sizeof(name)}
    )


LOOK = _type_of("WgLook")
"""The result of a run: the columns of ``WgReport`` and ``WgLook``."""

REPORT_FIELDS = tuple(name for name, _, _ in _numbers_of("WgReport"))


class Patience(NamedTuple):
    """The budget of runs that don't set one.

    Args:
        multiple: Multiple of the time that the path takes at top speed.
        fewest: Minimum number of steps.
        most: Maximum number of steps.
        watched: Steps for which a run is watched after it has spent its budget.
    """

    multiple: int
    fewest: int
    most: int
    watched: int


class SceneRobots(NamedTuple):
    """The sizes of robots and cells in scenes.

    Args:
        radii: Radii of the robots, of which a scene chooses one, m.
        cell_size: Side of a cell, m.
        passage: Radius of the disc for which a path to the target must be wide enough, m; 0 for the
            robot's own. For a body it is an estimate, and the prover decides the worlds that matter.
        target_radius: Radius of every target, m; None if a scene chooses it.
    """

    radii: tuple[float, ...]
    cell_size: float
    passage: float = 0.0
    target_radius: float | None = None


class Batch:
    """Runs and their results.

    Args:
        layouts: (n, LAYOUT_BYTES or SCENE_BYTES).
        seeds: (n,) uint64.
        kinds: (n,) index into the settings.
        budgets: (n,) steps; 0 for a number derived from the path to the target.
        settings: WgSettings for each time step, for any start.
        robots: Sizes of the robots, and of cells.
        patience: For runs without a budget.
        memory: Where the core finds the inputs and writes the results.

    Attributes:
        deaths: Number of runs that ended their process.
    """

    def __init__(
        self,
        layouts: Bytes,
        seeds: Words,
        kinds: Ints,
        budgets: Ints,
        settings: Sequence[Any],
        robots: SceneRobots,
        patience: Patience,
        memory: CoreMemory = PRIVATE,
    ) -> None:
        self.memory = memory
        self.deaths = 0
        self.looks: Columns = memory.zeros(len(layouts), LOOK)
        self._settings = memory.new("WgSettings[]", len(settings), ffi)
        for k, one in enumerate(settings):
            ffi.memmove(ffi.addressof(self._settings, k), one, ffi.sizeof("WgSettings"))
        discs, targets, flood_reach = _sizes(robots)
        made = (layouts, seeds, kinds, budgets, np.array(robots.radii), targets)
        arrays = (*(memory.own(array) for array in made), headings())
        described_discs = memory.new("WgDisc[]", discs, ffi)
        rays = ray_table()
        layouts_at, seeds_at, kinds_at, budgets_at, radii_at, targets_at, headings_at = (
            pointer(ffi, array, array.dtype.type) for array in arrays
        )
        batch = memory.new(
            "WgLooks *",
            {
                "layouts": layouts_at,
                "layout_bytes": layouts.shape[1],
                "count": len(layouts),
                "seeds": seeds_at,
                "kinds": kinds_at,
                "budgets": budgets_at,
                "settings": self._settings,
                "setting_count": len(settings),
                "discs": described_discs,
                "radii": radii_at,
                "radius_count": len(robots.radii),
                "flood_reach": flood_reach,
                "targets": targets_at,
                "target_count": len(targets),
                "headings": headings_at,
                "rays": ffi.cast("WgRay *", int(sim_ffi.cast("uintptr_t", rays))),
                "patience": tuple(patience),
                "looks": ffi.cast("WgLook *", writable(ffi, self.looks.view(np.uint8), np.uint8)),
            },
            ffi,
        )
        # What the settings point to belongs to the runs that they come from.
        held = (arrays, described_discs, rays, self._settings, self.looks, settings)
        self.c: Any = kept(ffi, batch, held)

    def __len__(self) -> int:
        return len(self.looks)

    @property
    def at(self) -> int:
        """The next run, or the one in progress."""
        return int(self.c.at)

    @at.setter
    def at(self, run: int) -> None:
        self.c.at = run

    @property
    def beams(self) -> int:
        """Number of range beams of the robots."""
        return int(self._settings[0].beams)

    def results(self) -> Columns:
        """Return the results of the runs, in this process's memory."""
        if not self.memory.is_shared:
            return self.looks
        # This includes the padding between columns, so that bytes can be compared.
        return self.looks.view(np.uint8).copy().view(LOOK)

    def note_fault(self, run: int, fault: ControllerError) -> None:
        """Record how the controller failed in a run, whose steps are known.

        Equal crashes share a number, so that a frequent one does not keep others from being proved.
        """
        ended = self.looks[run : run + 1]
        ended["ending"] = _OF_FAULTS[fault.verdict]
        ended["overlap_step"] = -1
        if fault.verdict == Verdict.CRASH:
            bucket = crash_bucket(replace(fault.evidence, step=int(ended["steps"][0])))
            ended["hit_ix"] = zlib.crc32(bucket.encode()) & _CRASH_NUMBERS

    def leave_out(self, runs: Any) -> None:
        """Mark runs as not run."""
        self.looks["distance"][runs] = -1
        self.looks["ending"][runs] = NOT_RUN


class Seat:
    """A robot that runs in one world of a batch after another.

    Args:
        batch: The runs.
        memory: The controller's memory at reset; write into :attr:`memory` before a run begins to
            change it.
        driver: A controller that is a function of a core; without one the core stops whenever the
            controller must act.
        number: Number of the seat, for an owner of many.
    """

    def __init__(
        self, batch: Batch, memory: Sequence[float], driver: Driver | None = None, number: int = 0
    ) -> None:
        room = batch.memory
        self.memory = room.own(np.array(memory, np.float64))
        held = (batch.c, driver and driver.c, self.memory)
        controller = kept(ffi, room.new("WgController *", ffi=ffi), held)
        controller.memory_size = len(self.memory)
        if len(self.memory):
            controller.memory = pointer(ffi, self.memory, np.float64)
        if driver is not None:
            controller.act = ffi.cast("WgAct", int(ffi.cast("uintptr_t", driver.c.act)))
            controller.flat = ffi.cast("WgFlatAct", int(ffi.cast("uintptr_t", driver.c.flat)))
            controller.cage = ffi.cast("WgCage *", int(sim_ffi.cast("uintptr_t", driver.c.cage)))
        if driver is not None and driver.cage is not None:
            self.c: Any = self._placed(batch, controller)
        else:
            made = ffi.new("WgSeat **")
            check(lib.wg_seat_new(batch.c, controller, made))
            self.c = kept(ffi, made[0], controller, free=lib.wg_seat_free)
        self.c.number = number

    @staticmethod
    def _placed(batch: Batch, controller: Any) -> Any:
        """Return a WgSeat that the process that runs its robot can find."""
        sizes = ffi.new("int64_t[3]")
        check(lib.wg_seat_sizes(batch.c, controller, sizes))
        blocks = [batch.memory.new("char[]", size) for size in sizes]
        places = ffi.new("void *[3]", [ffi.cast("void *", block) for block in blocks])
        made = lib.wg_seat_place(places, batch.c, controller)
        return kept(ffi, made, blocks, controller)

    @property
    def episode(self) -> Any:
        """Its episode, in the form that :class:`sim.runners.core_calls.Workspace` takes."""
        return SimpleNamespace(c=self.c.episode, seat=self)

    def begin(self) -> None:
        """Put the robot at its start."""
        check(lib.wg_seat_begin(self.c))


@functools.cache
def _sizes(robots: SceneRobots) -> tuple[list[tuple[int, int]], Ints, int]:
    """Return the squared clear distances and reaches of robots, target radii, and a path's reach.

    All are in lattice units; the last is 0 for each robot's own.
    """
    plain = bytes(layout_bytes.LAYOUT_BYTES)
    side = robots.cell_size

    def disc(radius: float) -> tuple[int, int]:
        return disc_numbers(decode_world(plain, robot_radius=radius, cell_size=side))

    own = robots.target_radius
    radii = target_radii(side) if own is None else (own,)
    within = [in_cells(radius, side) * UNIT for radius in radii]
    targets = np.array([math.floor(w * w) for w in within], np.int64)
    flood_reach = disc(robots.passage)[1] if robots.passage else 0
    return [disc(radius) for radius in robots.radii], targets, flood_reach
