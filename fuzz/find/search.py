"""The search: sample many layouts, climb from the best by small edits, prove what is kept. Prints nothing."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any

from fuzz.features import LAYOUT_BYTES, decode_world
from fuzz.find.layout import Layout
from fuzz.find.wishes import Result, Wish
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.family import FAMILIES, stream_for
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.world import Certificate, Pose, Provenance, Value, World

__all__ = ["VERSION", "Find", "FindConfig", "Found", "find_unit"]

VERSION = 1  # goes up whenever equal seeds find another world than before

_SAMPLES = 200  # layouts drawn in a unit before it climbs
_CLIMBS = 1500  # edits tried in a unit
_MEMORY = 40  # steps back that an edit may be compared with, instead of with the last
_WAITING = 1  # units that wait for a worker, so that none is idle


@dataclass(frozen=True)
class FindConfig:
    """What is looked for, and where.

    Args:
        wishes: An outcome for each of some controllers.
        seed: Of all chance.
        families: Families to draw from; none stands for feature layouts.
        params: Parameters of the family that are fixed.
        begin: A world to begin from, instead.
        start: A start pose that every world gets.
        mirror: Whether worlds are symmetric about the diagonal through the upper left.
        fixed_target: Whether edits leave the target where it is.
        leash: Cells that edits may move a wall's side, or the target, from where they were; -1 for any.
        edit: Whether sampled worlds are edited at all.
    """

    wishes: tuple[Wish, ...]
    seed: int = 0
    families: tuple[str, ...] = ()
    params: tuple[tuple[str, Value], ...] = ()
    begin: World | None = None
    start: Pose | None = None
    mirror: bool = False
    fixed_target: bool = False
    leash: int = -1
    edit: bool = True


@dataclass(frozen=True)
class Found:
    """A world and how near it comes.

    Args:
        world: With a witness, and how it was made.
        results: One for each wish.
        unit: Number of the unit that found it.
    """

    world: World
    results: tuple[Result, ...]
    unit: int

    @property
    def distance(self) -> float:
        """Sum over the wishes; 0 if all are fulfilled."""
        return sum(result.distance for result in self.results)

    def rank(self) -> tuple[float, int]:
        """The smaller the better: near first, then few solid cells."""
        return self.distance, self.world.solid_cells


@dataclass(frozen=True)
class _Candidate:
    layout: Layout
    world: World
    distance: float
    provenance: Provenance | None = None


class _Unit:
    """One unit's work: counts its runs, keeps its best proved candidate."""

    def __init__(self, config: FindConfig, number: int) -> None:
        self.config, self.number = config, number
        self.rng = RandomStream(config.seed).child("find", number)
        self.tried = 0
        self.best: _Candidate | None = None
        self._certificate: Certificate | None = None

    def distance(self, world: World, most: float) -> float:
        """Sum of the wishes' distances; more than ``most`` as soon as that is certain."""
        self.tried += 1
        total = 0.0
        for wish in self.config.wishes:
            try:
                total += wish.look(world).distance
            except InvalidWorld:
                return float("inf")
            if total > most:
                return total
        return total

    def keep(self, candidate: _Candidate) -> None:
        """Keeps a candidate that is nearer than the best, or simpler, if its target can be reached."""
        best = self.best
        if best is not None and (candidate.distance, candidate.world.solid_cells) >= (
            best.distance, best.world.solid_cells,
        ):  # fmt: skip
            return
        decision = decide(candidate.world)
        if decision.result == REACHABLE:
            self.best, self._certificate = candidate, decision.certificate

    def run(self) -> Found | None:
        """Samples, climbs, simplifies."""
        config = self.config
        for _ in range(_SAMPLES if config.begin is None else 1):
            sampled = _sample(config, self.rng)
            if sampled is not None:
                limit = self.best.distance if self.best else float("inf")
                self.keep(replace(sampled, distance=self.distance(sampled.world, limit)))
            if self.best is not None and self.best.distance == 0.0:
                break
        if self.best is not None and config.edit:
            self._climb(self.best)
            self._simplify()
        return self._found()

    def _climb(self, first: _Candidate) -> None:
        """Late acceptance: an edit is taken if it is no worse than what was held some steps ago.

        Source: Edmund Burke and Yuri Bykov, "The late acceptance hill-climbing heuristic", EJOR 2017.
        """
        held, past = first, [first.distance] * _MEMORY
        for step in range(_CLIMBS):
            layout = held.layout.edited(self.rng)
            for _ in range(self.rng.below(2)):
                layout = layout.edited(self.rng) if layout is not None else None
            if layout is None or layout == held.layout:
                continue
            bar = max(past[step % _MEMORY], held.distance)
            world = layout.world()
            distance = self.distance(world, bar)
            if distance <= bar:
                held = _Candidate(layout, world, distance)
                self.keep(held)
                if self.best is not None and self.best.distance == 0.0:
                    return
            past[step % _MEMORY] = held.distance

    def _simplify(self) -> None:
        """Takes away what the outcome does not need."""
        again = self.best is not None and self.best.distance == 0.0
        while again and self.best is not None:
            again = False
            for layout in self.best.layout.simpler():
                world = layout.world()
                if world.solid_cells < self.best.world.solid_cells and self.distance(world, 0.0) == 0.0:
                    before = self.best
                    self.keep(_Candidate(layout, world, 0.0))
                    again = self.best is not before
                    if again:
                        break

    def _found(self) -> Found | None:
        if self.best is None:
            return None
        results = tuple(wish.look(self.best.world) for wish in self.config.wishes)
        provenance = self.best.provenance or self._provenance()
        world = replace(self.best.world, certificate=self._certificate, provenance=provenance, failure=None)
        return Found(world, results, self.number)

    def _provenance(self) -> Provenance:
        config = self.config
        params: dict[str, Value] = {
            "outcome": ", ".join(f"{wish.scenario.label('', 0.0)}={wish.text}" for wish in config.wishes),
            "unit": self.number,
        }
        if config.families:
            params["families"] = list(config.families)
            params |= dict(config.params)
        if config.begin is not None and config.begin.provenance is not None:
            params["from"] = config.begin.provenance.family
        return Provenance("find", VERSION, config.seed, params)


def find_unit(config: FindConfig, number: int) -> tuple[Found | None, int]:
    """Does one unit, a pure function of its arguments: the best world it found, and how many it tried."""
    unit = _Unit(config, number)
    return unit.run(), unit.tried


def _sample(config: FindConfig, rng: RandomStream) -> _Candidate | None:
    """A layout to look at; its provenance is that of a family as long as nothing was changed."""
    provenance = None
    try:
        if config.begin is not None:
            world = config.begin
        elif config.families:
            world, provenance = _of_family(rng.choice(config.families), dict(config.params), rng)
        else:
            world = decode_world(bytes(rng.below(256) for _ in range(LAYOUT_BYTES)))
        if config.start is not None:
            world, provenance = replace(world, start=config.start), None
        layout = Layout.of(world, mirror=config.mirror, fixed_target=config.fixed_target, leash=config.leash)
    except (InvalidWorld, InvalidParameter):
        return None
    if config.mirror:
        world, provenance = layout.world(), None
    elif world.timeline:
        return _Candidate(layout, world, 0.0, provenance)
    if config.begin is not None:
        provenance = None
    return _Candidate(layout, world, 0.0, provenance)


def _of_family(name: str, fixed: dict[str, Value], rng: RandomStream) -> tuple[World, Provenance]:
    """A world of a family as ``worldgen FAMILY --seed`` makes it, not proved yet."""
    family = FAMILIES.get(name)
    params: dict[str, Value] = {
        parameter.name: rng.choice(parameter.choices) for parameter in family.parameters if parameter.choices
    }
    complete = family.complete(params | fixed)
    seed = rng.next64() >> 1
    return family.build(stream_for(seed, family.name, 0), **complete), Provenance(name, family.version, seed, complete)


class Find:
    """A search over units.

    Args:
        config: What is looked for.
        units: Amount of work; the result then depends on the seed alone.
        seconds: Stop handing out work after this time; ignored if ``units`` is given.
        workers: Processes; 1 works in this one.

    Iterating over :meth:`run` does the work and yields each better world; ``best`` keeps the last of them.
    """

    def __init__(
        self, config: FindConfig, *, units: int | None = None, seconds: float | None = None, workers: int = 1
    ) -> None:
        self.config, self.units, self.seconds, self.workers = config, units, seconds, workers
        self.best: Found | None = None
        self.done = 0
        self.tried = 0

    def run(self) -> Iterator[Found]:
        """Searches until a world has every outcome exactly, or the budget is spent."""
        started = time.monotonic()
        results = self._serially(started) if self.workers == 1 else self._in_parallel(started)
        for found, tried in results:
            self.done += 1
            self.tried += tried
            if found is not None and (self.best is None or found.rank() < self.best.rank()):
                self.best = found
                yield found
            if self.best is not None and self.best.distance == 0.0:
                return

    def _enough(self, unit: int, started: float) -> bool:
        if self.units is not None:
            return unit >= self.units
        return self.seconds is not None and time.monotonic() - started >= self.seconds

    def _serially(self, started: float) -> Iterator[tuple[Found | None, int]]:
        unit = 0
        while not self._enough(unit, started):
            yield find_unit(self.config, unit)
            unit += 1

    def _in_parallel(self, started: float) -> Iterator[tuple[Found | None, int]]:
        """Results in order of unit numbers, so that they do not depend on the workers."""
        pool = ProcessPoolExecutor(self.workers, mp_context=get_context("spawn"), initializer=_worker_start)
        waiting: list[Future[Any]] = []
        unit = 0
        try:
            while True:
                while len(waiting) < self.workers + _WAITING and not self._enough(unit, started):
                    waiting.append(pool.submit(find_unit, self.config, unit))
                    unit += 1
                if not waiting:
                    return
                yield waiting.pop(0).result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _worker_start() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the driver decides when a search ends
