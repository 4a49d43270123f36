"""Paths and rectangles of SVG as lines.

Source: W3C, "Scalable Vector Graphics (SVG) 2", 2018, chapters 9 and 10.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from worldgen.errors import FormatError
from worldgen.interop.geometry.drawing import TURN, arc_points
from worldgen.interop.readers.svg_values import NUMBER, attribute_text
from worldgen.interop.readers.xml_tree import XmlElement
from worldgen.support.arrays import Floats

_CURVE = TURN // 8
_FLAGS = re.compile(r"\s*+,?+\s*+([01])")
_ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}


def rectangle_lines(element: XmlElement, number: dict[str, float]) -> list[tuple[Floats, bool]]:
    """Return the outline of a ``<rect>``, whose corners may be round, as closed lines."""
    x, y, width, height = (number[name] for name in ("x", "y", "width", "height"))
    if width <= 0 or height <= 0:
        return []
    given = [element.attributes.peek(name) not in (None, "auto") for name in ("rx", "ry")]
    rx, ry = number["rx"] if given[0] else number["ry"], number["ry"] if given[1] else number["rx"]
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    if rx <= 0 or ry <= 0:
        return [(np.array(corners), True)]
    centres = [
        (x + rx, y + ry),
        (x + width - rx, y + ry),
        (x + width - rx, y + height - ry),
        (x + rx, y + height - ry),
    ]
    quarters = [
        arc_points(centre, (rx, ry), 0.0, math.pi + at * math.pi / 2, math.pi / 2)
        for at, centre in enumerate(centres)
    ]
    return [(np.vstack(quarters), True)]


def path_lines(element: XmlElement) -> Iterator[tuple[Floats, bool]]:
    """Yield the subpaths of path data, and whether each is closed.

    Like a browser, this draws a path up to its first error.
    """
    text = attribute_text(element, "d")
    if re.search(r"nan|inf", text, re.IGNORECASE):
        raise FormatError(
            "not-a-number",
            "a path has a coordinate that is not a number",
            "delete it",
            line=element.line,
        )
    line: list[Any] = []
    here = np.zeros(2)
    begin = np.zeros(2)
    control: Any = None
    previous = ""
    for command, values in _commands(text):
        kind = command.upper()
        base = here if command.islower() else np.zeros(2)
        if kind == "M":
            if line:
                yield np.vstack(line), False
            here = begin = base + values
            line = [here]
        elif kind == "Z":
            if line:
                yield np.vstack(line), True
            here, line = begin, []
        else:
            line = line or [here]
            if kind == "H":
                end = np.array([base[0] + values[0], here[1]])
                points: Any = [end]
            elif kind == "V":
                end = np.array([here[0], base[1] + values[0]])
                points = [end]
            elif kind == "A":
                end = base + values[5:]
                points = _svg_arc(here, end, values)
            else:
                given = [base + values[at : at + 2] for at in range(0, len(values), 2)]
                if kind in ("S", "T"):
                    kinds = ("C", "S") if kind == "S" else ("Q", "T")
                    given = [2 * here - control if previous in kinds else here, *given]
                end = given[-1]
                if kind == "L":
                    points = [end]
                else:
                    control = given[-2]
                    points = _bezier([here, *given])
            line.extend(points)
            here = end
        previous = kind
    if line:
        yield np.vstack(line), False


def _commands(text: str) -> Iterator[tuple[str, Any]]:
    """Yield the commands of path data with their numbers, up to the first error."""
    at = 0
    command = ""
    space = re.compile(r"[\s,]*")
    while True:
        at = space.match(text, at).end()  # type: ignore[union-attr]
        if at >= len(text):
            return
        if text[at].upper() in _ARGUMENTS:
            command = text[at]
            at += 1
            if command in "Zz":
                yield command, np.zeros(0)
                continue
        elif command in ("", "Z", "z"):
            return
        values = []
        for index in range(_ARGUMENTS[command.upper()]):
            # Flags of an arc may be written without a space between them.
            pattern = _FLAGS if command in "Aa" and index in (3, 4) else NUMBER
            if pattern is NUMBER:
                at = space.match(text, at).end()  # type: ignore[union-attr]
            match = pattern.match(text, at)
            if match is None:
                return
            values.append(float(match[match.lastindex or 0]))
            at = match.end()
        yield command, np.array(values)
        # More pairs after a move are lines.
        command = {"M": "L", "m": "l"}.get(command, command)


def _bezier(points: list[Any]) -> list[Any]:
    share = np.linspace(0.0, 1.0, _CURVE + 1)[1:, None]
    corners = [np.asarray(point)[None, :] for point in points]
    while len(corners) > 1:
        corners = [a + (b - a) * share for a, b in itertools.pairwise(corners)]
    return list(corners[0])


def _svg_arc(begin: Any, end: Any, values: Any) -> list[Any]:
    """Return the points of an arc after its begin (SVG 2, appendix B.2.4)."""
    rx, ry, degrees, large, sweep = (float(value) for value in values[:5])
    rx, ry = abs(rx), abs(ry)
    if rx == 0 or ry == 0 or (begin == end).all():
        return [end]
    tilt = math.radians(degrees)
    turn = np.array([[math.cos(tilt), math.sin(tilt)], [-math.sin(tilt), math.cos(tilt)]])
    x, y = turn @ ((begin - end) / 2)
    grown = (x / rx) ** 2 + (y / ry) ** 2
    if grown > 1:
        rx, ry = rx * math.sqrt(grown), ry * math.sqrt(grown)
    part = (rx * ry) ** 2 - (rx * y) ** 2 - (ry * x) ** 2
    part = math.sqrt(max(part, 0.0) / ((rx * y) ** 2 + (ry * x) ** 2))
    if bool(large) == bool(sweep):
        part = -part
    middle = np.array([part * rx * y / ry, -part * ry * x / rx])
    first = math.atan2((y - middle[1]) / ry, (x - middle[0]) / rx)
    last = math.atan2((-y - middle[1]) / ry, (-x - middle[0]) / rx)
    angle = last - first
    if sweep and angle < 0:
        angle += math.tau
    if not sweep and angle > 0:
        angle -= math.tau
    centre = turn.T @ middle + (begin + end) / 2
    points = arc_points((centre[0], centre[1]), (rx, ry), tilt, first, angle)
    return [*points[1:-1], end]
