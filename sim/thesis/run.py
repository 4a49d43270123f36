"""Pack a world for the thesis's simulator, run it, and convert the result to the world's frame.

The thesis's frame is in pixels, with y down, headings that grow clockwise from -x, and ten pixels
per cell. Its maps have a border of walls. A world with an open border gets a wall around it that
represents the solid outside; the robot then enters the cells next to that border only as far as its
disc fits.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.base import Controller
from sim.controllers.catalogue import CONTROLLERS
from sim.evidence import BudgetEvidence
from sim.options.robot import SIGNALS
from sim.options.run import RunOptions, check_recordable, check_step_length
from sim.options.thesis import ARBITERS, ThesisOptions
from sim.outcome import ENDINGS, Outcome
from sim.runners.controller_host import host_of
from sim.runners.drifting import period_of
from sim.runners.packing import disc_numbers, event_step, refuse_unless_plain, start_overlaps
from sim.thesis.core_calls import (
    CELL,
    STATE_FIELDS,
    WALL,
    ThesisEpisode,
    ThesisSetup,
    add_noise,
    new_rows,
    signal_map,
)
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.lattice import exact, in_cells, metres_to_lattice, radius_in_cells
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools, Floats, Ints, Words
from worldgen.support.ccall import pointer
from worldgen.support.rows import flip_rows
from worldgen.timeline import CellState
from worldgen.world import World

Cells = npt.NDArray[np.int32]
Rows = npt.NDArray[np.void]

# Random numbers that a run of the random rule gets at first; if they run out, it gets more.
_FIRST_DRAWS = 256
_CAUSES = {
    lib.WG_STRAIGHT: "",
    lib.WG_SLIDE: "slide",
    lib.WG_BACK_OFF: "back-off",
    lib.WG_CORNER: "corner",
}
_REPAIR_BITS = {
    "repair_slide": lib.WG_REPAIR_SLIDE,
    "repair_back_off": lib.WG_REPAIR_BACK_OFF,
    "repair_corner": lib.WG_REPAIR_CORNER,
}
# Pixels and rad. Poses that differ by less than this count as the same.
_DRIFT = 1e-6


class ThesisRun:
    """One world, robot of the thesis and set of options, ready to run any number of times.

    Args:
        world: The world to drive in.
        controller: The controller; it must be one of the thesis's.
        options: Options of the run.

    Raises:
        InvalidParameter: If it is another controller, the robot is wider than two cells, or the
            step longer than a cell allows.
        InvalidWorld: If start or target are in a wall.
    """

    def __init__(self, world: World, controller: Controller, options: RunOptions) -> None:
        rule = host_of(controller).thesis_rule
        if not rule:
            raise InvalidParameter(
                "motion-is-the-thesis-robots",
                "motion {name!r} runs the thesis's own robots: turn-left, turn-right, turn-random",
                "use --motion swept or endpoint for other controllers",
                at_terminal=True,
                name=options.motion,
            )
        refuse_unless_plain(world, "stepped", "not-for-stepped")
        self.world = world
        self.options = options
        check_step_length(world, options.time_step, Fraction(0))
        closed = bool(world.walls[[0, -1]].all() and world.walls[:, [0, -1]].all())
        self._pad = 0 if closed else 1
        self._height = world.height + 2 * self._pad
        solid = self._solid()
        target = self._target_cell(solid)
        self._cells, self._light = self._signal(solid, *target)
        self.setup = self._robot(rule, *target)
        self._events = self._event_rows()
        self._start = self._start_pose()

    def _radius(self) -> float:
        radius = radius_in_cells(self.world)
        if radius > 1:
            raise InvalidParameter(
                "robot-larger-than-cell",
                "robot_radius={robot_radius:g} m is {cells:g} cells; stepped looks one "
                "cell around the robot, so its radius can be at most 1 cell: use swept",
                robot_radius=self.world.robot_radius,
                cells=float(radius),
            )
        return float(radius * 10)

    def _robot(self, rule: int, target_x: int, target_y: int) -> ThesisSetup:
        """Return the robot in the thesis's units, px and ms."""
        world = self.world
        options = self.options
        thesis = self.options.thesis
        px = 10 / exact(world.cell_size)
        return ThesisSetup(
            rule=rule,
            time_step=float(exact(options.time_step) * 1000),
            sense=thesis.sensor_cells,
            collide_ticks=thesis.collide_ticks,
            drive_ticks=thesis.drive_ticks,
            turn_angle=thesis.turn_angle,
            radius=self._radius(),
            speed=float(exact(world.robot_speed) * px / 1000),
            tolerance=options.motion_model().overlap_tolerance * CELL,
            stop_at_tunnel=int(not thesis.keep_going),
            reading=ARBITERS.index(thesis.arbiter),
            repairs=sum(bit for name, bit in _REPAIR_BITS.items() if getattr(thesis, name)),
            acceleration=float(exact(thesis.acceleration) * px / 1_000_000),
            friction=float(exact(thesis.friction) * px / 1_000_000),
            wall_friction=thesis.wall_friction,
            slip=thesis.slip,
            sensor_field=thesis.sensor_field,
            sensor_noise=thesis.sensor_noise,
            signal=SIGNALS.index(thesis.signal),
            map_scale=thesis.map_scale,
            target_x=target_x,
            target_y=target_y,
            seed=RandomStream(options.seed).child("slip and sensor").next64() >> 1,
        )

    def _solid(self) -> Bools:
        """Return (width, height) bool, the walls in the thesis's frame."""
        walls = np.pad(self.world.walls, 1, constant_values=True) if self._pad else self.world.walls
        return np.ascontiguousarray(flip_rows(walls).T)

    def _target_cell(self, solid: Bools) -> tuple[int, int]:
        """Return the target's cell in the thesis's frame."""
        world = self.world
        target_x = math.floor(in_cells(world.target.x, world.cell_size)) + self._pad
        target_y = self._row(math.floor(in_cells(world.target.y, world.cell_size)))
        inside = 0 < target_x < solid.shape[0] - 1 and 0 < target_y < self._height - 1
        if not inside or solid[target_x, target_y]:
            raise InvalidWorld(
                "target-in-wall",
                "target ({x:g}, {y:g}) m is in a wall cell, which has no signal",
                "move it",
                x=world.target.x,
                y=world.target.y,
            )
        return target_x, target_y

    def _signal(self, solid: Bools, target_x: int, target_y: int) -> tuple[Cells, Cells]:
        """Return the signal map with walls, and without."""
        light = signal_map(solid.shape[0], self._height, target_x, target_y)
        cells = np.ascontiguousarray(np.where(solid, np.int32(WALL), light))
        if self.options.thesis.noise:
            add_noise(cells, light)
        return cells, light

    def _event_rows(self) -> Ints:
        rows = [
            (
                event_step(event, self.options.time_step),
                event.ix + self._pad,
                self._row(event.iy),
                int(event.state),
            )
            for event in self.world.timeline
        ]
        return np.array(rows, np.int64).reshape(-1, 4)

    def _start_pose(self) -> tuple[float, float, float]:
        world = self.world
        side = self.world.cell_size
        clear_sq, reach = disc_numbers(world)
        x = metres_to_lattice(world.start.x, side)
        y = metres_to_lattice(world.start.y, side)
        # The robot must fit at its start; this calls the same C function as the other motion
        # models.
        solid = np.array(world.walls, np.uint8, order="C")
        grid = {
            "cells": pointer(ffi, solid, np.uint8),
            "width": world.width,
            "height": world.height,
        }
        disc = {"clear_sq": clear_sq, "reach": reach}
        if not lib.wg_disc_is_clear(grid, lib.WG_SOLID, disc, x, y):
            raise start_overlaps(world)

        # Convert to pixels, with y down and headings that grow clockwise from -x.
        x_px = float(in_cells(world.start.x, side) * 10 + 10 * self._pad)
        y_px = float((self._height - self._pad - in_cells(world.start.y, side)) * 10)
        return x_px, y_px, (math.pi - world.start.heading) % (2.0 * math.pi)

    @property
    def last_event_step(self) -> int:
        """Step at whose beginning the world changes for the last time; 0 if it never changes."""
        return int(self._events[-1, 0]) if len(self._events) else 0

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Simulate up to ``steps`` ticks from the start; see :meth:`sim.outcome.Runnable.run`."""
        seeks = find_loop and not self.options.thesis.random
        search = lib.WG_SEEK_LOOP if seeks else lib.WG_NO_LOOP
        return self._run(steps, record=record, find_loop=search, digest=int(digest))[0]

    def prove(self, entry: int, period: int, *, record: bool) -> tuple[Outcome, Words] | None:
        """Simulate a loop's first period; see :meth:`sim.outcome.Runnable.prove`."""
        outcome, episode = self._run(
            entry + period, record=record, find_loop=lib.WG_PROVE_LOOP, loop_entry=entry
        )
        return (outcome, episode.proved_state()) if outcome.ending == Verdict.LOOP else None

    def _run(self, steps: int, *, record: bool, **fields: int) -> tuple[Outcome, ThesisEpisode]:
        """Run once from the start, with some fields of the setup changed."""
        rows = new_rows(steps + 1 if record else 0)
        episode = self._episode(steps, **fields)
        self._go_on(episode, steps, rows, 0)
        return self._outcome(
            episode.run, rows[: episode.run.steps + 1] if record else None
        ), episode

    def _episode(self, steps: int, **fields: int) -> ThesisEpisode:
        setup = self.setup._replace(steps=steps, **fields)
        return ThesisEpisode(self._cells, self._light, self._events, self._start, setup)

    def _go_on(self, episode: ThesisEpisode, until: int, rows: Rows, first_row: int) -> None:
        """Continue until the run is decided or a step is done, with as many draws as that takes."""
        count = _FIRST_DRAWS if self.setup.rule == lib.WG_RULE_RANDOM else 0
        while not episode.go(until, self._draws(count), rows, first_row):
            count *= 4

    def _draws(self, count: int) -> Floats:
        given = np.array(self.options.thesis.draws)
        return np.concatenate([given, RandomStream(self.options.seed).floats(count)])

    def signal(self) -> npt.NDArray[np.int32]:
        """Return the signal with walls in the world's frame; see :func:`signal_in`."""
        inner = slice(self._pad, -self._pad or None)
        return np.ascontiguousarray(flip_rows(self._cells[inner, inner].T))

    def with_confinement(self, evidence: BudgetEvidence, outcome: Outcome) -> BudgetEvidence:
        """Add to a stalled run's evidence how it behaves in the second half of its steps.

        It drifts if its poses recur within a millionth of a pixel; otherwise it is only confined.
        """
        steps = outcome.steps
        check_recordable(steps)
        # Run the first half without recording, and record the second.
        half = steps // 2
        episode = self._episode(steps, digest=0)
        self._go_on(episode, half, new_rows(0), 0)
        rows = new_rows(steps - half + 1)
        self._go_on(episode, steps, rows, half)

        # Measure the box of cells that it visits, and look for a period.
        poses = np.stack([rows["x"], rows["y"], rows["heading"]], axis=1)
        cells = np.floor(poses[:, :2] / CELL)
        columns, cell_rows = (int(side) for side in np.ptp(cells, axis=0) + 1)
        box = (columns, cell_rows)
        period, entry = period_of(poses, _DRIFT)
        if period == 0:
            return replace(evidence, kind="confined", box=box)
        return replace(evidence, kind="drifting", entry=half + entry, period=period, box=box)

    def _outcome(self, run: Any, rows: Rows | None) -> Outcome:
        """Return the outcome of a finished run, a ``WgThesisRun``, in the world's frame."""
        metres = self.world.cell_size / CELL
        ending = ENDINGS[run.ending]
        tunnelled = ending == Verdict.TUNNEL
        keeps_going = self.options.thesis.keep_going
        overlapped = run.overlap.step >= 0 and not keeps_going
        # Only a run that ended in a wall has a cause, and only if walls end runs.
        cause = ""
        cause_step = -1
        if tunnelled or overlapped:
            place = run.tunnel if tunnelled else run.overlap
            cause = _CAUSES[place.cause]
            cause_step = place.began
        hit = run.tunnel if tunnelled else run.hit
        return Outcome(
            ending=ending,
            steps=run.steps,
            period=run.period,
            entry=run.entry,
            path_length=run.path_length * metres,
            collisions=run.collisions,
            digest=f"{run.digest:016x}",
            last_new_cell=run.last_new_cell,
            hit_step=hit.step,
            hit_cell=self._cell(hit),
            hit_state=CellState(run.hit.state).word,
            overlap_step=run.overlap.step if overlapped else -1,
            overlap_cell=self._cell(run.overlap),
            cause=cause,
            cause_step=cause_step,
            wall_step=run.in_wall.step if keeps_going else -1,
            complete=not self.options.thesis.random,
            random_draws=run.state.draws_used,
            cells_visited=run.visited,
            trace=None if rows is None else self._trace(rows),
        )

    def _cell(self, place: Any) -> tuple[int, int]:
        """Return a place's cell in the world's frame; the added border is just outside it."""
        return place.x - self._pad, self._row(place.y)

    def _row(self, row: int) -> int:
        """Return a row of the world in the thesis's frame, or the other way round."""
        return self._height - 1 - self._pad - row

    def _trace(self, rows: Rows) -> Trace:
        """Return the recorded rows in metres and radians."""
        metres = float(exact(self.world.cell_size) / 10)
        x = (rows["x"] - 10.0 * self._pad) * metres
        y = ((self._height - self._pad) * 10.0 - rows["y"]) * metres
        heading = (2.0 * math.pi - rows["heading"]) % (2.0 * math.pi) - math.pi
        return Trace(
            time_step=self.options.time_step,
            x=x,
            y=y,
            heading=heading,
            bump=rows["collision"] != 0,
            path_x=x,
            path_y=y,
            path_step=np.arange(len(rows)),
            path_share=np.minimum(np.arange(len(rows)), 1.0),
            words=_digest_words(rows[1:]),
            states=np.ascontiguousarray(_table(rows)[:, : len(STATE_FIELDS)]).view(np.uint64),
            complete=not self.options.thesis.random,
            active=rows["active"].astype(np.int8),
        )


def signal_in(world: World, *, noise: bool = False) -> npt.NDArray[np.int32]:
    """Return the signal that the thesis's robot reads in each cell of a world.

    It is the squared distance to the target's cell, in cells.

    Args:
        world: The world.
        noise: Whether the noise filter has changed it near walls.

    Returns:
        (height, width) int32, row 0 is the lowest y; -2 in walls, and in a border that is open.

    Raises:
        InvalidWorld: If start or target are in a wall.
        InvalidParameter: If the robot is wider than two cells.
    """
    options = RunOptions("stepped", thesis=ThesisOptions(noise=noise))
    return ThesisRun(world, CONTROLLERS.get("thesis-1"), options).signal()


def _table(rows: Rows) -> Floats:
    """Return (n, fields) float64, the rows of a trace as plain numbers."""
    return rows.view(np.float64).reshape(len(rows), -1)


def _digest_words(rows: Rows) -> Words:
    """Return (n, 7) words, for each tick those from which recorded digests are computed."""
    words = np.zeros((len(rows), 7), np.uint64)
    for k, name in enumerate(("x", "y", "heading", "target_heading", "speed")):
        words[:, k] = rows[name].copy().view(np.uint64)
    behaviour = rows["behaviour"].astype(np.int64)
    busy = np.where(behaviour < 0, 0, 2 + 4 * (behaviour + 1))
    words[:, 5] = (rows["collision"].astype(np.int64) + busy).astype(np.uint64)
    words[:, 6] = rows["ticks_left"].copy().view(np.uint64)
    return words
