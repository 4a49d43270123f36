"""Supply the worlds of episodes: given ones, or a family's at a chosen difficulty."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from sim.options.run import whole
from worldgen.difficulty.expression import parse
from worldgen.difficulty.search import TRIES, Search
from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES, Family
from worldgen.files.grid import read_world
from worldgen.files.worlds import read_worlds
from worldgen.generation import stream
from worldgen.plugins.trust import admit_argument
from worldgen.world import World

__all__ = ["DEFAULT_FAMILY", "DEFAULT_POOL", "SOURCES", "Supply"]

DEFAULT_FAMILY = "trap"
DEFAULT_POOL = 64
MOST_POOL = 1_000_000

SOURCES = ("world", "worlds", "family", "params", "difficulty", "pool", "pool_seed")
"""The options that determine the source of worlds."""


class Supply:
    """A fixed number of worlds, each made or read when it is first needed.

    Args:
        options: Those of :data:`SOURCES` that are given; see
            :class:`worldgen_plugins.for_gymnasium.options.Options`.

    Raises:
        InvalidParameter: If the options contradict each other, or are out of range.
        FormatError: If a file is not a world.
    """

    def __init__(self, options: Mapping[str, Any]) -> None:
        # Worlds come from one source, and options of a family go with a family only.
        given = {name: value for name, value in options.items() if value is not None}
        named = [name for name in ("world", "worlds", "family") if name in given]
        if len(named) > 1:
            raise InvalidParameter(
                "conflict", "{named} are given", "use one of them", named=" and ".join(named)
            )
        fixed = named and named[0] != "family"
        stray = [
            name
            for name in ("params", "difficulty", "pool", "pool_seed")
            if fixed and name in given
        ]
        if stray:
            raise InvalidParameter(
                "conflict",
                "{only_for_family} is for a family, but {named} is given",
                "remove one of them",
                only_for_family=stray[0],
                named=named[0],
            )

        # Given worlds are read now; those of a family are made on demand.
        self.options: dict[str, Any] = given
        self._made: list[World] = []
        self._more: Iterator[World] = iter(())
        if fixed:
            self._made = (
                _read_one(given["world"]) if named == ["world"] else _read_all(given["worlds"])
            )
            self._count = len(self._made)
        else:
            self._count = whole("pool", given.get("pool", DEFAULT_POOL), 1, MOST_POOL)
            self._more = _of_family(given, self._count)

    def __getstate__(self) -> dict[str, Any]:
        """Return everything except the generator of further worlds, which cannot be copied."""
        return {name: value for name, value in vars(self).items() if name != "_more"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        done = len(self._made)
        self._more = (
            islice(_of_family(self.options, self._count), done, None)
            if done < self._count
            else iter(())
        )

    def changed(self, options: Mapping[str, Any]) -> Supply:
        """Return the supply with other options.

        Options of a family keep their values unless they are given. A world, or worlds, replace a
        family, and a family replaces them. ``None`` has no effect, except for difficulty and
        parameters, which it removes.
        """
        options = {
            name: value
            for name, value in options.items()
            if value is not None or name in ("difficulty", "params")
        }
        if not any(name in self.options or value is not None for name, value in options.items()):
            return self
        if "world" in options or "worlds" in options:
            return Supply(options)
        kept = {
            name: value for name, value in self.options.items() if name not in ("world", "worlds")
        }
        if "family" in options:
            kept = {name: value for name, value in kept.items() if name != "params"}
        return Supply({**kept, **options})

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, index: int) -> World:
        while len(self._made) <= index:
            self._made.append(next(self._more))
        return self._made[index]

    def all(self, progress: Callable[[int], None] = lambda done: None) -> Sequence[World]:
        """Return all worlds, making those that do not exist yet.

        Args:
            progress: Called with the number of worlds made so far.
        """
        worlds = []
        for index in range(len(self)):
            progress(index)
            worlds.append(self[index])
        return worlds


def _read_one(given: object) -> list[World]:
    if isinstance(given, World):
        return [given]
    if isinstance(given, str | Path):
        return [read_world(Path(given))]
    raise InvalidParameter(
        "wrong-type",
        "world={given} is neither a World nor a path",
        "use one of them",
        given=repr(given),
    )


def _read_all(given: object) -> list[World]:
    if isinstance(given, str | Path):
        return [world for _, world in read_worlds([Path(given)])]
    if not isinstance(given, Sequence) or not given:
        raise InvalidParameter(
            "wrong-type",
            "worlds={given} is not a folder, archive or list of worlds",
            "use one",
            given=repr(given),
        )
    return [
        world
        for one in given
        for world in ([one] if isinstance(one, World) else _read_all(str(one)))
    ]


def _of_family(given: Mapping[str, Any], count: int) -> Iterator[World]:
    """Yield worlds with rising seeds or, given a difficulty, different ones that a search finds."""
    name = given.get("family", DEFAULT_FAMILY)
    params = given.get("params", {})
    if not isinstance(params, Mapping):
        raise InvalidParameter(
            "wrong-type",
            "params={given} is not a dict",
            "write one such as {{'size': 30}}",
            given=repr(params),
        )
    if not isinstance(name, str | Family):
        raise InvalidParameter(
            "wrong-type",
            "family={given} is not a family's name",
            "use a name such as 'maze'",
            given=repr(name),
        )
    admit_argument(name)
    family = name if isinstance(name, Family) else FAMILIES.get(name)
    seed = whole("pool_seed", given.get("pool_seed", 0), 0, MASK64)
    # Without a range of difficulty, worlds are drawn from consecutive seeds.
    if "difficulty" not in given:
        return stream(family, seed, count, **params)
    # With one, worlds of any parameters are searched until their difficulty is in the range.
    low, high = _range(given["difficulty"])
    search = Search(family, parse(f"{low!r} <= difficulty <= {high!r}"), seed, params)
    return (one.world for one in search.found(count, TRIES))


def _range(given: object) -> tuple[float, float]:
    pair = tuple(given) if isinstance(given, tuple | list) else ()
    numbers = [
        float(one) for one in pair if isinstance(one, int | float) and not isinstance(one, bool)
    ]
    if len(pair) != 2 or len(numbers) != 2 or not 0.0 <= numbers[0] < numbers[1] <= 1.0:
        raise InvalidParameter(
            "out-of-range",
            "difficulty={given} is not a range within 0 to 1",
            "write one such as (0.2, 0.4)",
            given=repr(given),
        )
    return numbers[0], numbers[1]
