"""Draw a comparison as one picture: every world with every controller's path."""

from __future__ import annotations

from sim.compare.comparison import Comparison, ComparisonCell
from sim.compare.report import describe_outcome
from sim.controllers.catalogue import CONTROLLERS
from sim.drawing.picture import trails_of
from sim.episode import simulate
from sim.verdict import ARRIVALS
from worldgen.render import Panel, Trail, draw_sheet
from worldgen.world import World

MAX_CONTROLLERS = 8
_LONGEST_LABEL = 18
# Limit on the drawn steps of a run that does not arrive. More of its path would only blacken the
# picture.
_MOST_STEPS = 20_000


def draw_comparison(comparison: Comparison) -> bytes:
    """Draw the worlds side by side; return the bytes of a PNG file.

    For a random controller, the run with the median time is drawn, or the first if none arrives.

    Raises:
        InvalidParameter: If there are more than :data:`MAX_CONTROLLERS`, which could not be
            distinguished in a picture.
    """
    panels = []
    for world, cells in zip(comparison.worlds, comparison.cells, strict=True):
        trails = tuple(_way(world.world, cell) for cell in cells)
        notes = tuple(f"{_short(cell.label)}: {describe_outcome(cell, ' s')}" for cell in cells)
        panels.append(Panel(world.world, world.name, trails, notes))
    return draw_sheet(panels, comparison.labels)


def _short(label: str) -> str:
    """Return a label short enough to leave space for the outcome after it."""
    return label if len(label) <= _LONGEST_LABEL else f"{label[: _LONGEST_LABEL - 1]}\u2026"


def _way(world: World, cell: ComparisonCell) -> list[Trail]:
    shown = cell.shown
    steps = shown.steps if shown.verdict in ARRIVALS else min(shown.steps, _MOST_STEPS)
    if steps < 1:
        return []
    options = cell.scenario.with_run(seed=shown.seed).options(world, steps)
    return trails_of(
        simulate(world, CONTROLLERS.get(cell.scenario.controller), options, record=True), world
    )
