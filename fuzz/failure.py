"""Failures: a world, a controller and options under which it does not arrive, with evidence that holds."""

from __future__ import annotations

from dataclasses import dataclass, replace

from scipy.special import betaincinv

from fuzz.oracles import objection
from fuzz.signature import failure_class
from sim.controllers import CONTROLLERS, CompiledController
from sim.episode import Episode, prepare, simulate
from sim.motion import MOTIONS
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.reach import REACHABLE, check_certificate, decide
from worldgen.world import FailureRecord, Value, Witness, World

__all__ = [
    "Replay",
    "certified",
    "failure_of",
    "judge",
    "replay",
    "scenario_of",
    "seeds_that_fail",
]


@dataclass(frozen=True)
class Replay:
    """What replaying a failure showed."""

    verdict: str
    confirmed: bool
    reason: str
    episode: Episode | None = None


def certified(world: World) -> World | None:
    """The world with a fresh witness, or ``None`` if its target is not provably reachable."""
    decision = decide(world)
    return replace(world, certificate=decision.certificate) if decision.result == REACHABLE else None


def judge(world: World, controller: str, options: RunOptions) -> tuple[Episode, str]:
    """Runs a scenario, recorded, and lets the oracle of its verdict object.

    Returns:
        The episode, and the objection; empty if the verdict holds.
    """
    episode = simulate(world, controller, options, record=True)
    trace = episode.trace
    if episode.verdict == "loop":
        period = episode.evidence["period"]
        longer = episode.steps + (period if isinstance(period, int) else 0)
        trace = prepare(world, controller, options).run(longer, find_loop=False, record=True).trace
    if trace is None:  # a controller that failed before its first step leaves none
        return episode, "" if episode.verdict == "crash" else "no trace was recorded"
    return episode, objection(episode.verdict, world, trace, episode.evidence, MOTIONS.get(options.motion))


def failure_of(
    world: World, scenario: Scenario, *, fewest_steps: int = 0, steps: int | None = None, **details: Value
) -> World | None:
    """The failure file of a scenario, or ``None`` if the robot arrives or the verdict is not confirmed.

    Args:
        world: A world that carries a witness.
        scenario: What runs in it.
        fewest_steps: Budget to give at least, for verdicts that the run itself proves; ``stalled`` and
            ``timeout`` always speak of the witness's budget.
        steps: The budget itself, for verdicts that the run itself proves.
        **details: What else to note.
    """
    options = scenario.options(world)
    longer = replace(options, steps=steps or max(options.steps, fewest_steps))
    episode, wrong = judge(world, scenario.controller, longer)
    if episode.verdict in ("stalled", "timeout"):
        episode, wrong = judge(world, scenario.controller, options)
    else:
        options = longer
    if episode.verdict == "reached" or wrong:
        return None
    if not isinstance(CONTROLLERS.get(scenario.controller), CompiledController):
        again = simulate(world, scenario.controller, options)
        if (again.verdict, again.trace_digest, again.evidence) != (
            episode.verdict,
            episode.trace_digest,
            episode.evidence,
        ):
            return None  # a controller that does not do the same twice: nothing that a file could replay
    record = FailureRecord(
        controller=scenario.controller,
        motion=scenario.motion,
        seed=scenario.seed,
        verdict=episode.verdict,
        trace_digest=episode.trace_digest,
        parameters=options.parameters(),
        evidence=episode.evidence,
        details={
            "class": failure_class(world, episode),
            "motion_version": MOTIONS.get(scenario.motion).version,
            **details,
        },
    )
    return replace(world, failure=record)


def scenario_of(world: World) -> tuple[FailureRecord, RunOptions]:
    """The record of a failure and the options that it stores.

    Raises:
        InvalidParameter: If the file holds no failure, or its parameters are unknown.
    """
    record = world.failure
    if record is None:
        raise InvalidParameter("this world holds no failure; worldgen run simulates it")
    return record, RunOptions.of(record.motion, record.seed, record.parameters)


def replay(world: World, controller: str | None = None) -> Replay:
    """Runs a failure again from its file and compares verdict, evidence, digest and certificate.

    Args:
        world: A failure.
        controller: Another name for the controller, where the file's name cannot be found here.
    """
    record, options = scenario_of(world)
    if record.verdict == "reached":
        return Replay("reached", False, "the file records that the robot arrived, which is no failure")
    try:
        episode, wrong = judge(world, controller or record.controller, options)
    except WorldgenError as error:
        return Replay("error", False, str(error))
    reason = _difference(record, episode) or wrong
    if not reason and not isinstance(world.certificate, Witness):
        reason = "the file carries no witness that the target can be reached"
    elif not reason:
        report = check_certificate(world)
        reason = "" if report.valid else f"the witness does not hold: {report.reason}"
    return Replay(episode.verdict, not reason, reason, episode)


def _difference(record: FailureRecord, episode: Episode) -> str:
    """What is not as it was recorded; empty if nothing."""
    made, now = record.details.get("motion_version"), MOTIONS.get(record.motion).version
    other = f" (recorded with version {made} of {record.motion}, this is {now})" if made not in (None, now) else ""
    if episode.verdict != record.verdict:
        return f"the verdict is {episode.verdict}, not {record.verdict}{other}"
    if episode.trace_digest != record.trace_digest:
        return f"the trace digest is {episode.trace_digest}{other}"
    if dict(episode.evidence) != dict(record.evidence):
        return f"the evidence is {dict(episode.evidence)}{other}"
    return ""


def seeds_that_fail(world: World, scenario: Scenario, count: int = 40) -> dict[str, Value]:
    """For a controller with randomness: how many of ``count`` seeds do not arrive, and what that shows.

    Returns:
        ``failing_seeds`` as [k, n] and ``failing_share_at_least``, the lower end of the two-sided 95 %
        interval; empty for a controller without randomness.

    Source: Charles Clopper and Egon Pearson, "The use of confidence or fiducial limits illustrated in the
    case of the binomial", Biometrika 1934.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if not (isinstance(controller, CompiledController) and controller.randomised):
        return {}
    options = scenario.options(world)
    failing = 0
    for seed in range(count):
        run = prepare(world, controller, replace(options, seed=seed))
        failing += run.run(options.steps, find_loop=False, record=False).ending != "reached"
    least = float(betaincinv(failing, count - failing + 1, 0.025)) if failing else 0.0
    return {"failing_seeds": [failing, count], "failing_share_at_least": round(least, 4)}
