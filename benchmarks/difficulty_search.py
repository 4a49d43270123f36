"""Compare how many worlds a guided search makes until one fits with drawing seed after seed.

``python -m benchmarks.difficulty_search`` prints the table of ``docs/howto/difficulty.md``;
``--json`` prints one object. Each constraint is searched for with several seeds; a search that
finds nothing within ``--tries`` counts with that number, so the cost of drawing is then a lower
bound. Drawing comes in two kinds: with the family's defaults, and with parameters drawn at random.
"""

from __future__ import annotations

import argparse
import json
from statistics import median
from typing import Any

import click

from worldgen.difficulty.search import Search, constraint_for
from worldgen.family import FAMILIES

CASES = (
    ("maze", "detour > 3 and bottleneck < 1.2r"),
    ("maze", "detour > 4"),
    ("trap", "concavity > 2.5 and decisions <= 1"),
    ("rooms", "decisions >= 12"),
    ("cave", "detour > 2 and wall_distance > 2r"),
    ("corridor", "turns > 40 and length < 8"),
    ("rubble", "0.78 < difficulty < 0.83"),
)
SEEDS = 5
TRIES = 250
KINDS = {
    "guided": {"guided": True},
    "random parameters": {"learns": False},
    "defaults": {"guided": False},
}


def tries_of(family: str, where: str, seed: int, tries: int, **how: bool) -> int:
    """Return the number of worlds made until one fits, at most ``tries``."""
    search = Search(FAMILIES.get(family), constraint_for(where), seed, {}, **how)
    while search.tried < tries and search.asked < 5 * tries:
        found = search.step()
        if found is not None and found.violation == 0.0:
            return search.tried
    return tries


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
        for kind, how in KINDS.items():
            # The median over seeds, because a lucky first try decides a single search.
            counts = [
                tries_of(family, where, seed, given.tries, **how) for seed in range(given.seeds)
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
