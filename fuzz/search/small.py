"""The small strategy: for slow controllers, small worlds in short runs, one after another.

A run is dropped as soon as it promises nothing. The first failure of each cause is proved in the
unit that meets it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from fuzz.cause import Cause
from fuzz.facts.proofs import certified
from fuzz.failure import MOST_SHOWN
from fuzz.layouts.grown_worlds import grown_world
from fuzz.layouts.map_variations import variations_of
from fuzz.layouts.map_windows import Kind, kind_of
from fuzz.layouts.small_worlds import small_world
from fuzz.layouts.variation import applied
from fuzz.screening import can_screen
from fuzz.search.histories import Histories, extremes_of, line_cell
from fuzz.search.suspects import symptom_of
from fuzz.search.task import SearchTask
from fuzz.triage.diagnosis import cause_of_run
from fuzz.triage.triage import UNDECIDED, first_look
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import ScreenedRun
from sim.clock.stopping import check_time
from sim.controllers.lines_run import report_lines, watch_lines
from sim.episode import Episode, episode_of, prepare
from sim.evidence import LoopEvidence
from sim.options.run import RunOptions
from sim.outcome import LIMIT, Outcome, Runnable
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import InvalidWorld
from worldgen.random_streams import RandomStream
from worldgen.world import Witness, World

SMALL = "small"

_SECONDS = 1.0  # of the controller's time that a unit takes, without proofs
_OWN = 3e-3  # s of ours for each world
_USUAL_STEPS = 40  # of a run that arrives; only decides where a unit begins in the sequence
_MOST_WORLDS = 1_000  # of a unit, however quick the controller is
SETTLED = 24
"""Number of units that only look at what takes little. Later ones also grow worlds."""

# One in this many of them does, for so many s of the controller's time; it stops after this many
# worlds if no run changes any state.
_GROWN = 4
_GROWN_SECONDS = 2.0
_STATELESS = 4
# s for proving and deciding each cell of a grown world.
_PER_CELL = 5e-7
# Limits on the proof of a run in one: s of the controller's time, and numbers that it records.
_LONGEST_PROOF = 20.0
_MOST_RECORDED = 1 << 25
_USUAL_WIDTH = 32
# Times the witness's steps after which a run that has not arrived is examined, and the fewest
# steps; then after twice as many. Robots turn, or swing in, before they drive the shortest ways.
_FIRST_LOOK = 6
_FIRST_STEPS = 64
# Kinds of worlds on a user's map.
_KINDS_IN_TURN = (
    Kind.WINDOW,
    Kind.BOX,
    Kind.WINDOW,
    Kind.PERSON,
    Kind.WINDOW,
    Kind.DOOR,
    Kind.WINDOW,
    Kind.PIECE,
)


def fits(config: CampaignConfig) -> bool:
    """Return True if the strategy suits a campaign: it takes one robot, whose map stays as it is."""
    has_windows = config.fixed_map is None or not config.fixed_map.is_dynamic
    return config.robots == 1 and has_windows and can_screen(config.scenario)


def search(task: SearchTask) -> None:
    """Run small worlds one after another, and prove the first failure of each cause."""
    unit = _Unit(task)
    try:
        is_grown = task.unit >= SETTLED and task.unit % _GROWN == 0
        if is_grown and task.config.fixed_map is None:
            unit.grow()
        else:
            unit.screen()
        unit.prove_suspects()
    finally:
        unit.count_rest()


def grow(task: SearchTask) -> None:
    """Run worlds that are grown for long histories, and prove the failures that these lead to."""
    unit = _Unit(task)
    try:
        unit.grow()
        unit.prove_suspects()
    finally:
        unit.count_rest()


@dataclass(frozen=True)
class _Trial:
    """A run in a small world, which is begun with few steps.

    Slow controllers' answers are kept, so what was driven before costs little when the run is
    continued from its start.

    Args:
        world: The world, with its witness.
        scenario: The scenario.
        options: Options of the run, with the witness's budget.
        run: The run.
    """

    world: World
    scenario: Scenario
    options: RunOptions
    run: Runnable

    @property
    def witness_steps(self) -> int:
        """Steps that the witness takes."""
        witness = self.world.certificate
        time = witness.duration if isinstance(witness, Witness) else 0.0
        return math.ceil(time / self.options.time_step)

    def episode(self, outcome: Outcome) -> Episode:
        """Return a run as an episode, which is not a proof if the outcome is a loop."""
        episode = episode_of(self.run, self.world, outcome, self.options)
        if outcome.ending != Verdict.LOOP:
            return episode
        evidence = LoopEvidence(entry=outcome.entry, period=outcome.period, state_digest="")
        return replace(episode, verdict=Verdict.LOOP, evidence=evidence)


class _Suspect(NamedTuple):
    """A run that will hardly arrive.

    Args:
        price: Steps that a proof takes, multiplied if the symptom often deceives.
        number: Its place among the unit's worlds.
        steps: Steps so far.
        trial: The run.
    """

    price: int
    number: int
    steps: int
    trial: _Trial


class _Unit:
    """The work of one unit."""

    def __init__(self, task: SearchTask) -> None:
        self._task = task
        self._triage = task.triage
        self._pace = task.config.pace
        self._stream = task.stream
        # Varied options keep one value for the whole unit.
        self._values = {one.name: self._stream.choice(one.values) for one in task.config.vary}
        self._spent = 0.0  # s
        self._suspects: dict[Cause, _Suspect] = {}
        # Runs that were not examined, by verdict in screening and cause.
        self._alike: Counter[tuple[str, str]] = Counter()
        # Failures of earlier units, by cause.
        self._known = Counter(group for group, _ in task.memory.failures)
        # A loop that seems to recur is none if the controller hides memory, as its first run shows.
        self._finds_loops = True
        # Extremes of the runs in grown worlds.
        self._histories: Histories | None = None
        # Returns the lines that have run in them for the first time, and those of the first of them.
        self._lines: Callable[[], frozenset[int]] = frozenset
        self._usual_lines: frozenset[int] | None = None
        # Numbers that a run records for each step.
        self._width = _USUAL_WIDTH

    def screen(self) -> None:
        """Run small worlds until the unit's time is spent, or a failure of a new cause is proved."""
        usual = self._pace.reset + _USUAL_STEPS * self._pace.step + _OWN
        first = self._task.unit * max(1, round(_SECONDS / usual))
        for number in range(first, first + _MOST_WORLDS):
            check_time()
            seed = self._stream.next64() & 0xFFFFFFFF
            scenario = self._task.scenario(seed, self._stream.choice(self._task.config.time_steps))
            own = self._stream.child("world", number)
            world = self._world(own, number, scenario.run.time_step)
            if world is None:
                # Drawing takes time, too, so that a map without any world does not take all of it.
                self._spent += _OWN
                if self._spent >= _SECONDS:
                    return
                continue
            try:
                world, scenario = applied(self._values, world, scenario)
                # Another robot needs a witness of its own, which decides the budget.
                proved = world if world.certificate else certified(world)
                if proved is None:
                    continue
                self._try(proved, scenario, number)
            except InvalidWorld:
                # The drawn robot does not fit at the start.
                continue
            if self._task.config.fixed_map is not None:
                kind = kind_of(world, self._task.config.fixed_map)
                self._triage.result.tried[kind.value] += 1
            if self._has_found() or self._spent >= _SECONDS:
                return

    def _world(self, rng: RandomStream, number: int, time_step: float) -> World | None:
        """Return a small world, or a window or variation of the user's map."""
        config = self._task.config
        if config.fixed_map is None:
            return small_world(rng, number, self._values, time_step)
        step = config.fixed_map.robot_speed * config.time_steps[0]
        variations = variations_of(config.fixed_map, step)
        kind = _KINDS_IN_TURN[number % len(_KINDS_IN_TURN)]
        return variations.draw(kind, rng) or variations.draw(Kind.POSE, rng)

    def grow(self) -> None:
        """Run worlds that keep some behaviour going, and grow those that led further than others."""
        self._histories = Histories(self._task.memory.elites)
        # What other units of this process have seen must not matter, so watch all that is not known.
        report_lines()
        watch = watch_lines(self._task.controller, self._task.memory.lines)
        self._lines = frozenset if watch is None else watch.ran
        stream = self._stream.child("grown")
        scenario = self._task.scenario(
            stream.next64() & 0xFFFFFFFF, stream.choice(self._task.config.time_steps)
        )
        for number in range(_MOST_WORLDS):
            check_time()
            genome = self._histories.draw(stream)
            world = grown_world(genome, self._values)
            if world is not None:
                self._spent += _PER_CELL * world.walls.size
                self._grow(genome, world, scenario, number)
            # A controller without any state has no history.
            is_stateless = number >= _STATELESS and self._histories.is_empty
            if is_stateless or self._has_found() or self._spent >= _GROWN_SECONDS:
                break
        self._triage.result.elites |= self._histories.brought

    def _grow(self, genome: bytes, world: World, scenario: Scenario, number: int) -> None:
        """Run one grown world, unless its proof would take too long."""
        try:
            world, scenario = applied(self._values, world, scenario)
            proved = world if world.certificate else certified(world)
            if proved is None:
                return
            steps = scenario.options(proved).steps
            is_long = steps * self._pace.step > _LONGEST_PROOF
            if not is_long and steps * self._width <= _MOST_RECORDED:
                self._try(proved, scenario, number, genome)
        except InvalidWorld:
            # The robot does not fit at the start.
            return

    def _has_found(self) -> bool:
        """Return True if the unit has proved a failure of a new cause."""
        return bool({group for group, _ in self._triage.result.failures} - self._known.keys())

    def prove_suspects(self) -> None:
        """Give the best suspect of each new cause its whole budget, and prove its failure.

        Once a failure of a new cause is proved, the unit ends, so that the failure is stored.
        """
        in_order = sorted(self._suspects, key=lambda cause: self._suspects[cause][:-1])
        for cause in in_order:
            if self._has_found():
                return
            check_time()
            trial = self._suspects[cause].trial
            outcome = self._run(trial, trial.options.steps)
            del self._suspects[cause]
            self._take(trial, outcome)

    def count_rest(self) -> None:
        """Count the runs that were not examined, also if the unit's time ran out."""
        for cause, suspect in self._suspects.items():
            self._leave(suspect.steps, cause)
        for kind, count in self._alike.items():
            self._triage.count_alike(*kind, count)

    def _try(
        self, world: World, scenario: Scenario, number: int, genome: bytes | None = None
    ) -> None:
        """Run until the robot arrives or fails, or will hardly arrive.

        Args:
            world: The world, with its witness.
            scenario: The scenario.
            number: The world's number in the unit.
            genome: The genome of a grown world.
        """
        options = scenario.options(world)
        before = self._task.screened.get(number)
        trial = _Trial(world, scenario, options, prepare(world, self._task.controller, options))
        if before is not None:
            self._take_before(trial, number, before)
            return
        steps = max(_FIRST_LOOK * trial.witness_steps, _FIRST_STEPS)
        while True:
            steps = min(steps, options.steps)
            outcome = self._run(trial, steps)
            if outcome.ending != LIMIT or steps == options.steps:
                if first_look(outcome) == Verdict.REACHED and genome is None:
                    self._keep(number, ScreenedRun(outcome.steps, complete=outcome.complete))
                self._take(trial, outcome, is_new=self._is_new(trial, outcome, genome))
                break
            episode = trial.episode(outcome)
            symptom = symptom_of(world, episode)
            if symptom is not None:
                cause = cause_of_run(world, episode)
                if genome is None:
                    seen = ScreenedRun(steps, cause.value, int(symptom), outcome.complete)
                    self._keep(number, seen)
                # In a grown world, the longest history comes first: the others have been tried.
                price = options.steps * (1 + symptom) if genome is None else -steps
                is_new = self._is_new(trial, outcome, genome)
                self._suspect(cause, _Suspect(price, number, steps, trial), is_new=is_new)
                break
            steps *= 2
        self._spent += outcome.steps * self._pace.step + self._pace.reset + _OWN

    def _keep(self, number: int, run: ScreenedRun) -> None:
        """Keep a run for the case that the unit is cut short, unless an oracle has to see it."""
        if not self._task.config.oracles:
            self._triage.result.screened[number] = run

    def _take_before(self, trial: _Trial, number: int, run: ScreenedRun) -> None:
        """Do with a run that was made before the unit was cut short what was done then."""
        self._keep(number, run)
        self._finds_loops &= run.complete
        self._spent += run.steps * self._pace.step + self._pace.reset + _OWN
        if run.cause:
            price = trial.options.steps * (1 + run.symptom)
            self._suspect(Cause(run.cause), _Suspect(price, number, run.steps, trial))
        else:
            self._triage.count(Verdict.REACHED, run.steps)

    def _is_new(self, trial: _Trial, outcome: Outcome, genome: bytes | None) -> bool:
        """Return True if a run in a grown world has an extreme; keep its world if it arrives."""
        if self._histories is None or genome is None or outcome.trace is None:
            return False
        self._width = max(self._width, outcome.trace.states.shape[1])
        host = getattr(trial.run, "host", None)
        extremes = extremes_of(None if host is None else host.controller, outcome.trace)
        ran = self._lines()
        if self._usual_lines is None:
            self._usual_lines = ran
        extremes |= {line_cell(line): 1.0 for line in ran - self._usual_lines}
        return self._histories.take(genome, extremes, first_look(outcome))

    def _run(self, trial: _Trial, steps: int) -> Outcome:
        outcome = trial.run.run(steps, find_loop=self._finds_loops, record=True)
        self._finds_loops &= outcome.complete
        return outcome

    def _suspect(self, cause: Cause, found: _Suspect, *, is_new: bool = False) -> None:
        """Keep a suspect if it is the best of a cause that is new, or led to where no run was."""
        best = self._suspects.get(cause, found)
        if (self._known[cause.value] and not is_new) or best[:-1] < found[:-1]:
            self._leave(found.steps, cause)
            return
        if best is not found:
            self._leave(best.steps, cause)
        self._suspects[cause] = found

    def _take(self, trial: _Trial, outcome: Outcome, *, is_new: bool = False) -> None:
        """Count a run that is over, and prove its failure if it is one."""
        verdict = first_look(outcome)
        if verdict == Verdict.LOOP and not outcome.complete:
            # It may only seem to repeat itself, so run again without ending there.
            outcome = self._run(trial, trial.options.steps)
            verdict = first_look(outcome)
        if verdict not in (Verdict.LOOP, UNDECIDED):
            self._triage.look(trial.world, trial.scenario, outcome)
            return
        episode = trial.episode(outcome)
        cause = cause_of_run(trial.world, episode)
        # Few failures of a cause are shown, and one in a unit is enough to find another variant. One in
        # all is enough if its proof is a whole second run.
        most = 1 if verdict == UNDECIDED else MOST_SHOWN
        is_enough = self._known[cause.value] >= most and not is_new
        few = MOST_SHOWN if is_new else 1
        if is_enough or self._triage.examined(verdict, cause.value) >= few:
            self._leave(outcome.steps, cause, verdict)
            return
        known = episode if verdict == UNDECIDED else None
        self._triage.count(verdict, outcome.steps)
        self._triage.enter(trial.world, trial.scenario, verdict, cause.value, known=known)

    def _leave(self, steps: int, cause: Cause, verdict: str = UNDECIDED) -> None:
        """Count a run that is not examined."""
        self._triage.count(verdict, steps)
        self._alike[verdict, cause.value] += 1
