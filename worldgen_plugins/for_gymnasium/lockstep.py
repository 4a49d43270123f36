"""Robots in lockstep: packs worlds and robots for the core, and calls it. No maths of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim import CompiledController
from sim._core import ffi, lib
from sim.runners.core_calls import MOST_CORNERS, STATE_WORDS
from sim.runners.lattice import LatticeRun
from worldgen.lattice import lattice_to_metres
from worldgen.support.ccall import check, pointer, writable
from worldgen.world import World
from worldgen_plugins.for_gymnasium.distances import distances_to_target
from worldgen_plugins.for_gymnasium.options import Rules

__all__ = ["Lockstep", "StepResult"]

Ints = npt.NDArray[np.int64]
Singles = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]


def _nobody(observation: npt.NDArray[np.float64], memory: object, command: object) -> None:
    """Never called: an environment's actions are its commands."""


class StepResult(NamedTuple):
    """What a call says of each robot; made anew for each.

    Args:
        observation: (n, size) float32.
        reward: (n,).
        terminated: (n,) whether it arrived, or burned.
        truncated: (n,) whether its time is over.
        reached: (n,) whether it arrived.
        began: (n,) whether the observation is the first of an episode.
        last: (n, size) float32, the last observation of an episode after which the next began in
            the same step; of no rows where that does not happen.
    """

    observation: Singles
    reward: npt.NDArray[np.float64]
    terminated: Bools
    truncated: Bools
    reached: Bools
    began: Bools
    last: Singles

    def in_core(self) -> Any:
        """Return the WgTold whose memory this is."""
        told = ffi.new("WgTold *")
        for name, array in self._asdict().items():
            setattr(told, name, writable(ffi, array, array.dtype.type))
        return told


_OF_ROBOTS = ("world", "seed", "episode", "run", "clock", "elapsed", "distance", "over")


class RobotArrays:
    """What the core knows of n robots, as arrays over its memory.

    Args:
        rules: What an episode is.
        numbers: WgRules.
        count: Robots.
        size: Numbers of an observation.
    """

    def __init__(self, rules: Rules, numbers: Any, count: int, size: int) -> None:
        self.world = np.zeros(count, np.int64)
        self.seed = np.zeros(count, np.uint64)
        self.episode = np.zeros(count, np.int64)
        self.run = np.zeros(count, np.int64)
        self.clock = np.zeros(count, np.int64)
        self.elapsed = np.zeros(count, np.int64)
        self.distance = np.zeros(count)
        self.over = np.zeros(count, np.bool_)
        self.state = np.zeros((count, STATE_WORDS), np.int64)
        self.c: Any = ffi.new("WgCrew *")
        for name in _OF_ROBOTS:
            array = getattr(self, name)
            setattr(self.c, name, writable(ffi, array, array.dtype.type))

        # What all share.
        interface = rules.interface
        codes = interface.codes
        choices = interface.choices
        beams = np.full(interface.needs.beams, np.nan)
        self.c.count = count
        self.c.size = size
        self.c.rules = numbers
        self.c.sensors = pointer(ffi, codes, np.int64)
        self.c.sensor_count = len(codes)
        self.c.choices = pointer(ffi, choices, np.float64)
        self.c.choice_count = len(choices)
        self.c.workspace.beams = writable(ffi, beams, np.float64)
        self.c.workspace.observation.beams = self.c.workspace.beams
        self.c.workspace.observation.beam_count = len(beams)
        self._robots = ffi.new("WgRobot[]", count)
        self.c.robots = self._robots
        self._held: tuple[Any, ...] = (numbers, codes, choices, beams)
        self._worlds: tuple[Any, ...] = ()
        self._chain: Any = ffi.NULL
        self._own: tuple[npt.NDArray[Any], ...] = ()

    def load(self, places: Any, runs: Sequence[LatticeRun], held: tuple[Any, ...]) -> None:
        """Put the robots into other worlds, of which ``held`` is the memory."""
        changing = [run.events for run in runs if len(run.events)]
        most = max(
            (int(np.unique(rows[:, 0], return_counts=True)[1].max()) for rows in changing),
            default=0,
        )
        self._chain = ffi.new("WgCorner[]", MOST_CORNERS * (most + 1))
        self._tie_robots()
        self.c.places = places
        self.c.place_count = len(runs)
        self.c.cells = ffi.NULL
        self.c.near = ffi.NULL
        self.c.page = 0
        self._own = ()
        if changing:
            self.c.page = max(run.world.walls.size for run in runs)
            shape = (len(self.world), self.c.page)
            cells = np.zeros(shape, np.uint8)
            near = np.zeros(shape, np.int32)
            self.c.cells = writable(ffi, cells, np.uint8)
            self.c.near = writable(ffi, near, np.int32)
            self._own = (cells, near)
        self._worlds = (places, held)

    def _tie_robots(self) -> None:
        """Give the robots their states and their chain."""
        lib.wg_crew_robots(
            self.c, ffi.cast("WgState *", writable(ffi, self.state, np.int64)), self._chain
        )

    def snapshot(self) -> tuple[list[npt.NDArray[Any]], bytes]:
        """Return all that changes as robots go."""
        arrays = [getattr(self, name) for name in _OF_ROBOTS]
        return [array.copy() for array in (*arrays, self.state, *self._own)], bytes(
            ffi.buffer(self._robots)
        )

    def restore(self, snapshot: tuple[list[npt.NDArray[Any]], bytes]) -> None:
        """Put everything back as it was; the same worlds must be loaded."""
        arrays, robots = snapshot
        own = [getattr(self, name) for name in _OF_ROBOTS]
        for array, before in zip((*own, self.state, *self._own), arrays, strict=True):
            array[...] = before
        ffi.memmove(self._robots, robots, len(robots))
        self._tie_robots()


class Lockstep:
    """n robots in some of w worlds.

    Args:
        rules: What an episode is.
        count: Robots.
        limit: Steps until an episode is cut off; 0 for never.
        autoreset: WG_NEXT_STEP, WG_SAME_STEP or WG_NO_AUTORESET.
    """

    def __init__(
        self, rules: Rules, count: int, limit: int = 0, autoreset: int = lib.WG_NO_AUTORESET
    ) -> None:
        self._rules = rules
        self.count = count
        self._limit = limit
        self._autoreset = autoreset
        interface = rules.interface
        self.size = sum(len(low) for low, _ in interface.bounds().values())
        self._driver = CompiledController("gymnasium", _nobody, senses=interface.senses)
        self.worlds: Sequence[World] = ()
        self.crew = RobotArrays(rules, rules.numbers(limit, autoreset), count, self.size)

    def __getstate__(self) -> tuple[Any, ...]:
        """Return what a copy is made of, which memory of the core cannot be."""
        return (
            self._rules,
            self.count,
            self._limit,
            self._autoreset,
            self.worlds,
            self.crew.snapshot(),
        )

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        """Make the copy."""
        rules, count, limit, autoreset, worlds, snapshot = state
        self.__init__(rules, count, limit, autoreset)  # type: ignore[misc]
        if worlds:
            self.load(worlds)
        self.crew.restore(snapshot)

    def load(self, worlds: Sequence[World]) -> None:
        """Puts the robots into other worlds; each must begin an episode before it steps.

        Raises:
            InvalidWorld: If the robot cannot stand at the start of one.
            InvalidParameter: If the time step does not go with a robot's speed.
        """
        options = self._rules.run_options()
        runs = [LatticeRun(world, self._driver, options) for world in worlds]
        arenas = [run.arena() for run in runs]
        ways = [distances_to_target(world) for world in worlds] if self._rules.by_way else []
        places = ffi.new("WgPlace[]", len(runs))
        for k, (run, arena) in enumerate(zip(runs, arenas, strict=True)):
            places[k].arena = arena.c[0]
            places[k].settings = run.settings[0]
            if ways:
                places[k].ways = pointer(ffi, ways[k], np.float32)
        self.crew.load(places, runs, (arenas, ways))
        self.worlds = worlds

    def begin(self, robot: int, world: int) -> Singles:
        """Puts one robot at the start of an episode in a world; its observation."""
        out = np.empty(self.size, np.float32)
        lib.wg_crew_begin(self._crew(), robot, world, writable(ffi, out, np.float32))
        return out

    def begin_many(self, which: Bools) -> StepResult:
        """Puts robots at the starts of episodes in the worlds that their seeds choose."""
        told = self._told()
        lib.wg_crew_begin_many(
            self._crew(), pointer(ffi, which, np.bool_), writable(ffi, told.observation, np.float32)
        )
        return told

    def step(self, actions: npt.NDArray[Any]) -> StepResult:
        """One action of each robot.

        (n,) int64 discrete, or (n, 2) float32 continuous ones, in C order.

        Raises:
            ValueError: If there is no such discrete action.
        """
        told = self._told()
        chosen = ffi.NULL
        moves = ffi.NULL
        if actions.ndim == 1:
            chosen = pointer(ffi, actions, np.int64)
        else:
            moves = pointer(ffi, actions, np.float32)
        check(lib.wg_crew_step(self._crew(), chosen, moves, told.in_core()))
        return told

    def place_of(self, robot: int) -> tuple[float, float]:
        """Where a robot's centre is, m."""
        side = self.worlds[self.crew.world[robot]].cell_size
        x, y = self.crew.state[robot, :2].tolist()
        return lattice_to_metres(x, side), lattice_to_metres(y, side)

    def _crew(self) -> Any:
        if not self.worlds:
            raise RuntimeError("no worlds are loaded")
        return self.crew.c

    def _told(self) -> StepResult:
        n = self.count
        flags = [np.empty(n, np.bool_) for _ in range(4)]
        last = np.empty((n if self._autoreset == lib.WG_SAME_STEP else 0, self.size), np.float32)
        return StepResult(
            np.empty((n, self.size), np.float32),
            np.empty(n),
            flags[0],
            flags[1],
            flags[2],
            flags[3],
            last,
        )
