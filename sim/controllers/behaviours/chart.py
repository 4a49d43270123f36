"""Draw how a composition arbitrates, as a flow chart in SVG.

The thesis has such a chart of its arbitrator (section 3.2): triggers are tested in order, and the
first that applies lets its behaviour act.
"""

from __future__ import annotations

import math
import textwrap
from xml.sax.saxutils import escape

from sim.controllers.behaviours.arbitration import ALWAYS, Arbitration, PartFacts

__all__ = ["chart_svg"]

# Sizes in px.
_WIDTH = 860
_MIDDLE = 250
_HALF = 190
_ACTION_LEFT = 520
_ACTION_WIDTH = 310
_LINE = 17
_PAD = 12
_GAP = 30
_TITLE = 24

# Characters that fit on a line of a diamond, and of a box.
_IN_DIAMOND = 30
_IN_BOX = 44

_STYLE = (
    "text{font:13px system-ui,sans-serif;fill:#1b1f24}"
    ".title{font-weight:600;font-size:15px}.name{font-weight:600}.small{font-size:11.5px;fill:#57606a}"
    ".ask{fill:#fff8e5;stroke:#9a6700}.act{fill:#e6f2ff;stroke:#0969da}"
    ".end{fill:#f3f4f6;stroke:#57606a}.flow{stroke:#57606a;fill:none;marker-end:url(#tip)}"
)
_HEAD = (
    '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
    'orient="auto"><path d="M0 0 8 4 0 8z" fill="#57606a"/></marker></defs>'
)


class _Sheet:
    """The shapes so far, and how far down they reach."""

    def __init__(self) -> None:
        self.shapes: list[str] = []
        self.y = float(_PAD)
        self.tail = 0.0  # where the next arrow begins

    def add(self, shape: str) -> None:
        self.shapes.append(shape)

    def text(self, x: float, y: float, words: str, kind: str = "", anchor: str = "middle") -> None:
        self.add(
            f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" class="{kind}">{escape(words)}</text>'
        )

    def lines(self, x: float, top: float, lines: list[tuple[str, str]]) -> None:
        for k, (words, kind) in enumerate(lines):
            self.text(x, top + (k + 0.8) * _LINE, words, kind)

    def box(
        self, x: float, y: float, width: float, lines: list[tuple[str, str]], kind: str
    ) -> float:
        """Draw a box with lines of text; return its height."""
        height = len(lines) * _LINE + 2 * _PAD
        self.add(
            f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" '
            f'class="{kind}"/>'
        )
        self.lines(x + width / 2, y + _PAD, lines)
        return height

    def diamond(self, lines: list[tuple[str, str]]) -> float:
        """Draw a question in the middle column; return its height."""
        height = len(lines) * _LINE + 5 * _PAD
        half = height / 2
        points = (
            f"{_MIDDLE},{self.y:g} {_MIDDLE + _HALF},{self.y + half:g} "
            f"{_MIDDLE},{self.y + height:g} {_MIDDLE - _HALF},{self.y + half:g}"
        )
        self.add(f'<polygon points="{points}" class="ask"/>')
        self.lines(_MIDDLE, self.y + half - len(lines) * _LINE / 2, lines)
        return height

    def flow(self, *corners: tuple[float, float]) -> None:
        path = " ".join(f"{x:g},{y:g}" for x, y in corners)
        self.add(f'<polyline points="{path}" class="flow"/>')

    def svg(self, title: str) -> str:
        height = self.y + _PAD
        body = "\n".join(self.shapes)
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height:g}" '
            f'width="{_WIDTH}" height="{height:g}" role="img">\n<title>{escape(title)}</title>\n'
            f"<style>{_STYLE}</style>{_HEAD}\n"
            f'<rect width="{_WIDTH}" height="{height:g}" fill="#ffffff"/>\n{body}\n</svg>\n'
        )


def chart_svg(arbitration: Arbitration, title: str) -> str:
    """Return the flow chart of one step of a composition, as SVG.

    Args:
        arbitration: The controller's.
        title: Heading of the chart.
    """
    sheet = _Sheet()
    sheet.text(_PAD, sheet.y + _LINE, title, "title", "start")
    sheet.y += _TITLE + _PAD
    height = sheet.box(_MIDDLE - 90, sheet.y, 180, [("each step: observe", "")], "end")
    sheet.y += height
    sheet.tail = sheet.y
    if arbitration.arbiter == "vote":
        _votes(sheet, arbitration)
    else:
        _questions(sheet, arbitration)
    return sheet.svg(title)


def _action(part: PartFacts, name: str, note: str) -> list[tuple[str, str]]:
    """Return the lines of a part's box."""
    lines = [(name, "name")]
    lines += [(line, "") for line in textwrap.wrap(part.action, _IN_BOX)]
    return [*lines, (note, "small")]


def _control(part: PartFacts) -> str:
    """Return in words how long a part keeps control."""
    if math.isinf(part.duration):
        holds = "until it is done"
    elif part.duration <= 1:
        holds = "one step at a time"
    else:
        holds = f"{part.duration:g} steps"
    return f"{holds}; {'can be interrupted' if part.interruptible else 'keeps control'}"


def _arrow_down(sheet: _Sheet, gap: float = _GAP) -> None:
    """Draw the arrow to the next part below."""
    sheet.y += gap
    sheet.flow((_MIDDLE, sheet.tail), (_MIDDLE, sheet.y))


def _box_below(sheet: _Sheet, half: float, lines: list[tuple[str, str]]) -> None:
    _arrow_down(sheet)
    sheet.y += sheet.box(_MIDDLE - half, sheet.y, 2 * half, lines, "end")
    sheet.tail = sheet.y


def _ask(sheet: _Sheet, question: list[tuple[str, str]], answer: list[tuple[str, str]]) -> float:
    """Draw a question below the existing shapes, and to its right the result of answering yes.

    Returns the height of the middle of both.
    """
    box_height = len(answer) * _LINE + 2 * _PAD
    height = len(question) * _LINE + 5 * _PAD

    # A box that is taller than its diamond needs space above it, too.
    above = max(0.0, (box_height - height) / 2)
    _arrow_down(sheet, _GAP + above)
    sheet.diamond(question)
    middle = sheet.y + height / 2
    sheet.box(_ACTION_LEFT, middle - box_height / 2, _ACTION_WIDTH, answer, "act")
    sheet.flow((_MIDDLE + _HALF, middle), (_ACTION_LEFT, middle))
    sheet.text(_MIDDLE + _HALF + 20, middle - 6, "yes", "small")
    sheet.tail = sheet.y + height
    sheet.text(_MIDDLE + 14, sheet.tail + 15, "no", "small")
    sheet.y = sheet.tail + above
    return middle


def _questions(sheet: _Sheet, arbitration: Arbitration) -> None:
    """Draw the triggers one below the other, in the order in which they are tested."""
    keeps = arbitration.arbiter == "learning" or any(
        not part.interruptible for part in arbitration.parts
    )
    if keeps:
        _ask(
            sheet,
            [("is a behaviour in charge", ""), ("that keeps control?", "")],
            [("it acts on", "name"), ("until it is done", "small")],
        )
    order = sorted(range(len(arbitration.parts)), key=lambda k: -arbitration.parts[k].priority)
    if arbitration.arbiter == "learning":
        lines = [
            ("order by the value of each here:", "name"),
            ("good when the signal got stronger,", ""),
            ("bad when a wall was touched", ""),
        ]
        _box_below(sheet, _HALF, lines)
    for k in order:
        part = arbitration.parts[k]
        if part.trigger == ALWAYS and arbitration.arbiter != "learning":
            # Nothing below it ever gets a turn.
            _box_below(sheet, _HALF, _action(part, arbitration.names[k], _control(part)))
            return
        words = [(line, "") for line in textwrap.wrap(f"{part.trigger}?", _IN_DIAMOND)]
        _ask(sheet, words, _action(part, arbitration.names[k], _control(part)))
    _box_below(sheet, 90, [("stand still", "")])


def _votes(sheet: _Sheet, arbitration: Arbitration) -> None:
    """Draw all triggers with their weights, and the sum of their votes below."""
    middles = []
    for k, part in enumerate(arbitration.parts):
        words = [(line, "") for line in textwrap.wrap(f"{part.trigger}?", _IN_DIAMOND)]
        note = f"votes with weight {part.priority:g}"
        middles.append(_ask(sheet, words, _action(part, arbitration.names[k], note)))
    lines = [
        ("drive in the direction with the most votes", "name"),
        ("each part votes for its own and those near it", ""),
    ]
    _box_below(sheet, _HALF, lines)

    # All voting parts lead to the sum.
    right = _ACTION_LEFT + _ACTION_WIDTH
    into = sheet.y - (len(lines) * _LINE + 2 * _PAD) / 2
    for middle in middles:
        sheet.flow(
            (right, middle), (right + 12, middle), (right + 12, into), (_MIDDLE + _HALF, into)
        )
