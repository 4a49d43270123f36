"""Robots in lockstep: packs worlds and robots for the kernels, and calls them. No maths of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sim import CompiledController
from sim.kernels import layout
from sim.kernels._bridge import settings_of
from sim.kernels.lattice_state import new_robot, new_room
from sim.lattice_run import LatticeRun
from worldgen.lattice import lattice_to_metres
from worldgen.world import World
from worldgen_plugins.for_gymnasium.kernels import layout as at
from worldgen_plugins.for_gymnasium.kernels.navigate import Crew, Told, Worlds, begin, begin_many, step
from worldgen_plugins.for_gymnasium.options import Rules
from worldgen_plugins.for_gymnasium.ways import ways_to_target

__all__ = ["Lockstep"]

Ints = npt.NDArray[np.int64]
Singles = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]


def _nobody(observation: npt.NDArray[np.float64], memory: object, command: object) -> None:
    """Never called: an environment's actions are its commands."""


class Lockstep:
    """n robots in some of w worlds.

    Args:
        rules: What an episode is.
        count: Robots.
        limit: Steps until an episode is cut off; 0 for never.
        autoreset: ``NEXT_STEP``, ``SAME_STEP`` or ``DISABLED``.
    """

    def __init__(self, rules: Rules, count: int, limit: int = 0, autoreset: int = at.DISABLED) -> None:
        self._rules, self.count, self._autoreset = rules, count, autoreset
        interface = rules.interface
        self.size = sum(len(low) for low, _ in interface.bounds().values())
        self._driver = CompiledController("gymnasium", _nobody, senses=interface.senses)
        self.worlds: Sequence[World] = ()
        room, ints = new_room(0, interface.needs.beams), np.zeros((8, count), np.int64)
        nothing = np.zeros((0, 0), np.uint8)
        self.crew = Crew(
            nothing.ravel(), np.zeros(0, np.int32), nothing, np.zeros((0, 3), np.int64), room.memory, room.words,
            room.observation, room.command, room.search, rules.numbers(limit, autoreset),
            interface.codes, interface.choices, ints[0], ints[1], ints[2], ints[3], ints[4], ints[5], ints[6], ints[7],
            np.zeros(count), np.zeros(count, np.bool_), np.zeros((count, layout.STATE_MEMORY), np.int64),
            np.zeros((count, 3)), np.zeros((count, layout.OUT_SIZE), np.int64), np.zeros((count, layout.SUM_SIZE)),
        )  # fmt: skip
        self._packed: Worlds | None = None
        self._no_choice, self._no_move = np.zeros(0, np.int64), np.zeros((0, 2), np.float32)

    def load(self, worlds: Sequence[World]) -> None:
        """Puts the robots into other worlds; each must begin an episode before it steps.

        Raises:
            InvalidWorld: If the robot cannot stand at the start of one.
            InvalidParameter: If the time step does not go with a robot's speed.
        """
        options = self._rules.run_options()
        runs = [LatticeRun(world, self._driver, options) for world in worlds]
        packed = _packed(runs, [ways_to_target(world) for world in worlds] if self._rules.by_way else [])
        chain = np.zeros((max(len(new_robot(0, run.events).chain) for run in runs), 3), np.int64)
        cells, near = packed.cells, packed.near
        if len(packed.events):
            most = int((packed.place[:, at.PLACE_HEIGHT] * packed.place[:, at.PLACE_WIDTH]).max())
            cells, near = np.zeros(most * self.count, np.uint8), np.zeros(most * self.count, np.int32)
            self.crew.page[:] = np.arange(self.count) * most
        self.crew = self.crew._replace(cells=cells, near=near, chain=chain)
        self.worlds, self._packed = worlds, packed

    def begin(self, robot: int, world: int) -> Singles:
        """Puts one robot at the start of an episode in a world; its observation."""
        out = np.empty(self.size, np.float32)
        begin(self._worlds(), self.crew, robot, world, out)
        return out

    def begin_many(self, which: Bools) -> Told:
        """Puts robots at the starts of episodes in the worlds that their seeds choose."""
        told = self._told()
        begin_many(self._worlds(), self.crew, which, told)
        return told

    def step(self, actions: npt.NDArray[Any]) -> Told:
        """One action of each robot: (n,) int64 discrete, or (n, 2) float32 continuous ones, in C order."""
        told = self._told()
        if actions.ndim == 1:
            step(self._worlds(), self.crew, actions, self._no_move, told)
        else:
            step(self._worlds(), self.crew, self._no_choice, actions, told)
        return told

    def place_of(self, robot: int) -> tuple[float, float]:
        """Where a robot's centre is, m."""
        side = self.worlds[self.crew.world[robot]].cell_size
        state = self.crew.state[robot]
        return lattice_to_metres(int(state[layout.STATE_X]), side), lattice_to_metres(int(state[layout.STATE_Y]), side)

    def _worlds(self) -> Worlds:
        if self._packed is None:
            raise RuntimeError("no worlds are loaded")
        return self._packed

    def _told(self) -> Told:
        n = self.count
        flags = [np.empty(n, np.bool_) for _ in range(4)]
        last = np.empty((n if self._autoreset == at.SAME_STEP else 0, self.size), np.float32)
        return Told(np.empty((n, self.size), np.float32), np.empty(n), flags[0], flags[1], flags[2], flags[3], last)


def _packed(runs: Sequence[LatticeRun], ways: Sequence[Singles]) -> Worlds:
    """All parts of all worlds, one behind the other."""
    arenas = [run.arena() for run in runs]
    settings = [settings_of(run.settings) for run in runs]
    place = np.zeros((len(runs), at.PLACE_SIZE), np.int64)
    place[:, [at.PLACE_HEIGHT, at.PLACE_WIDTH]] = [arena.cells.shape for arena in arenas]
    place[:, [at.PLACE_ROWS, at.PLACE_COLUMNS]] = [arena.clearance.shape for arena in arenas]
    place[:, at.PLACE_CELLS] = _begins([arena.cells.size for arena in arenas])
    place[:, at.PLACE_CLEARANCE] = _begins([arena.clearance.size for arena in arenas])
    place[:, at.PLACE_EVENT] = _begins([len(arena.events) for arena in arenas])
    place[:, at.PLACE_LAST_EVENT] = np.cumsum([len(arena.events) for arena in arenas])
    place[:, at.PLACE_WAY] = _begins([len(way) for way in ways]) if ways else -1
    return Worlds(
        cells=np.concatenate([arena.cells.ravel() for arena in arenas]),
        near=np.concatenate([arena.near.ravel() for arena in arenas]),
        clearance=np.concatenate([arena.clearance.ravel() for arena in arenas]),
        events=np.concatenate([arena.events for arena in arenas]),
        headings=arenas[0].headings,
        place=place,
        settings=np.stack([ints for ints, _ in settings]),
        scales=np.stack([floats for _, floats in settings]),
        way=np.concatenate(ways) if ways else np.zeros(0, np.float32),
    )


def _begins(sizes: Sequence[int]) -> Ints:
    """Where each part begins."""
    ends = np.cumsum(sizes)
    return np.asarray(ends - sizes, np.int64)
