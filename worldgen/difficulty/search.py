"""Searches for worlds with wanted metrics, over seeds and over the parameters that nobody fixed.

An evolution strategy: of the worlds tried so far the nearest ones are parents; the next world has
the parameters of one or two of them, some changed, and a new seed or the parent's. What a family
refuses is left out and has no children. Every fourth is drawn again, so that a wish with more than
one answer is not lost in a corner.

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
from worldgen.random_streams import RandomStream
from worldgen.world import Value, World

__all__ = ["CLOSE", "TRIES", "Nearest", "Search", "constraint_for", "search_world"]

TRIES = 500  # worlds made before a search gives up
CLOSE = 0.025  # by how much the difficulty may miss the one asked for
_PARENTS = 12
_FIRST = 12  # tries before there are parents worth the name
# Times as many proposals as tries: the rest may be refused by the family, which takes no time.
_REFUSED = 5
_SEED_BITS = 32  # short enough to be read and typed


@dataclass(frozen=True)
class Nearest:
    """A world that was tried.

    Args:
        violation: 0 if it fits, else how far it is from the wish.
        seed: Its seed.
        params: The parameters that differ from the family's defaults, given ones among them.
        metrics: What was measured of it.
        number: Which try it was, from 1 on.
        world: The world.
    """

    violation: float
    seed: int
    params: Mapping[str, Value]
    metrics: Mapping[str, float]
    number: int
    world: World = field(repr=False)


def constraint_for(where: str | None, difficulty: float | None = None) -> Expression:
    """Return the wish of ``--where`` and ``--difficulty`` together.

    Raises:
        InvalidParameter: If neither is given, one cannot be read, or the difficulty is outside 0 to
            1.
    """
    parts = []
    if difficulty is not None:
        if not 0.0 <= difficulty <= 1.0:
            raise InvalidParameter(
                "out-of-range",
                "difficulty={difficulty:g} is outside 0 to 1",
                "give one between",
                difficulty=difficulty,
            )
        parts.append(
            f"{max(0.0, difficulty - CLOSE):.6g} <= difficulty <= {difficulty + CLOSE:.6g}"
        )
    if where is not None:
        parse(where)  # whose messages show what was written, no more
        parts.append(f"({where})" if parts else where)
    if not parts:
        raise InvalidParameter("missing", "nothing is wished for", "give where or difficulty")
    return parse(" and ".join(parts))


class Search:
    """A search that can be asked for one world after another.

    Attributes:
        asked: Worlds asked of the family so far.
        tried: Those of them that it made.
        nearest: The one nearest to the wish.

    Args:
        family: The family.
        wish: What the metrics must be.
        seed: Of all chance; the first world tried has this seed and the given parameters.
        given: Parameters that keep their values.
        guided: Whether to vary parameters; without it only new seeds are tried.
        learns: Whether the nearest worlds have children; without it all parameters are drawn.

    Raises:
        InvalidParameter: If a given parameter is refused, or a difficulty is wished of worlds that
            change.
    """

    def __init__(
        self,
        family: Family,
        wish: Expression,
        seed: int,
        given: Mapping[str, Value],
        *,
        guided: bool = True,
        learns: bool = True,
    ) -> None:
        self.family = family
        self.wish = wish
        self.seed = seed
        self.given = dict(given)
        family.complete(given)  # refuses at once what it would refuse every time
        if family.changes and "difficulty" in wish.names:
            raise InvalidParameter(
                "world-changes",
                "{name}: its worlds change, and those have no difficulty",
                "wish for another metric, say detour",
                name=family.name,
            )
        self._free = free_parameters(family, given) if guided else ()
        self._rng = RandomStream(seed).child("where", family.name)
        self._parents: list[Nearest] = []
        self._guided = guided
        self._learns = learns
        self.asked = self.tried = 0
        self.nearest: Nearest | None = None

    def step(self) -> Nearest | None:
        """Tries one world; None if there is none with its parameters.

        Raises:
            InvalidParameter: If the very first, with the given parameters alone, is refused.
        """
        self.asked += 1
        seed, values = (self.seed, {}) if self.asked == 1 else self._proposal()
        try:
            world = generate(self.family, seed, **{**self.given, **values})
        except InvalidParameter:
            if self.asked == 1 and not self._free:
                raise
            return None
        except GenerationFailed:
            return None
        self.tried += 1
        metrics = {
            k: v
            for k, v in measure(world, only=self.wish.names).as_dict().items()
            if k in self.wish.names
        }
        violation = self.wish.violation(metrics, world.robot_radius)
        found = Nearest(violation, seed, values, metrics, self.tried, world)
        if self.nearest is None or violation < self.nearest.violation:
            self.nearest = found
        self._keep(found)
        return found

    def _keep(self, found: Nearest) -> None:
        """Make it a parent if it is near enough.

        Of equally near ones only the last, so that equals do not crowd.
        """
        others = [one for one in self._parents if one.violation != found.violation]
        self._parents = sorted([*others, found], key=lambda one: one.violation)[:_PARENTS]

    def _proposal(self) -> tuple[int, dict[str, Value]]:
        rng = self._rng
        seed = rng.next64() >> (64 - _SEED_BITS)
        if not self._guided:
            return seed, {}
        if not self._learns or len(self._parents) < 2 or self.tried <= _FIRST or rng.below(4) == 0:
            return seed, drawn(self._free, rng, rng.random())
        parent = self._parents[min(rng.below(len(self._parents)), rng.below(len(self._parents)))]
        kind = rng.below(8)
        if kind < 2:  # the same parameters: chance may do the rest
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
    """Return a world of a family whose metrics are as wished.

    It is an ordinary world: ``generate`` makes it again from its provenance.

    Args:
        family: Name of a family, or the family itself.
        where: A wish, like ``"detour > 3 and bottleneck < 1.2r"``.
        difficulty: The difficulty wanted, 0 to 1, to within :data:`CLOSE`.
        seed: Of the search.
        tries: Worlds made at most.
        progress: Called after each.
        **given: Parameters that keep their values; the others are varied, save the robot's and the
            cells' size.

    Raises:
        InvalidParameter: If the wish cannot be read, or a parameter is unknown.
        GenerationFailed: If no world tried fits, with the nearest.
    """
    made_by = family if isinstance(family, Family) else FAMILIES.find(family, given)
    search = Search(made_by, constraint_for(where, difficulty), seed, given)
    return next(found(search, 1, tries, progress)).world


def found(
    search: Search, count: int, tries: int, progress: Callable[[Search], None] | None = None
) -> Iterator[Nearest]:
    """Different worlds that fit, as they are found.

    Args:
        search: The search.
        count: How many.
        tries: Worlds made at most for each.
        progress: Called after each try.

    Raises:
        GenerationFailed: If no world fits within the tries, with the nearest.
    """
    seen: set[str] = set()
    for _ in range(count):
        first = search.tried
        asked = search.asked
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
    problem = f"{{family}}: {after}none of {{tries}} worlds fits {{wish!r}}"
    facts: dict[str, Any] = {
        "family": search.family.name,
        "before": before,
        "tries": tries,
        "wish": search.wish.text,
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
            "give more tries, or fix fewer parameters",
            **facts,
        )
    metrics = {
        name: near.metrics[name] for name in sorted(search.wish.names) if name in near.metrics
    }
    return GenerationFailed(
        "no-world-found",
        problem + "; the nearest has {metrics!l:none of these metrics} ({settings!l})",
        "give more tries, fix fewer parameters, or wish for less",
        **facts,
        metrics=[f"{name} {value:g}" for name, value in metrics.items()],
        settings=[f"seed {near.seed}", *(f"{name}={value}" for name, value in near.params.items())],
    )
