"""One run of a controller in a world, and its verdict with evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sim.controllers import CompiledController, Controller, controller_of
from sim.lattice_run import LatticeRun
from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.outcome import BY_THE_CONTROLLER, Outcome, Runnable
from sim.run_options import RunOptions, check_recordable, check_world, options_of, switch_sets
from sim.thesis_run import ThesisRun
from sim.trace import Trace, state_digest
from worldgen.errors import InvalidParameter
from worldgen.world import Value, Witness, World

__all__ = ["Episode", "prepare", "simulate"]

_RECORDED_AT_ONCE = 100_000  # steps, 30 MB: what slow controllers have recorded before it is known whether it is needed


@dataclass(frozen=True)
class Episode:
    """What happened in one run.

    Args:
        verdict: ``reached``, ``loop``, ``stalled``, ``timeout``, ``tunnel``, ``overlap``, ``burned``,
            ``crash``, ``hang`` or ``invalid-command``.
        steps: Steps simulated; for a ``loop`` those until its first state has come back.
        time: Their duration, s.
        path_length: m.
        collisions: Times that the robot began to touch a wall.
        trace_digest: 16 hex digits over every state.
        evidence: What a checker needs, by verdict.
        trace: The recorded states, if they were asked for.
    """

    verdict: str
    steps: int
    time: float
    path_length: float
    collisions: int
    trace_digest: str
    evidence: Mapping[str, Value] = field(default_factory=dict)
    trace: Trace | None = None

    def __repr__(self) -> str:
        evidence = "".join(f"\n  {name}: {value!r}" for name, value in self.evidence.items())
        return (
            f"{self.verdict}: {self.steps} steps, {self.time:g} s, {self.path_length:.3f} m driven, "
            f"{self.collisions} collisions, trace {self.trace_digest}{evidence}"
        )


def simulate(
    world: World,
    controller: str | Controller | type,
    options: RunOptions | None = None,
    *,
    record: bool = False,
    lean: bool = False,
    **settings: Value,
) -> Episode:
    """Runs a controller in a world until it arrives, provably loops, breaks a rule, or its budget is spent.

    Args:
        world: Where.
        controller: Its name, the controller itself, or its class.
        options: How; without them, ``swept`` and a budget of 50 times the witness's time.
        record: Whether to keep every state (``trace``).
        lean: Whether a recording may leave out what would take more than 64 MB of a compiled controller's memory,
            to be seen with ``Trace.show_memory``.
        **settings: Single options, as an alternative to ``options``: ``motion="stepped", seed=3``.

    Returns:
        The verdict and its evidence.

    Raises:
        InvalidParameter: If a name or an option is unknown or of the wrong type, or the two do not fit each other.
        InvalidWorld: If the robot cannot stand at the start.
    """
    check_world(world)
    if options is None:
        options = options_of(world, settings)
    elif not isinstance(options, RunOptions):
        raise InvalidParameter(f"{options!r} is not RunOptions; give these, or single settings: steps=3000, seed=3")
    elif settings:
        raise InvalidParameter(f"give options or {', '.join(settings)}, not both")
    found = controller_of(controller)
    run = prepare(world, found, options, lean=lean)
    at_once = record and options.steps <= _RECORDED_AT_ONCE and not isinstance(found, CompiledController)
    outcome = run.run(options.steps, find_loop=True, record=at_once)
    if outcome.ending == "loop":
        return _loop(run, world, outcome, options, record)
    if record and outcome.trace is None:
        check_recordable(outcome.steps)
        outcome = run.run(outcome.steps, find_loop=False, record=True)
    return _decided(run, world, outcome, options)


def prepare(world: World, controller: str | Controller | type, options: RunOptions, *, lean: bool = False) -> Runnable:
    """Packs a scenario for its motion model; see :func:`simulate`."""
    found = controller_of(controller)
    motion = MOTIONS.get(options.motion)
    switch_sets(motion.name, options.robot.changed() if motion.kernel == THESIS else options.thesis.changed())
    if motion.kernel != THESIS:
        return LatticeRun(world, found, options, lean=lean)
    if not isinstance(found, CompiledController) or not found.thesis_rule:
        raise InvalidParameter(
            f"motion {motion.name!r} runs the thesis's own robots: turn-left, turn-right, turn-random; "
            "take --motion swept or endpoint for other controllers"
        )
    return ThesisRun(world, found.thesis_rule, options)


def _loop(run: Runnable, world: World, found: Outcome, options: RunOptions, record: bool) -> Episode:
    """Finds where the recurrence begins; the run ends with its first period."""
    entry, period = found.entry, found.period
    if record:
        check_recordable(entry + period)
    proof = run.prove(entry, period, record=record)
    if proof is None:  # the controller keeps memory that it does not declare: the budget counts
        return _decided(run, world, run.run(options.steps, find_loop=False, record=record), options)
    outcome, state = proof
    if outcome.overlap_step >= 0:
        return _episode("overlap", outcome, options, _overlap_evidence(outcome))
    evidence: dict[str, Value] = {
        "entry": entry,
        "period": period,
        "state_digest": state_digest(state),
    }
    return _episode("loop", outcome, options, evidence)


def _decided(run: Runnable, world: World, outcome: Outcome, options: RunOptions) -> Episode:
    evidence = _evidence(world, outcome, options)
    if outcome.verdict == "stalled" and isinstance(run, ThesisRun):
        check_recordable(outcome.steps)
        evidence |= run.confinement(outcome.steps)
    return _episode(outcome.verdict, outcome, options, evidence)


def _evidence(world: World, outcome: Outcome, options: RunOptions) -> dict[str, Value]:
    verdict = outcome.verdict
    if verdict == "tunnel":
        return {"step": outcome.hit_step, "cell": list(outcome.hit_cell), **_cause(outcome)}
    if verdict == "burned":
        return {"step": outcome.hit_step, "cell": list(outcome.hit_cell), "state": outcome.hit_state}
    if verdict == "overlap":
        return _overlap_evidence(outcome)
    if verdict in ("stalled", "timeout"):
        budget: dict[str, Value] = {"last_new_cell": outcome.last_new_cell}
        if isinstance(world.certificate, Witness) and world.certificate.duration > 0:
            spent = outcome.steps * options.time_step
            budget["witness_multiple"] = round(spent / world.certificate.duration, 3)
        return budget
    if verdict in BY_THE_CONTROLLER:
        return {**outcome.fault, "step": outcome.steps}
    entered: dict[str, Value] = {"wall_step": outcome.wall_step} if outcome.wall_step >= 0 else {}
    return {"step": outcome.steps, **entered}


def _overlap_evidence(outcome: Outcome) -> dict[str, Value]:
    return {"step": outcome.overlap_step, "cell": list(outcome.overlap_cell), **_cause(outcome)}


def _cause(outcome: Outcome) -> dict[str, Value]:
    """Which move let the robot into the wall, where the motion model knows."""
    return {"cause": outcome.cause, "since": outcome.cause_step} if outcome.cause else {}


def _episode(verdict: str, outcome: Outcome, options: RunOptions, evidence: dict[str, Value]) -> Episode:
    return Episode(
        verdict=verdict,
        steps=outcome.steps,
        time=round(outcome.steps * options.time_step, 9),
        path_length=outcome.path_length,
        collisions=outcome.collisions,
        trace_digest=outcome.digest,
        evidence=evidence,
        trace=outcome.trace,
    )
