"""Targets for a world: outcomes of controllers.

Each controller has an outcome; a run's distance from it can be measured.
"""

from __future__ import annotations

import math
import re
import statistics
from dataclasses import dataclass

from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.noise import is_noisy, is_random
from sim.episode import prepare, simulate
from sim.evidence import LoopEvidence
from sim.options.run import RunOptions
from sim.scenario import Scenario
from sim.verdict import FAILURES, STUCK, UNENDED, Verdict
from worldgen.errors import InvalidParameter
from worldgen.world import World

# Number of runs of a random controller.
SEEDS = 20
# Seeds that may have another outcome: one in twenty.
_SHARE = 0.05
# Distance of a run that ends in a completely different way.
_OTHERWISE = 2.0
# Distance of an unwanted run that breaks through a wall, burns or crashes.
_BROKEN = 3.0
_UNTIMED_STEPS = 20_000
# Minimum budget if a latest arrival is requested.
_TIMED_STEPS = 1_000
# Limit on a run's length, as a multiple of the requested steps.
_LATE = 3

_GROUPS = {"stuck": STUCK, "fails": FAILURES}
_OLD_NAMES = {"never": "stuck"}
_EXAMPLE = 'write for example "thesis-1=reached@330, thesis-2=loop"'
_OUTCOME = re.compile(r"(?P<word>[a-z-]+)(?:@(?P<range>.+))?")
_NUMBER = r"\d+(?:\.\d+)?s?"
_RANGE = re.compile(
    rf"(?P<exact>{_NUMBER})|(?P<low>{_NUMBER})\.\.(?P<high>{_NUMBER})|<(?P<below>{_NUMBER})|>(?P<above>{_NUMBER})"
)


@dataclass(frozen=True)
class Result:
    """The result of a controller: of one run, or over the seeds of a random controller.

    Args:
        verdict: Verdict of the run; of several runs, the most frequent.
        steps: Steps until the run's end, or the period of a ``loop``; over seeds, the median until
            arrival, ``inf`` if most do not arrive.
        share: Share of runs that arrived.
        distance: Distance from the target; 0 if it is met.
        seeds: Number of runs.
    """

    verdict: str
    steps: float
    share: float
    distance: float
    seeds: int = 1


@dataclass(frozen=True)
class _Run:
    verdict: str
    # The period of a loop.
    steps: int
    distance: float
    # True if another seed may give another outcome.
    chance: bool


@dataclass(frozen=True)
class OutcomeTarget:
    """The requested outcome of one controller.

    Args:
        scenario: The controller and how it runs.
        text: The outcome as it was written.
        verdicts: Accepted verdicts.
        low: Fewest steps (or shortest period), or ``None``.
        high: Maximum number of steps (or longest period), or ``None``.
    """

    scenario: Scenario
    text: str
    verdicts: tuple[str, ...]
    low: float | None = None
    high: float | None = None

    @property
    def says_chance(self) -> bool:
        """True if the controller, or the simulator under it, is known to draw random numbers."""
        controller = CONTROLLERS.get(self.scenario.controller)
        return is_random(controller, self.scenario.run)

    @property
    def cost(self) -> int:
        """A rank that increases with the time that a run takes.

        In order: one compiled run, many compiled runs, runs of a Python controller.
        """
        if not isinstance(CONTROLLERS.get(self.scenario.controller), CompiledController):
            return 2
        return int(self.says_chance)

    @property
    def steps(self) -> int:
        """Budget of a run, in steps."""
        latest = int(_LATE * (self.high or self.low or 0))
        return max(
            latest, _TIMED_STEPS if self._timed and self.high is not None else _UNTIMED_STEPS
        )

    @property
    def _timed(self) -> bool:
        return self.verdicts == (Verdict.REACHED,) and (
            self.low is not None or self.high is not None
        )

    def look(self, world: World, *, prove: bool = False) -> Result:
        """Run the controller in a world.

        A controller that draws random numbers there is run with :data:`SEEDS` seeds.

        Args:
            world: The world.
            prove: True to prove a loop that the kernel claims. Only a controller that hides memory
                can disprove it, but the proof records the run.

        Raises:
            InvalidWorld: If the robot cannot stand at the start.
        """
        first = self._run(world, 0, prove)
        if first.chance:
            return self._over_seeds(
                [first, *(self._run(world, seed, prove) for seed in range(1, SEEDS))]
            )
        # It drew no random numbers, so every seed gives the same run.
        if self.says_chance:
            return self._over_seeds([first] * SEEDS)
        return Result(
            first.verdict, first.steps, float(first.verdict == Verdict.REACHED), first.distance
        )

    def _run(self, world: World, seed: int, prove: bool) -> _Run:
        scenario = self.scenario.with_run(seed=seed)
        options = scenario.options(world, self.steps)
        outcome = prepare(world, scenario.controller, options).run(
            options.steps, find_loop=True, record=False, digest=False
        )
        chance = outcome.random_draws > 0 or is_noisy(
            CONTROLLERS.get(scenario.controller), scenario.run
        )
        verdict = outcome.verdict
        steps = outcome.steps
        if verdict == Verdict.LOOP:
            verdict, steps = (
                self._proved(world, options) if prove else (Verdict.LOOP, outcome.period)
            )
        return _Run(
            verdict, steps, self._distance(verdict, steps, chance or self.says_chance), chance
        )

    def _proved(self, world: World, options: RunOptions) -> tuple[Verdict, int]:
        episode = simulate(world, self.scenario.controller, options)
        evidence = episode.evidence
        return episode.verdict, evidence.period if isinstance(
            evidence, LoopEvidence
        ) else episode.steps

    def _over_seeds(self, runs: list[_Run]) -> Result:
        """Return the combined outcome of many runs.

        It is met if nearly all runs are as requested and none passes through walls, or the median
        time is as requested.
        """
        # Summarise the runs.
        verdicts = [run.verdict for run in runs]
        verdict = max(Verdict, key=verdicts.count)
        share = verdicts.count(Verdict.REACHED) / len(runs)
        steps = statistics.median(
            run.steps if run.verdict == Verdict.REACHED else math.inf for run in runs
        )
        # The distance is computed from the median time, or from the share of fitting runs.
        if self._timed:
            distance = self._off(steps) if math.isfinite(steps) else _OTHERWISE - share
        else:
            fitting = sum(run.distance == 0.0 for run in runs) / len(runs)
            broken = sum(run.distance == _BROKEN for run in runs) / len(runs)
            distance = (max(1.0 - _SHARE - fitting, 0.0) + broken) * _OTHERWISE
        return Result(verdict, steps, share, distance, len(runs))

    def _distance(self, verdict: str, number: int, chance: bool) -> float:
        """Return the distance of one run from the target.

        With randomness, no state needs to recur, so ``stuck`` only means not within the budget.
        """
        if verdict in self.verdicts or (
            chance and verdict == Verdict.TIMEOUT and self.verdicts == _GROUPS["stuck"]
        ):
            return self._off(number)
        if verdict not in (Verdict.REACHED, *UNENDED):
            return _BROKEN
        # The later it arrives, the closer it is to not arriving.
        if verdict == Verdict.REACHED:
            return _OTHERWISE - min(number / self.steps, 1.0)
        return _OTHERWISE

    def _off(self, number: float) -> float:
        """Return how far a number of steps is from the range, as a share of its nearer end."""
        if self.low is not None and number < self.low:
            return (self.low - number) / self.low
        if self.high is not None and number > self.high:
            return min((number - self.high) / self.high, _OTHERWISE / 2)
        return 0.0


def parse_targets(
    text: str, *, motion: str = "swept", time_step: float = RunOptions.time_step
) -> tuple[OutcomeTarget, ...]:
    """Read ``CONTROLLER=OUTCOME, ...``.

    Args:
        text: Each outcome is a verdict, ``stuck`` (loop or stalled; for random controllers also
            timeout) or ``fails`` (anything but reached); ``reached`` and ``loop`` can be followed
            by ``@`` and steps (for a loop, its period): ``330``, ``300..400``, ``<400``, ``>400``;
            an
            ``s`` after a number means seconds.
        motion: Motion model of controllers that don't set one.
        time_step: Time step of such controllers, s.

    Raises:
        InvalidParameter: If the text isn't such a list.
    """
    parts = [part.strip() for part in text.split(",")]
    return tuple(_parse_target(part, motion, time_step) for part in parts)


def _parse_target(part: str, motion: str, time_step: float) -> OutcomeTarget:
    # Split the text into controller and outcome.
    name, equals, outcome = part.rpartition("=")
    if not equals or not name:
        raise InvalidParameter(
            "not-an-outcome",
            "outcome {outcome!r} is not CONTROLLER=OUTCOME",
            _EXAMPLE,
            outcome=part[:80],
        )
    scenario = Scenario.parse(name, motion=motion, time_step=time_step)
    CONTROLLERS.get(scenario.controller)
    outcome = _OLD_NAMES.get(outcome.strip(), outcome)
    match = _OUTCOME.fullmatch(outcome.strip())
    if match is None or match["word"] not in (*Verdict, *_GROUPS):
        known = [str(word) for word in (*_GROUPS, *Verdict)]
        raise InvalidParameter(
            "unknown-name",
            "outcome {outcome!r} of {controller} is not one of {known!l}",
            _EXAMPLE,
            outcome=outcome[:80],
            controller=name,
            known=known,
        )
    # Only an arrival and a loop can have a range.
    verdicts = _GROUPS.get(match["word"], (match["word"],))
    if match["range"] is None:
        return OutcomeTarget(scenario, outcome.strip(), verdicts)
    if match["word"] not in (Verdict.REACHED, Verdict.LOOP):
        raise InvalidParameter(
            "takes-no-steps",
            "outcome {outcome!r}: only reached and loop take steps after @",
            _EXAMPLE,
            outcome=outcome[:80],
        )
    low, high = _parse_range(match["range"].strip(), scenario.run.time_step)
    return OutcomeTarget(scenario, outcome.strip(), verdicts, low, high)


def _parse_range(text: str, time_step: float) -> tuple[float | None, float | None]:
    match = _RANGE.fullmatch(text)
    if match is None:
        raise InvalidParameter(
            "not-steps",
            "steps {steps!r} are not of a form such as 330, 300..400, <400, >400 or 4.95s",
            steps=text[:40],
        )
    bounds = {
        name: _steps(word, time_step)
        for name, word in match.groupdict().items()
        if word is not None
    }
    low = bounds.get("exact", bounds.get("low", bounds["above"] + 1 if "above" in bounds else None))
    high = bounds.get(
        "exact", bounds.get("high", bounds["below"] - 1 if "below" in bounds else None)
    )
    if (
        (low is not None and low < 1)
        or (high is not None and high < 1)
        or (low and high and low > high)
    ):
        raise InvalidParameter(
            "no-steps-left",
            "no number of steps matches {steps!r}",
            "use at least 1, with the smaller number first",
            steps=text[:40],
        )
    return low, high


def _steps(word: str, time_step: float) -> float:
    try:
        number = float(word.removesuffix("s"))
    except ValueError:
        raise InvalidParameter(
            "not-a-number", "steps {steps!r} are not a number", "write 330, or 4.95s", steps=word
        ) from None
    steps = number / time_step if word.endswith("s") else number
    if not steps <= 1e7 or abs(steps - round(steps)) > 1e-6:
        raise InvalidParameter(
            "not-a-whole-number",
            "{steps} is not a whole number of steps up to 10 million, at {time_step:g} s a step",
            steps=word,
            time_step=time_step,
        )
    return float(round(steps))
