"""From (family, version, seed, parameters) to a world that carries its proof."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count as rising
from typing import cast

from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES, MARGIN, Family, stream_for
from worldgen.random_streams import MASK64
from worldgen.reach import REACHABLE, decide
from worldgen.world import Provenance, Value, World

__all__ = ["MAX_ATTEMPTS", "generate", "stream"]

MAX_ATTEMPTS = 64  # layouts tried per seed before the parameters are called unsolvable


def generate(name: str | Family, seed: int = 0, **params: Value) -> World:
    """A world of a family, with a witness that its target can be reached.

    Args:
        name: Name of a registered family, ``./recipe.toml``, ``./file.py:name``, or the family itself.
        seed: Any integer; its low 64 bits count. Equal seed and parameters, equal world.
        **params: The family's parameters; see its documentation. One called ``margin`` is the number of seconds by
            which the robot may begin the witness later.

    Returns:
        The world, with certificate and provenance.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, or a value is out of range.
        GenerationFailed: If no layout in ``MAX_ATTEMPTS`` is solvable for the disc.
    """
    made_by = name if isinstance(name, Family) else FAMILIES.find(name, params)
    complete = made_by.complete(params)
    seed &= MASK64
    margin = float(cast("float", complete.get(MARGIN, 0.0)))
    for attempt in range(MAX_ATTEMPTS):
        world = made_by.build(stream_for(seed, made_by.name, attempt), **complete)
        decision = decide(world, margin=margin, cut=False)
        if decision.result == REACHABLE:
            provenance = Provenance(made_by.name, made_by.version, seed, complete)
            return replace(world, certificate=decision.certificate, provenance=provenance)
    settings = ", ".join(f"{parameter.name}={complete[parameter.name]}" for parameter in made_by.parameters)
    raise GenerationFailed(
        "no-layout-found",
        "{family}: none of {layouts} layouts lets the robot through (seed {seed}; {settings})",
        "give it more room: a larger size, a smaller robot_radius, or fewer obstacles",
        family=made_by.name,
        layouts=MAX_ATTEMPTS,
        seed=seed,
        settings=settings,
    )


def stream(name: str | Family, seed: int = 0, count: int | None = None, **params: Value) -> Iterator[World]:
    """The worlds of a family with rising seeds, each made when it is asked for.

    Args:
        name: Name of a registered family, ``./file.py:name``, or the family itself.
        seed: Of the first world; after 2**64 - 1 comes 0.
        count: How many; without it there is no end.
        **params: The family's parameters.

    Returns:
        The worlds, each with certificate and provenance.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, at once; if a value is out of range, with the
            first world.
        GenerationFailed: With a world that cannot be made.
    """
    made_by = name if isinstance(name, Family) else FAMILIES.find(name, params)
    complete = made_by.complete(params)
    if count is not None and count < 0:
        raise InvalidParameter(
            "below-minimum", "count={count} is below 0", "give how many worlds, or leave it out for no end", count=count
        )
    numbers = rising() if count is None else range(count)
    return (generate(made_by, (seed + k) & MASK64, **complete) for k in numbers)
