"""Compare how many worlds a guided search makes until one fits with drawing seed after seed.

``python -m benchmarks.difficulty_search`` prints the table of ``docs/notes/difficulty.md``;
``--json`` prints one object. Each constraint is searched for with several seeds; a search that
finds nothing within ``--tries`` counts with that number, so the cost of drawing is then a lower
bound. Drawing comes in two kinds: with the family's defaults, and with parameters drawn at random.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from itertools import islice
from statistics import median
from typing import Any

import click

from worldgen.difficulty import measure
from worldgen.difficulty.search import Search, constraint_for
from worldgen.difficulty.space import drawn, free_parameters
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.generation import generate
from worldgen.random_streams import RandomStream

# The words of a round that takes seconds; the gate runs it.
TINY = ("--seeds", "1", "--tries", "2")

CASES = (
    ("maze", "detour > 3 and bottleneck < 1.2r"),
    ("maze", "detour > 4"),
    ("corridor", "turns > 40 and length < 8"),
    ("rubble", "0.78 < difficulty < 0.83"),
)
SEEDS = 5
TRIES = 250
KINDS = ("guided", "random parameters", "defaults")
# Worlds that may be refused for each one that is made.
_REFUSED = 5


def tries_of(family: str, where: str, seed: int, tries: int, kind: str) -> int:
    """Return the number of worlds made until one fits, at most ``tries``."""
    search = Search(FAMILIES.get(family), constraint_for(where), seed, {})
    worlds = _guided(search) if kind == "guided" else _drawn(search, kind)
    for tried, violation in enumerate(filter(_is_made, islice(worlds, _REFUSED * tries)), 1):
        if violation == 0.0 or tried == tries:
            return tried
    return tries


def _is_made(violation: float | None) -> bool:
    return violation is not None


def _guided(search: Search) -> Iterator[float | None]:
    """Yield how far each world of a search is from the constraint, or ``None`` without a world."""
    while True:
        found = search.step()
        yield None if found is None else found.violation


def _drawn(search: Search, kind: str) -> Iterator[float | None]:
    """Yield the same for worlds that do not depend on earlier ones."""
    rng = RandomStream(search.seed).child("drawn", search.family.name)
    free = free_parameters(search.family, ()) if kind != "defaults" else ()
    while True:
        values = drawn(free, rng, rng.random())
        try:
            world = generate(search.family, rng.next64() >> 32, **values)
        except (GenerationFailed, InvalidParameter):
            yield None
            continue
        metrics = measure(world, only=search.constraint.names).as_dict()
        yield search.constraint.violation(metrics, world.robot_radius)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--seeds", type=int, default=SEEDS, help=f"searches for each constraint (default {SEEDS})"
    )
    parser.add_argument(
        "--tries", type=int, default=TRIES, help=f"worlds made at most (default {TRIES})"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for family, where in CASES:
        row: dict[str, Any] = {"family": family, "where": where}
        for kind in KINDS:
            # The median over seeds, because a lucky first try decides a single search.
            counts = [
                tries_of(family, where, seed, given.tries, kind) for seed in range(given.seeds)
            ]
            row[kind] = {
                "median": median(counts),
                "found": sum(count < given.tries for count in counts),
            }
        row["ratio"] = {
            kind: row[kind]["median"] / row["guided"]["median"]
            for kind in KINDS
            if kind != "guided"
        }
        rows.append(row)
        if not given.json:
            cells = [
                f"{row[kind]['median']:g} ({row[kind]['found']}/{given.seeds})" for kind in KINDS
            ]
            click.echo(f"| `{family}` | `{where}` | {' | '.join(cells)} |")
    if given.json:
        click.echo(json.dumps({"seeds": given.seeds, "tries": given.tries, "constraints": rows}))


if __name__ == "__main__":
    main()
