"""Run one controller in one world, and return a verdict with its evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from sim.controllers.base import Controller
from sim.controllers.catalogue import controller_of
from sim.controllers.catalogue.renewal import as_loaded
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    ContactEvidence,
    CoveredEvidence,
    Evidence,
    FaultEvidence,
    LoopEvidence,
    ReachedEvidence,
)
from sim.fleet.assignment import assigned
from sim.motion import MOTIONS
from sim.options.run import TARGET, RunOptions, check_world, options_from, switch_sets
from sim.outcome import Episode, Outcome, Ran, Runnable, area_of, wall_evidence
from sim.runners.controller_host import host_of
from sim.runners.decide import decide
from sim.runners.lattice import LatticeRun
from sim.runners.recording import has_waypoints
from sim.trace import state_digest
from sim.verdict import ARRIVALS, BY_THE_CONTROLLER, OUT_OF_BUDGET, Verdict
from worldgen.support.arrays import Words
from worldgen.world import Value, Witness, World

__all__ = ["Episode", "area_of", "episode_of", "prepare", "simulate", "wall_evidence"]

E = TypeVar("E", bound=Episode)

# Steps, 30 MB. Slow controllers record this much from the start, before a verdict shows if the
# recording is needed, so that they need not run twice.
_RECORDED_AT_ONCE = 100_000


def simulate(
    world: World,
    controller: str | Controller | type | Mapping[int, str | Controller | type],
    options: RunOptions | None = None,
    *,
    record: bool = False,
    lean: bool = False,
    **settings: Value,
) -> Episode:
    """Run a controller until it arrives, provably loops, breaks a rule or spends its budget.

    Args:
        world: The world to drive in.
        controller: Its name, the controller itself, or its class. In a world of several robots it
            drives all of them, or ``{1: "bug2", 2: "vfh"}`` gives each robot its own.
        options: How to run; if omitted, ``swept`` and a budget of 50 times the witness's time.
        record: True to keep every state, as ``trace``.
        lean: True if a recording may omit a compiled controller's memory if that would take more
            than 64 MB. ``Trace.show_memory`` still shows it, by running the episode again.
        **settings: Single options, as an alternative to ``options``: ``motion="stepped", seed=3``.

    Returns:
        The verdict and its evidence; a :class:`~sim.FleetEpisode` for several robots.

    Raises:
        InvalidParameter: If a name or an option is unknown or of the wrong type, or the controller
            and the options do not fit each other.
        InvalidWorld: If a robot does not fit at the start.
    """
    check_world(world)
    options = options_from(world, options, settings)
    if world.is_fleet:
        from sim.fleet.episode import simulate_fleet  # noqa: PLC0415 - loaded for fleets only

        fleet = simulate_fleet(world, controller, options, record=record)
        drivers: list[str | Controller | type] = assigned(controller, len(world.robots))
        return _with_run(fleet, world, drivers[0], options) if record else fleet
    named: list[str | Controller | type] = assigned(controller, 1)
    found = controller_of(named[0])

    # Slow controllers record in their first run, to be run only once. Compiled ones are fast enough
    # to run again, and record only the steps that the verdict needs.
    run = prepare(world, found, options, lean=lean)
    name = named[0]
    at_once = record and options.steps <= _RECORDED_AT_ONCE and not host_of(found).in_core
    decided = decide(
        run,
        options.steps,
        record=record,
        at_once=at_once,
        renewed=(lambda: prepare(world, as_loaded(name), options))
        if isinstance(name, str)
        else None,
    )
    if isinstance(decided, Outcome):
        episode = episode_of(run, world, decided, options)
    else:
        episode = _loop(world, options, *decided)
    return _with_run(episode, world, name, options) if record else episode


def _with_run(episode: E, world: World, named: str | Controller | type, options: RunOptions) -> E:
    """Return a recorded episode with what was run."""
    label = named if isinstance(named, str) else getattr(named, "__name__", type(named).__name__)
    return replace(episode, ran=Ran(world, label, controller_of(named), options))


def prepare(
    world: World, controller: str | Controller | type, options: RunOptions, *, lean: bool = False
) -> Runnable:
    """Pack a world, a controller and options for their motion model; see :func:`simulate`."""
    found = controller_of(controller)
    motion = MOTIONS.get(options.motion)
    switch_sets(
        motion.name, options.thesis.changed() if motion.on_lattice else options.robot.changed()
    )
    if motion.on_lattice:
        return LatticeRun(world, found, options, lean=lean)
    from sim.thesis.run import ThesisRun  # noqa: PLC0415 - loaded for `stepped` only

    return ThesisRun(world, found, options)


def _loop(world: World, options: RunOptions, outcome: Outcome, state: Words) -> Episode:
    """Return the episode of a proved loop, which ends with the loop's first period."""
    if outcome.overlap_step >= 0:
        return _episode(Verdict.OVERLAP, world, outcome, options, wall_evidence(outcome))
    evidence = LoopEvidence(
        entry=outcome.entry, period=outcome.period, state_digest=state_digest(state)
    )
    return _episode(Verdict.LOOP, world, outcome, options, evidence)


def episode_of(run: Runnable, world: World, outcome: Outcome, options: RunOptions) -> Episode:
    """Return the episode of a run whose outcome needs no further proof, which a loop does."""
    evidence = _evidence(world, outcome, options)
    if outcome.verdict == Verdict.STALLED and isinstance(evidence, BudgetEvidence):
        evidence = run.with_confinement(evidence, outcome)
    return _episode(outcome.verdict, world, outcome, options, evidence)


def _evidence(world: World, outcome: Outcome, options: RunOptions) -> Evidence:
    verdict = outcome.verdict
    if verdict in (Verdict.TUNNEL, Verdict.OVERLAP):
        return wall_evidence(outcome)
    if verdict == Verdict.CONTACT:
        return ContactEvidence(step=outcome.hit_step, cell=outcome.hit_cell)
    if verdict == Verdict.BURNED:
        return BurnedEvidence(step=outcome.hit_step, cell=outcome.hit_cell, state=outcome.hit_state)
    if verdict == Verdict.COVERED:
        return CoveredEvidence(step=outcome.steps, cells=outcome.cells_wanted)
    if verdict in OUT_OF_BUDGET:
        multiple = None
        if (
            options.task == TARGET
            and isinstance(world.certificate, Witness)
            and world.certificate.duration > 0
        ):
            spent = outcome.steps * options.time_step
            multiple = round(spent / world.certificate.duration, 3)
        return BudgetEvidence(last_new_cell=outcome.last_new_cell, witness_multiple=multiple)
    if verdict in BY_THE_CONTROLLER:
        return replace(outcome.fault or FaultEvidence(), step=outcome.steps)
    entered = outcome.wall_step if outcome.wall_step >= 0 else None
    return ReachedEvidence(step=outcome.steps, wall_step=entered)


def _episode(
    verdict: Verdict, world: World, outcome: Outcome, options: RunOptions, evidence: Evidence
) -> Episode:
    return Episode(
        verdict=verdict,
        steps=outcome.steps,
        time=round(outcome.steps * options.time_step, 9),
        path_length=outcome.path_length,
        collisions=outcome.collisions,
        area_covered=area_of(outcome.cells_visited, world),
        cells_left=outcome.cells_left if outcome.cells_wanted else None,
        goals_reached=outcome.goals if has_waypoints(world, options) else None,
        trace_digest=outcome.digest,
        evidence=evidence,
        trace=outcome.trace,
        shortfall=None if verdict in ARRIVALS else outcome.shortfall,
    )
