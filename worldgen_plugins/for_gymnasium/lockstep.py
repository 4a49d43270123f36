"""Robots in lockstep: pack worlds and robots for the core, and call it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.runners.controller_host import OutsideHost
from sim.runners.core_calls import MOST_CORNERS, STATE_WORDS
from sim.runners.lattice import LatticeRun
from worldgen.lattice import lattice_to_metres
from worldgen.support.arrays import Bools, Floats
from worldgen.support.ccall import check, kept, pointer, writable
from worldgen.world import World
from worldgen_plugins.for_gymnasium.distances import distances_to_target
from worldgen_plugins.for_gymnasium.options import Rules

__all__ = ["Lockstep", "StepResult"]

Singles = npt.NDArray[np.float32]


class StepResult(NamedTuple):
    """The result of a step for each robot; every step makes a new one.

    Args:
        observation: (n, size) float32.
        reward: (n,) float64.
        terminated: (n,) bool, whether it arrived or burned.
        truncated: (n,) bool, whether its time is over.
        reached: (n,) bool, whether it arrived.
        began: (n,) bool, whether the observation is the first of an episode.
        last: (n, size) float32, the last observation of an episode if the next one began in the
            same step; without rows if that cannot happen.
    """

    observation: Singles
    reward: Floats
    terminated: Bools
    truncated: Bools
    reached: Bools
    began: Bools
    last: Singles

    def in_core(self) -> Any:
        """Return the WgTold that points to these arrays."""
        told = ffi.new("WgTold *")
        for name, array in self._asdict().items():
            setattr(told, name, writable(ffi, array, array.dtype.type))
        return told


# Words of a WgCarriage.
_CARRIAGE_WORDS = ffi.sizeof("WgCarriage") // 8
_OF_ROBOTS = ("world", "seed", "episode", "run", "clock", "elapsed", "distance", "over", "passed")


class RobotArrays:
    """The core's data on n robots, as arrays that share its memory.

    Args:
        rules: The rules of an episode.
        numbers: WgRules.
        count: Number of robots.
        size: Numbers in an observation.
    """

    def __init__(self, rules: Rules, numbers: Any, count: int, size: int) -> None:
        # Each robot's own state.
        self.world = np.zeros(count, np.int64)
        self.seed = np.zeros(count, np.uint64)
        self.episode = np.zeros(count, np.int64)
        self.run = np.zeros(count, np.int64)
        self.clock = np.zeros(count, np.int64)
        self.elapsed = np.zeros(count, np.int64)
        self.distance = np.zeros(count)
        self.over = np.zeros(count, np.bool_)
        self.passed = np.zeros(count, np.int64)
        self.state = np.zeros((count, STATE_WORDS), np.int64)
        self.carriage = np.zeros((count, _CARRIAGE_WORDS), np.int64)
        self.c: Any = ffi.new("WgCrew *")
        for name in _OF_ROBOTS:
            array = getattr(self, name)
            setattr(self.c, name, writable(ffi, array, array.dtype.type))

        # These are shared by all robots.
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
        self.c = kept(ffi, self.c, self._robots, numbers, codes, choices, beams)
        self._places: Any = ffi.NULL
        self._chain: Any = ffi.NULL
        self._own: tuple[npt.NDArray[Any], ...] = ()

    def load(self, places: Any, runs: Sequence[LatticeRun]) -> None:
        """Put the robots into other worlds: WgPlace[], one for each run."""
        # A step may have as many corners as events, so the busiest step decides the room for them.
        changing = [run.events for run in runs if len(run.events)]
        most = max(
            (int(np.unique(rows[:, 0], return_counts=True)[1].max()) for rows in changing),
            default=0,
        )
        legs = max(int(lib.wg_most_legs(run.settings)) for run in runs)
        self._chain = ffi.new("WgCorner[]", MOST_CORNERS * (most + legs))
        self._tie_robots()
        self._places = places
        self.c.places = places

        # In worlds that change, each robot needs its own copy of the cells.
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

    def _tie_robots(self) -> None:
        """Connect the robots with their states and with the shared chain of corners."""
        states = ffi.cast("WgState *", writable(ffi, self.state, np.int64))
        carriages = ffi.cast("WgCarriage *", writable(ffi, self.carriage, np.int64))
        lib.wg_crew_robots(self.c, states, carriages, self._chain)

    def snapshot(self) -> tuple[list[npt.NDArray[Any]], bytes]:
        """Return copies of everything that changes as robots move."""
        arrays = [getattr(self, name) for name in _OF_ROBOTS]
        return [array.copy() for array in (*arrays, self.state, self.carriage, *self._own)], bytes(
            ffi.buffer(self._robots)
        )

    def restore(self, snapshot: tuple[list[npt.NDArray[Any]], bytes]) -> None:
        """Restore everything from a snapshot; the same worlds must be loaded."""
        arrays, robots = snapshot
        own = [getattr(self, name) for name in _OF_ROBOTS]
        for array, before in zip(
            (*own, self.state, self.carriage, *self._own), arrays, strict=True
        ):
            array[...] = before
        ffi.memmove(self._robots, robots, len(robots))
        self._tie_robots()


class Lockstep:
    """n robots in some of w worlds.

    Args:
        rules: The rules of an episode.
        count: Number of robots.
        limit: Steps after which an episode is truncated; 0 for never.
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
        self._host = OutsideHost(interface.senses)
        self.worlds: Sequence[World] = ()
        self.crew = RobotArrays(rules, rules.numbers(limit, autoreset), count, self.size)

    def __getstate__(self) -> tuple[Any, ...]:
        """Return what a copy is built from; memory of the core cannot be copied."""
        return (
            self._rules,
            self.count,
            self._limit,
            self._autoreset,
            self.worlds,
            self.crew.snapshot(),
        )

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        """Build the copy."""
        rules, count, limit, autoreset, worlds, snapshot = state
        self.__init__(rules, count, limit, autoreset)  # type: ignore[misc]
        if worlds:
            self.load(worlds)
        self.crew.restore(snapshot)

    def load(self, worlds: Sequence[World]) -> None:
        """Put the robots into other worlds; each must begin an episode before it steps.

        Raises:
            InvalidWorld: If the robot does not fit at the start of a world.
            InvalidParameter: If the time step does not fit a robot's speed.
        """
        options = self._rules.run_options()
        runs = [LatticeRun(world, self._host, options) for world in worlds]
        arenas = [run.arena() for run in runs]
        # Distances to the goals are needed only if the reward measures progress.
        ways = [_distances(world) for world in worlds] if self._rules.by_way else []
        places = ffi.new("WgPlace[]", len(runs))
        for k, (run, arena) in enumerate(zip(runs, arenas, strict=True)):
            places[k].arena = arena.c[0]
            places[k].settings = run.settings[0]
            if ways:
                places[k].ways = pointer(ffi, ways[k], np.float32)
        self.crew.load(kept(ffi, places, runs, arenas, ways), runs)
        self.worlds = worlds

    def begin(self, robot: int, world: int) -> Singles:
        """Put one robot at the start of an episode in a world, and return its observation."""
        out = np.empty(self.size, np.float32)
        lib.wg_crew_begin(self._crew(), robot, world, writable(ffi, out, np.float32))
        return out

    def begin_many(self, which: Bools) -> StepResult:
        """Put robots at the starts of episodes, in the worlds that their seeds choose."""
        result = self._new_result()
        lib.wg_crew_begin_many(
            self._crew(),
            pointer(ffi, which, np.bool_),
            writable(ffi, result.observation, np.float32),
        )
        return result

    def step(self, actions: npt.NDArray[Any]) -> StepResult:
        """Step all robots.

        Args:
            actions: (n,) int64 discrete actions, or (n, 2) float32 continuous ones, in C order.

        Raises:
            ValueError: If a discrete action does not exist.
        """
        result = self._new_result()
        chosen = ffi.NULL
        moves = ffi.NULL
        if actions.ndim == 1:
            chosen = pointer(ffi, actions, np.int64)
        else:
            moves = pointer(ffi, actions, np.float32)
        check(lib.wg_crew_step(self._crew(), chosen, moves, result.in_core()))
        return result

    def place_of(self, robot: int) -> tuple[float, float]:
        """Return the position of a robot's centre, m."""
        side = self.worlds[self.crew.world[robot]].cell_size
        x, y = self.crew.state[robot, :2].tolist()
        return lattice_to_metres(x, side), lattice_to_metres(y, side)

    def _crew(self) -> Any:
        if not self.worlds:
            raise RuntimeError("no worlds are loaded")
        return self.crew.c

    def _new_result(self) -> StepResult:
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


def _distances(world: World) -> Singles:
    """Return the lengths of the shortest paths to each goal, m, one goal after another."""
    goals = range(len(world.robots[0].goals))
    return np.concatenate([distances_to_target(world.for_goal(number)) for number in goals])
