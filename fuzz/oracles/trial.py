"""Trials: the runs that an oracle judges, with the means to run them again or in other worlds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from fuzz.evidence_checks import check_evidence
from sim.controllers import CompiledController
from sim.controllers.catalogue.renewal import as_loaded
from sim.episode import Episode, prepare, simulate
from sim.evidence import JointLoopEvidence, LoopEvidence
from sim.options.run import MAX_RECORDED, RunOptions
from sim.outcome import FleetEpisode
from sim.trace import Trace
from sim.verdict import BY_THE_CONTROLLER
from worldgen.world import Witness, World


@dataclass(frozen=True)
class Trial:
    """One run of a controller, for an oracle to judge. It runs on first use.

    Args:
        world: The world, with its certificate.
        controller: Name, as on the command line.
        options: Options of the run: motion model, budget, time step, seed and others.
        known: The recorded run, if it has already been done.
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
        as_loaded(controller)
        return cls(world, controller, options, simulate(world, controller, options, record=True))

    @cached_property
    def episode(self) -> Episode:
        """The run: verdict, steps, path length, evidence."""
        if self.known is not None:
            return self.known
        found = as_loaded(self.controller)
        # A compiled run is cheap to repeat, so it is recorded only if its trace is needed.
        at_once = not isinstance(found, CompiledController) and self.options.steps <= MAX_RECORDED
        return simulate(self.world, self.controller, self.options, record=at_once)

    @cached_property
    def trace(self) -> Trace | None:
        """Every state of the run.

        ``None`` if the run failed before its first step, or is too long to be recorded.
        """
        is_final = self.known is not None or self.episode.steps > MAX_RECORDED
        if is_final or self.episode.trace is not None:
            return self.episode.trace
        return self.again(record=True).trace

    @cached_property
    def recorded_run(self) -> Episode:
        """The run with its recordings: one, or one for each robot if there are several."""
        if not isinstance(self.episode, FleetEpisode):
            return replace(self.episode, trace=self.trace)
        is_recorded = all(one.trace is not None for one in self.episode.robots)
        return self.episode if is_recorded else self.again(record=True)

    @property
    def witness(self) -> Witness | None:
        """The path that proves that the target can be reached; ``None`` if there isn't one."""
        return self.world.certificate if isinstance(self.world.certificate, Witness) else None

    @cached_property
    def flaw(self) -> str:
        """The reason why the recorded run does not support the evidence for its verdict.

        Empty if it does.
        """
        episode = self.episode
        if isinstance(episode, FleetEpisode):
            return self._flaw_of_fleet(episode)
        trace = self.trace
        if isinstance(episode.evidence, LoopEvidence):
            # Only a second period proves a loop, and the episode has already ended by then.
            longer = episode.steps + episode.evidence.period
            run = prepare(self.world, self.controller, self.options)
            trace = run.run(longer, find_loop=False, record=True).trace
        if trace is None:
            return "" if episode.verdict in BY_THE_CONTROLLER else "no trace was recorded"
        return check_evidence(
            episode.verdict, self.world, trace, episode.evidence, self.options.motion_model()
        )

    def _flaw_of_fleet(self, episode: FleetEpisode) -> str:
        """Return why the recordings of several robots do not support the evidence."""
        from fuzz.evidence_checks.fleet import check_fleet  # noqa: PLC0415 - only fleets need it

        if episode.verdict in BY_THE_CONTROLLER:
            return ""
        recorded = self.recorded_run
        traces: Sequence[Trace | None] = [one.trace for one in getattr(recorded, "robots", ())]
        if isinstance(episode.evidence, JointLoopEvidence):
            from sim.fleet.episode import fleet_traces  # noqa: PLC0415 - loaded for fleets only

            # Only a second period proves a loop, and the episode has already ended by then.
            traces = fleet_traces(
                self.world,
                self.controller,
                self.options,
                episode.steps + episode.evidence.driven_period,
            )
        found = [trace for trace in traces if trace is not None]
        if len(found) < len(traces):
            return "no trace was recorded"
        return check_fleet(
            self.world, found, episode.verdict, episode.evidence, self.options.motion_model()
        )

    def again(self, world: World | None = None, *, record: bool = False, **changes: Any) -> Episode:
        """Run the same controller once more.

        Args:
            world: Another world to run it in.
            record: Keep every state (``trace``).
            **changes: Options that differ, fields of :class:`RunOptions`: ``time_step=0.0075``.

        Raises:
            InvalidParameter: If an option is out of range.
            InvalidWorld: If the robot cannot stand at the start.
        """
        where = self.world if world is None else world
        return simulate(where, self.controller, replace(self.options, **changes), record=record)
