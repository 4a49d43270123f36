"""The metrics of a world: names, units, and which direction is harder."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final, NamedTuple

# Significant digits of a metric: more than its meaning supports, fewer than a float's last bits.
DIGITS: Final = 6


class Metric(NamedTuple):
    """The definition of a metric.

    Args:
        unit: m, s, rad, rad/m, or nothing.
        harder: 1 if higher values should make a world harder, -1 if lower values should, 0 if
            neither is expected.
        meaning: One line for tables.
        source: Its publication, if it isn't ours.
    """

    unit: str
    harder: int
    meaning: str
    source: str = ""


_BARN = "Perille, Truong, Xiao, Stone, Benchmarking Metric Ground Navigation, 2020"

METRICS: Final = {
    "difficulty": Metric(
        "", 1, "how likely the library's controllers are to fail, by a fitted model, 0 to 1"
    ),
    "length": Metric("m", 1, "length of the witness"),
    "detour": Metric("", 1, "length of the witness over the straight line from start to target"),
    "turns": Metric("rad", 1, "all turning along the witness"),
    "turning": Metric("rad/m", 1, "turning over the straight line from start to target"),
    "bottleneck": Metric("m", -1, "radius of the largest disc that could pass at all"),
    "bottleneck_radii": Metric("", -1, "the same, in robot radii"),
    "slack": Metric("m", -1, "how far a footprint could be padded all around, along the witness"),
    "concavity": Metric(
        "m", 1, "depth of the deepest pocket that a robot heading for the target enters"
    ),
    "retreat": Metric(
        "m",
        1,
        "detour to places farther from the target than the start, which every path has to make",
    ),
    "tortuosity": Metric(
        "", 1, "length of the witness over the straight line between its ends", _BARN
    ),
    "solid": Metric("", 0, "share of the cells that are solid at time 0"),
    "duration": Metric("s", 1, "time at which the witness arrives"),
    "waiting": Metric("s", 1, "time for which the witness stands still"),
    "margin": Metric("s", -1, "time by which the witness may begin later"),
    "changing": Metric("", 1, "share of the cells that change with time"),
    "robots": Metric("", 1, "number of robots, if there are several"),
}
"""Every metric by name, in table order."""

OF_DISCS: Final = frozenset(
    {"difficulty", "bottleneck", "bottleneck_radii", "concavity", "retreat"}
)
"""Metrics that only say something about a disc that turns on the spot."""

OF_MAPS: Final = frozenset({"solid", "bottleneck", "bottleneck_radii"})
"""Metrics that a static map has even if no path leads to the target."""


@dataclass(frozen=True)
class Metrics:
    """The difficulty of a world, described in :data:`METRICS` and rounded to :data:`DIGITS` digits.

    A metric that is undefined for the world is None: those along a path if none is known, those
    over the straight line if start and target coincide. For a robot that is not a disc turning on
    the spot, those of :data:`OF_DISCS` are; a footprint has a slack instead.
    """

    difficulty: float | None = None
    length: float | None = None
    detour: float | None = None
    turns: float | None = None
    turning: float | None = None
    bottleneck: float | None = None
    bottleneck_radii: float | None = None
    slack: float | None = None
    concavity: float | None = None
    retreat: float | None = None
    tortuosity: float | None = None
    solid: float | None = None
    duration: float | None = None
    waiting: float | None = None
    margin: float | None = None
    changing: float | None = None
    robots: float | None = None

    def as_dict(self) -> dict[str, float]:
        """Return the metrics that have a value, by name, in table order."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


def rounded(value: float) -> float:
    """Round to :data:`DIGITS` significant digits, the same on every machine; no minus zero."""
    return float(f"{value:.{DIGITS}g}") + 0.0
