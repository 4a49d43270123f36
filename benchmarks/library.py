"""Measure how often each registered controller arrives.

The worlds are ``corpora/thesis``, and many worlds of every family. ``python -m benchmarks.library``
prints how the runs ended, table by table, and then the tables of ``docs/notes/library.md``;
``--json`` prints one object. With 500 worlds of each family it takes half an hour, most of it for
the dynamic window.

Worlds are made here, each from its own seed, so they and all runs are the same on every machine.
All controllers, including the thesis's three, run under ``swept``, each with the sensors that it
needs.
"""

from __future__ import annotations

import argparse
import importlib.resources
import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product

import click
import numpy as np

from sim import CONTROLLERS, Runs, simulate_many
from sim.verdict import UNENDED, Verdict
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.grid import read_world
from worldgen.world import Witness, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--worlds", "1", "--controller", "bug2", "--family", "trap")

# Worlds of each family.
WORLDS = 500
# Five minutes in steps of 15 ms, in which a robot can drive 600 m; the worlds are 3 m wide.
STEPS = 20_000
VERDICTS = (Verdict.REACHED, *UNENDED, Verdict.TUNNEL, Verdict.BURNED)


@dataclass(frozen=True)
class Row:
    """The outcomes of one controller in the worlds of one table.

    Args:
        controller: Name of the controller.
        verdicts: Runs by verdict, those of ``VERDICTS`` and ``other``.
        detour: Median, over the runs that arrived, of the driven path divided by the witness's; NaN
            if none arrived.
    """

    controller: str
    verdicts: dict[str, int]
    detour: float


FOR_FLEETS = {"naive", "orca", "pibt", "right-hand", "team-mapper"}
"""Controllers for several robots."""


def controllers() -> list[str]:
    """Return all registered controllers for one robot, by the first of their names."""
    found = {id(CONTROLLERS.get(name)): name for name in reversed(CONTROLLERS.names())}
    return sorted(set(found.values()) - FOR_FLEETS)


def tables(worlds: int, seed: int, families: Sequence[str]) -> Iterator[tuple[str, list[World]]]:
    """Yield each table's name and its worlds.

    They are the corpus, then worlds of each family with seeds from ``seed`` on.
    """
    files = sorted(
        (file for file in (importlib.resources.files("corpora") / "thesis").iterdir()), key=str
    )
    yield "corpora/thesis", [read_world(str(file)) for file in files if file.name.endswith(".grid")]
    for family in families:
        yield family, family_worlds(family, worlds, seed)


def family_worlds(family: str, count: int, seed: int) -> list[World]:
    """Return the worlds of consecutive seeds, cycling through choices (shapes, algorithms, masks).

    Combinations that a family refuses are skipped.
    """
    words = {
        parameter.name: parameter.choices
        for parameter in FAMILIES.get(family).parameters
        if parameter.choices
    }
    allowed = []
    for values in product(*words.values()):
        try:
            generate(family, seed, **(chosen := dict(zip(words, values, strict=True))))
        except InvalidParameter:
            continue
        allowed.append(chosen)
    return [generate(family, seed + k, **allowed[k % len(allowed)]) for k in range(count)]


def rows_of(worlds: Sequence[World], names: Sequence[str], steps: int) -> list[Row]:
    """Run every controller once in every world."""
    runs = simulate_many(worlds, names, motion="swept", steps=steps)
    return [_row(runs, index, worlds) for index in range(len(names))]


def _row(runs: Runs, index: int, worlds: Sequence[World]) -> Row:
    own = runs.controller == index
    counts = Counter(runs.verdicts[own].tolist())
    verdicts = {verdict: counts.pop(verdict, 0) for verdict in VERDICTS}
    arrived = np.flatnonzero(own & runs.reached)
    ways = [
        runs.path_length[run] / world.certificate.length
        for run in arrived
        if isinstance((world := worlds[runs.world[run]]).certificate, Witness)
    ]
    return Row(
        runs.names[index],
        {**verdicts, "other": counts.total()},
        float(np.median(ways)) if ways else np.nan,
    )


def _in_words(title: str, count: int, rows: Sequence[Row]) -> str:
    columns = (*VERDICTS, "other")
    lines = [
        f"{title}, {count} world{'s' if count > 1 else ''}:",
        "",
        f"| | {' | '.join(columns)} | path / witness |",
        "| --- |" + " ---: |" * (len(columns) + 1),
    ]
    for row in rows:
        numbers = [str(row.verdicts[name] or "") for name in columns]
        detour = "" if np.isnan(row.detour) else f"{row.detour:.2f}"
        lines.append(f"| `{row.controller}` | {' | '.join([*numbers, detour])} |")
    return "\n".join(lines) + "\n"


def _summary(title: str, tables_of: dict[str, list[Row]], entry: Callable[[Row], str]) -> str:
    lines = [
        f"{title}:",
        "",
        f"| | {' | '.join(tables_of)} |",
        "| --- |" + " ---: |" * len(tables_of),
    ]
    for rows in zip(*tables_of.values(), strict=True):
        lines.append(f"| `{rows[0].controller}` | {' | '.join(entry(row) for row in rows)} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the tables."""
    # Parse the options.
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--worlds", type=int, default=WORLDS, help=f"worlds of each family (default {WORLDS})"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the first world (default 0)")
    parser.add_argument(
        "--steps", type=int, default=STEPS, help=f"budget of a run (default {STEPS})"
    )
    parser.add_argument("--controller", action="append", help="only this one; may be repeated")
    parser.add_argument("--family", action="append", help="only this one; may be repeated")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    if given.worlds < 1:
        parser.error(f"--worlds {given.worlds} is below 1; use a number of worlds")
    # Run every table, and print each as soon as it is done.
    names = given.controller or controllers()
    all_rows = dict[str, list[Row]]()
    alone = [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots]
    for title, worlds in tables(given.worlds, given.seed, given.family or alone):
        all_rows[title] = rows_of(worlds, names, given.steps)
        if not given.json:
            click.echo(_in_words(title, len(worlds), all_rows[title]))
    # Print everything as one object, or the summaries.
    if given.json:
        plain = {
            title: [
                {**asdict(row), "detour": None if np.isnan(row.detour) else row.detour}
                for row in rows
            ]
            for title, rows in all_rows.items()
        }
        click.echo(
            json.dumps(
                {"seed": given.seed, "steps": given.steps, "worlds": given.worlds, "tables": plain}
            )
        )
        return
    click.echo(_summary("Reached", all_rows, lambda row: str(row.verdicts["reached"] or "")))
    click.echo(
        _summary(
            "Path / witness",
            all_rows,
            lambda row: "" if np.isnan(row.detour) else f"{row.detour:.2f}",
        )
    )


if __name__ == "__main__":
    main()
