"""What pictures consist of: ``marks.json``, which Python's pictures and the pages' scripts both read.

It holds the colours by name, light and dark; the colour and the sign of each verdict; and the
marks, the lowest first, each with its label in a legend. ``python -m build_tools.page_marks`` turns
it into a style and a module for the pages.

Source of the hues: Masataka Okabe, Kei Ito, "Color Universal Design: How to make figures and
    presentations that are friendly to colorblind people", 2008; darkened until lines have a
    contrast of 3 to 1 to the floor and words one of 4.5 to 1 to the page.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import MappingProxyType

import msgspec

from worldgen.render.primitives import Paint


class Mark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How one kind of mark looks; lengths are in units, pixels of a picture of the usual size.

    Args:
        colour: Name of its colour; of several robots each has its own instead.
        label: Its words in a legend; empty for a mark that explains itself.
        width: Width of its line.
        dash: Lengths drawn and skipped; empty for a solid line.
        opacity: Of its line, 0 to 1.
        casing: Width of the light line below, which keeps it visible on walls and other lines.
        fill: Opacity of its inside, 0 to 1.
        size: Least radius, length of an arrow head, distance of stripes, or height of type.
        fade: Opacities along a path, in the direction of driving.
        on_cards: Whether small pictures show it.
    """

    colour: str
    label: str = ""
    width: float = 0.0
    dash: tuple[float, ...] = ()
    opacity: float = 1.0
    casing: float = 0.0
    fill: float = 0.0
    size: float = 0.0
    fade: tuple[float, ...] = ()
    on_cards: bool = True

    def line(self, unit: float, colour: str = "") -> Paint:
        """Return its line, perhaps in another ``colour`` than its own."""
        return Paint(
            stroke=colour or hue(self.colour),
            width=self.width * unit,
            opacity=self.opacity,
            dash=tuple(length * unit for length in self.dash),
        )

    @property
    def full_tint(self) -> str:
        """The floor where the mark is strongest."""
        return mix(hue("floor"), hue(self.colour), self.fill)

    def inside(self, colour: str = "") -> Paint:
        """Return its inside."""
        return Paint(fill=colour or hue(self.colour), opacity=self.fill)

    def lines(self, unit: float, colour: str = "") -> tuple[Paint, ...]:
        """Return its line above its casing, the lowest first."""
        if not self.casing:
            return (self.line(unit, colour),)
        below = Paint(stroke=hue("floor"), width=self.casing * unit, opacity=0.8)
        return below, self.line(unit, colour)


class Card(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a small picture shows of a large world.

    Args:
        side: Its usual side, px.
        robot: Diameter of the robot, px, below which the picture shows a part of the world only.
        around: Radii of the robot to show around what happens.
        small: Share of the longer side of a world below which a picture of what happens replaces
            one of all of it.
    """

    side: float
    robot: float
    around: float
    small: float


class Specification(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The contents of ``marks.json``.

    Args:
        colours: By name, ``#rrggbb`` in a light and in a dark theme.
        verdicts: By verdict, the name of its colour, and its sign.
        series: Names of the colours of several controllers in one world.
        blues: The steps of the signal, the strongest first, in a terminal of 256 colours.
        card: What a small picture shows.
        legend: The names of the marks in a legend, in its order.
        marks: By name, the lowest first.
    """

    colours: dict[str, tuple[str, str]]
    verdicts: dict[str, tuple[str, str]]
    series: list[str]
    blues: list[str]
    card: Card
    legend: list[str]
    marks: dict[str, Mark]


SPECIFICATION = msgspec.json.decode(
    Path(__file__).with_name("marks.json").read_bytes(), type=Specification
)
LIGHT, DARK = 0, 1
MARKS = MappingProxyType(SPECIFICATION.marks)


def hue(name: str, theme: int = LIGHT) -> str:
    """Return a colour by name, ``#rrggbb``; pictures in files are for paper, and so light."""
    return SPECIFICATION.colours[name][theme]


@cache
def robot_colours() -> tuple[str, ...]:
    """Return the colours of several robots in one world; after the last comes the first again."""
    return tuple(hue(name) for name in SPECIFICATION.colours if name.startswith("robot-"))


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of ``#rrggbb``."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def mix(first: str, second: str, share: float) -> str:
    """Mix ``share`` (0 to 1) of the second colour into the first."""
    parts = (round(a + (b - a) * share) for a, b in zip(rgb(first), rgb(second), strict=True))
    return "#" + "".join(f"{part:02x}" for part in parts)


def darker(colour: str, share: float = 0.4) -> str:
    """Return a colour with less light, for what must stand out from a line in it."""
    return "#" + "".join(f"{round(part * (1.0 - share)):02x}" for part in rgb(colour))
