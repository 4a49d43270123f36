"""Judge runs: turn a run into a failure with confirmed evidence.

Campaigns, shrinking, replays and regression tests all call :func:`violation_in` before a violation
counts. If a user's oracle finds one, the run keeps its verdict, mostly ``reached``, and the
failure's evidence names the oracle and the facts that it found.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from fuzz.facts.crash_bucket import FACTS, NAMED
from fuzz.failure import Failure
from fuzz.oracles import NamedOracle, Oracle, Trial, Violation, verdict_oracle
from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.catalogue.renewal import as_loaded
from sim.controllers.instances import origin_of
from sim.controllers.shared.object_file import is_library_name
from sim.episode import Episode
from sim.episode.differences import count_sources, note_difference
from sim.evidence import LoopEvidence, evidence_table
from sim.motion import MOTIONS
from sim.options.run import USUAL_BUDGET, RunOptions
from sim.scenario import Scenario
from sim.verdict import ARRIVALS, OUT_OF_BUDGET, Verdict
from worldgen.world import FailureRecord, Value, World

# Times the witness that a run in another world may take if steps are expensive.
_FEW_WITNESSES = 10


class JudgedRun(NamedTuple):
    """What judging a run has shown.

    Args:
        failure: The proved failure; ``None`` if nothing is proved.
        is_settled: False if the run looks like a failure, but the check of its evidence or a second
            run does not agree, so that nothing is shown.
    """

    failure: Failure | None
    is_settled: bool


def violation_in(trial: Trial, oracle: Oracle) -> Violation | None:
    """Return what an oracle finds in a run, provided the evidence for the run's verdict holds.

    Searches and shrinking may call an oracle directly, to decide which runs deserve this check.

    Raises:
        InvalidParameter: If the oracle does not fit the run, or fails.
    """
    found = oracle.check(trial)
    return None if found is None or not _holds(trial, found) else found


def _holds(trial: Trial, found: Violation) -> bool:
    """Return True if the evidence for the run's verdict holds, where the violation needs it."""
    return not (found.is_repeatable and trial.flaw)


def oracle_of(failure: Failure) -> Oracle:
    """Return the oracle that found a failure.

    Raises:
        InvalidParameter: If there is no such oracle.
    """
    return (
        verdict_oracle(failure.world)
        if failure.oracle is None
        else NamedOracle.parse(failure.oracle)
    )


def failure_of(
    world: World,
    scenario: Scenario,
    oracle: Oracle | None = None,
    *,
    fewest_steps: int = 0,
    steps: int | None = None,
    **details: Value,
) -> Failure | None:
    """Return the failure that an oracle finds in a scenario.

    ``None`` if it finds none, or if a second run does not show the same.

    Args:
        world: As for :func:`judge`, like all others.
        scenario: The scenario to run.
        oracle: The oracle that judges the run.
        fewest_steps: Smallest budget for verdicts that the run itself proves.
        steps: The exact budget for verdicts that the run itself proves.
        **details: Further details to record.
    """
    judged = judge(
        world,
        scenario,
        oracle,
        fewest_steps=fewest_steps,
        steps=steps,
        known=None,
        elsewhere=True,
        **details,
    )
    return judged.failure


def judge(
    world: World,
    scenario: Scenario,
    oracle: Oracle | None = None,
    *,
    fewest_steps: int = 0,
    steps: int | None = None,
    known: Episode | None = None,
    elsewhere: bool = True,
    **details: Value,
) -> JudgedRun:
    """Judge a scenario: run it, and prove the failure that an oracle finds.

    Args:
        world: A world with a witness or, for a breach, with a cut.
        scenario: The scenario to run.
        oracle: The oracle that judges the run; its verdict alone if omitted.
        fewest_steps: Smallest budget for verdicts that the run itself proves. ``stalled`` and
            ``timeout`` always refer to the witness's budget, even if the robot arrives after it.
        steps: The exact budget for verdicts that the run itself proves.
        known: The run with the witness's budget, recorded, if it has already been done.
        elsewhere: Whether to run it in other worlds, too, for a circumstance that only these show.
        **details: Further details to record.
    """
    oracle = oracle or verdict_oracle(world)
    options = scenario.options(world)
    longer = (
        replace(options, steps=steps or max(options.steps, fewest_steps))
        if oracle.by_verdict
        else options
    )
    if known is not None:
        longer = options
    repeated_before = _repeated_proofs(scenario.controller)
    trial = (
        Trial.recorded(world, scenario.controller, longer)
        if known is None
        else Trial(world, scenario.controller, options, known)
    )
    episode = trial.episode

    # A robot that needs more than the witness's budget is judged by that budget.
    late = episode.verdict in ARRIVALS and episode.steps > options.steps
    if longer != options and (late or episode.verdict in OUT_OF_BUDGET):
        trial = Trial.recorded(world, scenario.controller, options)

    # Here a world is known in which this may be seen again, and named.
    if (origin := origin_of(CONTROLLERS.get(scenario.controller))) and origin.answers.differ:
        note_difference(world, scenario.controller, options)

    found = oracle.check(trial)
    if found is None:
        return JudgedRun(None, is_settled=True)
    # The proof of a loop may have been a second run already.
    is_loop = oracle.by_verdict and isinstance(trial.episode.evidence, LoopEvidence)
    is_repeated = is_loop and _repeated_proofs(scenario.controller) > repeated_before
    if not _holds(trial, found) or not (
        is_repeated or _comes_again(trial, found, oracle, is_fresh=known is None)
    ):
        if known is None:
            return JudgedRun(None, is_settled=False)
        # A run of the search may end later than a fresh one, which looks for a loop, or earlier.
        # Only two fresh runs show whether the controller does the same again.
        return judge(
            world,
            scenario,
            oracle,
            fewest_steps=fewest_steps,
            steps=steps,
            known=None,
            elsewhere=elsewhere,
            **details,
        )
    # Only what follows needs these modules, so a replay does not load them.
    from fuzz.facts.hazards import hazard_details  # noqa: PLC0415

    if oracle.by_verdict:
        run = trial.recorded_run if trial.episode.verdict == Verdict.BURNED else trial.episode
        details = {**hazard_details(trial.world, run, scenario), **details}
    record = FailureRecord(
        controller=scenario.controller,
        motion=scenario.run.motion,
        seed=scenario.run.seed,
        verdict=trial.episode.verdict.value,
        trace_digest=trial.episode.trace_digest,
        parameters=trial.options.parameters(),
        evidence=found.table,
        details={
            "class": found.bucket,
            **_diagnosis(
                trial,
                found,
                oracle,
                details,
                _options_elsewhere(trial, scenario) if elsewhere else None,
            ),
            "motion_version": MOTIONS.get(scenario.run.motion).version,
            **details,
        },
    )
    return JudgedRun(Failure(replace(world, failure=None), record), is_settled=True)


def _diagnosis(
    trial: Trial,
    found: Violation,
    oracle: Oracle,
    details: Mapping[str, Value],
    options_elsewhere: RunOptions | None,
) -> dict[str, Value]:
    """Return the details that hold a new failure's cause; a replay finds them in the file.

    Args:
        trial: The run.
        found: What the oracle finds in it.
        oracle: The oracle.
        details: Further details of the record.
        options_elsewhere: Options of runs in other worlds; ``None`` if there are to be none.
    """
    from fuzz.cause import Cause, Circumstance, Diagnosis  # noqa: PLC0415
    from fuzz.facts.changed_worlds import OtherWorlds  # noqa: PLC0415 - loads the metrics of worlds
    from fuzz.facts.hazards import hazard_in  # noqa: PLC0415
    from fuzz.triage import diagnosis  # noqa: PLC0415

    if not oracle.by_verdict:
        return diagnosis.details_of(Diagnosis(Cause.BREAKS_A_RULE))
    if (hazard := hazard_in(details)) is not None:
        return diagnosis.details_of(Diagnosis(diagnosis.CAUSE_OF_HAZARD[hazard]))
    episode = trial.episode
    others = OtherWorlds(trial.controller, options_elsewhere) if options_elsewhere else None
    seen = diagnosis.diagnosis_of_run(
        trial.world, replace(episode, evidence=found.evidence or episode.evidence), others
    )
    # Where it is says little as long as nothing shows that no gap, and no change, holds it there.
    if others is None and seen.circumstance in (
        Circumstance.BEHIND_A_WALL,
        Circumstance.AT_THE_TARGET,
    ):
        seen = Diagnosis(seen.cause)
    return diagnosis.details_of(seen)


def _options_elsewhere(trial: Trial, scenario: Scenario) -> RunOptions:
    """Return the options of runs in other worlds, which only decide a failure's circumstance."""
    options = trial.options
    if scenario.budget.fewest >= USUAL_BUDGET.fewest or trial.witness is None:
        return options
    # Each step is expensive here. Robots that arrive at all mostly do so much earlier.
    few = math.ceil(_FEW_WITNESSES * trial.witness.duration / options.time_step)
    return replace(options, steps=min(options.steps, few))


def _repeated_proofs(controller: str) -> int:
    origin = origin_of(CONTROLLERS.get(controller))
    return 0 if origin is None else origin.answers.repeated_proofs


def _comes_again(trial: Trial, found: Violation, oracle: Oracle, *, is_fresh: bool) -> bool:
    """Return True if a second run has the same result, which a file needs in order to replay.

    Args:
        trial: The first run.
        found: What the oracle finds in it.
        oracle: The oracle.
        is_fresh: False for a run of the search, which may end otherwise than a second one.
    """
    if not found.is_repeatable:
        return True
    # A compiled controller is deterministic by construction, but a library may keep state.
    controller = as_loaded(trial.controller)
    if isinstance(controller, CompiledController) and not is_library_name(trial.controller):
        return True
    if oracle.by_verdict:
        # The controller must really act again: in the two periods that prove a loop, or always.
        if (origin := origin_of(controller)) is not None:
            is_loop = isinstance(trial.episode.evidence, LoopEvidence)
            origin.answers.forget(proofs_only=is_loop)
        again = trial.again()
        is_same = _identity(again) == _identity(trial.episode)
        has_hung = Verdict.HANG in (again.verdict, trial.episode.verdict)
        if not is_same and is_fresh and not has_hung:
            count_sources(trial.world, trial.controller, trial.options)
        return is_same
    second = Trial.recorded(trial.world, trial.controller, trial.options)
    other = violation_in(second, oracle)
    is_same = other is not None and other.facts == found.facts
    return is_same and second.episode.trace_digest == trial.episode.trace_digest


def _identity(episode: Episode) -> tuple[object, ...]:
    return episode.verdict, episode.trace_digest, repeatable(evidence_table(episode.evidence))


def repeatable(evidence: Mapping[str, Value]) -> dict[str, Value]:
    """Return the evidence without the parts that may differ in a replay.

    A program's stderr, and how much of its answer had arrived, depend on the clock. The line in
    which a class raised changes when its file is edited. Files written by older versions have no
    facts for buckets, nor the names in ``NAMED``, which the error implies, nor a drift of the memory,
    which only recorded runs show.
    """
    drift = ("memory_drift", "entry", "period") if "memory_drift" in evidence else ()
    unstable = ("stderr", "unfinished", "at", "remedy", *FACTS, *NAMED, *drift)
    return {name: value for name, value in evidence.items() if name not in unstable}
