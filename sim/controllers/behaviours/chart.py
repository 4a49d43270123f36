"""Draw how a controller arbitrates, as a flow chart of one step.

The thesis has such a chart of its arbitrator (section 3.2): triggers are tested in order, and the
first that applies lets its behaviour act. A chart is a list of shapes, which ``chart_svg`` writes
to a file and the studio's page draws in its own colours.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.sax.saxutils import escape, quoteattr

from sim.controllers.behaviours.arbitration import ALWAYS, Arbitration, PartFacts, sentences
from worldgen.render.marks import hue, mix

# Sizes in px. Questions are in the left column, and the behaviours in the right one.
_WIDTH = 450
_MIDDLE = 104
_HALF = 96
_TIP = 16
_ACTION_LEFT = 232
_ACTION_WIDTH = 196
_LINE = 16
_PAD = 8
_GAP = 22

# Characters that fit on a line of a question, of a box, and in small letters.
_IN_QUESTION = 23
_IN_BOX = 27
_IN_NOTE = 32

_PAPER = hue("paper")
_STYLE = (
    f"text{{font:13px system-ui,sans-serif;fill:{hue('ink')}}}"
    f".name{{font-weight:600}}.small{{font-size:11.5px;fill:{hue('quiet')}}}"
    f".ask{{fill:{mix(_PAPER, hue('named'), 0.15)};stroke:{hue('burn')}}}"
    f".act{{fill:{mix(_PAPER, hue('target'), 0.1)};stroke:{hue('target')}}}"
    f".end{{fill:{hue('panel')};stroke:{hue('quiet')}}}"
    f".flow{{stroke:{hue('quiet')};fill:none}}.tip{{fill:{hue('quiet')}}}"
)


class ChartShape(NamedTuple):
    """An element of the chart.

    Args:
        tag: ``rect``, ``polygon``, ``polyline`` or ``text``.
        attributes: Its attributes; ``class`` names its kind, and ``data-part`` the behaviour of
            which it is the box.
        text: Its text, if it has one.
    """

    tag: str
    attributes: dict[str, str]
    text: str = ""


Lines = list[tuple[str, str]]


@dataclass
class Chart:
    """A flow chart.

    Args:
        shapes: In the order in which they are drawn.
        height: px; the width is always :attr:`width`.
    """

    shapes: list[ChartShape] = field(default_factory=list)
    height: float = float(_PAD)
    width: float = _WIDTH
    tail: float = 0.0  # where the next arrow begins

    def add(self, tag: str, kind: str, text: str = "", **attributes: str | float) -> None:
        """Add a shape of some kind."""
        written = {
            name.replace("_", "-"): value if isinstance(value, str) else f"{value:g}"
            for name, value in attributes.items()
        }
        self.shapes.append(ChartShape(tag, {"class": kind, **written}, text))

    def lines(self, x: float, top: float, lines: Lines) -> None:
        """Write lines of text, each with its kind, below each other."""
        for k, (words, kind) in enumerate(lines):
            self.add("text", kind, words, x=x, y=top + (k + 0.78) * _LINE, text_anchor="middle")

    def box(self, x: float, y: float, width: float, lines: Lines, part: str = "") -> float:
        """Draw a box with lines of text, of a behaviour or of something else; return its height."""
        height = len(lines) * _LINE + 2 * _PAD
        whose = {"data_part": part} if part else {}
        kind = "act" if part else "end"
        self.add("rect", kind, x=x, y=y, width=width, height=height, rx=6, **whose)
        self.lines(x + width / 2, y + _PAD, lines)
        return height

    def flow(self, *corners: tuple[float, float]) -> None:
        """Draw an arrow, whose last part is level or leads down."""
        path = " ".join(f"{x:g},{y:g}" for x, y in corners)
        self.add("polyline", "flow", points=path)
        x, y = corners[-1]
        before = corners[-2][0]
        if before == x:
            tip = f"{x - 3:g},{y - 7:g} {x + 3:g},{y - 7:g} {x:g},{y:g}"
        else:
            back = -7 if before < x else 7
            tip = f"{x + back:g},{y - 3:g} {x + back:g},{y + 3:g} {x:g},{y:g}"
        self.add("polygon", "tip", points=tip)

    def down(self, gap: float = _GAP) -> None:
        """Draw the arrow to the next shape below."""
        self.height += gap
        self.flow((_MIDDLE, self.tail), (_MIDDLE, self.height))

    def below(self, half: float, lines: Lines, part: str = "") -> None:
        """Draw a box below the existing shapes."""
        self.down()
        self.height += self.box(_MIDDLE - half, self.height, 2 * half, lines, part)
        self.tail = self.height

    def ask(self, question: str, answer: Lines, part: str = "") -> float:
        """Draw a question below the existing shapes, and to its right the result of answering yes.

        Returns:
            The height of the middle of both.
        """
        lines = [(line, "") for line in textwrap.wrap(f"{question}?", _IN_QUESTION)]
        height = len(lines) * _LINE + 3 * _PAD
        box_height = len(answer) * _LINE + 2 * _PAD

        # A box that is taller than its question needs space above it, too.
        above = max(0.0, (box_height - height) / 2)
        self.down(_GAP + above)
        top = self.height
        middle = top + height / 2
        left = _MIDDLE - _HALF
        right = _MIDDLE + _HALF
        corners = (
            (left, middle),
            (left + _TIP, top),
            (right - _TIP, top),
            (right, middle),
            (right - _TIP, top + height),
            (left + _TIP, top + height),
        )
        self.add("polygon", "ask", points=" ".join(f"{x:g},{y:g}" for x, y in corners))
        self.lines(_MIDDLE, middle - len(lines) * _LINE / 2, lines)
        self.box(_ACTION_LEFT, middle - box_height / 2, _ACTION_WIDTH, answer, part)
        self.flow((right, middle), (_ACTION_LEFT, middle))
        self.add("text", "small", "yes", x=right + 4, y=middle - 5)
        self.tail = top + height
        self.add("text", "small", "no", x=_MIDDLE + 8, y=self.tail + 13)
        self.height = self.tail + above
        return middle


def chart_of(arbitration: Arbitration) -> Chart:
    """Return the flow chart of one step of a controller."""
    chart = Chart()
    chart.height += chart.box(_MIDDLE - 75, chart.height, 150, [("each step: observe", "")])
    chart.tail = chart.height
    if arbitration.arbiter == "vote":
        _votes(chart, arbitration)
    else:
        _questions(chart, arbitration)
    chart.height += _PAD
    return chart


def chart_svg(arbitration: Arbitration, title: str) -> str:
    """Return the flow chart as an SVG file, with the same in words as its description.

    Args:
        arbitration: The controller's.
        title: Title of the picture.
    """
    chart = chart_of(arbitration)
    body = "\n".join(
        f"<{tag} {' '.join(f'{name}={quoteattr(value)}' for name, value in attributes.items())}>"
        f"{escape(text)}</{tag}>"
        for tag, attributes, text in chart.shapes
    )
    size = f'width="{chart.width:g}" height="{chart.height:g}"'
    words = "\n".join((f"by {arbitration.arbiter}", *sentences(arbitration)))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {chart.width:g} {chart.height:g}" '
        f'{size} role="img">\n<title>{escape(title)}</title>\n<desc>{escape(words)}</desc>\n'
        f'<style>{_STYLE}</style>\n<rect {size} fill="{_PAPER}"/>\n{body}\n</svg>\n'
    )


def _action(part: PartFacts, name: str, note: str) -> Lines:
    """Return the lines of a part's box."""
    lines = [(name, "name")]
    lines += [(line, "") for line in textwrap.wrap(part.action, _IN_BOX)]
    return [*lines, *((line, "small") for line in textwrap.wrap(note, _IN_NOTE))]


def _questions(chart: Chart, arbitration: Arbitration) -> None:
    """Draw the triggers one below the other, in the order in which they are tested."""
    learns = arbitration.arbiter == "learning"
    if learns or any(not part.interruptible for part in arbitration.parts):
        chart.ask(
            "is a behaviour in charge that keeps control",
            [("it continues", "name"), ("until it is done", "small")],
        )
    if learns:
        lines = [
            ("order by value here:", "name"),
            ("good if the signal got", ""),
            ("stronger, bad if a wall", ""),
            ("was touched", ""),
        ]
        chart.below(_HALF, lines)
    order = sorted(range(len(arbitration.parts)), key=lambda k: -arbitration.parts[k].priority)
    for k in order:
        part = arbitration.parts[k]
        name = arbitration.names[k]
        lines = _action(part, name, part.control)
        if part.trigger == ALWAYS and not learns:
            # The parts below it never get a turn.
            chart.below(_HALF, lines, name)
            return
        chart.ask(part.trigger, lines, name)
    chart.below(75, [("stand still", "")])


def _votes(chart: Chart, arbitration: Arbitration) -> None:
    """Draw all triggers with their weights, and the sum of their votes below."""
    middles = []
    for k, part in enumerate(arbitration.parts):
        name = arbitration.names[k]
        lines = _action(part, name, f"votes with weight {part.priority:g}")
        middles.append(chart.ask(part.trigger, lines, name))
    lines = [
        ("take the direction", "name"),
        ("with the most votes", "name"),
        ("each part votes for its", ""),
        ("own and those near it", ""),
    ]
    chart.below(_HALF, lines)

    # All voting parts lead to the sum.
    right = _ACTION_LEFT + _ACTION_WIDTH
    into = chart.height - (len(lines) * _LINE + 2 * _PAD) / 2
    for middle in middles:
        chart.flow(
            (right, middle), (right + 12, middle), (right + 12, into), (_MIDDLE + _HALF, into)
        )
