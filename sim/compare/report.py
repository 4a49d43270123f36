"""Present a comparison as text, CSV and JSON (``docs/howto/compare.md`` has columns and keys)."""

from __future__ import annotations

import csv
import io
import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from sim.compare.comparison import PERCENTILES, Comparison, ComparisonCell, Total, standing
from sim.compare.published import Agreement, PublishedRow
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


def as_text(comparison: Comparison, agreed: Agreement | None = None) -> Styled:
    """Return the table, the totals and the agreement with a published table, as aligned text."""
    parts = [_main_table(comparison, agreed), _totals_table(comparison)]
    if agreed is not None:
        parts.append(_agreement_text(agreed))
    return joined("\n\n".join(parts), "\n")


def _main_table(comparison: Comparison, agreed: Agreement | None) -> str:
    # One row per world, with a row of published figures below it if there are any.
    several = len(comparison.labels) > 1
    rows = [["world", *comparison.labels, *(("best", "worst") if several else ())]]
    for index, cells in enumerate(comparison.cells):
        ranks = _ranks([cell.rank_time for cell in cells], comparison.labels) if several else []
        rows.append([comparison.worlds[index].name, *map(describe_outcome, cells), *ranks])
        figures = {} if agreed is None else agreed.figures
        known = {c: own for (row, c), own in figures.items() if row == index}
        if known:
            row_below = _published_row(cells, known)
            rows.append(["  published", *row_below, *_published_ranks(comparison, known)])

    # Explain the notation that the table uses.
    text = aligned(_by_the_point(rows, range(1, 1 + len(comparison.labels))))
    keys = ["Times in s."]
    if any(cell.random for row in comparison.cells for cell in row):
        keys.append("(k/n): k of n seeds arrive; the time is their median.")
    if agreed is not None and agreed.figures:
        keys.append(
            "In brackets after a published time: our time minus the published one; for random "
            "controllers, the share of seeds that are no later."
        )
    return text + "\n" + _wrapped(" ".join(keys))


def _ranks(times: Sequence[float], labels: Sequence[str]) -> list[str]:
    best, worst = standing(times)
    return [", ".join(labels[index] for index in places) or "-" for places in (best, worst)]


def _published_row(
    cells: Sequence[ComparisonCell], known: Mapping[int, tuple[PublishedRow, ...]]
) -> list[str]:
    return [
        "; ".join(_describe_figure(cell, figure) for figure in known.get(c, ()))
        for c, cell in enumerate(cells)
    ]


def _published_ranks(
    comparison: Comparison, known: Mapping[int, tuple[PublishedRow, ...]]
) -> list[str]:
    """Return the best and the worst by the first figure of each cell."""
    if len(known) < 2:
        return []
    return _ranks(
        [own[0].rank_time for own in known.values()],
        [comparison.labels[column] for column in known],
    )


def _describe_figure(cell: ComparisonCell, figure: PublishedRow) -> str:
    if figure.time is None:
        return figure.verdict
    time = f"{figure.time:.3f}"
    if cell.random:
        return f"{time} ({cell.share_until(figure.time):.0%})"
    return time if cell.time is None else f"{time} ({cell.time - figure.time:+.3f})"


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

    # Explain which worlds the times cover, and how the intervals are computed.
    text = aligned(rows)
    if len(totals) > 1:
        count = len(comparison.common)
        of = len(comparison.worlds)
        if count:
            text = joined(
                text,
                f"\nMean and median times are over the {count} of {of} worlds in which every "
                "controller arrives.",
            )
        else:
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


def _agreement_text(agreed: Agreement) -> str:
    if not agreed.figures:
        return "There are no published figures for these worlds and controllers."
    parts = []
    if agreed.rankings[1]:
        parts.append(f"same ranking in {agreed.rankings[0]} of {agreed.rankings[1]} worlds")
    if agreed.never[1]:
        parts.append(
            f'both have no arrival, which they call "never", in {agreed.never[0]} of '
            f"{agreed.never[1]} cells"
        )
    if agreed.within[1]:
        parts.append(
            f"{agreed.within[0]} of {agreed.within[1]} figures are within the middle 95 % of our "
            f"seeds"
        )
    if agreed.largest is not None:
        far = agreed.largest
        parts.append(
            f"largest deviation without randomness {far.relative:+.1%} "
            f"({far.label} in {far.world}: {far.ours:.3f} against {far.theirs:.3f})"
        )
    if not parts:
        return "None of the published figures for these worlds and controllers can be compared."
    return _wrapped("Against the published figures: " + "; ".join(parts) + ".")


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


def as_json(comparison: Comparison, agreed: Agreement | None = None) -> dict[str, Any]:
    """Return the comparison as plain data."""
    figures = {} if agreed is None else agreed.figures
    worlds = []
    for index, cells in enumerate(comparison.cells):
        best, worst = standing([cell.rank_time for cell in cells])
        worlds.append(
            {
                "world": comparison.worlds[index].name,
                **_json_robots(comparison.worlds[index].world),
                "cells": [
                    _json_cell(cell, figures.get((index, c), ())) for c, cell in enumerate(cells)
                ],
                "best": [comparison.labels[place] for place in best],
                "worst": [comparison.labels[place] for place in worst],
            }
        )
    return {
        "controllers": list(comparison.labels),
        "worlds": worlds,
        "totals": [_json_total(total) for total in comparison.totals()],
        "common_worlds": [comparison.worlds[index].name for index in comparison.common],
        "agreement": None if agreed is None else _json_agreement(agreed),
    }


def _json_robots(world: World) -> dict[str, int]:
    """Return the number of robots; rows of worlds with one robot omit it."""
    return {"robots": len(world.robots)} if world.is_fleet else {}


def _json_cell(cell: ComparisonCell, figures: Sequence[PublishedRow]) -> dict[str, Any]:
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
        "published": [_json_figure(cell, figure) for figure in figures],
    }


def _json_figure(cell: ComparisonCell, figure: PublishedRow) -> dict[str, Any]:
    difference = None
    if figure.time is not None and cell.time is not None and not cell.random:
        difference = round(cell.time - figure.time, 9)
    return {
        "time": figure.time,
        "verdict": figure.verdict,
        "motion": figure.motion or None,
        "source": figure.source,
        "note": figure.note,
        "difference": difference,
        "share_no_later": cell.share_until(figure.time)
        if cell.random and figure.time is not None
        else None,
    }


def _json_total(total: Total) -> dict[str, Any]:
    figures = asdict(total)
    return {"controller": figures.pop("label"), **figures}


def _json_agreement(agreed: Agreement) -> dict[str, Any]:
    far = agreed.largest
    return {
        "same_ranking": list(agreed.rankings),
        "never": list(agreed.never),
        "within_middle_95": list(agreed.within),
        "largest_deviation": None
        if far is None
        else {
            "world": far.world,
            "controller": far.label,
            "ours": far.ours,
            "published": far.theirs,
            "relative": far.relative if math.isfinite(far.relative) else None,
        },
    }
