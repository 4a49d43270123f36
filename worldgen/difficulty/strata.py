"""Search for worlds spread evenly over a range of difficulty.

Worlds of one family with its default parameters are about equally hard: 98 % of 10,000 default
mazes are between 0.70 and 0.86. So the range is divided into strata of equal width, each of which
gets the same number of worlds. The strata share one search: each proposal is made for one of them,
from the parameters of worlds in it or near it, and a world counts for the stratum that it turns out
to be in.

Source: Mouret, Clune, "Illuminating search spaces by mapping elites", 2015: an archive with a place
    for each part of the range.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from worldgen.difficulty.expression import Expression, parse
from worldgen.difficulty.measuring import measure
from worldgen.difficulty.space import drawn, free_parameters, mixed, varied
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import Family
from worldgen.files.grid import world_digest
from worldgen.generation import generate
from worldgen.random_streams import RandomStream
from worldgen.world import Value, World

MOST_STRATA = 10
# Least width of a range: the edges of its strata are rounded to a millionth and must differ.
_NARROWEST = 1e-3
# Parents kept per stratum, the latest.
_PARENTS = 12
# Proposals per try, because proposals that a family refuses take no time.
_REFUSED = 5
# Short enough to be read and typed.
_SEED_BITS = 32


@dataclass(frozen=True)
class InStratum:
    """A world that was found.

    Args:
        world: The world.
        difficulty: Its difficulty.
        stratum: Lower and upper end of its stratum.
    """

    world: World = field(repr=False)
    difficulty: float
    stratum: tuple[float, float]


@dataclass
class _Stratum:
    """A part of the range.

    Args:
        wanted: Worlds that it should get.
        found: Worlds that it has.
        tried: Worlds made for it since the last one was found in it.
        asked: Worlds requested from the family since then, some of them refused.
        closed: Whether the search has given up on it.
        parents: Parameters of its latest worlds that satisfy every other constraint.
    """

    wanted: int
    found: int = 0
    tried: int = 0
    asked: int = 0
    closed: bool = False
    parents: list[dict[str, Value]] = field(default_factory=list)

    @property
    def open(self) -> bool:
        return not self.closed and self.found < self.wanted


def check_range(low: float, high: float) -> None:
    """Reject an invalid range of difficulty.

    Raises:
        InvalidParameter: If an end is outside 0 to 1, or the lower one is not below the upper one
            by 0.001 or more.
    """
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
            "widen it, or give a single difficulty, such as {low:g}",
            low=low,
            high=high,
            narrowest=_NARROWEST,
        )


def edges_of(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return the edges of a range's strata, one more than there are strata.

    There are at most 10 strata, and no more than worlds.

    Raises:
        InvalidParameter: If it isn't a range of difficulty.
    """
    check_range(low, high)
    strata = min(MOST_STRATA, count)
    return tuple(round(low + (high - low) * k / strata, 6) for k in range(strata + 1))


class StrataSearch:
    """A search for worlds in every stratum of a range of difficulty.

    Args:
        family: The family.
        edges: Edges of the strata, ascending.
        count: Total number of worlds to find.
        seed: Source of all randomness; the first world tried has this seed and the given
            parameters.
        given: Parameters that keep their values; the others are varied.
        where: Further constraint on each world.
        tries: Worlds made without success for a stratum before the search gives up on it.

    Raises:
        InvalidParameter: If a given parameter is refused, or the family's worlds change and have no
            difficulty.
    """

    def __init__(
        self,
        family: Family,
        edges: tuple[float, ...],
        count: int,
        seed: int,
        given: Mapping[str, Value],
        *,
        where: str | None,
        tries: int,
    ) -> None:
        # Refuse immediately what would be refused every time.
        family.complete(given)
        if family.changes:
            raise InvalidParameter(
                "world-changes",
                "{name}: its worlds change, and difficulty is only defined for worlds that do not",
                "leave out difficulty",
                name=family.name,
            )
        self._family = family
        self._edges = edges
        self._seed = seed
        self._given = dict(given)
        self._where: Expression | None = None if where is None else parse(where)
        self._names = frozenset({"difficulty"} | (self._where.names if self._where else set()))
        self._tries = tries
        self._free = free_parameters(family, given)
        self._rng = RandomStream(seed).child("strata", family.name)
        strata = len(edges) - 1
        self._strata = [_Stratum(count // strata + (k < count % strata)) for k in range(strata)]
        self._count = count
        self._asked = 0

    def found(self) -> Iterator[InStratum]:
        """Yield the requested number of different worlds, in the order in which they are found.

        The worlds of an abandoned stratum go to the nearest strata that can be filled.

        Raises:
            GenerationFailed: If every stratum is abandoned.
        """
        seen: set[str] = set()
        turn = 0
        while len(seen) < self._count:
            still_open = [k for k, stratum in enumerate(self._strata) if stratum.open]
            if not still_open:
                raise self._nothing(len(seen))
            # Take the strata in turn, starting after the last one.
            aim = next((k for k in still_open if k >= turn), still_open[0])
            turn = aim + 1
            one = self._try(aim)
            if one is not None and (digest := world_digest(one.world)) not in seen:
                seen.add(digest)
                stratum = self._strata[self._edges.index(one.stratum[0])]
                stratum.found += 1
                stratum.tried = stratum.asked = 0
                yield one
            self._give_up(aim)

    def _try(self, aim: int) -> InStratum | None:
        """Make a world for a stratum; None if it is refused, or its own stratum is full."""
        # Make a world; the first has just the given parameters.
        stratum = self._strata[aim]
        self._asked += 1
        stratum.asked += 1
        seed, values = (self._seed, {}) if self._asked == 1 else self._proposal(aim)
        try:
            world = generate(self._family, seed, **{**self._given, **values})
        except (InvalidParameter, GenerationFailed):
            return None
        stratum.tried += 1
        # Measure it, and find the stratum that it belongs to.
        metrics = measure(world, only=self._names).as_dict()
        difficulty = metrics.get("difficulty")
        at = None if difficulty is None else self._stratum_of(difficulty)
        if difficulty is None or at is None:
            return None
        if self._where is not None and self._where.violation(metrics, world.robot_radius) > 0.0:
            return None
        # It becomes a parent even if its stratum is full.
        came = self._strata[at]
        came.parents = [*(one for one in came.parents if one != values), values][-_PARENTS:]
        if not came.open:
            return None
        return InStratum(world, difficulty, (self._edges[at], self._edges[at + 1]))

    def _stratum_of(self, difficulty: float) -> int | None:
        """Return the number of the stratum with this difficulty; the upper end belongs to the last."""
        if not self._edges[0] <= difficulty <= self._edges[-1]:
            return None
        return min(bisect_right(self._edges, difficulty), len(self._strata)) - 1

    def _proposal(self, aim: int) -> tuple[int, dict[str, Value]]:
        """Return the seed and parameters of the next world for a stratum."""
        rng = self._rng
        seed = rng.next64() >> (64 - _SEED_BITS)
        known = [k for k, stratum in enumerate(self._strata) if stratum.parents]
        if not known or rng.below(4) == 0:
            return seed, drawn(self._free, rng, rng.random())
        nearest = min(known, key=lambda k: (abs(k - aim), k))
        parent = rng.choice(self._strata[nearest].parents)
        kind = rng.below(8)
        # The parameters are the same; another seed gives another world of about this difficulty.
        if kind < 3 and nearest == aim:
            return seed, dict(parent)
        if kind == 3:
            other = rng.choice(self._strata[rng.choice(known)].parents)
            return seed, dict(varied(self._free, mixed(parent, other, rng), rng))
        return seed, dict(varied(self._free, parent, rng))

    def _give_up(self, number: int) -> None:
        """Close a stratum that was tried without success, and give its worlds to the nearest open ones."""
        stratum = self._strata[number]
        if stratum.tried < self._tries and stratum.asked < _REFUSED * self._tries:
            return
        stratum.closed = True
        left = stratum.wanted - stratum.found
        # Give the worlds that are still missing to the nearest strata that can take them.
        stratum.wanted = stratum.found
        takers = [k for k, one in enumerate(self._strata) if not one.closed and one.found]
        takers = takers or [k for k, one in enumerate(self._strata) if not one.closed]
        below = [k for k in takers if k < number][-1:]
        above = [k for k in takers if k > number][:1]
        near = [*below, *above]
        for k, taker in enumerate(near):
            self._strata[taker].wanted += left // len(near) + (k < left % len(near))

    def _nothing(self, before: int) -> GenerationFailed:
        return GenerationFailed(
            "no-world-found",
            "{family}: only {before} of {count} worlds were found with a difficulty of {low:g} to "
            "{high:g}, {tries} tries after the last",
            "give more tries, fix fewer parameters, or another range",
            family=self._family.name,
            before=before,
            count=self._count,
            low=self._edges[0],
            high=self._edges[-1],
            tries=self._tries,
        )
