"""Read SVG as a drawing: what is drawn dark is a wall, what is drawn in white is floor.

Source: W3C, "Scalable Vector Graphics (SVG) 2", 2018, chapters 5 to 10 and 13; "CSS Transforms
    Module Level 1", 2019.
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import shapely

from worldgen.errors import FormatError
from worldgen.interop.format.foreign_map import ForeignMap, read_bounded
from worldgen.interop.geometry.drawing import (
    NO_LAYER,
    UNITS,
    Drawing,
    arc_points,
    check_crossings,
    filled,
    finite,
    too_large,
)
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.interop.readers.plan_facts import OwnPlan, own_map, own_plan
from worldgen.interop.readers.svg_paths import path_lines, rectangle_lines
from worldgen.interop.readers.svg_styles import INHERITED, PROPERTIES, css_rules, declarations
from worldgen.interop.readers.svg_values import (
    ABSOLUTE,
    INCH,
    PIXELS,
    Matrix,
    all_numbers,
    attribute_number,
    attribute_text,
    parsed_colour,
    parsed_length,
    parsed_opacity,
    placed,
    shift_matrix,
    transform_matrix,
    view_matrix,
)
from worldgen.interop.readers.xml_tree import XmlElement, parse_xml
from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Floats

_MOST_VISITS = 200_000
# Visits of elements that <use> copies.
_MOST_COPIES = 20_000
_MOST_CLIPS = 5_000
_MOST_RULES = 3_000
_MOST_DEPTH = 60
_GROUPS = ("svg", "g", "a", "switch", "symbol")
# Shown only where something uses them, or never.
_UNSHOWN = {
    "defs", "symbol", "clipPath", "mask", "marker", "pattern", "linearGradient", "radialGradient",
    "filter", "title", "desc", "metadata", "style", "script", "view", "cursor", "font", "font-face",
    "color-profile", "animate", "animateTransform", "animateMotion", "animateColor", "set",
    "meshgradient", "hatch", "solidcolor", "solidColor",
    "text", "textPath", "tspan",  # names of rooms and measures, not walls
}  # fmt: skip
_MOVES = {"animate", "animateTransform", "animateMotion", "set"}
# Our own plans show the robot and its target, too.
_OWN_MARKS = frozenset({"target", "robot", "heading", "witness"})


@dataclass(frozen=True)
class _Style:
    """The properties of an element, with those that it inherits, and its place."""

    values: dict[str, str]
    opacity: float = 1.0
    matrix: Matrix = field(default_factory=lambda: np.eye(3))
    clip: Any = None
    layers: tuple[str, ...] = ()


@dataclass
class _Rule:
    """One selector of a style sheet."""

    selector: tuple[str, str, tuple[str, ...]]
    weight: tuple[int, int, int]
    values: dict[str, str]
    important: dict[str, str]


class _Reader:
    """Walks over a file's elements, and adds what they draw."""

    def __init__(self, root: XmlElement, threshold: float) -> None:
        self.root = root
        self.drawing = Drawing(guesses=(1.0, 0.01))
        self.threshold = threshold
        self.by_id: dict[str, XmlElement] = {}
        self.rules: list[_Rule] = []
        self.visits = 0
        self.copies = 0
        self.uses = 0
        self.clips = 0
        self.clipping: list[XmlElement] = []
        self.dashed = 0
        self.is_own = False
        self.page_scale = 1.0

    # Style

    def collect(self) -> None:
        """Find the elements by id, and the rules of style sheets."""
        waiting = [self.root]
        while waiting:
            element = waiting.pop()
            element.name = element.name.removeprefix("svg:")
            name = element.attributes.peek("id")
            if name:
                self.by_id.setdefault(str(name), element)
            if element.name == "style":
                self._read_sheet(element)
            waiting.extend(reversed(element.children))

    def _read_sheet(self, element: XmlElement) -> None:
        # Programs ignore style sheets in another language.
        if attribute_text(element, "type").strip().lower() not in ("", "text/css"):
            return
        is_limited = attribute_text(element, "media").strip().lower() not in ("", "all", "screen")
        for selectors, body in css_rules(element.text):
            if selectors.lower().startswith("@import"):
                self.drawing.unread("imports of style sheets", ())
                continue
            values = declarations(re.sub("[{}]", ";", body))
            if is_limited or selectors.startswith("@") or "{" in body:
                if any(values):
                    self.drawing.unread("rules of <style> under a condition", ())
                continue
            # A selector that is wrong spoils the rule.
            parts = selectors.split(",")
            for selector in parts if all(map(str.strip, parts)) else ():
                match = re.fullmatch(r"\s*([\w*-]*)((?:[.#][\w-]+)*)\s*", selector)
                if match is None:
                    if any(values):
                        self.drawing.unread("rules of <style> for elements inside others", ())
                    continue
                names = re.findall(r"[.#][\w-]+", match[2])
                ids = [name[1:] for name in names if name[0] == "#"]
                classes = tuple(name[1:] for name in names if name[0] == ".")
                kind = "" if match[1] == "*" else match[1].removeprefix("svg|")
                self.rules.append(
                    _Rule(
                        (kind, ids[0] if ids else "", classes),
                        (len(ids), len(classes), int(bool(kind))),
                        *values,
                    )
                )
        if len(self.rules) > _MOST_RULES:
            raise FormatError(
                "too-large",
                "has more than {most:,} rules in <style>",
                "save it with presentation attributes",
                most=_MOST_RULES,
                line=element.line,
            )
        self.rules.sort(key=lambda rule: rule.weight)

    def own_values(self, element: XmlElement) -> dict[str, str]:
        """Return the properties of an element: attributes, style sheets, and its own style."""
        attributes = element.attributes
        values = {
            name: str(attributes.peek(name)).strip() for name in attributes if name in PROPERTIES
        }
        classes = set(str(attributes.peek("class", "")).split())
        important: dict[str, str] = {}
        for rule in self.rules:
            kind, name, needed = rule.selector
            if (
                kind in ("", element.name)
                and name in ("", attributes.peek("id"))
                and classes.issuperset(needed)
            ):
                values.update(rule.values)
                important.update(rule.important)
        own, own_important = declarations(str(attributes.peek("style", "")))
        return {**values, **own, **important, **own_important}

    def style(self, element: XmlElement, above: _Style) -> tuple[_Style, dict[str, str]]:
        """Return the style of an element, and its own properties."""
        own = self.own_values(element)
        inherited = {name: own[name] for name in INHERITED if own.get(name, "inherit") != "inherit"}
        matrix = above.matrix @ transform_matrix(own.get("transform", ""))
        style = _Style(
            {**above.values, **inherited},
            above.opacity * parsed_opacity(own.get("opacity")),
            matrix,
            above.clip,
            self._layers(element, above),
        )
        if own.get("clip-path", "none") != "none":
            style = self._clipped(style, own["clip-path"])
        return style, own

    def _layers(self, element: XmlElement, above: _Style) -> tuple[str, ...]:
        """Return the names by which a user may choose an element; the first is listed."""
        attributes = element.attributes
        labels = [attributes.peek("inkscape:label") or attributes.peek("data-name")]
        ids = [] if element is self.root else [attributes.peek("id")]
        classes = str(attributes.peek("class", "")).split()
        if element.name in _GROUPS:
            found = (*labels, *ids, *classes, *above.layers)
        else:
            nearest = () if any(labels) else (*above.layers[:1], *classes, NO_LAYER)[:1]
            found = (*labels, *nearest, *above.layers, *classes, *ids)
        return tuple(dict.fromkeys(str(name) for name in found if name))

    def _clipped(self, style: _Style, value: str) -> _Style:
        found = self._referred(value)
        if found is None or found.name != "clipPath":
            return style
        self.clips += 1
        if self.clips > _MOST_CLIPS or any(found is one for one in self.clipping):
            raise FormatError(
                "too-large",
                "has more than {most:,} clips, or one that clips itself",
                "apply the clips in the drawing program",
                most=_MOST_CLIPS,
                line=found.line,
            )
        if found.attributes.peek("clipPathUnits") == "objectBoundingBox":
            self.drawing.unread("clips in units of their object", style.layers)
            return style
        if any(child.name == "text" for child in found.children):
            self.drawing.unread("clips to texts", style.layers)
            return style
        self.clipping.append(found)
        inner = replace(
            style, matrix=style.matrix @ transform_matrix(attribute_text(found, "transform"))
        )
        shapes = []
        for child in found.children:
            own_style, _ = self.style(child, replace(inner, clip=None, layers=()))
            drawn = child
            if child.name == "use":
                other = self._referred(
                    attribute_text(child, "href") or attribute_text(child, "xlink:href")
                )
                if other is None:
                    continue
                at = shift_matrix(attribute_number(child, "x"), attribute_number(child, "y"))
                own_style = replace(own_style, matrix=own_style.matrix @ at)
                drawn = other
            rings = [ring for ring, _ in self._outline(drawn)]
            area = filled(rings, even_odd=own_style.values.get("clip-rule") == "evenodd")
            if area is not None:
                shapes.append(placed(area, own_style.matrix))
        self.clipping.pop()
        clip = shapely.union_all(shapes) if shapes else shapely.Polygon()
        if style.clip is not None:
            clip = shapely.intersection(clip, style.clip)
        return replace(style, clip=clip)

    def _referred(self, text: str) -> XmlElement | None:
        match = re.fullmatch(r"""\s*(?:url\(\s*['"]?)?#([^'")]+)['"]?\s*\)?.*""", text)
        return None if match is None else self.by_id.get(match[1].strip())

    # Elements

    def walk(self, element: XmlElement, above: _Style, depth: int = 0) -> None:
        """Add what an element and those inside it draw."""
        self.visits += 1
        self.copies += self.uses > 0
        if self.visits > _MOST_VISITS or self.copies > _MOST_COPIES:
            raise too_large()
        if depth > _MOST_DEPTH:
            raise FormatError(
                "nested-too-deep",
                "groups and uses are nested deeper than {most}, or an element uses itself",
                "draw the copies as shapes",
                most=_MOST_DEPTH,
                line=element.line,
            )
        if self._is_unshown(element, above):
            return
        style, own = self.style(element, above)
        if own.get("display") == "none" or style.opacity == 0.0:
            return
        if own.get("mask", "none") != "none":
            self.drawing.unread("masks", style.layers)
        if "transform-origin" in own and "transform" in own:
            self.drawing.unread("transforms about an origin of their own", style.layers)
        values = {key: value for key, value in style.values.items() if key != "-use"}
        style = replace(style, values=values)
        name = element.name
        if name in _GROUPS:
            if name in ("svg", "symbol") and depth:
                style = self._viewport(element, style, above)
            for child in element.children:
                self.walk(child, style, depth + 1)
        elif name == "use":
            self._use(element, style, depth)
        elif name in ("image", "foreignObject"):
            if style.values.get("visibility", "visible") == "visible":
                words = "pictures" if name == "image" else "foreign elements"
                self.drawing.unread(f"{words} in <{name}>", style.layers)
        elif name in ("rect", "circle", "ellipse", "line", "polyline", "polygon", "path"):
            self._shape(element, style, own)
        else:
            self.drawing.unread(f"elements <{name}>", style.layers)

    def _is_unshown(self, element: XmlElement, above: _Style) -> bool:
        """Return True if an element draws nothing by itself."""
        name = element.name
        if name in _MOVES:
            self.drawing.unread("animations", above.layers)
            return True
        is_used = name == "symbol" and "-use" in above.values
        # Programs draw nothing of another namespace.
        return (
            (name in _UNSHOWN and not is_used)
            or ":" in name
            or (self.is_own and bool(_OWN_MARKS & set(attribute_text(element, "class").split())))
        )

    def _use(self, element: XmlElement, style: _Style, depth: int) -> None:
        reference = attribute_text(element, "href") or attribute_text(element, "xlink:href")
        found = self._referred(reference)
        if found is None:
            if reference and not reference.startswith("#"):
                self.drawing.unread("uses of other files", style.layers)
            return
        at = shift_matrix(attribute_number(element, "x"), attribute_number(element, "y"))
        values = {**style.values, "-use": "1"}
        if found.name in ("symbol", "svg"):
            for side in ("width", "height"):
                if element.attributes.peek(side) is not None:
                    values[f"-{side}"] = attribute_text(element, side)
        self.uses += 1
        self.walk(found, replace(style, matrix=style.matrix @ at, values=values), depth + 1)
        self.uses -= 1

    def _viewport(self, element: XmlElement, style: _Style, above: _Style) -> _Style:
        """Return the style inside a nested <svg> or a <symbol>."""
        sizes = [
            parsed_length(above.values.get(f"-{side}") or attribute_text(element, side) or "100%")
            for side in ("width", "height")
        ]
        values = {key: value for key, value in style.values.items() if key[:1] != "-"}
        x, y = (
            (0.0, 0.0)
            if element.name == "symbol"
            else (attribute_number(element, "x"), attribute_number(element, "y"))
        )
        box = all_numbers(attribute_text(element, "viewBox"))
        matrix = style.matrix @ shift_matrix(x, y)
        clip = style.clip
        pixels = [value * PIXELS[unit] if unit in PIXELS else None for value, unit in sizes]
        inside = np.eye(3)
        if len(box) == 4 and box[2] > 0 and box[3] > 0:
            pixels = [
                side if given is None else given
                for given, side in zip(pixels, box[2:], strict=True)
            ]
            inside = view_matrix(
                box,
                pixels[0] or 0.0,
                pixels[1] or 0.0,
                attribute_text(element, "preserveAspectRatio"),
            )
        width, height = pixels
        if (
            width is not None
            and height is not None
            and "visible" not in attribute_text(element, "overflow")
        ):
            area = placed(shapely.box(0, 0, width, height), matrix)
            clip = area if clip is None else shapely.intersection(clip, area)
        return replace(style, values=values, matrix=matrix @ inside, clip=clip)

    def _shape(self, element: XmlElement, style: _Style, own: dict[str, str]) -> None:
        """Add the fill and the stroke of a shape."""
        if style.values.get("visibility", "visible") != "visible":
            return
        lines = self._outline(element)
        if any(
            own.get(name, "none") != "none"
            for name in ("marker", "marker-start", "marker-mid", "marker-end")
        ):
            self.drawing.unread("markers of lines", style.layers)
        if element.name != "line":
            darkness, alpha = self._paint(style, "fill", "black")
            if alpha:
                area = filled(
                    [line for line, _ in lines], even_odd=style.values.get("fill-rule") == "evenodd"
                )
                if area is not None:
                    self._add(placed(area, style.matrix), style, darkness, alpha)
        darkness, alpha = self._paint(style, "stroke", "none")
        value, unit = parsed_length(style.values.get("stroke-width", "1"))
        width = value * PIXELS.get(unit, 0.0 if unit else 1.0)
        if unit == "%" and self.drawing.page:
            left, low, right, high = self.drawing.page
            width = value / 100 * math.hypot(right - left, high - low) / math.sqrt(2)
        if not alpha or width <= 0:
            return
        if own.get("stroke-dasharray", "none") not in ("none", "", "0"):
            self.dashed += 1
        self._stroke(lines, style, width, (darkness, alpha), own.get("vector-effect", ""))

    def _stroke(
        self,
        lines: list[tuple[Floats, bool]],
        style: _Style,
        width: float,
        paint: tuple[float, float],
        effect: str,
    ) -> None:
        caps: dict[str, Literal["round", "square"]] = {"round": "round", "square": "square"}
        joins: dict[str, Literal["round", "bevel"]] = {"round": "round", "bevel": "bevel"}
        cap: Literal["round", "square", "flat"] = caps.get(
            style.values.get("stroke-linecap", ""), "flat"
        )
        join: Literal["round", "bevel", "mitre"] = joins.get(
            style.values.get("stroke-linejoin", ""), "mitre"
        )
        limit = parsed_length(style.values.get("stroke-miterlimit", "4"))[0] or 4.0
        is_fixed = effect == "non-scaling-stroke"
        if is_fixed:
            width /= self.page_scale
        for line, is_closed in lines:
            points = line
            if is_fixed:
                points = points @ style.matrix[:2, :2].T + style.matrix[:2, 2]
            keep = np.ones(len(points), bool)
            keep[1:] = (points[1:] != points[:-1]).any(axis=1)
            points = finite(points[keep])
            if is_closed and len(points) > 1 and (points[0] == points[-1]).all():
                points = points[:-1]
            if len(points) < 2:
                if cap == "flat" or not len(points):
                    continue
                shape: Any = shapely.Point(points[0])
            else:
                ring = is_closed and len(points) > 2
                shape = shapely.LinearRing(points) if ring else shapely.LineString(points)
                check_crossings([shape])
            area: Any = shapely.buffer(
                shape,
                width / 2,
                quad_segs=16,
                cap_style=cap,
                join_style=join,
                mitre_limit=max(limit, 1.0),
            )
            self._add(area if is_fixed else placed(area, style.matrix), style, *paint)

    def _add(self, area: Any, style: _Style, darkness: float, alpha: float) -> None:
        """Add a painted area: dark is a wall, opaque and light is floor, anything else a tint."""
        if style.clip is not None:
            area = shapely.intersection(area, style.clip)
        if darkness >= self.threshold:
            self.drawing.add(area, style.layers)
        elif alpha > 0.99:
            self.drawing.add(area, style.layers, is_free=True)

    def _paint(self, style: _Style, name: str, default: str) -> tuple[float, float]:
        """Return the darkness of a fill or stroke on white, and how opaque it is."""
        word = style.values.get(name, default).strip()
        alpha = style.opacity * parsed_opacity(style.values.get(f"{name}-opacity"))
        if word.lower() in ("none", "transparent") or alpha == 0.0:
            return 0.0, 0.0
        if word.lower() == "currentcolor":
            word = style.values.get("color", "black")
        if word.startswith("url("):
            # A pattern or a gradient; a fallback after it does not matter.
            return (alpha, alpha) if self._referred(word) is not None else (0.0, 0.0)
        luma, own_alpha = parsed_colour(word)
        alpha *= own_alpha
        return alpha * (1.0 - luma), alpha

    def _outline(self, element: XmlElement) -> list[tuple[Floats, bool]]:
        """Return the lines of a shape in its own coordinates, and whether each is closed."""
        number = {
            name: self._measure(element, name)
            for name in (
                "x",
                "y",
                "width",
                "height",
                "rx",
                "ry",
                "cx",
                "cy",
                "r",
                "x1",
                "y1",
                "x2",
                "y2",
            )
        }
        kind = element.name
        if kind == "rect":
            return rectangle_lines(element, number)
        if kind in ("circle", "ellipse"):
            radii = (number["r"],) * 2 if kind == "circle" else (number["rx"], number["ry"])
            if min(radii) <= 0:
                return []
            return [
                (arc_points((number["cx"], number["cy"]), radii, 0.0, 0.0, math.tau)[:-1], True)
            ]
        if kind == "line":
            ends = [[number["x1"], number["y1"]], [number["x2"], number["y2"]]]
            return [(np.array(ends), False)]
        if kind in ("polyline", "polygon"):
            values = all_numbers(attribute_text(element, "points"))
            points = np.array(values[: len(values) // 2 * 2], np.float64).reshape(-1, 2)
            return [(points, kind == "polygon")] if len(points) else []
        return list(path_lines(element)) if kind == "path" else []

    def _measure(self, element: XmlElement, name: str) -> float:
        text = element.attributes.peek(name)
        if text is None:
            return 0.0
        value, unit = parsed_length(str(text))
        if unit == "%" and self.drawing.page is not None:
            left, low, right, high = self.drawing.page
            across, along = right - left, high - low
            whole = across if name in ("x", "width", "rx", "cx", "x1", "x2") else along
            return (
                value / 100 * (math.hypot(across, along) / math.sqrt(2) if name == "r" else whole)
            )
        return value * PIXELS.get(unit, 1.0)


def read_svg_drawing(
    path: Path, options: DrawingOptions, threshold: float, most_bytes: int
) -> ForeignMap:
    """Read an SVG file.

    Args:
        path: The file.
        options: Layers, unit and cells.
        threshold: Darkness, 0 white to 1 black, from which a shape is a wall.
        most_bytes: Largest file.

    Raises:
        FormatError: If it is not SVG, or has no walls.
    """
    check_between("threshold", threshold, 0.0, 1.0)
    data = read_bounded(path, most_bytes)
    root = parse_xml(data, plain_entities=True)
    if root.name.removeprefix("svg:") != "svg":
        raise FormatError("unknown-format", "is XML, but not SVG", "save it as plain SVG")
    reader = _Reader(root, threshold)
    if b"<?xml-stylesheet" in data:
        reader.drawing.unread("imports of style sheets", ())
    reader.collect()
    own = _own_facts(root)
    reader.is_own = own is not None
    _set_page(reader, root)
    reader.walk(root, _Style({}))
    drawing = reader.drawing
    # The page counts y down, and its lower edge is at 0.
    drawing.parts = [
        part._replace(shape=shapely.transform(part.shape, lambda xy: xy * (1.0, -1.0)))
        for part in drawing.parts
    ]
    if drawing.page is not None:
        left, top, right, bottom = drawing.page
        drawing.page = (left, -bottom, right, -top)
        shown = shapely.box(*drawing.page)
        outside = [not shapely.intersects(shown, part.shape) for part in drawing.parts]
        if any(outside) and len(outside) > sum(outside):
            drawing.notes.append(f"not obstacles: shapes outside the page ({sum(outside)})")
        drawing.parts = [
            part for part, is_out in zip(drawing.parts, outside, strict=True) if not is_out
        ]
    if reader.dashed:
        drawing.notes.append(f"dashed lines ({reader.dashed}) count as walls without gaps")
    if own is not None:
        return own_map(drawing, options, own)
    if drawing.page is not None:
        unit = drawing._unit(options)
        drawing.origin = (-drawing.page[0] * unit, -drawing.page[1] * unit)
    return drawing.map(options, {"threshold": threshold})


def _own_facts(root: XmlElement) -> OwnPlan | None:
    """Return what our own writer says about its plan; None for anybody else's."""
    for element in root.all("metadata"):
        if element.attributes.peek("id") == "worldgen":
            try:
                return own_plan(json.loads(element.text))
            except (ValueError, RecursionError):
                return None
    return None


def _set_page(reader: _Reader, root: XmlElement) -> None:
    """Find the part of the drawing that is shown, and the length of its unit."""
    box = all_numbers(attribute_text(root, "viewBox"))
    sizes = [parsed_length(attribute_text(root, side) or "100%") for side in ("width", "height")]
    drawing = reader.drawing
    pixels = [value * PIXELS[unit] if unit in PIXELS else None for value, unit in sizes]
    if len(box) == 4 and box[2] > 0 and box[3] > 0:
        drawing.page = (box[0], box[1], box[0] + box[2], box[1] + box[3])
        scales = [
            given / side
            for given, side in zip(pixels, box[2:], strict=True)
            if given is not None and given > 0
        ]
    else:
        width, height = pixels
        if width and height and width > 0 and height > 0:
            drawing.page = (0.0, 0.0, width, height)
        scales = [1.0] if all(unit in ABSOLUTE for _, unit in sizes) else []
    if scales:
        reader.page_scale = min(scales)
    if scales and all(unit in ABSOLUTE or pixels[at] is None for at, (_, unit) in enumerate(sizes)):
        # A unit of exactly 1 mm stays exact.
        value, unit = next(size for size in sizes if size[1] in ABSOLUTE)
        drawing.unit = min(scales) * 0.0254 / INCH
        if len(box) == 4 and unit in UNITS:
            at = next(at for at, size in enumerate(sizes) if size[1] in ABSOLUTE)
            exactly = value * UNITS[unit] / box[2 + at]
            if math.isclose(exactly, drawing.unit, rel_tol=1e-6):
                drawing.unit = float(f"{exactly:.12g}")
        drawing.unit_from = "the page's width and height"
