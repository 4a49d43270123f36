"""Trials: what an oracle judges. A run in a world, and the way to run it again, or elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from sim.controllers import CONTROLLERS, CompiledController, ProcessController
from sim.episode import Episode, simulate
from sim.options.run import MAX_RECORDED, RunOptions
from sim.trace import Trace
from worldgen.world import Witness, World

__all__ = ["Trial"]


@dataclass(frozen=True)
class Trial:
    """One run of a controller, for an oracle to judge.

    Args:
        world: Where; it carries a witness.
        controller: Name, as the command line takes it.
        options: How: motion model, budget, time step, seed, switches.
        known: The run, if it was done already.
    """

    world: World
    controller: str
    options: RunOptions
    known: Episode | None = None

    @cached_property
    def episode(self) -> Episode:
        """The run: verdict, steps, path length, evidence. A program is started anew for it."""
        if self.known is not None:
            return self.known
        found = CONTROLLERS.get(self.controller)
        if isinstance(found, ProcessController):
            found.close()
        at_once = not isinstance(found, CompiledController) and self.options.steps <= MAX_RECORDED
        return simulate(self.world, found, self.options, record=at_once)

    @cached_property
    def trace(self) -> Trace | None:
        """Every state of the run; ``None`` of one that failed before its first step, or is too long to be recorded."""
        if self.episode.trace is not None or self.episode.steps > MAX_RECORDED:
            return self.episode.trace
        return self.again(record=True).trace

    @property
    def witness(self) -> Witness | None:
        """The path that proves that the target can be reached."""
        return self.world.certificate if isinstance(self.world.certificate, Witness) else None

    def again(self, world: World | None = None, *, record: bool = False, **changes: Any) -> Episode:
        """The same controller once more.

        Args:
            world: Elsewhere, instead of in the same world.
            record: Whether to keep every state (``trace``).
            **changes: Options that differ, fields of :class:`RunOptions`: ``time_step=0.0075``.

        Raises:
            InvalidParameter: If an option is out of range.
            InvalidWorld: If the robot cannot stand at the start.
        """
        where = self.world if world is None else world
        return simulate(where, self.controller, replace(self.options, **changes), record=record)
