"""Summarise the searches of :mod:`benchmarks.finding` in the tables of the documentation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median
from typing import Any

# Wall seconds on two cores; a find within this many CPU seconds is also within this time.
_FLOOR_SECONDS = 60.0


def summary(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return, per searcher, the share found and quartiles over all searches.

    A search without a find counts as endless.
    """
    found = []
    for name in _searchers(rows):
        own = [row for row in rows if row["searcher"] == name]
        hits = [row for row in own if row["found"]]
        entry: dict[str, Any] = {"searcher": name, "searches": len(own), "found": len(hits)}
        # Count distinct faults as well: ten searches for one fault prove little.
        entry["faults"] = len({row["fault"] for row in hits})
        entry["in_60_s"] = sum(row["seconds"] <= _FLOOR_SECONDS for row in hits)
        for what in ("worlds", "steps", "seconds"):
            # A search without a find counts as infinitely long.
            entry[what] = _quartiles([row[what] if row["found"] else math.inf for row in own])
        entry["solid_cells"] = _quartiles([row["solid_cells"][1] for row in hits])
        entry["shrink_ms"] = _quartiles([1000 * row["shrink_seconds"] for row in hits])
        entry["one_minimal"] = sum(row["one_minimal"] for row in hits)
        entry["checked"] = sum(not row["removable"] for row in hits)
        found.append(entry)
    return found


def _quartiles(values: Sequence[float]) -> list[float | None]:
    """Return lower quartile, median and upper quartile, each one of the values.

    They are ``None`` if endless or missing.
    """
    ranked = sorted(values)
    picked = (
        [ranked[math.ceil(len(ranked) * share) - 1] for share in (0.25, 0.5, 0.75)]
        if ranked
        else [math.inf] * 3
    )
    return [round(value, 3) if value < math.inf else None for value in picked]


def tables(rows: Sequence[dict[str, Any]]) -> str:
    """Return the two tables of ``docs/explanation/search.md``: by searcher, and by fault."""
    columns = (
        "found",
        "worlds",
        "thousand steps",
        "CPU s",
        "solid cells, shrunk",
        "1-minimal",
        "shrink, ms",
    )
    lines = [f"| searcher | {' | '.join(columns)} |", "| --- |" + " ---: |" * len(columns)]
    for entry in summary(_done_by_all(rows)):
        thousands = [value / 1000 if value is not None else None for value in entry["steps"]]
        cells = (
            f"{entry['found']} of {entry['searches']}",
            _span(entry["worlds"]), _span(thousands), _span(entry["seconds"]), _span(entry["solid_cells"]),
            f"{entry['one_minimal']} ({entry['checked']})", _span(entry["shrink_ms"]),
        )  # fmt: skip
        lines.append(f"| `{entry['searcher']}` | {' | '.join(cells)} |")
    searchers = _searchers(rows)
    lines += [
        "",
        "| fault | " + " | ".join(searchers) + " |",
        "| --- |" + " ---: |" * len(searchers),
    ]
    for fault in dict.fromkeys(row["fault"] for row in rows):
        cells = tuple(
            _cell([row for row in rows if (row["fault"], row["searcher"]) == (fault, s)])
            for s in searchers
        )
        lines.append(f"| `{fault}` | {' | '.join(cells)} |")
    return "\n".join(lines)


def _done_by_all(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the searches that every searcher has done.

    A table made in pieces may not be complete yet.
    """
    done = {
        name: {(row["fault"], row["seed"]) for row in rows if row["searcher"] == name}
        for name in _searchers(rows)
    }
    return [row for row in rows if all((row["fault"], row["seed"]) in own for own in done.values())]


def _searchers(rows: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(row["searcher"] for row in rows))


def _cell(rows: Sequence[dict[str, Any]]) -> str:
    """Return the median worlds to the find, and how many searches found it if not all did.

    The text is empty if none was done.
    """
    hits = [row["worlds"] for row in rows if row["found"]]
    if not hits:
        return "not found" if rows else ""
    return f"{median(hits):.0f}" + (
        f" ({len(hits)} of {len(rows)})" if len(hits) < len(rows) else ""
    )


def _span(three: Sequence[float | None]) -> str:
    low, middle, high = ("-" if value is None else f"{value:.3g}" for value in three)
    return f"{middle} ({low} to {high})"
