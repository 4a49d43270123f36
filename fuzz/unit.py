"""Units of a campaign: pure functions of (configuration, unit number), so any worker may do any of them."""

from __future__ import annotations

import contextlib
from collections import Counter
from dataclasses import dataclass, field, replace

from fuzz.asked import Asked, Trial
from fuzz.failure import certified, failure_by, failure_of, regardless_of_walls, walled_off
from fuzz.lanes import SEALED, Draw, combined, explore, lane_strategy
from sim.controllers import CONTROLLERS, CompiledController, ProcessController
from sim.episode import prepare
from sim.outcome import Outcome
from sim.run_options import RunOptions, step_budget
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.random_streams import RandomStream
from worldgen.world import World

__all__ = ["CampaignConfig", "UnitResult", "run_unit"]

_SEARCH_STEPS = 6_000  # budget of a first look, before the witness is known
_PROOF_STEPS = 60_000  # budget in which a failing run may close its loop
_SLOWER = 8  # a Python controller takes microseconds where a compiled one takes nanoseconds: that much less of each
_PROVE_AT_MOST = 24  # failing runs of one verdict and cause that a unit proves and classifies; the rest it counts
_PROVE_HANGS_AT_MOST = 2  # likewise, for each run that hangs costs a whole deadline, several times


@dataclass(frozen=True)
class CampaignConfig:
    """What a campaign looks for.

    Args:
        scenario: Controller, motion model and switches; each draw has its own seed and time step.
        seed: Of the whole campaign.
        families: Where worlds come from; empty for feature layouts and the built-in families in turn.
        time_steps: Durations of a step to draw from, s.
        fixed_map: A foreign map on which only start, heading, target and radius vary.
        examples: Hypothesis examples in one unit.
        shrink: Whether failures are shrunk; on a user's own map they are more useful where they are.
        oracles: Oracles to ask about each run beside its verdict, as ``--oracle`` takes them.
    """

    scenario: Scenario
    seed: int = 0
    families: tuple[str, ...] = ()
    time_steps: tuple[float, ...] = (RunOptions.time_step,)
    fixed_map: World | None = None
    examples: int = 400
    shrink: bool = True
    oracles: tuple[str, ...] = ()

    def lane(self, unit: int) -> str:
        """The lane of a unit."""
        names = ("map",) if self.fixed_map is not None else (self.families or combined(self.scenario))
        return names[unit % len(names)]


@dataclass
class UnitResult:
    """What one unit found.

    Args:
        worlds: Scenarios simulated.
        steps: Steps simulated.
        verdicts: How often each verdict came up at first look; where the target is walled off, ``breach`` for
            a robot that got there, ``sealed`` for one that did not.
        failures: The smallest failure of each class, with witness, evidence and class.
        met: How often each class was met among the failures that were classified.
    """

    worlds: int = 0
    steps: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    failures: dict[str, World] = field(default_factory=dict)
    met: Counter[str] = field(default_factory=Counter)


def run_unit(config: CampaignConfig, unit: int) -> UnitResult:
    """Does one unit: draws, runs, proves, classifies. No clock, no shared state."""
    search = _Search(config, UnitResult())
    lane = config.lane(unit)
    strategy = lane_strategy(lane, time_steps=config.time_steps, fixed_map=config.fixed_map)
    unit_seed = RandomStream(config.seed).child("unit", unit).next64()
    share = (1 if lane in ("features", "map", SEALED) else 4) * (1 if search.compiled else _SLOWER)
    examples = max(config.examples // share, 1)
    explore(strategy, unit_seed, examples, search.visit_sealed if lane == SEALED else search.visit)
    return search.result


class _Search:
    """Runs draws and keeps what fails."""

    def __init__(self, config: CampaignConfig, result: UnitResult) -> None:
        self._config, self.result = config, result
        self._controller = CONTROLLERS.get(config.scenario.controller)
        self.compiled = isinstance(self._controller, CompiledController)
        self._asked = [Asked.parse(text) for text in config.oracles]
        self._failed: Counter[tuple[str, str]] = Counter()
        self._proof_steps = _PROOF_STEPS if self.compiled else _PROOF_STEPS // _SLOWER
        if isinstance(self._controller, ProcessController):  # of which no loop can be proved
            self._proof_steps = 0

    def visit(self, draw: Draw) -> None:
        """Runs one scenario; a failure is proved, classified and kept if it is the smallest of its class."""
        scenario = self._scenario(draw)
        budget = step_budget(draw.world, draw.time_step) if draw.world.certificate else _SEARCH_STEPS
        try:
            run = prepare(draw.world, self._controller, scenario.options(draw.world, budget))
            outcome = run.run(budget, find_loop=True, record=False, digest=False)
        except InvalidWorld:  # the drawn start is in a wall
            return
        verdict = _first_look(outcome)
        self.result.worlds += 1
        self.result.steps += outcome.steps
        self.result.verdicts[verdict] += 1
        if verdict != "reached" and self._is_to_be_proved(verdict, outcome):
            self._prove(draw.world, scenario)
        if self._asked:
            self._ask(draw.world, scenario)

    def visit_sealed(self, draw: Draw) -> None:
        """Runs one scenario whose target is walled off; all that counts is a robot that gets there."""
        scenario, verdict = self._scenario(draw), "sealed"
        options = scenario.options(draw.world)
        outcome = prepare(draw.world, self._controller, options).run(
            options.steps, find_loop=True, record=False, digest=False
        )
        if outcome.ending == "tunnel":
            run = prepare(draw.world, self._controller, regardless_of_walls(options))
            whole = run.run(options.steps, find_loop=True, record=False, digest=False)
            verdict = "breach" if whole.ending == "reached" else "sealed"
        self.result.worlds += 1
        self.result.steps += outcome.steps
        self.result.verdicts[verdict] += 1
        if verdict == "breach" and self._is_to_be_proved(verdict, outcome):
            sealed = walled_off(draw.world)
            self._keep(None if sealed is None else failure_of(sealed, scenario, steps=options.steps))

    def _is_to_be_proved(self, verdict: str, outcome: Outcome) -> bool:
        return self._is_one_of_few(verdict, outcome.cause)

    def _is_one_of_few(self, verdict: str, cause: str) -> bool:
        self._failed[verdict, cause] += 1
        return self._failed[verdict, cause] <= (_PROVE_HANGS_AT_MOST if verdict == "hang" else _PROVE_AT_MOST)

    def _scenario(self, draw: Draw) -> Scenario:
        return replace(self._config.scenario, time_step=draw.time_step, seed=draw.seed)

    def _prove(self, world: World, scenario: Scenario) -> None:
        proved = world if world.certificate else certified(world)
        try:
            self._keep(None if proved is None else failure_of(proved, scenario, fewest_steps=self._proof_steps))
        except InvalidParameter:  # too long to be recorded, so nothing that could be shown
            return

    def _ask(self, world: World, scenario: Scenario) -> None:
        """Lets every oracle that was asked for judge the run, with its witness's budget."""
        proved = world if world.certificate else certified(world)
        if proved is None:
            return
        trial = Trial(proved, scenario.controller, scenario.options(proved))
        for asked in self._asked:
            said = asked.objection(trial)
            if said is None or not self._is_one_of_few("oracle", asked.kind(said)):
                continue
            with contextlib.suppress(InvalidParameter):  # too long to be recorded
                self._keep(failure_by(proved, scenario, asked))

    def _keep(self, failure: World | None) -> None:
        if failure is None or failure.failure is None:
            return
        kind = str(failure.failure.details["class"])
        self.result.met[kind] += 1
        before = self.result.failures.get(kind)
        if before is None or failure.solid_cells < before.solid_cells:
            self.result.failures[kind] = failure


def _first_look(outcome: Outcome) -> str:
    if outcome.ending == "limit":
        return "overlap" if outcome.overlap_step >= 0 else "undecided"
    return "overlap" if outcome.overlap_step >= 0 and outcome.ending in ("reached", "loop") else outcome.ending
