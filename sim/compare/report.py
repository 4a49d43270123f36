"""Present a comparison as text, CSV and JSON (``docs/reference/tables.md`` has columns and keys)."""

from __future__ import annotations

import csv
import io
import textwrap
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from sim.compare.comparison import PERCENTILES, Comparison, ComparisonCell, Total, standing
from sim.evidence import evidence_table
from sim.verdict import NEVER, STUCK, without_arrival
from worldgen.support.plain_text import Styled, aligned, joined
from worldgen.world import World

CSV_COLUMNS = (
    "world",
    "controller",
    "motion",
    "time_step",
    "budget",
    "seeds",
    "first_seed",
    "reached",
    "low",
    "high",
    "verdict",
    "detail",
    "verdicts",
    "steps",
    "time",
    *(f"p{percent}" for percent in PERCENTILES),
    "source",
    "area_covered",
)

# Blocked worlds to name.
_MOST_NAMED = 5
# Width of sentences below a table, in characters.
_WIDTH = 116


def describe_outcome(cell: ComparisonCell, unit: str = "") -> str:
    """Describe a controller's result in a world, in a few words.

    Examples: ``4.950``, ``12.300 (97/100)``, ``never (loop, period 104)``, ``no arrival
    (stalled)``, ``tunnel``.

    Args:
        cell: The controller's runs in the world.
        unit: Text after a time, such as `` s``; a table's heading has the unit.
    """
    # A random controller has a share of arrivals; the others one outcome.
    if cell.random:
        share = f"({cell.reached}/{len(cell.runs)})"
        if cell.time is not None:
            return f"{cell.time:.3f}{unit} {share}"
        # Even if each of these runs is a proved loop, another seed may arrive.
        return f"none arrives ({describe_detail(cell)})"
    if cell.time is not None:
        return f"{cell.time:.3f}{unit}"
    if cell.verdict in STUCK:
        known = [cell.detail] if cell.detail else []
        # A stalled run's detail says more than the verdict.
        if cell.verdict in NEVER or not known:
            known = [cell.verdict, *known]
        return f"{without_arrival(cell.verdict)} ({', '.join(known)})"
    return f"{cell.verdict} ({cell.detail})" if cell.detail else cell.verdict


def describe_detail(cell: ComparisonCell) -> str:
    """Return what is known beyond the verdict: ``period 104``, or ``loop 3, stalled 2``."""
    if not cell.random:
        return cell.detail
    return ", ".join(f"{verdict} {count}" for verdict, count in cell.verdicts.items())


def as_text(comparison: Comparison) -> Styled:
    """Return the table and the totals, as aligned text."""
    return joined("\n\n".join((_main_table(comparison), _totals_table(comparison))), "\n")


def _main_table(comparison: Comparison) -> str:
    several = len(comparison.labels) > 1
    rows = [["world", *comparison.labels, *(("best", "worst") if several else ())]]
    for index, cells in enumerate(comparison.cells):
        ranks = _ranks([cell.rank_time for cell in cells], comparison.labels) if several else []
        rows.append([comparison.worlds[index].name, *map(describe_outcome, cells), *ranks])

    # Explain the notation that the table uses.
    text = aligned(_by_the_point(rows, range(1, 1 + len(comparison.labels))))
    keys = ["Times in s."]
    if any(cell.random for row in comparison.cells for cell in row):
        keys.append("(k/n): k of n seeds arrive; the time is their median.")
    return text + "\n" + _wrapped(" ".join(keys))


def _ranks(times: Sequence[float], labels: Sequence[str]) -> list[str]:
    best, worst = standing(times)
    return [", ".join(labels[index] for index in places) or "-" for places in (best, worst)]


def _by_the_point(rows: Sequence[Sequence[str]], numbers: Sequence[int]) -> list[list[str]]:
    """Return the rows at equal length, with decimal points aligned in the columns ``numbers``."""
    columns = max(map(len, rows))
    filled = [[*row, *[""] * (columns - len(row))] for row in rows]
    # Shift each number so that the decimal points of a column are aligned.
    for column in numbers:
        lead = max(
            (text.find(".") for row in filled[1:] if (text := row[column])[:1].isdigit()), default=0
        )
        for row in filled[1:]:
            if row[column][:1].isdigit():
                row[column] = " " * (lead - row[column].find(".")) + row[column]
    return filled


def _totals_table(comparison: Comparison) -> str:
    totals = comparison.totals()
    # Arrivals and failures of every controller, and which was best if there are several.
    rows = [["total", *comparison.labels], ["arrived", *map(_arrived, totals)]]
    failures = (", ".join(f"{kind} {n}" for kind, n in t.failures.items()) for t in totals)
    rows.append(["failed", *(text or "-" for text in failures)])
    rows.append(["mean area, m2", *(f"{total.mean_area:.2f}" for total in totals)])
    if len(totals) > 1:
        shared = (f" + {t.shared_wins} shared" if t.shared_wins else "" for t in totals)
        rows.append(["best", *(f"{t.wins}{more}" for t, more in zip(totals, shared, strict=True))])
        if comparison.common:
            rows.append(["mean time", *(f"{total.mean_time:.3f}" for total in totals)])
            rows.append(["median time", *(f"{total.median_time:.3f}" for total in totals)])

    # Explain which worlds count, which the times cover, and how the intervals are computed.
    text = aligned(rows)
    if comparison.blocked:
        names = [comparison.worlds[row].name for row in comparison.blocked]
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        text = joined(
            text,
            "\nNot counted, because a cut proves that the target cannot be reached: "
            f"{', '.join(names[:_MOST_NAMED])}{more}.",
        )
    if len(totals) > 1:
        count = len(comparison.common)
        of = len(comparison.worlds) - len(comparison.blocked)
        if count:
            text = joined(
                text,
                f"\nMean and median times are over the {count} of {of} worlds in which every "
                "controller arrives.",
            )
        elif of:
            text = joined(
                text,
                "\nNo mean or median times are given: in every world, some controller does not "
                "arrive.",
            )
    if any(total.random for total in totals):
        text = joined(
            text, "\nIntervals: 95 %, Clopper and Pearson, over the seeds in these worlds."
        )
    return text


def _arrived(total: Total) -> str:
    text = f"{total.reached} of {total.runs}"
    if total.interval is None:
        return text
    low, high = total.interval
    return f"{text} ({100 * low:.1f} to {100 * high:.1f} %)"


def _wrapped(text: str) -> str:
    return textwrap.fill(text, _WIDTH, break_long_words=False, break_on_hyphens=False)


def as_csv(comparison: Comparison) -> str:
    """Return one line per world and controller, with the columns :data:`CSV_COLUMNS`."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    for row in comparison.cells:
        for cell in row:
            writer.writerow(_csv_row(cell))
    return stream.getvalue()


def _csv_time(cell: ComparisonCell) -> str:
    if cell.is_unended:
        # A random controller may arrive with another seed.
        proved = not cell.random and cell.verdict in NEVER
        return without_arrival(cell.verdict) if proved else ""
    return "" if cell.time is None else repr(cell.time)


def _csv_row(cell: ComparisonCell) -> list[object]:
    scenario = cell.scenario
    interval = cell.interval
    verdicts = " ".join(f"{name}:{count}" for name, count in cell.verdicts.items())
    percentiles = [cell.percentile(percent) if cell.random else None for percent in PERCENTILES]
    return [
        cell.world,
        scenario.label(),
        scenario.run.motion,
        repr(scenario.run.time_step),
        cell.budget,
        len(cell.runs),
        scenario.run.seed if cell.random else "",
        cell.reached,
        *((round(end, 6) for end in interval) if interval else ("", "")),
        cell.verdict,
        cell.detail,
        verdicts,
        f"{cell.steps:g}" if cell.steps % 1 else int(cell.steps),
        _csv_time(cell),
        *("" if time is None else repr(time) for time in percentiles),
        "worldgen compare",
        f"{cell.area_covered:.9g}",
    ]


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Return the comparison as plain data."""
    worlds = []
    for index, cells in enumerate(comparison.cells):
        best, worst = standing([cell.rank_time for cell in cells])
        worlds.append(
            {
                "world": comparison.worlds[index].name,
                **_json_robots(comparison.worlds[index].world),
                **({"blocked": True} if index in comparison.blocked else {}),
                "cells": list(map(_json_cell, cells)),
                "best": [comparison.labels[place] for place in best],
                "worst": [comparison.labels[place] for place in worst],
            }
        )
    return {
        "controllers": list(comparison.labels),
        "worlds": worlds,
        "totals": [_json_total(total) for total in comparison.totals()],
        "common_worlds": [comparison.worlds[index].name for index in comparison.common],
    }


def _json_robots(world: World) -> dict[str, int]:
    """Return the number of robots; rows of worlds with one robot omit it."""
    return {"robots": len(world.robots)} if world.is_fleet else {}


def _json_cell(cell: ComparisonCell) -> dict[str, Any]:
    scenario = cell.scenario
    return {
        "controller": cell.label,
        "motion": scenario.run.motion,
        "time_step": scenario.run.time_step,
        "budget": cell.budget,
        "random": cell.random,
        "first_seed": scenario.run.seed,
        "seeds": len(cell.runs),
        "reached": cell.reached,
        "interval": list(cell.interval) if cell.interval else None,
        "verdict": cell.verdict,
        "verdicts": cell.verdicts,
        "evidence": {} if cell.evidence is None else evidence_table(cell.evidence),
        "time": cell.time,
        "steps": cell.steps,
        "area_covered": cell.area_covered,
        "percentiles": {f"p{p}": cell.percentile(p) for p in PERCENTILES} if cell.random else None,
    }


def _json_total(total: Total) -> dict[str, Any]:
    figures = asdict(total)
    return {"controller": figures.pop("label"), **figures}
