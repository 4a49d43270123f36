"""Compare controllers over worlds and seeds: what each did, which was best, and the totals.

A random controller runs with many seeds, any other once. Its time in a world is the median over the
seeds with which it arrives, and it counts as arriving if at least half of them do.

In a world of several robots, a controller drives all of them. It arrives if every robot does, its
time is the last robot's, and its area is the sum over the robots.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from sim.controllers.base import Controller
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.noise import is_noisy, is_random
from sim.episode import Episode, area_of, prepare, simulate, wall_evidence
from sim.evidence import BudgetEvidence, Evidence, JointLoopEvidence, LoopEvidence, WallEvidence
from sim.fleet.episode import simulate_fleet
from sim.motion import MOTIONS
from sim.options.run import MAX_RECORDED, RunOptions
from sim.scenario import Scenario
from sim.verdict import ARRIVALS, UNENDED, Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.parameters.bounds import check_between
from worldgen.support.intervals import interval_95
from worldgen.world import Cut, World

MAX_SEEDS = 1_000_000
PERCENTILES = (5, 25, 50, 75, 95)
# Seconds. Times are rounded to this, so smaller differences are meaningless.
_SAME = 1e-9

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class NamedWorld:
    """A world and its name.

    Args:
        name: Name in tables, unique among the worlds.
        world: The world.
    """

    name: str
    world: World


@dataclass(frozen=True)
class ComparedRun:
    """One run's result, as :func:`sim.episode.simulate` reports it; ``time`` in s, area in m2."""

    seed: int
    verdict: str
    steps: int
    time: float
    area_covered: float


@dataclass(frozen=True)
class ComparisonCell:
    """The results of one controller in one world.

    Args:
        world: Name of the world.
        label: Name of the controller in the table.
        scenario: The controller and how it ran; its seed is the first one used.
        budget: Budget of each run, steps.
        random: Whether the controller is random.
        runs: One run per seed, in order; a single run if the controller is not random.
        evidence: Evidence of a single run; ``None`` if only its verdict is known.
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
        """The runs that arrived, fastest first."""
        return sorted(
            (run for run in self.runs if run.verdict in ARRIVALS),
            key=lambda run: (run.steps, run.seed),
        )

    @property
    def reached(self) -> int:
        """Number of runs that arrived."""
        return sum(run.verdict in ARRIVALS for run in self.runs)

    @property
    def arrives(self) -> bool:
        """True if the controller counts as arriving: at least half of its runs do."""
        return 2 * self.reached >= len(self.runs)

    @property
    def time(self) -> float | None:
        """Median time of the runs that arrived, s; ``None`` if none did."""
        arrived = self.arrivals
        return round(statistics.median(run.time for run in arrived), 9) if arrived else None

    @property
    def steps(self) -> float:
        """Median steps of the runs that arrived, or of all runs if none did."""
        return statistics.median(run.steps for run in self.arrivals or self.runs)

    @property
    def area_covered(self) -> float:
        """Median area of the cells that the centre was in, m2, over all runs."""
        return statistics.median(run.area_covered for run in self.runs)

    @property
    def rank_time(self) -> float:
        """Time to rank by, s; ``inf`` if the controller does not count as arriving."""
        return self.time if self.arrives and self.time is not None else math.inf

    @property
    def verdicts(self) -> dict[str, int]:
        """The number of runs with each verdict, in the order of :class:`sim.verdict.Verdict`."""
        counts = Counter(run.verdict for run in self.runs)
        return {verdict: counts[verdict] for verdict in Verdict if verdict in counts}

    @property
    def verdict(self) -> str:
        """``reached`` or ``covered`` if this counts as arriving, otherwise the main failure."""
        if self.arrives:
            return self.arrivals[0].verdict if self.arrivals else Verdict.REACHED
        failures = {
            verdict: count for verdict, count in self.verdicts.items() if verdict not in ARRIVALS
        }
        return max(failures, key=lambda verdict: failures[verdict])

    @property
    def is_unended(self) -> bool:
        """True if the run did not arrive, and nothing ended it but its budget or a proof.

        A random controller counts if at most 5 % of its runs arrive, and most others do not end.
        """
        if self.random:
            return 20 * self.reached <= len(self.runs) and self.verdict in UNENDED
        return self.verdict in UNENDED

    @property
    def detail(self) -> str:
        """Detail of a single run's verdict, as ``period 104`` or ``1 of 3 arrive``, or empty."""
        match self.evidence:
            case JointLoopEvidence(waiting=waiting, parked=parked):
                return f"{len(parked)} of {len(waiting) + len(parked)} arrive"
            case LoopEvidence(period=period):
                return f"period {period}"
            case BudgetEvidence(kind=kind):
                return kind or ""
            case WallEvidence(cause=cause):
                return cause or ""
        return ""

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % interval of the fraction of seeds that arrive; ``None`` if not random."""
        return interval_95(self.reached, len(self.runs)) if self.random else None

    @property
    def shown(self) -> ComparedRun:
        """The run to draw: the one with the median time among arrivals, or the first."""
        arrived = self.arrivals
        return arrived[(len(arrived) - 1) // 2] if arrived else self.runs[0]

    def percentile(self, percent: int) -> float | None:
        """Return the time by which that percentage of the arriving runs had arrived, s.

        ``None`` if none arrived.
        """
        arrived = self.arrivals
        place = max(math.ceil(len(arrived) * percent / 100), 1)
        return arrived[place - 1].time if arrived else None


@dataclass(frozen=True)
class Total:
    """A controller's totals over the worlds that are not proved to be blocked.

    Args:
        label: Name of the controller in the table.
        random: Whether it is random.
        runs: Number of runs, over all seeds.
        reached: Number of runs that arrived.
        interval: 95 % interval of that fraction; ``None`` if not random.
        failures: Number of the other runs, by verdict.
        wins: Worlds in which it alone was best.
        shared_wins: Worlds in which it tied for best.
        mean_time: Mean time over the worlds that all controllers reach, s; ``None`` if there are
        none.
        median_time: Median time over the same worlds, s.
        mean_area: Mean area of the cells that its centre was in, m2, over all runs.
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
    mean_area: float


@dataclass(frozen=True)
class Comparison:
    """The whole table.

    Args:
        labels: Names of the controllers, one per column.
        worlds: The worlds, one per row.
        cells: Rows of cells, one cell per controller.
    """

    labels: tuple[str, ...]
    worlds: tuple[NamedWorld, ...]
    cells: tuple[tuple[ComparisonCell, ...], ...]

    @property
    def blocked(self) -> tuple[int, ...]:
        """Rows whose world has a cut: a robot that does not arrive there has not failed."""
        return tuple(
            row for row, named in enumerate(self.worlds) if isinstance(named.world.certificate, Cut)
        )

    @property
    def common(self) -> tuple[int, ...]:
        """Rows in which every controller arrives; only there can times be compared fairly."""
        return tuple(
            row
            for row, cells in enumerate(self.cells)
            if row not in self.blocked and all(cell.arrives for cell in cells)
        )

    def totals(self) -> tuple[Total, ...]:
        """Return the totals of each controller."""
        best = [standing([cell.rank_time for cell in row])[0] for row in self.cells]
        return tuple(self._total(index, best) for index in range(len(self.labels)))

    def _total(self, index: int, best: Sequence[tuple[int, ...]]) -> Total:
        blocked = self.blocked
        cells = [row[index] for k, row in enumerate(self.cells) if k not in blocked]
        runs = sum(len(cell.runs) for cell in cells)
        reached = sum(cell.reached for cell in cells)
        failures = Counter(
            run.verdict for cell in cells for run in cell.runs if run.verdict not in ARRIVALS
        )
        times = [self.cells[row][index].rank_time for row in self.common]
        ranked = [winners for row, winners in enumerate(best) if row not in blocked]
        areas = [run.area_covered for cell in cells for run in cell.runs]
        chance = self.cells[0][index].random
        return Total(
            label=self.labels[index],
            random=chance,
            runs=runs,
            reached=reached,
            interval=interval_95(reached, runs) if chance and runs else None,
            failures={verdict: failures[verdict] for verdict in Verdict if verdict in failures},
            wins=sum(winners == (index,) for winners in ranked),
            shared_wins=sum(index in winners and len(winners) > 1 for winners in ranked),
            mean_time=round(statistics.fmean(times), 9) if times else None,
            median_time=round(statistics.median(times), 9) if times else None,
            mean_area=round(statistics.fmean(areas), 9) if areas else 0.0,
        )


def standing(times: Sequence[float]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return which controllers were best and which were worst, including ties.

    Args:
        times: Times, s; ``inf`` for never.

    Returns:
        Indices of the best and of the worst. The first is empty if none arrives, the second if all
        times are equal.
    """
    first = min(times)
    last = max(times)
    best = tuple(index for index, time in enumerate(times) if time == first < math.inf)
    worst = tuple(index for index, time in enumerate(times) if time == last != first)
    return best, worst


def compare(
    worlds: Sequence[NamedWorld],
    scenarios: Mapping[str, Scenario],
    *,
    seeds: int = 100,
    steps: int | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Run every controller in every world.

    Args:
        worlds: The rows.
        scenarios: The columns by label; the seed of each is the first that it runs with.
        seeds: Number of seeds that a random controller runs with.
        steps: Budget of each run; if omitted, it follows from each world's witness.
        progress: Called with a short text after each cell.

    Raises:
        InvalidParameter: If there is nothing to compare, a name is unknown, or parts do not fit
            each other.
        InvalidWorld: If the robot does not fit into a world; the error names it.
    """
    if not worlds or not scenarios:
        raise InvalidParameter(
            "nothing-given", "nothing to compare", "use at least one world and one controller"
        )
    check_between("seeds", seeds, 1, MAX_SEEDS)
    columns = [
        _Column(label, scenario, CONTROLLERS.get(scenario.controller))
        for label, scenario in scenarios.items()
    ]

    # Check every scenario before the first run.
    for column in columns:
        MOTIONS.get(column.scenario.run.motion)
        if column.scenario.run.seed + seeds > 2**64:
            raise InvalidParameter(
                "seeds-run-out",
                "seed={seed} does not leave {seeds} seeds below 2**64",
                "begin lower",
                seed=column.scenario.run.seed,
                seeds=seeds,
            )
    done = [column.cells(worlds, seeds, steps, progress) for column in columns]
    return Comparison(tuple(scenarios), tuple(worlds), tuple(zip(*done, strict=True)))


@dataclass(frozen=True)
class _TriedRun:
    """One run, and the facts known about it."""

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
        """True if the controller, or the simulator under it, declares that it is random."""
        return is_random(self.controller, self.scenario.run)

    def cells(
        self, worlds: Sequence[NamedWorld], seeds: int, steps: int | None, progress: Progress | None
    ) -> list[ComparisonCell]:
        """Return one cell per world.

        A Python controller is random if it reports ``used_random`` in any world with the first
        seed. Until it first does, its run is the same for every seed, so a run without draws stands
        for all seeds.
        """
        # Without a declaration, all worlds must be tried before it is known if seeds matter.
        options = [self.scenario.options(world.world, steps) for world in worlds]
        trials = [] if self.declared_random else list(map(self._try, worlds, options))
        random = self.declared_random or any(trial.draws for trial in trials)
        cells = []
        for row, world in enumerate(worlds):
            first = trials[row] if trials else self._try(world, options[row])
            runs = self._over_seeds(world, options[row], first, seeds) if random else (first.run,)
            evidence = None if random else first.evidence
            budget = options[row].steps
            cells.append(
                ComparisonCell(
                    world.name, self.label, self.scenario, budget, random, runs, evidence
                )
            )
            if progress is not None:
                progress(f"{self.label}: {row + 1} of {len(worlds)} worlds")
        return cells

    def _over_seeds(
        self, world: NamedWorld, options: RunOptions, first: _TriedRun, seeds: int
    ) -> tuple[ComparedRun, ...]:
        # The first run drew no random numbers, so it is the same with every other seed.
        own = range(options.seed + 1, options.seed + seeds)
        if not first.draws and not is_noisy(self.controller, self.scenario.run):
            return (first.run, *(replace(first.run, seed=seed) for seed in own))
        return (first.run, *(self._try(world, replace(options, seed=seed)).run for seed in own))

    def _try(self, world: NamedWorld, options: RunOptions) -> _TriedRun:
        try:
            return self._try_unnamed(world.world, options)
        except InvalidWorld as error:
            raise InvalidWorld.of(
                error.message.behind("world {world}: ", world=world.name)
            ) from error
        except InvalidParameter as error:
            place = error.message.behind(
                "world {world}, {column}: ", world=world.name, column=self.label
            )
            raise InvalidParameter.of(place) from error

    def _try_unnamed(self, world: World, options: RunOptions) -> _TriedRun:
        """Run without recording; simulate in full only runs that need a proof or an explanation."""
        if world.is_fleet:
            fleet = simulate_fleet(world, self.controller, options)
            return _TriedRun(_compared(options, fleet), fleet.evidence, fleet.random_draws)
        outcome = prepare(world, self.controller, options).run(
            options.steps, find_loop=True, record=False, digest=False
        )
        verdict = outcome.verdict
        explained = not self.declared_random and not MOTIONS.get(options.motion).on_lattice
        if outcome.steps > MAX_RECORDED // 2:
            # The run is too long to prove a loop or to explain a stall.
            verdict = Verdict.STALLED if verdict == Verdict.LOOP else verdict
        elif outcome.ending == Verdict.LOOP or (verdict == Verdict.STALLED and explained):
            episode = simulate(world, self.controller, options)
            return _TriedRun(_compared(options, episode), episode.evidence, outcome.random_draws)
        time = round(outcome.steps * options.time_step, 9)
        area = area_of(outcome.cells_visited, world)
        evidence = wall_evidence(outcome) if outcome.cause else None
        run = ComparedRun(options.seed, verdict, outcome.steps, time, area)
        return _TriedRun(run, evidence, outcome.random_draws)


def _compared(options: RunOptions, episode: Episode) -> ComparedRun:
    """Return the part of a run that the table keeps."""
    return ComparedRun(
        options.seed, episode.verdict, episode.steps, episode.time, episode.area_covered
    )
