"""Screening runs of many layouts: pack them for the core, run it, read the results back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzz._core import lib
from fuzz.layouts import layout_bytes
from fuzz.layouts.features import RADII, arena_for, decode_scene
from fuzz.layouts.variation import layout_disc, overrides_in, with_robot
from fuzz.screening.batch import CRASH, HANG, NOT_RUN, Batch, Patience, SceneRobots, Seat
from fuzz.screening.in_core import screen_in_core
from fuzz.screening.in_lockstep import screen_in_batch, screen_in_lockstep
from fuzz.screening.one_by_one import OneByOne, SeededOptions
from sim.controllers import CONTROLLERS
from sim.motion import MOTIONS
from sim.options.run import MAX_STEPS, TARGET
from sim.outcome import ENDINGS
from sim.runners.controller_host import ControllerHost, host_of
from sim.runners.lattice import LatticeRun
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.lattice import TURN, UNIT
from worldgen.support.arrays import Bools, Bytes, Floats, Ints, Words
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

WIDEST = 1.5 * DEFAULT_CELL_SIZE
"""Largest radius of a robot, m: a cell around start and target is free in every layout."""

_KNOWN = {**ENDINGS, lib.WG_LIMIT: "undecided", NOT_RUN: "", HANG: Verdict.HANG}
_FIRST_LOOKS = np.array([str(_KNOWN[ending]) for ending in range(NOT_RUN, max(_KNOWN) + 1)])
# Exceeds the key of any run without a crash.
_MOST_KEYS = 1 << 16
# Patience of screening runs. It equals a witness's budget, so a run that spends it has failed,
# except on the longest paths.
_PATIENT = Patience(50, 4_000, 8_000, 600)
# If each step takes microseconds, failing runs take most of the time, so they are shorter. They are
# proved with the full budget anyway.
_BRISK = Patience(15, 800, 2_400, 150)


@dataclass(frozen=True, eq=False)
class Screening:
    """Screening runs in many worlds; every array is of shape (n,).

    If the flood found no path to the target, nothing was simulated: ``ran`` is False there, and
    only ``layout`` has a meaning.

    Args:
        layouts: (n, LAYOUT_BYTES or SCENE_BYTES) uint8.
        scenario: The scenario; :meth:`scenario_of` knows the seed and time step of each run.
        seeds: uint64.
        time_steps: s.
        raw: (n,) :data:`fuzz.screening.batch.LOOK`.
        robot: What is the same for all robots, whatever the scenes say.
        deaths: Runs that ended the process that ran a shared library's controller.
    """

    layouts: Bytes
    scenario: Scenario
    seeds: Words
    time_steps: Floats
    raw: npt.NDArray[np.void]
    robot: Mapping[str, Value] = field(default_factory=dict)
    deaths: int = 0

    def __len__(self) -> int:
        return len(self.raw)

    @property
    def ran(self) -> Bools:
        """True if the robot can certainly reach the target, so that the controller was run."""
        found: Bools = self.raw["distance"] >= 0
        return found

    @property
    def ending(self) -> Ints:
        """The ending, such as ``WG_LIMIT``, from ``sim/core/wg_sim.h``."""
        return self.raw["ending"]

    @property
    def verdict(self) -> npt.NDArray[np.str_]:
        """The verdict in screening: ``undecided`` if the budget was spent, empty if nothing ran."""
        ending = self.ending
        overlaps = self.raw["overlap_step"] >= 0
        covered = overlaps & np.isin(ending, (lib.WG_LIMIT, lib.WG_REACHED, lib.WG_LOOP))
        return np.where(covered, Verdict.OVERLAP.value, _FIRST_LOOKS[ending + 1])

    @property
    def failed(self) -> Bools:
        """True if the controller was run and did not arrive as it should."""
        found: Bools = self.ran & (self.verdict != Verdict.REACHED.value)
        return found

    @property
    def steps(self) -> Ints:
        """Steps until the run ended; for a loop, until it was found."""
        return self.raw["steps"]

    @property
    def budget(self) -> Ints:
        """Budget of the run, steps."""
        return self.raw["budget"]

    @property
    def simulated(self) -> int:
        """Total steps simulated, including those that were only watched."""
        return int(self.steps.sum() + self.raw["watched"].sum())

    @property
    def period(self) -> Ints:
        """Period of a loop, steps."""
        return self.raw["period"]

    @property
    def collisions(self) -> Ints:
        """Number of times that the robot began to touch a wall."""
        return self.raw["collisions"]

    @property
    def solid(self) -> Ints:
        """Number of solid cells."""
        return self.raw["solid"]

    @property
    def density(self) -> Floats:
        """Share of the cells inside the border that are solid."""
        width = self.raw["width"]
        height = self.raw["height"]
        share: Floats = (self.solid - 2 * (width + height - 2)) / ((width - 2) * (height - 2))
        return share

    @property
    def way(self) -> Ints:
        """Cells of a path to the target along edges, an upper bound of the shortest."""
        return self.raw["distance"]

    @property
    def straight(self) -> Floats:
        """Distance from start to target, cells."""
        cells: Floats = np.sqrt(self.raw["straight_sq"])
        return cells

    @property
    def path(self) -> Floats:
        """Driven length, lattice units."""
        return self.raw["path_length"]

    @property
    def driven(self) -> Floats:
        """Driven length, cells."""
        cells: Floats = self.path / UNIT
        return cells

    @property
    def visited(self) -> Ints:
        """Cells that the robot's centre visited."""
        return self.raw["visited"]

    @property
    def revisits(self) -> Floats:
        """Driven cells per visited cell.

        About 1 for a robot that visits no place twice.
        """
        return self.driven / np.maximum(self.visited, 1)

    @property
    def mean_clearance(self) -> Floats:
        """Mean distance to the nearest wall over the visited cells: 1, 2, or 3 for more."""
        return self.raw["clearances"] / np.maximum(self.visited, 1)

    @property
    def key(self) -> Ints:
        """A coarse signature of what went wrong, the same in a mirrored, turned or shifted world.

        It is made of the ending; of touches, kind of contact, turning, extent and progress in one
        period of a loop, or in a few more steps of a run that spent its budget; and of the kind of
        wall that a robot went through or into, or that ended its run. It approximates the failure's class
        (docs/reference/verdicts.md) without a recording. It is 0 if the robot arrived or nothing
        ran.
        """
        raw = self.raw
        made = self.ending + 1
        facts = (
            (raw["overlap_step"] >= 0, 2),
            (np.minimum(raw["bumps"], 3), 4),
            (raw["contact"], 6),
            (np.abs(raw["turned"]) >= TURN, 2),
            (np.searchsorted(np.array([0.5, 4.0, 16.0]) * UNIT, self._extent), 4),
            (raw["closer"], 2),
            (np.minimum(raw["around"], 3) + 1, 5),
        )
        for fact, kinds in facts:
            made = made * kinds + fact
        # OneByOne distinguishes crashes by a number here; compiled controllers leave 0.
        crashed = np.where(self.ending == CRASH, np.maximum(raw["hit_ix"], 0), 0)
        made += crashed * _MOST_KEYS
        return np.where(self.failed, made, 0)

    @property
    def _extent(self) -> Ints:
        """Larger side of the robot's bounding box while it was watched, lattice units."""
        raw = self.raw
        wide = raw["right"] - raw["left"]
        larger: Ints = np.maximum(wide, raw["high"] - raw["low"])
        return larger

    def world(self, n: int) -> World:
        """Return the world of a run, without certificate."""
        return _world_of(self.layouts, n, self.robot)

    def scenario_of(self, n: int) -> Scenario:
        """Return the scenario of a run, with its seed and time step."""
        return self.scenario.with_run(seed=int(self.seeds[n]), time_step=float(self.time_steps[n]))


def can_screen(scenario: Scenario) -> bool:
    """Return True if native search can run a scenario.

    It can run any controller with a target to reach, under a motion model on the pose lattice.
    """
    reaches = scenario.run.task == TARGET
    return reaches and MOTIONS.get(scenario.run.motion).on_lattice


def evaluate(
    layouts: Bytes,
    scenario: Scenario,
    seeds: Words,
    time_steps: float | npt.ArrayLike,
    budget: int | npt.ArrayLike | None = None,
    **robot: Value,
) -> Screening:
    """Run a controller once in the world of each layout and describe the result without proving it.

    Each run equals, bit for bit, that of :func:`sim.simulate` in ``decode_scene(layout)`` with the
    scenario's options, the run's seed and time step, and the same budget. If no path is certainly
    wide enough for the robot, nothing is run. The result depends only on the arguments. Threads may
    call it with a compiled controller at the same time. After the second hang of a program or a
    shared library, stop the runs.

    Args:
        layouts: (n, LAYOUT_BYTES) or (n, SCENE_BYTES) uint8, any bytes.
        scenario: The scenario; its seed and time step are ignored.
        seeds: (n,) uint64.
        time_steps: Time steps, s; (n,), or one for all.
        budget: Steps, (n,) or one for all; if omitted, derived from the path to the target: 4,000
            to 8,000 for a compiled controller, 800 to 2,400 for another.
        **robot: Quantities of all robots, overriding the bytes of their worlds, by their names in
            :data:`fuzz.layouts.variation.OF_THE_ROBOT`: ``robot_radius`` (m, at most
            :data:`WIDEST`), ``robot_speed`` (m/s), ``robot_footprint``, ... With a body, cells grow
            so that the disc for which worlds are laid out is as wide as the usual robot.

    Raises:
        InvalidParameter: If the scenario or robot cannot run natively, or the arrays do not match.
    """
    _check(layouts, scenario, budget, robot)
    count = len(layouts)
    # Single values apply to all layouts.
    steps = _spread(np.asarray(time_steps, np.float64), count, "time_steps")
    numbers = _spread(np.asarray(seeds, np.uint64), count, "seeds")
    limits = _spread(np.asarray(0 if budget is None else budget, np.int64), count, "budget")
    # Layouts with the same time step share a packed scenario.
    values, kinds = np.unique(steps, return_inverse=True)
    packed = _Packed.of(scenario, tuple(values.tolist()), robot)
    batch = packed.batch(np.array(layouts), numbers, kinds.astype(np.int64), limits)
    packed.run(
        batch,
        lambda n: _world_of(layouts, n, robot),
        lambda n: (packed.runs[kinds[n]].options, int(numbers[n])),
    )
    return Screening(layouts, scenario, numbers, steps, batch.results(), robot, batch.deaths)


def _check(layouts: Bytes, scenario: Scenario, budget: Any, robot: Mapping[str, Value]) -> None:
    """Reject arguments that the core cannot process."""
    widths = (layout_bytes.LAYOUT_BYTES, layout_bytes.SCENE_BYTES)
    if layouts.ndim != 2 or layouts.shape[1] not in widths or layouts.dtype != np.uint8:
        raise InvalidParameter(
            "wrong-shape",
            "the layouts have shape {shape} and type {dtype}",
            "use uint8 with {narrow} or {wide} bytes per row",
            shape=layouts.shape,
            dtype=layouts.dtype,
            narrow=widths[0],
            wide=widths[1],
        )
    if not can_screen(scenario):
        raise InvalidParameter(
            "not-native",
            "{controller} under {motion} does not run natively",
            "use --motion swept or endpoint",
            at_terminal=True,
            controller=scenario.label(),
            motion=scenario.run.motion,
        )
    if (
        budget is not None
        and np.size(budget)
        and not (np.min(budget) >= 1 and np.max(budget) <= MAX_STEPS)
    ):
        raise InvalidParameter(
            "out-of-range",
            "budget={budget!r} is outside 1 to {most} steps",
            "use one between",
            budget=budget,
            most=MAX_STEPS,
        )
    radius = robot.get("robot_radius", 0.0)
    if not isinstance(radius, float) or radius > WIDEST:
        raise InvalidParameter(
            "robot-too-wide",
            "robot_radius={robot_radius:g} m is more than {widest:g} m, the room around start and "
            "target in the worlds of native search",
            "use a smaller one, or use another strategy",
            robot_radius=radius,
            widest=WIDEST,
        )


def _world_of(layouts: Bytes, n: int, robot: Mapping[str, Value]) -> World:
    _, cell_size = layout_disc(robot)
    return with_robot(decode_scene(layouts[n].tobytes(), cell_size=cell_size), robot)


def _spread(values: Any, count: int, name: str) -> Any:
    """Return one value per run."""
    if values.shape not in ((), (count,)):
        raise InvalidParameter(
            "wrong-shape",
            "{name} has shape {shape}, but there are {count} layouts",
            "use one per layout, or one for all",
            name=name,
            shape=values.shape,
            count=count,
        )
    return np.array(np.broadcast_to(values, (count,)))


def _scene_robots(world: World, robot: Mapping[str, Value]) -> SceneRobots:
    """Return the sizes of robots like one that is packed, and of their cells."""
    is_fixed = "robot_radius" in robot or not world.robots[0].is_disc
    radii = (world.robot_radius,) if is_fixed else RADII
    passage, cell_size = layout_disc(robot)
    overrides = overrides_in(robot)
    own_passage = passage if overrides.changes_body else 0.0
    return SceneRobots(radii, cell_size, own_passage, overrides.target_radius)


@dataclass(frozen=True)
class _Packed:
    """A scenario in the form that the core expects."""

    host: ControllerHost
    runs: tuple[LatticeRun, ...]
    robots: SceneRobots

    @classmethod
    def of(
        cls, scenario: Scenario, time_steps: Sequence[float], robot: Mapping[str, Value]
    ) -> _Packed:
        """Pack the simplest layout for each time step.

        The core replaces the parts that other layouts have.
        """
        host = host_of(CONTROLLERS.get(scenario.controller))
        world = arena_for(robot)
        each = (scenario.with_run(time_step=time_step).options(world) for time_step in time_steps)
        runs = tuple(LatticeRun(world, host, options) for options in each)
        return cls(host, runs, _scene_robots(world, robot))

    def batch(self, layouts: Bytes, seeds: Words, kinds: Ints, budgets: Ints) -> Batch:
        """Return the runs of one call."""
        for run in self.runs:
            run.settings.find_loop = run.search
            run.settings.digest = 0
        patience = _PATIENT if self.host.in_core else _BRISK
        settings = [run.settings for run in self.runs]
        memory = self.runs[0].memory
        return Batch(layouts, seeds, kinds, budgets, settings, self.robots, patience, memory)

    def run(
        self, batch: Batch, world: Callable[[int], World], options: Callable[[int], SeededOptions]
    ) -> None:
        """Fill in the results."""
        if len(batch) == 0:
            return
        # Compiled controllers run inside the core.
        if self.host.in_core:
            driver = self.runs[0].driver()
            screen_in_core(driver, Seat(batch, self.host.begin(None), driver), batch)
            return
        # Programs and vector classes act for many robots at once, unless they break a rule.
        alone = OneByOne(self.host, batch, world, options)
        if not self.host.in_python:
            if self.host.controller.offer is None:
                # Its first answer may offer to act for many robots.
                alone.run(1)
            begun = batch.at
            if screen_in_batch(self.host, batch):
                return
            batch.at = begun
        elif self.host.acts_for_many:
            if screen_in_lockstep(self.host, batch):
                return
            batch.at = 0
        alone.run(len(batch))
