"""The few shapes that every picture is made of. All coordinates are picture pixels, y down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from worldgen.support.arrays import Bools, Floats


@dataclass(frozen=True, slots=True)
class Paint:
    """How a shape looks.

    Args:
        fill: ``#RRGGBB``; ``None`` leaves the inside unfilled.
        stroke: ``#RRGGBB``; ``None`` draws no outline.
        width: Width of the outline, px.
        opacity: 0 (invisible) to 1, of fill and outline together.
        dash: px drawn and px skipped, in turn; empty for a solid line.
    """

    fill: str | None = None
    stroke: str | None = None
    width: float = 1.0
    opacity: float = 1.0
    dash: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class DrawnCircle:
    """A circle; ``clipped`` cuts it off at the edge of the map."""

    x: float
    y: float
    radius: float
    paint: Paint
    clipped: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLine:
    """Straight lines through (n, 2) float64 points, with round joins and ends."""

    points: Floats
    paint: Paint
    closed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class DrawnCells:
    """Whole cells of the map in one colour, where ``mask`` (height, width) bool is set.

    Row 0 is the lowest y.

    Args:
        mask: The cells.
        fill: ``#RRGGBB``.
        opacity: 0 to 1.
        hatch: Distance between diagonal stripes, px; 0 fills the cells.
    """

    mask: Bools
    fill: str
    opacity: float = 1.0
    hatch: float = 0.0


@dataclass(frozen=True, slots=True)
class Glow:
    """The map's floor, tinted by the logarithm of the distance from a point.

    The signal falls with the square of the distance, so equal steps of tint are equal ratios of
    signal.

    Args:
        x: Centre, px.
        y: Centre, px.
        near: Distance with the full tint, px.
        far: Distance without opacity, px.
        inner: ``#RRGGBB`` at ``near``.
        outer: ``#RRGGBB`` at ``far``.
    """

    x: float
    y: float
    near: float
    far: float
    inner: str
    outer: str


@dataclass(frozen=True, slots=True)
class Text:
    """A line of text; ``x`` is its left end, ``y`` its baseline, ``size`` its height, px."""

    x: float
    y: float
    size: float
    text: str
    fill: str


Primitive: TypeAlias = DrawnCircle | DrawnLine | DrawnCells | Glow | Text
