"""Search for worlds with given metrics, over seeds and over the parameters that are not fixed.

This is an evolution strategy: the nearest worlds tried so far are parents. The next world has the
parameters of one or two of them, some of them changed, and a new seed or the parent's. Worlds that
a family refuses have no children. Every fourth world is drawn from scratch, so that a constraint
with more than one solution does not get stuck in one region.

A search may have several parts, each with a constraint and parents of its own: strata of
difficulty, for worlds that are spread evenly over a range. (98 % of 10,000 default mazes have a
difficulty between 0.70 and 0.86.) Each proposal is made for one part, and its world counts for the
part that it fits.

Source: Rechenberg, "Evolutionsstrategie", 1973; Beyer, Schwefel, "Evolution Strategies: A
    Comprehensive Introduction", 2002, for (mu + lambda); Mouret, Clune, "Illuminating search spaces
    by mapping elites", 2015, for an archive with a place for each part of a range.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from operator import itemgetter
from typing import Any

from worldgen.difficulty.expression import Expression, parse
from worldgen.difficulty.measuring import measure
from worldgen.difficulty.metrics import OF_DISCS, OF_MAPS
from worldgen.difficulty.space import drawn, free_parameters, mixed, varied
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import BLOCKED, FAMILIES, Family
from worldgen.files.grid import world_digest
from worldgen.generation import generate
from worldgen.parameters.bounds import check_between
from worldgen.plugins.trust import admit_argument
from worldgen.random_streams import RandomStream
from worldgen.support.plain_text import alternatives
from worldgen.world import Value, World

# Worlds made before a search gives up.
TRIES = 500
# Tolerance of the difficulty.
CLOSE = 0.025
_PARENTS = 12
# Tries before parents are selected.
_FIRST = 12
# Proposals per try: the family may refuse most of them, which takes no time.
_REFUSED = 5
# Short enough to be read and typed.
_SEED_BITS = 32
_MOST_STRATA = 10
# Minimum width of a range: the edges of its strata are rounded to a millionth and must differ.
_NARROWEST = 1e-3


@dataclass(frozen=True)
class Nearest:
    """A world that was tried.

    Args:
        violation: 0 if it fits, otherwise its distance from the constraint.
        seed: Its seed.
        params: The parameters that differ from the family's defaults, including given ones.
        metrics: Its metrics.
        number: Number of the try, from 1.
        world: The world.
        part: Index of the part that it fits, or is nearest to.
    """

    violation: float
    seed: int
    params: Mapping[str, Value]
    metrics: Mapping[str, float]
    number: int
    world: World = field(repr=False)
    part: int = 0


def constraint_for(
    where: str | None, difficulty: float | tuple[float, float] | None = None
) -> Expression:
    """Combine ``--where`` and ``--difficulty``, a number or a range, into one constraint.

    Raises:
        InvalidParameter: If neither is given, one cannot be parsed, or the difficulty is outside 0
            to 1, or not a range.
    """
    parts = []
    if isinstance(difficulty, tuple):
        _check_range(*difficulty)
        parts.append("{:g} <= difficulty <= {:g}".format(*difficulty))
    elif difficulty is not None:
        check_between("difficulty", difficulty, 0, 1)
        parts.append(
            f"{max(0.0, difficulty - CLOSE):.6g} <= difficulty <= {difficulty + CLOSE:.6g}"
        )
    if where is not None:
        # Its messages only quote the original text.
        parse(where)
        parts.append(f"({where})" if parts else where)
    if not parts:
        raise InvalidParameter("missing", "no constraint is given", "use where or difficulty")
    return parse(" and ".join(parts))


def _check_range(low: float, high: float) -> None:
    if not 0.0 <= low < high <= 1.0:
        raise InvalidParameter(
            "out-of-range",
            "difficulty={low:g}..{high:g} is not a range inside 0 to 1",
            "write 0.1..0.9",
            low=low,
            high=high,
        )
    if high - low < _NARROWEST * (1 - 1e-9):
        raise InvalidParameter(
            "range-too-narrow",
            "difficulty={low!r}..{high!r} is narrower than {narrowest:g}",
            "widen it, or use a single difficulty, such as {low:g}",
            low=low,
            high=high,
            narrowest=_NARROWEST,
        )


def strata_edges(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return the edges of a range's strata of difficulty, one more than there are strata.

    There are at most 10 strata, and no more than worlds.

    Raises:
        InvalidParameter: If it isn't a range of difficulty.
    """
    _check_range(low, high)
    strata = min(_MOST_STRATA, count)
    return tuple(round(low + (high - low) * k / strata, 6) for k in range(strata + 1))


def strata_constraints(constraint: str, edges: Sequence[float]) -> tuple[Expression, ...]:
    """Return the constraint within each stratum; only the last one includes its upper edge."""
    return tuple(
        parse(
            f"{low:.6f} <= difficulty {'<=' if high == edges[-1] else '<'} {high:.6f} and ({constraint})"
        )
        for low, high in pairwise(edges)
    )


@dataclass
class _Part:
    """A constraint of a search, and what was found for it.

    Args:
        constraint: The constraint.
        wanted: Worlds that it should get.
        found: Worlds that it has.
        tried: Worlds made for it since the last one was found.
        asked: Worlds requested from the family since then, some of them refused.
        closed: True if the search has given up on it.
        parents: The nearest worlds, each with its distance from the constraint.
    """

    constraint: Expression
    wanted: int = 1
    found: int = 0
    tried: int = 0
    asked: int = 0
    closed: bool = False
    parents: list[tuple[float, Nearest]] = field(default_factory=list)

    @property
    def open(self) -> bool:
        return not self.closed and self.found < self.wanted

    def keep(self, violation: float, found: Nearest) -> None:
        """Make a world a parent if it is near enough.

        Of equally near ones only the last counts, so that equals do not crowd out others.
        """
        others = [one for one in self.parents if one[0] != violation]
        self.parents = sorted([*others, (violation, found)], key=itemgetter(0))[:_PARENTS]


def _check_defined(family: Family, constraint: Expression, given: Mapping[str, Value]) -> None:
    """Refuse a constraint on a metric that no world with these parameters has.

    Raises:
        InvalidParameter: If there is one.
    """
    if family.changes and "difficulty" in constraint.names:
        raise InvalidParameter(
            "world-changes",
            "{name}: its worlds change, and difficulty is only defined for worlds that do not",
            "constrain another metric, such as detour",
            name=family.name,
        )
    # What is joined with "or" may hold all the same.
    if not constraint.needs_all:
        return
    robot = family.overrides(given)
    is_disc = robot.footprint is None and robot.drive is None
    of_maps = OF_MAPS | {"changing"} if family.changes else OF_MAPS
    of_maps = of_maps if is_disc else of_maps - OF_DISCS
    others = ["detour", "slack"] if robot.footprint is not None else ["detour"]
    if given.get(BLOCKED):
        others = sorted(of_maps)
    if not is_disc and (of_discs := sorted(constraint.names & OF_DISCS)):
        raise InvalidParameter(
            "metric-of-discs",
            "{metric} is only defined for a disc that turns on the spot, and the robot {robot}",
            "constrain another metric, such as {others}",
            metric=of_discs[0],
            others=alternatives(others),
            robot="is a car" if robot.drive == "car" else "has a footprint",
        )
    if given.get(BLOCKED) and (of_paths := sorted(constraint.names - of_maps)):
        raise InvalidParameter(
            "metric-of-paths",
            "{metric} is only defined where there is a path, so no blocked world would fit",
            "omit blocked, or constrain only {others}",
            metric=of_paths[0],
            others=alternatives(sorted(of_maps)),
        )


class Search:
    """A search that returns one world after another.

    Attributes:
        asked: Worlds requested from the family so far.
        tried: Those that it made.
        nearest: The world nearest to the constraint.

    Args:
        family: The family.
        constraint: The constraint on the metrics.
        seed: Source of all randomness; the first world tried has this seed and the given
            parameters.
        given: Parameters that keep their values.
        parts: Constraints that share the worlds equally; just the constraint if omitted.

    Raises:
        InvalidParameter: If a given parameter is refused, or no world with the given parameters has
            a metric of the constraint.
    """

    def __init__(
        self,
        family: Family,
        constraint: Expression,
        seed: int,
        given: Mapping[str, Value],
        parts: Sequence[Expression] = (),
    ) -> None:
        self.family = family
        self.constraint = constraint
        self.seed = seed
        self.given = dict(given)
        # Refuse immediately what would be refused every time, and what no world could have.
        family.complete(given)
        _check_defined(family, constraint, given)
        self._free = free_parameters(family, given)
        self._rng = RandomStream(seed).child("where", family.name)
        self._parts = [_Part(part) for part in parts or (constraint,)]
        self._names = frozenset().union(*(part.constraint.names for part in self._parts))
        self.asked = self.tried = 0
        self.nearest: Nearest | None = None

    def step(self, aim: int = 0) -> Nearest | None:
        """Try one world for a part; return None if none exists with its parameters.

        Raises:
            InvalidParameter: If the first world, with just the given parameters, is refused.
        """
        # The first proposal is the user's own parameters, unchanged.
        self.asked += 1
        seed, values = (
            (self.seed, {}) if self.asked == 1 else self._proposal(self._parts[aim].parents)
        )
        try:
            world = generate(self.family, seed, **{**self.given, **values})
        # A refused combination is part of the search, unless only the user's own values were
        # refused.
        except InvalidParameter:
            if self.asked == 1 and not self._free:
                raise
            return None
        except GenerationFailed:
            return None
        self.tried += 1
        metrics = {
            k: v for k, v in measure(world, only=self._names).as_dict().items() if k in self._names
        }
        # It becomes a parent of each part that it is near to.
        violations = [
            part.constraint.violation(metrics, world.robot_radius) for part in self._parts
        ]
        best = min(range(len(violations)), key=violations.__getitem__)
        found = Nearest(violations[best], seed, values, metrics, self.tried, world, best)
        if self.nearest is None or found.violation < self.nearest.violation:
            self.nearest = found
        for part, violation in zip(self._parts, violations, strict=True):
            part.keep(violation, found)
        return found

    def _proposal(self, parents: list[tuple[float, Nearest]]) -> tuple[int, dict[str, Value]]:
        rng = self._rng
        seed = rng.next64() >> (64 - _SEED_BITS)
        if len(parents) < 2 or self.tried <= _FIRST or rng.below(4) == 0:
            return seed, drawn(self._free, rng, rng.random())
        _, parent = parents[min(rng.below(len(parents)), rng.below(len(parents)))]
        kind = rng.below(8)
        # The parameters are the same, so leave the rest to chance.
        if kind < 2:
            return seed, dict(parent.params)
        values: Mapping[str, Value] = parent.params
        if kind == 2:
            values = mixed(values, rng.choice(parents)[1].params, rng)
        return (seed if rng.below(2) else parent.seed), varied(self._free, values, rng)

    def found(
        self, count: int, tries: int, progress: Callable[[Search], None] | None = None
    ) -> Iterator[Nearest]:
        """Yield different worlds that fit, as they are found; each part gets an equal share.

        A part for which none is found leaves its worlds to the nearest parts that can be filled.

        Args:
            count: Number of worlds.
            tries: Maximum number of worlds to make for each.
            progress: Called after each try.

        Raises:
            GenerationFailed: If no world fits within the tries; the message describes the nearest
                one.
        """
        parts = self._parts
        for k, part in enumerate(parts):
            part.wanted = count // len(parts) + (k < count % len(parts))
        seen: set[str] = set()
        turn = 0
        while len(seen) < count:
            still_open = [k for k, part in enumerate(parts) if part.open]
            if not still_open:
                raise self._nothing(tries, len(seen))
            # Take the parts in turn, starting after the last one.
            aim = next((k for k in still_open if k >= turn), still_open[0])
            turn = aim + 1
            one = self.step(aim)
            parts[aim].asked += 1
            parts[aim].tried += one is not None
            if progress is not None:
                progress(self)
            if (
                one is not None
                and one.violation == 0.0
                and (reached := parts[one.part]).open
                and (digest := world_digest(one.world)) not in seen
            ):
                seen.add(digest)
                reached.found += 1
                reached.tried = reached.asked = 0
                yield one
            # Refused proposals are cheap, so allow more of them before giving up.
            if parts[aim].tried >= tries or parts[aim].asked >= _REFUSED * tries:
                self._give_up(aim)

    def _give_up(self, number: int) -> None:
        """Close a part without success, and give its worlds to the nearest ones that can take them."""
        part = self._parts[number]
        part.closed = True
        left = part.wanted - part.found
        part.wanted = part.found
        takers = [k for k, one in enumerate(self._parts) if not one.closed and one.found]
        takers = takers or [k for k, one in enumerate(self._parts) if not one.closed]
        near = [*[k for k in takers if k < number][-1:], *[k for k in takers if k > number][:1]]
        for k, taker in enumerate(near):
            self._parts[taker].wanted += left // len(near) + (k < left % len(near))

    def _nothing(self, tries: int, before: int) -> GenerationFailed:
        near = self.nearest
        after = "after {before} that do, " if before else ""
        problem = f"{{family}}: {after}none of {{tries}} worlds fits {{constraint!r}}"
        facts: dict[str, Any] = {
            "family": self.family.name,
            "before": before,
            "tries": tries,
            "constraint": self.constraint.text,
        }
        if near is None:
            return GenerationFailed(
                "no-world-found",
                problem + "; the family refused them all",
                "fix fewer parameters",
                **facts,
            )
        if near.violation == 0.0:
            return GenerationFailed(
                "no-world-found", problem + " and is new", "fix fewer parameters", **facts
            )
        metrics = {
            name: near.metrics[name]
            for name in sorted(self.constraint.names)
            if name in near.metrics
        }
        return GenerationFailed(
            "no-world-found",
            problem + "; the nearest has {metrics!l:none of these metrics} ({settings!l})",
            "fix fewer parameters, or relax the constraint",
            **facts,
            metrics=[f"{name} {value:g}" for name, value in metrics.items()],
            settings=[
                f"seed {near.seed}",
                *(f"{name}={value}" for name, value in near.params.items()),
            ],
        )


def search_world(
    family: str | Family,
    where: str | None = None,
    *,
    difficulty: float | tuple[float, float] | None = None,
    seed: int = 0,
    tries: int = TRIES,
    progress: Callable[[Search], None] | None = None,
    **given: Value,
) -> World:
    """Return a world of a family whose metrics satisfy a constraint.

    It is an ordinary world: ``generate`` reproduces it from its provenance.

    Args:
        family: Name of a family, or the family itself.
        where: A constraint, such as ``"detour > 3 and bottleneck < 1.2r"``.
        difficulty: The difficulty, 0 to 1, to within :data:`CLOSE`; or a range of it.
        seed: Seed of the search.
        tries: Maximum number of worlds to make.
        progress: Called after each try.
        **given: Parameters that keep their values; the others vary, except the sizes of robot and
            cells.

    Raises:
        InvalidParameter: If the constraint cannot be parsed, or a parameter is unknown.
        GenerationFailed: If no world tried fits; the message describes the nearest one.
    """
    admit_argument(family)
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    search = Search(made_by, constraint_for(where, difficulty), seed, given)
    return next(search.found(1, tries, progress)).world
