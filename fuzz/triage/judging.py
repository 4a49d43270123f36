"""Judging: from a run to a failure with evidence that holds, and back from a failure's file to the same run.

A run may also fail by an oracle that was asked for: its verdict is then what it is, ``reached`` for one, and the
evidence names the ``oracle`` and its ``objection`` (:mod:`fuzz.oracles`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from fuzz.evidence_checks import check_breach, check_evidence
from fuzz.failure import Failure, regardless_of_walls
from fuzz.oracles import Asked, Trial
from fuzz.triage.crash_bucket import FACTS
from fuzz.triage.hazards import hazard_details
from fuzz.triage.proofs import certificate_fault
from fuzz.triage.signature import failure_class
from sim.controllers import CONTROLLERS, CompiledController, ProcessController
from sim.episode import Episode, prepare, simulate
from sim.evidence import LoopEvidence, WallEvidence, evidence_table
from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.options.run import RunOptions
from sim.scenario import Scenario
from sim.verdict import BY_THE_CONTROLLER, Verdict
from worldgen.errors import WorldgenError
from worldgen.world import Cut, FailureRecord, Value, World

__all__ = ["Replay", "failure_by", "failure_of", "judge", "judge_asked", "replay"]


@dataclass(frozen=True)
class Replay:
    """What replaying a failure showed."""

    verdict: str
    confirmed: bool
    reason: str
    episode: Episode | None = None


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
    wrong = check_evidence(episode.verdict, world, trace, episode.evidence, options.motion_model())
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
    return replace(episode, evidence=wall), check_breach(world, episode.trace, whole.trace, wall)


def failure_of(
    world: World, scenario: Scenario, *, fewest_steps: int = 0, steps: int | None = None, **details: Value
) -> Failure | None:
    """The failure of a scenario, or ``None`` if the robot arrives or the verdict is not confirmed.

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


def failure_by(world: World, scenario: Scenario, asked: Asked, **details: Value) -> Failure | None:
    """The failure of a scenario to which an oracle objects, or ``None`` if it does not, or not twice alike.

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
) -> Failure:
    """The failure with the record of what went wrong; ``kind`` is its class."""
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
    return Failure(replace(world, failure=None), record)


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


def replay(failure: Failure, controller: str | None = None) -> Replay:
    """Runs a failure again from its file and compares verdict, evidence, digest and certificate.

    Args:
        failure: From its file.
        controller: Another name for the controller, where the file's name cannot be found here.

    Raises:
        InvalidParameter: If the record names options that are unknown here.
    """
    failure = failure.driven_by(controller)
    record, options = failure.record, failure.options
    if failure.oracle is not None:
        return _replay_asked(failure, failure.oracle)
    if record.verdict == Verdict.REACHED:
        return Replay("reached", False, "the file records that the robot arrived, which is no failure")
    try:
        episode, wrong = judge(failure.world, record.controller, options)
    except WorldgenError as error:
        return Replay("error", False, str(error))
    reason = _difference(record, episode) or wrong or certificate_fault(failure.world)
    return Replay(episode.verdict, not reason, reason, episode)


def _replay_asked(failure: Failure, oracle: str) -> Replay:
    """The replay of a failure by an oracle that was asked for."""
    record = failure.record
    if not failure.objection:
        return Replay("error", False, "the evidence names no oracle and objection")
    try:
        asked = Asked.parse(oracle)
        episode, said = judge_asked(failure.world, record.controller, failure.options, asked)
    except WorldgenError as error:
        return Replay("error", False, str(error))
    if said is None:
        return Replay(episode.verdict, False, f"oracle {asked.text} does not object to the run", episode)
    if _comes_again(said):
        reason = _difference(record, episode, {"oracle": asked.text, "objection": said})
    else:
        is_alike = asked.kind(said) == asked.kind(failure.objection)
        reason = "" if is_alike else f"oracle {asked.text} objects otherwise: {said}"
    reason = reason or certificate_fault(failure.world)
    return Replay(episode.verdict, not reason, reason, episode)


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
