"""Counts for each radius, with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from worldgen.interop.census.radius import Radius
from worldgen.interop.census.take import Census, CensusCase
from worldgen.reach import BLOCKED, REACHABLE
from worldgen.support.intervals import interval_95

__all__ = ["ROWS", "Tally", "tally"]

ROWS = {
    "reachable": "reachable for the disc",
    "blocked": "blocked for the disc",
    "no_room": "  no room for it at the start or the target",
    "four_only": "  4-connected path on the grid all the same",
    "four_parted": "    with room at both ends",
    "eight_only": "  8-connected path on the grid all the same",
    "eight_parted": "    with room at both ends",
    "undecided": "undecided, or certificate refused",
    "costmap_wrong_yes": "costmap inflation: a path, wrongly",
    "costmap_wrong_no": "costmap inflation: no path, wrongly",
    "square_wrong_yes": "square inflation: a path, wrongly",
    "square_wrong_no": "square inflation: no path, wrongly",
}
"""What is counted, as the table calls it; indented where it is part of the line above."""


@dataclass(frozen=True)
class Tally:
    """What holds of all questions at one radius.

    Args:
        asked: The radius.
        questions: How many.
        counts: By the names of :data:`ROWS`.
        radius: Smallest and largest, m.
        radius_in_cells: Likewise, cells.
        seconds: That prover and checker took.
    """

    asked: Radius
    questions: int
    counts: dict[str, int]
    radius: tuple[float, float]
    radius_in_cells: tuple[float, float]
    seconds: float

    def share(self, name: str) -> float | None:
        """Of all questions, or None where there are none."""
        return self.counts[name] / self.questions if self.questions else None

    def interval(self, name: str) -> tuple[float, float]:
        """95 %, Clopper and Pearson."""
        return interval_95(self.counts[name], self.questions) if self.questions else (0.0, 1.0)


def tally(census: Census) -> tuple[Tally, ...]:
    """One for each radius, in the order in which they were asked for."""
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
    """The lines that a question belongs to."""
    grid = question.grid
    if not question.proved:
        return ["undecided"]
    if question.result == REACHABLE:
        wrong = {"costmap_wrong_no": not grid.costmap, "square_wrong_no": not grid.square}
        return ["reachable", *(name for name, holds in wrong.items() if holds)]
    holding = {
        "no_room": not question.room,
        "four_only": grid.four,
        "four_parted": grid.four and question.room,
        "eight_only": grid.eight,
        "eight_parted": grid.eight and question.room,
        "costmap_wrong_yes": grid.costmap,
        "square_wrong_yes": grid.square,
    }
    return [BLOCKED, *(name for name, holds in holding.items() if holds)]
