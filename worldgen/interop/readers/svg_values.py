"""Values of SVG's attributes: numbers, lengths, colours and transforms."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import shapely
from PIL import ImageColor

from worldgen.interop.readers.xml_tree import XmlElement

NUMBER = re.compile(r"[-+]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][-+]?\d++)?")
_LENGTH = re.compile(rf"\s*+({NUMBER.pattern})\s*+([a-zA-Z%]*+)\s*+$")
# CSS's pixels of an inch, and the length of each unit in pixels. Plans to scale also use m.
INCH = 96.0
PIXELS = {
    "": 1.0, "px": 1.0, "in": INCH, "cm": INCH / 2.54, "mm": INCH / 25.4, "q": INCH / 101.6,
    "pt": INCH / 72, "pc": INCH / 6, "m": INCH / 0.0254, "ft": INCH * 12,
}  # fmt: skip
ABSOLUTE = ("in", "cm", "mm", "q", "pt", "pc", "m", "ft")
_TRANSFORM = re.compile(r"(?<![a-zA-Z])([a-zA-Z]++)\s*+\(([^()]*+)\)")

Matrix = Any


def attribute_text(element: XmlElement, name: str) -> str:
    """Return an attribute's text; empty if it is missing."""
    return str(element.attributes.peek(name, ""))


def attribute_number(element: XmlElement, name: str) -> float:
    """Return an attribute's length in pixels; 0 if it is missing."""
    value, unit = parsed_length(attribute_text(element, name) or "0")
    return value * PIXELS.get(unit, 1.0)


def all_numbers(text: str) -> list[float]:
    """Return the numbers of a text, whatever is between them."""
    return [float(word) for word in NUMBER.findall(text)]


def parsed_length(text: str) -> tuple[float, str]:
    """Return a number and its unit in lower case; 0 for what is neither."""
    match = _LENGTH.match(text)
    return (float(match[1]), match[2].lower()) if match else (0.0, "")


def parsed_opacity(text: str | None) -> float:
    """Return an opacity from 0 to 1, which is 1 if it is missing."""
    if text is None:
        return 1.0
    value, unit = parsed_length(text)
    return min(max(value / 100 if unit == "%" else value, 0.0), 1.0)


def parsed_colour(word: str) -> tuple[float, float]:
    """Return the luma and the opacity of a colour, 0 to 1; what is unknown is black."""
    match = re.fullmatch(r"rgba?\(([^()]*)\)", word.strip().lower())
    try:
        if match:
            parts = [part for part in re.split(r"[\s,/]+", match[1].strip()) if part]
            levels = [
                float(part[:-1]) / 100
                if part.endswith("%")
                else float(part) / (255 if at < 3 else 1)
                for at, part in enumerate(parts)
            ]
            red, green, blue, *more = levels
            alpha = more[0] if more else 1.0
        else:
            red, green, blue, *rest = (level / 255 for level in ImageColor.getrgb(word.strip()))
            alpha = rest[0] if rest else 1.0
    except ValueError:
        return 0.0, 1.0
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    if not (math.isfinite(luma) and math.isfinite(alpha)):
        return 0.0, 1.0
    return min(max(luma, 0.0), 1.0), min(max(alpha, 0.0), 1.0)


def shift_matrix(x: float, y: float) -> Matrix:
    """Return a shift."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def view_matrix(box: list[float], width: float, height: float, aspect: str) -> Matrix:
    """Return the transform of a view box into a viewport of this size."""
    scales = [width / box[2], height / box[3]]
    words = aspect.split()
    if words[:1] != ["none"]:
        scales = [max(scales) if "slice" in words else min(scales)] * 2
    word = words[0] if words else "xMidYMid"
    shares = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
    free = [width - box[2] * scales[0], height - box[3] * scales[1]]
    x = free[0] * shares.get(word[1:4], 0.5) - box[0] * scales[0]
    y = free[1] * shares.get(word[5:8], 0.5) - box[1] * scales[1]
    return np.array([[scales[0], 0.0, x], [0.0, scales[1], y], [0.0, 0.0, 1.0]])


def transform_matrix(text: str) -> Matrix:
    """Return the matrix of a transform attribute."""
    matrix = np.eye(3)
    for name, words in _TRANSFORM.findall(text):
        values = []
        for number, unit in re.findall(rf"({NUMBER.pattern})\s*([a-zA-Z%]*)", words):
            values.append(
                float(number)
                * (PIXELS.get(unit.lower(), 1.0) if name.startswith("translate") else 1.0)
            )
        kind = name.lower()
        one = np.eye(3)
        if kind == "matrix" and len(values) == 6:
            one[:2] = np.array(values).reshape(3, 2).T
        elif kind in ("translate", "translatex", "translatey") and values:
            x, y = (values[0], values[1] if len(values) > 1 else 0.0)
            one = shift_matrix(*((0.0, x) if kind == "translatey" else (x, y)))
        elif kind == "scale" and values:
            one[0, 0], one[1, 1] = values[0], values[-1]
        elif kind in ("scalex", "scaley") and values:
            one["xy".index(kind[-1]), "xy".index(kind[-1])] = values[0]
        elif kind == "rotate" and values:
            one = _rotation(values[0])
            if len(values) == 3:
                one = shift_matrix(*values[1:]) @ one @ shift_matrix(-values[1], -values[2])
        elif kind == "skewx" and values:
            one[0, 1] = math.tan(math.radians(values[0]))
        elif kind == "skewy" and values:
            one[1, 0] = math.tan(math.radians(values[0]))
        matrix = matrix @ one
    return matrix


def _rotation(degrees: float) -> Matrix:
    """Return a rotation, exact for quarter turns."""
    quarters = degrees / 90.0
    if quarters.is_integer():
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    else:
        cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def placed(shape: Any, matrix: Matrix) -> Any:
    """Return a shape after a transform."""
    if (matrix == np.eye(3)).all():
        return shape
    with np.errstate(all="ignore"):
        return shapely.transform(shape, lambda xy: xy @ matrix[:2, :2].T + matrix[:2, 2])
