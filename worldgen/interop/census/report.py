"""Count a census's answers for each radius, and print them as text, CSV and JSON.

``docs/howto/census.md`` describes the lines, columns and keys.
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from worldgen.interop.census.case import Radius
from worldgen.interop.census.take import Census, CensusCase
from worldgen.reach import BLOCKED, REACHABLE
from worldgen.support.intervals import interval_95
from worldgen.support.plain_text import GAP, Styled, aligned, counted, stacked

ROWS = {
    "reachable": "reachable for the disc",
    "blocked": "blocked for the disc",
    "no_room": "  no room for it at the start or the target",
    "four_only": "  4-connected path on the grid anyway",
    "four_parted": "    with room at both ends",
    "eight_only": "  8-connected path on the grid anyway",
    "eight_parted": "    with room at both ends",
    "undecided": "undecided, or certificate refused",
}
"""The table's rows by key; an indented row is part of the one above it."""

CSV_COLUMNS = (
    "map", "pair", "named", "width", "height", "cell_size", "radius", "radius_in_cells", "result", "proved", "room",
    "four", "eight",
)  # fmt: skip
# Number of refused maps that the text lists; JSON has all of them.
_MOST_REFUSALS = 10


@dataclass(frozen=True)
class Tally:
    """Counts over all questions at one radius.

    Args:
        asked: The radius as the user gave it.
        questions: Number of questions.
        counts: Number of questions in each row of :data:`ROWS`.
        radius: Smallest and largest radius, m.
        radius_in_cells: Smallest and largest radius, cells.
        seconds: Time spent in prover and checker.
    """

    asked: Radius
    questions: int
    counts: dict[str, int]
    radius: tuple[float, float]
    radius_in_cells: tuple[float, float]
    seconds: float

    def share(self, name: str) -> float | None:
        """Return the fraction of all questions, or None if there are none."""
        return self.counts[name] / self.questions if self.questions else None

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % confidence interval of the share (Clopper and Pearson)."""
        return interval_95(self.counts[name], self.questions) if self.questions else (0.0, 1.0)


def tally(census: Census) -> tuple[Tally, ...]:
    """Return one tally for each radius, in the order of the options."""
    return tuple(
        _tally_one(radius, [question for question in census.questions if question.asked == radius])
        for radius in census.options.radii
    )


def _tally_one(radius: Radius, questions: Sequence[CensusCase]) -> Tally:
    metres = [question.radius for question in questions] or [0.0]
    cells = [float(radius.in_cells(question.cell_size)) for question in questions] or [0.0]
    counts = dict.fromkeys(ROWS, 0)
    for question in questions:
        for name in _counted(question):
            counts[name] += 1
    return Tally(
        radius,
        len(questions),
        counts,
        (min(metres), max(metres)),
        (min(cells), max(cells)),
        sum(question.seconds for question in questions),
    )


def _counted(question: CensusCase) -> list[str]:
    """Return the keys of the rows that count a question."""
    if not question.proved:
        return ["undecided"]
    if question.result == REACHABLE:
        return ["reachable"]
    holding = {
        "no_room": not question.room,
        "four_only": question.four,
        "four_parted": question.four and question.room,
        "eight_only": question.eight,
        "eight_parted": question.eight and question.room,
    }
    return [BLOCKED, *(name for name, holds in holding.items() if holds)]


def as_text(census: Census) -> Styled:
    """Return a line about the maps, a table with a column per radius, and the refusals."""
    tallies = tally(census)
    rows = [["", *(str(one.asked) for one in tallies)], ["", *map(_in_the_other_unit, tallies)]]
    rows += [[label, *(_share(one, name) for one in tallies)] for name, label in ROWS.items()]
    rows.append(["seconds", *(f"{one.seconds:.2f}" for one in tallies)])
    lines = [_headline(census), "", aligned(rows, right=range(1, 1 + len(tallies)))]
    if census.options.pairs > 1:
        lines += [
            "",
            "The 95 % intervals assume that pairs on one map are independent, which is not quite true.",
        ]
    for refused in census.refused[:_MOST_REFUSALS]:
        lines.append(f"refused: {refused.name}: {refused.reason}")
    if len(census.refused) > _MOST_REFUSALS:
        lines.append(f"refused: {len(census.refused) - _MOST_REFUSALS} more; --json lists them")
    return stacked([*lines, ""])


def _headline(census: Census) -> str:
    asked = {(question.map, question.pair): question for question in census.questions}.values()
    named = sum(question.named for question in asked)
    sides = sorted(
        {(question.width, question.height) for question in asked},
        key=lambda side: side[0] * side[1],
    )
    size = ""
    if sides:
        ends = [f"{width} x {height}" for width, height in (sides[0], sides[-1])]
        size = (
            f" of {ends[0]} cells" if sides[0] == sides[-1] else f" of {ends[0]} to {ends[1]} cells"
        )
    return (
        f"{counted(census.maps, 'map')}{size}, {len(census.refused)} refused; "
        f"{counted(len(asked), 'start and target', 'starts and targets')}, {named} named by the "
        f"map, {len(asked) - named} drawn with seed {census.options.seed}"
    )


def _in_the_other_unit(one: Tally) -> str:
    ends, unit = (one.radius, "m") if one.asked.cells else (one.radius_in_cells, "cells")
    if not one.questions:
        return "-"
    return (
        f"{ends[0]:.4g} {unit}" if ends[0] == ends[1] else f"{ends[0]:.4g} to {ends[1]:.4g} {unit}"
    )


def _share(one: Tally, name: str) -> str:
    share = one.share(name)
    if share is None:
        return "-"
    low, high = one.interval(name)
    return f"{one.counts[name]}{GAP}{100 * share:5.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def as_csv(census: Census) -> str:
    """Return a CSV row for each question, without times, so that equal seeds give equal bytes."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    for question in census.questions:
        flags = (question.proved, question.room, question.four, question.eight)
        writer.writerow(
            [question.map, question.pair, int(question.named), question.width, question.height, question.cell_size,
             question.radius, float(question.asked.in_cells(question.cell_size)), question.result, *map(int, flags)]
        )  # fmt: skip
    return stream.getvalue()


def as_json(census: Census) -> dict[str, Any]:
    """Return what ``census --json`` prints."""
    asked = {(question.map, question.pair): question.named for question in census.questions}
    sources = Counter(asked.values())
    return {
        "seed": census.options.seed,
        "maps": census.maps,
        "pairs": {"named": sources[True], "drawn": sources[False]},
        "clear_ends": census.options.clear_ends,
        "interrupted": census.interrupted,
        "radii": [_tally_json(one) for one in tally(census)],
        "refused": [{"name": refused.name, "reason": refused.reason} for refused in census.refused],
    }


def _tally_json(one: Tally) -> dict[str, Any]:
    return {
        "radius": list(one.radius),
        "radius_in_cells": list(one.radius_in_cells),
        "questions": one.questions,
        **{
            name: {
                "count": one.counts[name],
                "share": one.share(name),
                "interval": list(one.interval(name)),
            }
            for name in ROWS
        },
        "seconds": one.seconds,
    }
