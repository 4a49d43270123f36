"""Controllers over worlds and seeds: what each did where, who was best, and what that adds up to.

A controller with chance runs with many seeds, any other once. Its time in a world is the median
over the seeds that arrive, and it counts as arriving where at least half of them do.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from sim.controllers import CONTROLLERS, CompiledController, Controller
from sim.episode import prepare, simulate, wall_evidence
from sim.evidence import BudgetEvidence, Evidence, LoopEvidence, WallEvidence
from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.options.run import MAX_RECORDED, MAX_STEPS, RunOptions
from sim.scenario import Scenario
from sim.verdict import NEVER, UNENDED, Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.support.intervals import interval_95
from worldgen.world import World

__all__ = [
    "MAX_SEEDS",
    "PERCENTILES",
    "Cell",
    "ComparedRun",
    "Comparison",
    "NamedWorld",
    "Total",
    "compare",
    "standing",
]

MAX_SEEDS = 1_000_000
PERCENTILES = (5, 25, 50, 75, 95)
_SAME = 1e-9  # s; times are rounded to that

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class NamedWorld:
    """A world and what it is called.

    Args:
        name: In tables; no two worlds share one.
        world: The world.
        stem: Name of its file without folder and ending, by which other tables may call it.
        folder: Where its file lies.
        least_time: s that a run gets at least, where the witness's time alone gives less.
    """

    name: str
    world: World
    stem: str = ""
    folder: str = ""
    least_time: float = 0.0


@dataclass(frozen=True)
class ComparedRun:
    """One run's verdict, as :func:`sim.episode.simulate` gives it; ``time`` in s."""

    seed: int
    verdict: str
    steps: int
    time: float


@dataclass(frozen=True)
class Cell:
    """What one controller did in one world.

    Args:
        world: Name of the world.
        label: The controller as the table calls it.
        scenario: The controller and how it ran; its seed is the first.
        budget: Steps that each run had.
        random: Whether the controller has chance.
        runs: One a seed, in order of the seeds; a single one without chance.
        evidence: Of a single run; ``None`` where nothing is known beside its verdict.
    """

    world: str
    label: str
    scenario: Scenario
    budget: int
    random: bool
    runs: tuple[ComparedRun, ...]
    evidence: Evidence | None = None

    @property
    def arrivals(self) -> list[ComparedRun]:
        """The runs that arrived, earliest first."""
        return sorted(
            (run for run in self.runs if run.verdict == Verdict.REACHED),
            key=lambda run: (run.steps, run.seed),
        )

    @property
    def reached(self) -> int:
        """How many runs arrived."""
        return sum(run.verdict == Verdict.REACHED for run in self.runs)

    @property
    def arrives(self) -> bool:
        """Whether the controller counts as arriving: at least half of its runs do."""
        return 2 * self.reached >= len(self.runs)

    @property
    def time(self) -> float | None:
        """Median time of the runs that arrived, s; ``None`` if none did."""
        arrived = self.arrivals
        return round(statistics.median(run.time for run in arrived), 9) if arrived else None

    @property
    def steps(self) -> float:
        """Median steps of the runs that arrived, or, if none did, of all."""
        return statistics.median(run.steps for run in self.arrivals or self.runs)

    @property
    def rank_time(self) -> float:
        """The time to rank by, s; ``inf`` where the controller does not count as arriving."""
        return self.time if self.arrives and self.time is not None else math.inf

    @property
    def verdicts(self) -> dict[str, int]:
        """How often each verdict came up: ``reached`` first, then by kind."""
        counts = Counter(run.verdict for run in self.runs)
        return {verdict: counts[verdict] for verdict in Verdict if verdict in counts}

    @property
    def verdict(self) -> str:
        """``reached`` if the controller counts as arriving, else the most frequent other verdict."""
        if self.arrives:
            return Verdict.REACHED
        failures = {
            verdict: count for verdict, count in self.verdicts.items() if verdict != Verdict.REACHED
        }
        return max(failures, key=lambda verdict: failures[verdict])

    @property
    def never(self) -> bool:
        """Whether it drives on for ever.

        With chance, whether so few arrive that this is to be expected of a run.
        """
        if self.random:
            return 20 * self.reached <= len(self.runs) and self.verdict in UNENDED
        return self.verdict in NEVER

    @property
    def detail(self) -> str:
        """More of a single run's verdict: ``period 104``, ``drifting``, ``confined``, ``slide``.

        May be empty.
        """
        match self.evidence:
            case LoopEvidence(period=period):
                return f"period {period}"
            case BudgetEvidence(kind=kind):
                return kind or ""
            case WallEvidence(cause=cause):
                return cause or ""
        return ""

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % interval of the share of seeds that arrive; ``None`` without chance."""
        return interval_95(self.reached, len(self.runs)) if self.random else None

    @property
    def shown(self) -> ComparedRun:
        """The run to draw: the one with the median time of those that arrived, or the first."""
        arrived = self.arrivals
        return arrived[(len(arrived) - 1) // 2] if arrived else self.runs[0]

    def percentile(self, percent: int) -> float | None:
        """Time in which that many percent of the arriving runs had arrived, s.

        ``None`` if none arrived.
        """
        arrived = self.arrivals
        return (
            arrived[max(math.ceil(len(arrived) * percent / 100), 1) - 1].time if arrived else None
        )

    def share_until(self, time: float) -> float:
        """Share of all runs that arrived no later than ``time``, s."""
        return sum(
            run.verdict == Verdict.REACHED and run.time <= time + _SAME for run in self.runs
        ) / len(self.runs)

    def share_before(self, time: float) -> float:
        """Share of all runs that arrived earlier than ``time``, s."""
        return sum(
            run.verdict == Verdict.REACHED and run.time < time - _SAME for run in self.runs
        ) / len(self.runs)


@dataclass(frozen=True)
class Total:
    """A controller over all worlds.

    Args:
        label: The controller as the table calls it.
        random: Whether it has chance.
        runs: How many, all seeds counted.
        reached: How many of them arrived.
        interval: 95 % interval of that share; ``None`` without chance.
        failures: The other runs by verdict.
        wins: Worlds in which it alone was best.
        shared_wins: Worlds in which it was best together with others.
        mean_time: s, over the worlds that all controllers reach; ``None`` if there is none.
        median_time: s, likewise.
    """

    label: str
    random: bool
    runs: int
    reached: int
    interval: tuple[float, float] | None
    failures: Mapping[str, int]
    wins: int
    shared_wins: int
    mean_time: float | None
    median_time: float | None


@dataclass(frozen=True)
class Comparison:
    """The whole table.

    Args:
        labels: One a controller.
        worlds: One a row.
        cells: Rows of one cell a controller.
    """

    labels: tuple[str, ...]
    worlds: tuple[NamedWorld, ...]
    cells: tuple[tuple[Cell, ...], ...]

    @property
    def common(self) -> tuple[int, ...]:
        """Rows in which every controller arrives: only there are times compared fairly."""
        return tuple(
            row for row, cells in enumerate(self.cells) if all(cell.arrives for cell in cells)
        )

    def totals(self) -> tuple[Total, ...]:
        """One a controller."""
        best = [standing([cell.rank_time for cell in row])[0] for row in self.cells]
        return tuple(self._total(index, best) for index in range(len(self.labels)))

    def _total(self, index: int, best: Sequence[tuple[int, ...]]) -> Total:
        cells = [row[index] for row in self.cells]
        runs = sum(len(cell.runs) for cell in cells)
        reached = sum(cell.reached for cell in cells)
        failures = Counter(
            run.verdict for cell in cells for run in cell.runs if run.verdict != Verdict.REACHED
        )
        times = [cells[row].rank_time for row in self.common]
        chance = cells[0].random
        return Total(
            label=self.labels[index],
            random=chance,
            runs=runs,
            reached=reached,
            interval=interval_95(reached, runs) if chance else None,
            failures={verdict: failures[verdict] for verdict in Verdict if verdict in failures},
            wins=sum(winners == (index,) for winners in best),
            shared_wins=sum(index in winners and len(winners) > 1 for winners in best),
            mean_time=round(statistics.fmean(times), 9) if times else None,
            median_time=round(statistics.median(times), 9) if times else None,
        )


def standing(times: Sequence[float]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Who was best and who was worst, ties together.

    Args:
        times: s; ``inf`` for never.

    Returns:
        Indices of the best and of the worst; nobody is best if nobody arrives, nor worst if all are
        equal.
    """
    first = min(times)
    last = max(times)
    best = (
        tuple(index for index, time in enumerate(times) if time == first)
        if math.isfinite(first)
        else ()
    )
    worst = (
        tuple(index for index, time in enumerate(times) if time == last) if first != last else ()
    )
    return best, worst


def compare(
    worlds: Sequence[NamedWorld],
    scenarios: Mapping[str, Scenario],
    *,
    seeds: int = 100,
    steps: int | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Runs every controller in every world.

    Args:
        worlds: Rows.
        scenarios: Columns by label; the seed of each is the first that it runs with.
        seeds: How many seeds a controller with chance runs with.
        steps: Budget of each run; without it what the world's witness gives.
        progress: Told what was done.

    Raises:
        InvalidParameter: If there is nothing to compare, a name is unknown, or parts do not fit
            each other.
        InvalidWorld: If the robot cannot stand in a world, which is named.
    """
    if not worlds or not scenarios:
        raise InvalidParameter(
            "nothing-given", "nothing to compare", "give at least one world and one controller"
        )
    if not 1 <= seeds <= MAX_SEEDS:
        raise InvalidParameter(
            "out-of-range", "seeds={seeds} is outside 1 to {most}", seeds=seeds, most=MAX_SEEDS
        )
    columns = [
        _Column(label, scenario, CONTROLLERS.get(scenario.controller))
        for label, scenario in scenarios.items()
    ]
    for column in columns:
        RunOptions(
            motion=MOTIONS.get(column.scenario.motion).name, time_step=column.scenario.time_step
        )
        if column.scenario.seed + seeds > 2**64:
            raise InvalidParameter(
                "seeds-run-out",
                "seed={seed} leaves no {seeds} seeds below 2**64",
                "begin lower",
                seed=column.scenario.seed,
                seeds=seeds,
            )
    done = [column.cells(worlds, seeds, steps, progress) for column in columns]
    return Comparison(tuple(scenarios), tuple(worlds), tuple(zip(*done, strict=True)))


@dataclass(frozen=True)
class _Look:
    """One run, and what may be told of it."""

    run: ComparedRun
    evidence: Evidence | None
    draws: int


@dataclass(frozen=True)
class _Column:
    label: str
    scenario: Scenario
    controller: Controller

    @property
    def declared_random(self) -> bool:
        """Whether the controller, or the simulator under it, says that it has chance."""
        chance = isinstance(self.controller, CompiledController) and self.controller.randomised
        return chance or self.scenario.random

    def cells(
        self, worlds: Sequence[NamedWorld], seeds: int, steps: int | None, progress: Progress | None
    ) -> list[Cell]:
        """One cell a world.

        A Python controller has chance if it says ``used_random`` in any world with the first seed.
        Until it first does, its run is the same for every seed; so a run without draws stands for
        all seeds.
        """
        options = [self._options(world, steps) for world in worlds]
        looks = [] if self.declared_random else list(map(self._look, worlds, options))
        random = self.declared_random or any(look.draws for look in looks)
        cells = []
        for row, world in enumerate(worlds):
            first = looks[row] if looks else self._look(world, options[row])
            runs = self._over_seeds(world, options[row], first, seeds) if random else (first.run,)
            evidence = None if random else first.evidence
            cells.append(
                Cell(
                    world.name,
                    self.label,
                    self.scenario,
                    options[row].steps,
                    random,
                    runs,
                    evidence,
                )
            )
            if progress is not None:
                progress(f"{self.label}: {row + 1} of {len(worlds)} worlds")
        return cells

    def _options(self, world: NamedWorld, steps: int | None) -> RunOptions:
        options = self.scenario.options(world.world, steps)
        least = math.ceil(world.least_time / options.time_step)
        return (
            options
            if steps is not None
            else replace(options, steps=min(max(options.steps, least), MAX_STEPS))
        )

    def _over_seeds(
        self, world: NamedWorld, options: RunOptions, first: _Look, seeds: int
    ) -> tuple[ComparedRun, ...]:
        own = range(options.seed + 1, options.seed + seeds)
        if not first.draws and not self.scenario.random:
            return (first.run, *(replace(first.run, seed=seed) for seed in own))
        return (first.run, *(self._look(world, replace(options, seed=seed)).run for seed in own))

    def _look(self, world: NamedWorld, options: RunOptions) -> _Look:
        try:
            return self._unnamed_look(world.world, options)
        except InvalidWorld as error:
            raise InvalidWorld.of(
                error.message.behind("world {world}: ", world=world.name)
            ) from error
        except InvalidParameter as error:
            place = error.message.behind(
                "world {world}, {column}: ", world=world.name, column=self.label
            )
            raise InvalidParameter.of(place) from error

    def _unnamed_look(self, world: World, options: RunOptions) -> _Look:
        """A run without recording; only what needs proof or explanation is simulated in full."""
        outcome = prepare(world, self.controller, options).run(
            options.steps, find_loop=True, record=False, digest=False
        )
        verdict = outcome.verdict
        explained = not self.declared_random and MOTIONS.get(options.motion).kernel == THESIS
        if outcome.steps > MAX_RECORDED // 2:
            verdict = (
                Verdict.STALLED if verdict == Verdict.LOOP else verdict
            )  # too long a run to prove or to explain
        elif outcome.ending == Verdict.LOOP or (verdict == Verdict.STALLED and explained):
            episode = simulate(world, self.controller, options)
            run = ComparedRun(options.seed, episode.verdict, episode.steps, episode.time)
            return _Look(run, episode.evidence, outcome.random_draws)
        time = round(outcome.steps * options.time_step, 9)
        evidence = wall_evidence(outcome) if outcome.cause else None
        return _Look(
            ComparedRun(options.seed, verdict, outcome.steps, time), evidence, outcome.random_draws
        )
