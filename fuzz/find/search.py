"""Search: sample many layouts, climb from the best by small edits, and prove the kept results.

It prints nothing.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from functools import partial

from fuzz.campaign.executors import local_executor
from fuzz.campaign.schedule import Schedule
from fuzz.campaign.scheduler import Goal, Scheduler, Work
from fuzz.find.layout import Layout
from fuzz.find.targets import OutcomeTarget, Result
from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.unit.deadline import Deadline
from sim.clock.stopping import OutOfTime, stopping_when
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.family import FAMILIES, stream_for
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.world import Certificate, Pose, Provenance, Value, World

# Raise this whenever equal seeds find a different world than before.
VERSION = 1

# Layouts drawn in a unit before it climbs.
_SAMPLES = 200
# Edits tried in a unit.
_CLIMBS = 1500
# Number of earlier steps that an edit may be compared with, instead of with the last one.
_MEMORY = 40


@dataclass(frozen=True)
class FindConfig:
    """The goal of a search, and its space.

    Args:
        targets: An outcome for each of some controllers.
        seed: Seed of the search.
        families: Families to draw from; none means feature layouts.
        params: Fixed parameters of the family.
        begin: A world to start from instead.
        start: Start pose of every world.
        fixed_target: True if edits leave the target in place.
        leash: Cells that edits may move a wall's side, or the target, from its place;
            ``None`` for any.
        edit: True to edit sampled worlds.
    """

    targets: tuple[OutcomeTarget, ...]
    seed: int = 0
    families: tuple[str, ...] = ()
    params: tuple[tuple[str, Value], ...] = ()
    begin: World | None = None
    start: Pose | None = None
    fixed_target: bool = False
    leash: int | None = None
    edit: bool = True


@dataclass(frozen=True)
class NearestWorld:
    """A world and how close it comes.

    Args:
        world: The world, with a witness and its provenance.
        results: One result for each target.
        unit: Number of the unit that found it.
    """

    world: World
    results: tuple[Result, ...]
    unit: int

    @property
    def distance(self) -> float:
        """Sum over the targets; 0 if all are fulfilled."""
        return _distance(self.results)


def _distance(results: tuple[Result, ...]) -> float:
    return sum(result.distance for result in results)


@dataclass(frozen=True)
class _UnitResult:
    """The result of a unit.

    Args:
        nearest: Its best world, if any was proved.
        tried: Worlds tried.
        ended: Runs that ended.
        interrupted: True if Ctrl-C interrupted the unit; the search must then end.
    """

    nearest: NearestWorld | None
    tried: int
    ended: int
    interrupted: bool = False


@dataclass(frozen=True)
class _Candidate:
    layout: Layout
    world: World
    distance: float = 0.0
    provenance: Provenance | None = None
    results: tuple[Result, ...] = ()
    certificate: Certificate | None = None


def _rank(one: NearestWorld | _Candidate) -> tuple[float, int]:
    """Return a sort key: nearest first, then fewest solid cells."""
    return one.distance, one.world.solid_cells


def _never() -> bool:
    return False


class _Unit:
    """One unit's work: counts the worlds that it tries, and keeps its best proved candidate.

    Args:
        config: The goal.
        number: Number of the unit, which together with the seed determines all randomness.
        stopped: Called before each world; once it returns True, the unit ends with the worlds made
            so far, at least one.
    """

    def __init__(
        self, config: FindConfig, number: int, stopped: Callable[[], bool] = _never
    ) -> None:
        self.config = config
        self.number = number
        self._stopped = stopped
        self.rng = RandomStream(config.seed).child("find", number)
        self.tried = 0
        self.ended = 0
        self.best: _Candidate | None = None
        self._cheap_first = sorted(config.targets, key=lambda target: target.cost)

    def distance(self, world: World, most: float) -> float:
        """Return the sum of the distances to the targets; or, once certain, more than ``most``."""
        self.tried += 1
        total = 0.0
        for target in self._cheap_first:
            try:
                total += target.look(world).distance
                self.ended += 1
            except InvalidWorld:
                return float("inf")
            if total > most:
                return total
        return total

    def keep(self, candidate: _Candidate) -> None:
        """Keep a candidate that is nearer than the best, or simpler, if its proofs succeed."""
        if self.best is not None and _rank(candidate) >= _rank(self.best):
            return
        decision = decide(candidate.world)
        if decision.result != REACHABLE:
            return
        results = tuple(target.look(candidate.world, prove=True) for target in self.config.targets)
        proved = replace(
            candidate,
            distance=_distance(results),
            results=results,
            certificate=decision.certificate,
        )
        if self.best is None or _rank(proved) < _rank(self.best):
            self.best = proved

    @property
    def _done(self) -> bool:
        return self.best is not None and (self.best.distance == 0.0 or self._stopped())

    def run(self) -> _UnitResult:
        """Sample, climb and simplify.

        A slow controller's run in progress is abandoned when time is up, as is a run that Ctrl-C
        interrupts because it did not end in time; the best result so far is kept.
        """
        interrupted = False
        try:
            with contextlib.suppress(OutOfTime), stopping_when(self._stopped):
                self._search()
        except KeyboardInterrupt:
            interrupted = True
        return _UnitResult(self.found(), self.tried, self.ended, interrupted)

    def _search(self) -> None:
        config = self.config
        # Sample, and keep the best.
        for _ in range(_SAMPLES if config.begin is None else 1):
            sampled = _sample(config, self.rng)
            if sampled is not None:
                limit = self.best.distance if self.best else float("inf")
                self.keep(replace(sampled, distance=self.distance(sampled.world, limit)))
            if self._done:
                break
        # Improve it by edits.
        if self.best is not None and config.edit:
            self._climb(self.best)
            self._simplify()

    def _climb(self, first: _Candidate) -> None:
        """Climb by late acceptance: take an edit if it is no worse than the layout some steps ago.

        Source: Edmund Burke and Yuri Bykov, "The late acceptance hill-climbing heuristic", EJOR
            2017.
        """
        held = first
        past = [first.distance] * _MEMORY
        # Edit the layout once or twice.
        for step in range(_CLIMBS):
            if self._done:
                return
            layout = held.layout.edited(self.rng)
            for _ in range(self.rng.below(2)):
                layout = layout.edited(self.rng) if layout is not None else None
            if layout is None or layout == held.layout:
                continue
            # Compare it with the layout some steps ago.
            bar = max(past[step % _MEMORY], held.distance)
            world = layout.world()
            distance = self.distance(world, bar)
            if distance <= bar:
                held = _Candidate(layout, world, distance)
                self.keep(held)
            past[step % _MEMORY] = held.distance

    def _simplify(self) -> None:
        """Remove everything that the outcome does not need."""
        before = None
        # Take any simpler layout that has the outcome, and start over from it.
        while self.best is not None and self.best.distance == 0.0 and self.best is not before:
            before = self.best
            for layout in before.layout.simpler():
                if self._stopped():
                    return
                world = layout.world()
                if (
                    world.solid_cells < before.world.solid_cells
                    and self.distance(world, 0.0) == 0.0
                ):
                    self.keep(_Candidate(layout, world))
                    if self.best is not before:
                        break

    def found(self) -> NearestWorld | None:
        """Return the best result so far."""
        best = self.best
        if best is None:
            return None
        provenance = best.provenance or self._provenance()
        world = replace(
            best.world, certificate=best.certificate, provenance=provenance, failure=None
        )
        return NearestWorld(world, best.results, self.number)

    def _provenance(self) -> Provenance:
        config = self.config
        params: dict[str, Value] = {
            "outcome": ", ".join(
                f"{target.scenario.label('', 0.0)}={target.text}" for target in config.targets
            ),
            "unit": self.number,
        }
        if config.families:
            params["families"] = list(config.families)
            params |= dict(config.params)
        if config.begin is not None and config.begin.provenance is not None:
            params["from"] = config.begin.provenance.family
        return Provenance("find", VERSION, config.seed, params)


def _sample(config: FindConfig, rng: RandomStream) -> _Candidate | None:
    """Return a layout to try, or ``None`` if the draw fails."""
    try:
        return _drawn(config, rng)
    except (InvalidWorld, InvalidParameter):
        return None


def draw(config: FindConfig) -> World:
    """Return a world that the search might try first.

    Raises:
        InvalidWorld, InvalidParameter: If all draws of a unit fail; it is the last draw's error.
    """
    rng = RandomStream(config.seed).child("draw", 0)
    for _ in range(_SAMPLES - 1):
        sampled = _sample(config, rng)
        if sampled is not None:
            return sampled.world
    return _drawn(config, rng).world


def _drawn(config: FindConfig, rng: RandomStream) -> _Candidate:
    """Return a layout to try; it keeps the family's provenance unless it was changed."""
    # Take the given world, a family's or a layout's.
    provenance = None
    if config.begin is not None:
        world = config.begin
    elif config.families:
        world, provenance = _of_family(rng.choice(config.families), dict(config.params), rng)
    else:
        world = decode_world(bytes(rng.below(256) for _ in range(LAYOUT_BYTES)))
    # A changed world no longer comes from the family.
    if config.start is not None:
        world = replace(world, start=config.start)
        provenance = None
    layout = Layout.of(world, fixed_target=config.fixed_target, leash=config.leash)
    return _Candidate(layout, world, provenance=provenance)


def _of_family(name: str, fixed: dict[str, Value], rng: RandomStream) -> tuple[World, Provenance]:
    """Return a world of a family as ``worldgen FAMILY --seed`` makes it, without a proof."""
    family = FAMILIES.get(name)
    own = {parameter.name for parameter in family.parameters}
    params: dict[str, Value] = {
        parameter.name: rng.choice(parameter.choices)
        for parameter in family.parameters
        if parameter.choices
    }
    complete = family.complete(
        params | {name: value for name, value in fixed.items() if name in own}
    )
    seed = rng.next64() >> 1
    world = family.build(stream_for(seed, family.name, 0), **complete)
    return world, family.provenance(seed, complete)


class OutcomeSearch(Goal[NearestWorld]):
    """A campaign that ends with the first world that has every outcome.

    Args:
        config: The goal.
        units: Amount of work; with it, the result depends only on the seed.
        seconds: Time limit; ignored if ``units`` is given.
        workers: Number of processes; 1 means this process.

    Iterating over :meth:`run` does the work and yields each better world; ``best`` keeps the last
    of them, even after Ctrl-C.
    """

    def __init__(
        self,
        config: FindConfig,
        *,
        units: int | None = None,
        seconds: float | None = None,
        workers: int = 1,
    ) -> None:
        self._scheduler = Scheduler(
            [target.scenario for target in config.targets],
            local_executor(workers),
            Schedule(None if units is not None else seconds, shrinks=False),
            units,
        )
        self.config = config
        self.best: NearestWorld | None = None
        self.done = 0
        self.tried = 0
        self.ended = 0

    def run(self) -> Generator[NearestWorld, None, None]:
        """Run the search, as :meth:`fuzz.campaign.scheduler.Scheduler.run` does."""
        return self._scheduler.run(self)

    def is_reached(self) -> bool:
        """Return True once a world has every outcome."""
        return self.best is not None and self.best.distance == 0.0

    def next_work(self) -> Work[NearestWorld] | None:
        """Return the next unit; the first tries at least one world, however short the time is."""
        unit = self._scheduler.next_unit
        schedule = self._scheduler.schedule
        if not self._scheduler.has_more_units or (unit and not schedule.may_search):
            return None
        self._scheduler.get_ready()
        return Work(partial(_search_unit, self.config, unit, schedule.deadline()), self._merge)

    def _merge(self, result: _UnitResult) -> Iterator[NearestWorld]:
        found = result.nearest
        self.done += 1
        self.tried += result.tried
        self.ended += result.ended
        if found is not None and (self.best is None or _rank(found) < _rank(self.best)):
            self.best = found
            yield found


def _search_unit(config: FindConfig, number: int, deadline: Deadline) -> _UnitResult:
    return _Unit(config, number, deadline.to_begin_is_over).run()
