"""Search for worlds with given metrics, over seeds and over the parameters that are not fixed.

This is an evolution strategy: the nearest worlds tried so far are parents. The next world has the
parameters of one or two of them, some of them changed, and a new seed or the parent's. Worlds that
a family refuses have no children. Every fourth world is drawn from scratch, so that a constraint
with more than one solution does not get stuck in one region.

Source: Rechenberg, "Evolutionsstrategie", 1973; Beyer, Schwefel, "Evolution Strategies: A
    Comprehensive Introduction",
2002, for (mu + lambda).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from worldgen.difficulty.expression import Expression, parse
from worldgen.difficulty.measuring import measure
from worldgen.difficulty.space import drawn, free_parameters, mixed, varied
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES, Family
from worldgen.files.grid import world_digest
from worldgen.generation import generate
from worldgen.parameters.bounds import check_between
from worldgen.plugins.trust import admit_argument
from worldgen.random_streams import RandomStream
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
    """

    violation: float
    seed: int
    params: Mapping[str, Value]
    metrics: Mapping[str, float]
    number: int
    world: World = field(repr=False)


def constraint_for(where: str | None, difficulty: float | None = None) -> Expression:
    """Combine ``--where`` and ``--difficulty`` into one constraint.

    Raises:
        InvalidParameter: If neither is given, one cannot be parsed, or the difficulty is outside 0
            to 1.
    """
    parts = []
    if difficulty is not None:
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

    Raises:
        InvalidParameter: If a given parameter is refused, or a difficulty is requested of worlds
            that change.
    """

    def __init__(
        self, family: Family, constraint: Expression, seed: int, given: Mapping[str, Value]
    ) -> None:
        self.family = family
        self.constraint = constraint
        self.seed = seed
        self.given = dict(given)
        # Refuse immediately what would be refused every time.
        family.complete(given)
        if family.changes and "difficulty" in constraint.names:
            raise InvalidParameter(
                "world-changes",
                "{name}: its worlds change, and difficulty is only defined for worlds that do not",
                "constrain another metric, such as detour",
                name=family.name,
            )
        self._free = free_parameters(family, given)
        self._rng = RandomStream(seed).child("where", family.name)
        self._parents: list[Nearest] = []
        self.asked = self.tried = 0
        self.nearest: Nearest | None = None

    def step(self) -> Nearest | None:
        """Try one world; return None if none exists with its parameters.

        Raises:
            InvalidParameter: If the first world, with just the given parameters, is refused.
        """
        # The first proposal is the user's own parameters, unchanged.
        self.asked += 1
        seed, values = (self.seed, {}) if self.asked == 1 else self._proposal()
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
            k: v
            for k, v in measure(world, only=self.constraint.names).as_dict().items()
            if k in self.constraint.names
        }
        violation = self.constraint.violation(metrics, world.robot_radius)
        found = Nearest(violation, seed, values, metrics, self.tried, world)
        if self.nearest is None or violation < self.nearest.violation:
            self.nearest = found
        self._keep(found)
        return found

    def _keep(self, found: Nearest) -> None:
        """Make it a parent if it is near enough.

        Of equally near ones only the last counts, so that equals do not crowd out others.
        """
        others = [one for one in self._parents if one.violation != found.violation]
        self._parents = sorted([*others, found], key=lambda one: one.violation)[:_PARENTS]

    def _proposal(self) -> tuple[int, dict[str, Value]]:
        rng = self._rng
        seed = rng.next64() >> (64 - _SEED_BITS)
        if len(self._parents) < 2 or self.tried <= _FIRST or rng.below(4) == 0:
            return seed, drawn(self._free, rng, rng.random())
        parent = self._parents[min(rng.below(len(self._parents)), rng.below(len(self._parents)))]
        kind = rng.below(8)
        # The parameters are the same, so leave the rest to chance.
        if kind < 2:
            return seed, dict(parent.params)
        values: Mapping[str, Value] = parent.params
        if kind == 2:
            values = mixed(values, rng.choice(self._parents).params, rng)
        return (seed if rng.below(2) else parent.seed), varied(self._free, values, rng)


def search_world(
    family: str | Family,
    where: str | None = None,
    *,
    difficulty: float | None = None,
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
        difficulty: The difficulty, 0 to 1, to within :data:`CLOSE`.
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
    return next(found(search, 1, tries, progress)).world


def found(
    search: Search, count: int, tries: int, progress: Callable[[Search], None] | None = None
) -> Iterator[Nearest]:
    """Yield different worlds that fit, as they are found.

    Args:
        search: The search.
        count: Number of worlds.
        tries: Maximum number of worlds to make for each.
        progress: Called after each try.

    Raises:
        GenerationFailed: If no world fits within the tries; the message describes the nearest one.
    """
    seen: set[str] = set()
    for _ in range(count):
        first = search.tried
        asked = search.asked
        # Refused proposals are cheap, so allow more of them before giving up.
        while search.tried < first + tries and search.asked < asked + _REFUSED * tries:
            one = search.step()
            if progress is not None:
                progress(search)
            if (
                one is not None
                and one.violation == 0.0
                and (digest := world_digest(one.world)) not in seen
            ):
                seen.add(digest)
                yield one
                break
        else:
            raise _nothing(search, tries, len(seen))


def _nothing(search: Search, tries: int, before: int) -> GenerationFailed:
    near = search.nearest
    after = "after {before} that do, " if before else ""
    problem = f"{{family}}: {after}none of {{tries}} worlds fits {{constraint!r}}"
    facts: dict[str, Any] = {
        "family": search.family.name,
        "before": before,
        "tries": tries,
        "constraint": search.constraint.text,
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
            "no-world-found",
            problem + " and is new",
            "use more tries, or fix fewer parameters",
            **facts,
        )
    metrics = {
        name: near.metrics[name] for name in sorted(search.constraint.names) if name in near.metrics
    }
    return GenerationFailed(
        "no-world-found",
        problem + "; the nearest has {metrics!l:none of these metrics} ({settings!l})",
        "use more tries, fix fewer parameters, or relax the constraint",
        **facts,
        metrics=[f"{name} {value:g}" for name, value in metrics.items()],
        settings=[f"seed {near.seed}", *(f"{name}={value}" for name, value in near.params.items())],
    )
