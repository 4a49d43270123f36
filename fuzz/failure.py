"""Failures: a world, a controller and options under which it does not arrive, with evidence that holds.

A run may also fail by an oracle that was asked for: its verdict is then what it is, ``reached`` for one, and the
evidence names the ``oracle`` and its ``objection`` (:mod:`fuzz.asked`).

One kind is the other way round, a *breach*: the target is walled off, as a cut proves, the robot goes through a
wall (verdict ``tunnel``), and, where walls end nothing, it arrives (``reached`` in the evidence).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from fuzz.asked import Asked, Trial, asked_by
from fuzz.crash_bucket import FACTS
from fuzz.hazards import hazard_details
from fuzz.oracles import object_to_breach, objection
from fuzz.signature import failure_class
from sim.controllers import CONTROLLERS, CompiledController, ProcessController
from sim.episode import Episode, prepare, simulate
from sim.evidence import LoopEvidence, WallEvidence, evidence_table
from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.run_options import RunOptions
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER, Verdict
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.grid_file import dumps
from worldgen.intervals import interval_95
from worldgen.lattice import in_cells
from worldgen.reach import BLOCKED, REACHABLE, CheckReport, check_certificate, decide
from worldgen.world import Cut, FailureRecord, Pose, Target, Value, World

__all__ = [
    "ID_DIGITS",
    "Replay",
    "certificate_fault",
    "certified",
    "failure_by",
    "failure_id",
    "failure_of",
    "judge",
    "judge_asked",
    "regardless_of_walls",
    "replay",
    "scenario_of",
    "seeds_that_fail",
    "share_that_fails",
    "walled_off",
]

ID_DIGITS = 16
"""Hex digits of a failure's id."""


@dataclass(frozen=True)
class Replay:
    """What replaying a failure showed."""

    verdict: str
    confirmed: bool
    reason: str
    episode: Episode | None = None


def failure_id(failure: World) -> str:
    """A failure's id: the first hex digits of the SHA-256 of its text, the record included.

    The world's id would not do: one world may hold several failures, of other seeds for example.
    """
    return hashlib.sha256(dumps(failure)).hexdigest()[:ID_DIGITS]


def certified(world: World) -> World | None:
    """The world with a fresh witness, or ``None`` if its target is not provably reachable."""
    decision = decide(world, cut=False)
    return replace(world, certificate=decision.certificate) if decision.result == REACHABLE else None


def walled_off(world: World) -> World | None:
    """The world with a fresh cut round its target's cell, or ``None`` if that is not provably walled off.

    The thesis's robot arrives where it enters the target's cell, so the cut parts the start from all of it. A
    target where the robot has no room is not walled off but in a slot: that is not what is looked for.
    """
    at_target = replace(world, start=Pose(world.target.x, world.target.y, 0.0), certificate=None, failure=None)
    if decide(at_target, certificate=False).result != REACHABLE:
        return None
    decision = decide(_with_whole_cell(world))
    return replace(world, certificate=decision.certificate) if decision.result == BLOCKED else None


def _with_whole_cell(world: World) -> World:
    """The world with the disc round the target's cell, or the target itself if that is larger, as target."""
    side, target = world.cell_size, world.target
    x, y = (float((math.floor(in_cells(v, side)) + 0.5) * side) for v in (target.x, target.y))
    corner = side * math.sqrt(0.5) * (1 + 1e-9)
    needed = math.dist((x, y), (target.x, target.y)) + target.radius
    return replace(world, target=Target(x, y, max(corner, needed)), failure=None)


def regardless_of_walls(options: RunOptions) -> RunOptions:
    """The same run, where walls that the robot enters neither end it nor decide its verdict."""
    return replace(options, thesis=replace(options.thesis, keep_going=True))


def judge(world: World, controller: str, options: RunOptions) -> tuple[Episode, str]:
    """Runs a scenario, recorded, and lets the oracle of its verdict object.

    In a world whose certificate is a cut, the scenario runs once more regardless of walls; ``reached`` in the
    evidence is the step in which it then arrives.

    Returns:
        The episode, and the objection; empty if the verdict holds.
    """
    _afresh(controller)
    episode = simulate(world, controller, options, record=True)
    trace = episode.trace
    if isinstance(episode.evidence, LoopEvidence):
        longer = episode.steps + episode.evidence.period
        trace = prepare(world, controller, options).run(longer, find_loop=False, record=True).trace
    if trace is None:  # a controller that failed before its first step leaves none
        return episode, "" if episode.verdict in BY_THE_CONTROLLER else "no trace was recorded"
    wrong = objection(episode.verdict, world, trace, episode.evidence, options.motion_model())
    if wrong or not isinstance(world.certificate, Cut):
        return episode, wrong
    return _judge_breach(world, controller, options, episode)


def _afresh(controller: str) -> None:
    """Starts a program anew, so that a failure does not hang on episodes that no file holds."""
    found = CONTROLLERS.get(controller)
    if isinstance(found, ProcessController):
        found.close()


def _judge_breach(world: World, controller: str, options: RunOptions, episode: Episode) -> tuple[Episode, str]:
    wall = episode.evidence
    if (
        episode.verdict != Verdict.TUNNEL
        or not isinstance(wall, WallEvidence)
        or options.motion_model().kernel != THESIS
    ):
        return episode, "the target is walled off, and the robot goes through no wall"
    whole = simulate(world, controller, regardless_of_walls(options), record=True)
    if whole.verdict != Verdict.REACHED or whole.trace is None or episode.trace is None:
        return episode, "the target is walled off, and the robot does not reach it"
    wall = replace(wall, reached=whole.steps)
    return replace(episode, evidence=wall), object_to_breach(world, episode.trace, whole.trace, wall)


def failure_of(
    world: World, scenario: Scenario, *, fewest_steps: int = 0, steps: int | None = None, **details: Value
) -> World | None:
    """The failure file of a scenario, or ``None`` if the robot arrives or the verdict is not confirmed.

    Args:
        world: A world that carries a witness; or a cut, for a breach.
        scenario: What runs in it.
        fewest_steps: Budget to give at least, for verdicts that the run itself proves; ``stalled`` and
            ``timeout`` always speak of the witness's budget, also of a robot that arrives after it.
        steps: The budget itself, for verdicts that the run itself proves.
        **details: What else to note.
    """
    options = scenario.options(world)
    longer = replace(options, steps=steps or max(options.steps, fewest_steps))
    episode, wrong = judge(world, scenario.controller, longer)
    late = episode.verdict == Verdict.REACHED and episode.steps > options.steps
    if longer != options and (late or episode.verdict in (Verdict.STALLED, Verdict.TIMEOUT)):
        episode, wrong = judge(world, scenario.controller, options)
    else:
        options = longer
    if episode.verdict == Verdict.REACHED or wrong:
        return None
    if not isinstance(CONTROLLERS.get(scenario.controller), CompiledController):
        again = simulate(world, scenario.controller, options)
        if (again.verdict, again.trace_digest, _repeatable(evidence_table(again.evidence))) != (
            episode.verdict,
            episode.trace_digest,
            _repeatable(evidence_table(episode.evidence)),
        ):
            return None  # a controller that does not do the same twice: nothing that a file could replay
    kind = failure_class(world, episode)
    details = {**hazard_details(episode.verdict, kind, scenario), **details}
    return _recorded(world, scenario, options, episode, evidence_table(episode.evidence), kind, details)


def failure_by(world: World, scenario: Scenario, asked: Asked, **details: Value) -> World | None:
    """The failure file of a scenario to which an oracle objects, or ``None`` if it does not, or not twice alike.

    Args:
        world: A world that carries a witness.
        scenario: What runs in it.
        asked: The oracle.
        **details: What else to note.
    """
    options = scenario.options(world)
    episode, said = judge_asked(world, scenario.controller, options, asked)
    if said is None:
        return None
    if _comes_again(said) and not isinstance(CONTROLLERS.get(scenario.controller), CompiledController):
        again, same = judge_asked(world, scenario.controller, options, asked)
        if same != said or again.trace_digest != episode.trace_digest:
            return None
    evidence: dict[str, Value] = {**evidence_table(episode.evidence), "oracle": asked.text, "objection": said}
    return _recorded(world, scenario, options, episode, evidence, asked.kind(said), details)


def _recorded(
    world: World,
    scenario: Scenario,
    options: RunOptions,
    episode: Episode,
    evidence: Mapping[str, Value],
    kind: str,
    details: Mapping[str, Value],
) -> World:
    """The world with the record of what went wrong in it; ``kind`` is the failure's class."""
    record = FailureRecord(
        controller=scenario.controller,
        motion=scenario.motion,
        seed=scenario.seed,
        verdict=episode.verdict.value,
        trace_digest=episode.trace_digest,
        parameters=options.parameters(),
        evidence=evidence,
        details={"class": kind, "motion_version": MOTIONS.get(scenario.motion).version, **details},
    )
    return replace(world, failure=record)


def judge_asked(
    world: World, controller: str, options: RunOptions, asked: Asked
) -> tuple[Episode, dict[str, Value] | None]:
    """Runs a scenario, recorded, and asks an oracle about it.

    Returns:
        The episode, and the objection; ``None`` also if already the verdict does not hold.
    """
    episode, wrong = judge(world, controller, options)
    said = asked.objection(Trial(world, controller, options, episode))
    return episode, None if said is None or (wrong and _comes_again(said)) else said


def _comes_again(objection: Mapping[str, Value]) -> bool:
    """Whether the run and the objection come again with the same bytes."""
    return objection.get("repeatable") is not False


def scenario_of(world: World) -> tuple[FailureRecord, RunOptions]:
    """The record of a failure and the options that it stores.

    Raises:
        InvalidParameter: If the file holds no failure, or its parameters are unknown.
    """
    record = world.failure
    if record is None:
        raise InvalidParameter(
            "no-failure", "this world holds no failure", "worldgen run simulates it", at_terminal=True
        )
    return record, RunOptions.of(record.motion, record.seed, record.parameters)


def replay(world: World, controller: str | None = None) -> Replay:
    """Runs a failure again from its file and compares verdict, evidence, digest and certificate.

    Args:
        world: A failure.
        controller: Another name for the controller, where the file's name cannot be found here.
    """
    record, options = scenario_of(world)
    if "oracle" in record.evidence:
        return _replay_asked(world, record, controller or record.controller, options)
    if record.verdict == Verdict.REACHED:
        return Replay("reached", False, "the file records that the robot arrived, which is no failure")
    try:
        episode, wrong = judge(world, controller or record.controller, options)
    except WorldgenError as error:
        return Replay("error", False, str(error))
    reason = _difference(record, episode) or wrong or certificate_fault(world)
    return Replay(episode.verdict, not reason, reason, episode)


def _replay_asked(world: World, record: FailureRecord, controller: str, options: RunOptions) -> Replay:
    """The replay of a failure by an oracle that was asked for."""
    before = record.evidence.get("objection")
    try:
        asked = asked_by(record.evidence)
        if asked is None or not isinstance(before, dict):
            return Replay("error", False, "the evidence names no oracle and objection")
        episode, said = judge_asked(world, controller, options, asked)
    except WorldgenError as error:
        return Replay("error", False, str(error))
    if said is None:
        return Replay(episode.verdict, False, f"oracle {asked.text} does not object to the run", episode)
    if _comes_again(said):
        reason = _difference(record, episode, {"oracle": asked.text, "objection": said})
    else:
        reason = "" if asked.kind(said) == asked.kind(before) else f"oracle {asked.text} objects otherwise: {said}"
    reason = reason or certificate_fault(world)
    return Replay(episode.verdict, not reason, reason, episode)


def certificate_fault(world: World) -> str:
    """Why a world's certificate does not hold; empty if it does."""
    if world.certificate is None:
        return "the file carries no witness that the target can be reached"
    if isinstance(world.certificate, Cut):
        report = _check_cut(world)
        return "" if report.valid else f"the cut does not hold: {report.reason}"
    report = check_certificate(world)
    return "" if report.valid else f"the witness does not hold: {report.reason}"


def _check_cut(world: World) -> CheckReport:
    """Checks the cut for the target as it is, then for its whole cell."""
    report = check_certificate(world)
    return check_certificate(_with_whole_cell(world)) if report.valid else report


def _difference(record: FailureRecord, episode: Episode, said: Mapping[str, Value] | None = None) -> str:
    """What is not as it was recorded; empty if nothing. ``said`` is what the record's oracle says now."""
    evidence = {**evidence_table(episode.evidence), **(said or {})}
    made, now = record.details.get("motion_version"), MOTIONS.get(record.motion).version
    other = f" (recorded with version {made} of {record.motion}, this is {now})" if made not in (None, now) else ""
    if episode.verdict != record.verdict:
        return f"the verdict is {episode.verdict}, not {record.verdict}{other}"
    if episode.trace_digest != record.trace_digest:
        return f"the trace digest is {episode.trace_digest}{other}"
    if _repeatable(evidence) != _repeatable(record.evidence):
        return f"the evidence is {evidence}{other}"
    return ""


def _repeatable(evidence: Mapping[str, Value]) -> dict[str, Value]:
    """The evidence without what may differ in a replay.

    A program's stderr and how far it came with an answer depend on the clock, the line in which a class raised moves
    when its file is edited, and files from before buckets of crashes have no facts for them.
    """
    unstable = ("stderr", "unfinished", "at", "remedy", *FACTS)
    return {name: value for name, value in evidence.items() if name not in unstable}


def seeds_that_fail(world: World, scenario: Scenario, count: int = 40) -> dict[str, Value]:
    """For a run with randomness: how many of ``count`` seeds do not arrive, and what that shows.

    The controller may draw random numbers, or the simulator, for slip or a noisy sensor.

    Returns:
        Of :func:`share_that_fails`; empty for a run without randomness, and for what is not compiled.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if not (isinstance(controller, CompiledController) and (controller.randomised or scenario.random)):
        return {}
    return share_that_fails(world, scenario, count)


def share_that_fails(world: World, scenario: Scenario, count: int) -> dict[str, Value]:
    """How many of ``count`` seeds do not arrive, and what that shows.

    Where the target is walled off, it is the seeds with which the robot does arrive, regardless of walls.

    Returns:
        ``failing_seeds`` as [k, n] and ``failing_share_at_least``, the lower end of the two-sided 95 % interval.

    Source: Charles Clopper and Egon Pearson, "The use of confidence or fiducial limits illustrated in the
    case of the binomial", Biometrika 1934.
    """
    controller = CONTROLLERS.get(scenario.controller)
    options, sealed = scenario.options(world), isinstance(world.certificate, Cut)
    options = regardless_of_walls(options) if sealed else options
    failing = 0
    for seed in range(count):
        run = prepare(world, controller, replace(options, seed=seed))
        arrives = run.run(options.steps, find_loop=False, record=False, digest=False).ending == Verdict.REACHED
        failing += arrives == sealed
    least, _ = interval_95(failing, count)
    return {"failing_seeds": [failing, count], "failing_share_at_least": round(least, 4)}
