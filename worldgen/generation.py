"""Generate a world with its proof from (family, version, seed, parameters)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count as rising

from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES, MAX_ATTEMPTS, Family
from worldgen.plugins.trust import admit_argument
from worldgen.random_streams import Seed, seed_of
from worldgen.world import Value, World

__all__ = ["MAX_ATTEMPTS", "generate", "stream"]


def generate(name: str | Family, seed: Seed = 0, **params: Value | None) -> World:
    """Return a world of a family, with a witness that its target can be reached, or with a cut.

    A cut proves that it cannot be reached; only a share of ``blocked`` asks for such worlds.

    Args:
        name: Name of a registered family, ``./file.py:name``, or the family itself.
        seed: An integer, of which the low 64 bits count, or a NumPy generator, from which the next
            64 bits are taken. Equal seeds and parameters give equal worlds.
        **params: The family's parameters; see its documentation. ``None`` lets the family choose,
            if it can. A parameter called ``margin`` is the number of seconds by which the robot may
            begin the witness later.

    Returns:
        The world, with certificate and provenance.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, or a value is out of range.
        GenerationFailed: If no layout in ``MAX_ATTEMPTS`` is solvable for the disc.
    """
    return _family(name)(seed, **params)


def stream(
    name: str | Family, seed: Seed = 0, count: int | None = None, **params: Value | None
) -> Iterator[World]:
    """Yield the worlds of a family with consecutive seeds, each made when it is requested.

    Args:
        name: Name of a registered family, ``./file.py:name``, or the family itself.
        seed: Seed of the first world; 0 follows 2**64 - 1. A NumPy generator supplies the first
            one.
        count: Number of worlds; unlimited if omitted.
        **params: The family's parameters.

    Returns:
        The worlds, each with certificate and provenance.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, immediately; if a value is out of
            range, with the first world.
        GenerationFailed: When a world cannot be made.
    """
    made_by = _family(name)
    complete = made_by.complete(params)
    first = seed_of(seed)
    if count is not None and count < 0:
        raise InvalidParameter(
            "below-minimum",
            "count={count} is below 0",
            "pass the number of worlds, or omit it for an unlimited number",
            count=count,
        )
    numbers = rising() if count is None else range(count)
    return (made_by((first + k) & MASK64, **complete) for k in numbers)


def _family(name: str | Family) -> Family:
    if isinstance(name, Family):
        return name
    admit_argument(name)
    return FAMILIES.get(name)
