"""Trials: what an oracle judges. A run in a world, and the means to run it again, or elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from fuzz.evidence_checks import check_evidence
from sim.controllers import CONTROLLERS, CompiledController, Controller, ProcessController
from sim.episode import Episode, prepare, simulate
from sim.evidence import LoopEvidence
from sim.options.run import MAX_RECORDED, RunOptions
from sim.trace import Trace
from sim.verdict import BY_THE_CONTROLLER
from worldgen.world import Witness, World

__all__ = ["Trial"]


@dataclass(frozen=True)
class Trial:
    """One run of a controller, for an oracle to judge. It runs when it is first needed.

    Args:
        world: Where; it carries a certificate.
        controller: Name, as the command line takes it.
        options: How: motion model, budget, time step, seed, switches.
        known: The run, recorded, if it was done already.
    """

    world: World
    controller: str
    options: RunOptions
    known: Episode | None = None

    @classmethod
    def recorded(cls, world: World, controller: str, options: RunOptions) -> Trial:
        """Run a controller now, recorded.

        Raises:
            InvalidParameter: If a name or an option is unknown, or the run is too long to be
                recorded.
            InvalidWorld: If the robot cannot stand at the start.
        """
        return cls(
            world, controller, options, simulate(world, _begun(controller), options, record=True)
        )

    @cached_property
    def episode(self) -> Episode:
        """The run: verdict, steps, path length, evidence."""
        if self.known is not None:
            return self.known
        found = _begun(self.controller)
        at_once = not isinstance(found, CompiledController) and self.options.steps <= MAX_RECORDED
        return simulate(self.world, found, self.options, record=at_once)

    @cached_property
    def trace(self) -> Trace | None:
        """Every state of the run.

        ``None`` of one that failed before its first step, or is too long to be recorded.
        """
        is_final = self.known is not None or self.episode.steps > MAX_RECORDED
        if is_final or self.episode.trace is not None:
            return self.episode.trace
        return self.again(record=True).trace

    @property
    def witness(self) -> Witness | None:
        """The path that proves that the target can be reached."""
        return self.world.certificate if isinstance(self.world.certificate, Witness) else None

    @cached_property
    def flaw(self) -> str:
        """Why the evidence for the run's verdict does not hold, by what was recorded.

        Empty if it holds.
        """
        episode = self.episode
        trace = self.trace
        if isinstance(episode.evidence, LoopEvidence):
            # A loop shows itself only in a second period, where the episode has ended.
            longer = episode.steps + episode.evidence.period
            run = prepare(self.world, self.controller, self.options)
            trace = run.run(longer, find_loop=False, record=True).trace
        if trace is None:
            return "" if episode.verdict in BY_THE_CONTROLLER else "no trace was recorded"
        return check_evidence(
            episode.verdict, self.world, trace, episode.evidence, self.options.motion_model()
        )

    def again(self, world: World | None = None, *, record: bool = False, **changes: Any) -> Episode:
        """Run the same controller once more.

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


def _begun(controller: str) -> Controller:
    """Return the controller.

    A program is started anew, so that a run does not depend on what no file holds.
    """
    found = CONTROLLERS.get(controller)
    if isinstance(found, ProcessController):
        found.close()
    return found
