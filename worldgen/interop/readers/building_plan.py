"""Read Open-RMF's ``building.yaml`` as a drawing: walls, doors and floors of one level.

Source: Open-RMF, rmf_building_map_tools (``building.py``, ``level.py``, ``wall.py``).
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop.format.foreign_map import ForeignMap, read_bounded
from worldgen.interop.geometry.drawing import Drawing, filled, is_layer
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml
from worldgen.support.arrays import Floats
from worldgen.support.plain_text import quote

_SYSTEMS = ("reference_image", "cartesian_meters")
# Floors that are drawn this close together, m, have no gap.
_SEAM = 0.02


def read_building_plan(
    path: Path, options: DrawingOptions, level: str, most_bytes: int
) -> ForeignMap:
    """Read one level of a building.

    Args:
        path: The file.
        options: Layers, unit and cells; the layers are walls, doors, holes and "outside the floors".
        level: Name of the level; if empty, the reference level, or the first.
        most_bytes: Largest file.

    Raises:
        FormatError: If it is not such a file, or the level has no walls.
        InvalidParameter: If there is no such level.
    """
    top = read_yaml(
        read_bounded(path, most_bytes), "a building has `levels:` with vertices and walls"
    )
    if "levels" not in top or top.is_null("levels"):
        raise FormatError("missing-key", "levels is missing; a building has levels with walls")
    levels = top.tables("levels")[0]
    names = list(levels)
    first = names[0] if names else ""
    reference = top.word("reference_level_name") if "reference_level_name" in top else first
    chosen = level or reference
    if chosen not in names:
        raise InvalidParameter(
            "level-missing",
            "there is no level {name!q}; levels: {known!l:none}",
            "name one with --from building+level=NAME",
            at_terminal=True,
            name=chosen,
            known=[quote(name) for name in names[:30]],
        )
    system = top.word("coordinate_system") if "coordinate_system" in top else _SYSTEMS[0]
    if system not in _SYSTEMS:
        raise FormatError(
            "unsupported",
            "its coordinate_system is {system!q}",
            "save it from the traffic editor with one of {known!l}",
            system=system,
            known=list(_SYSTEMS),
            line=top.line_of("coordinate_system"),
        )
    drawing = Drawing(guesses=(1.0, 0.01))
    if len(names) > 1:
        others = ", ".join(quote(name) for name in names if name != chosen)
        drawing.notes.append(f"this is level {quote(chosen)}; +level= names another: {others}")
    here = levels.tables(chosen)[0]
    flip = -1.0 if system == _SYSTEMS[0] else 1.0
    if flip > 0:
        drawing.unit, drawing.unit_from = 1.0, "its coordinate system"
    else:
        base = here if reference not in names else levels.tables(reference)[0]
        _scale(drawing, here, base, flip)
    for name in names:
        if name != chosen:
            levels.tables(name)[0].pass_over()
    _add_level(drawing, here, flip, options)
    if "lifts" in top and not top.is_null("lifts"):
        for name in top.tables("lifts")[0]:
            drawing.unread("lifts", (f"lift {name}",))
        top.tables("lifts")[0].pass_over()
    has_doors = any("doors" in part.layers for part in drawing.parts)
    if has_doors and not is_layer("doors", options):
        options = replace(options, free=f"{options.free},doors")
    return drawing.map(options, {"level": chosen})


def _add_level(drawing: Drawing, level: YamlTable, flip: float, options: DrawingOptions) -> None:
    """Add the walls, the doors and what is not on a floor."""
    corners = _vertices(level, flip)
    lines: dict[str, list[Any]] = {}
    for key in ("walls", "doors"):
        lines[key] = [
            shapely.LineString(corners[edge]) for edge, _ in _edges(level, key, len(corners))
        ]
    areas = {key: _areas(level, key, corners) for key in ("floors", "holes")}
    for line in lines["walls"]:
        drawing.add(line, ("walls",))
    for area in areas["holes"]:
        drawing.add(area, ("holes",))
    if areas["floors"]:
        unit = drawing._unit(options)
        floor = shapely.union_all(areas["floors"])
        everything = np.array([floor, *lines["walls"], *lines["doors"]], object)
        around = shapely.box(*shapely.total_bounds(everything))
        outside = shapely.difference(
            around, shapely.buffer(floor, _SEAM / unit, join_style="mitre")
        )
        drawing.add(outside, ("outside the floors",))
    for line in lines["doors"]:
        drawing.add(line, ("doors",))
    for row in _tables(level, "models"):
        drawing.unread("models", ("models",))
        row.pass_over()


def _vertices(level: YamlTable, flip: float) -> Floats:
    rows = level.lists("vertices") if "vertices" in level else []
    points = []
    for row in rows:
        for part in row:
            if isinstance(part, YamlTable):
                part.pass_over()
        try:
            x, y = float(str(row[0])), flip * float(str(row[1]))
        except (ValueError, IndexError):
            x = y = math.nan
        if not (math.isfinite(x) and math.isfinite(y)):
            raise FormatError(
                "wrong-type",
                "each of vertices begins with two numbers",
                line=level.line_of("vertices"),
            )
        points.append((x, y))
    return np.array(points, np.float64).reshape(-1, 2)


def _edges(level: YamlTable, key: str, count: int) -> list[tuple[list[int], YamlTable]]:
    """Return pairs of vertices with their parameters."""
    found = []
    for row in level.lists(key) if key in level and not level.is_null(key) else []:
        try:
            ends = [int(str(row[0])), int(str(row[1]))]
        except (ValueError, IndexError):
            ends = [-1, -1]
        if not all(0 <= end < count for end in ends):
            raise FormatError(
                "wrong-type",
                "each of {key} begins with the numbers of two vertices, 0 to {last}",
                key=key,
                last=count - 1,
                line=level.line_of(key),
            )
        table = next((part for part in row if isinstance(part, YamlTable)), YamlTable())
        if key != "measurements":
            table.pass_over()
        found.append((ends, table))
    return found


def _areas(level: YamlTable, key: str, corners: Floats) -> list[Any]:
    found = []
    for table in _tables(level, key):
        words = table.words("vertices") or []
        table.pass_over()
        numbers = [int(word) if word.isdigit() else -1 for word in words]
        if not all(0 <= number < len(corners) for number in numbers):
            raise FormatError(
                "wrong-type",
                "vertices of {key} must be numbers of vertices, 0 to {last}",
                key=key,
                last=len(corners) - 1,
                line=table.line,
            )
        area = filled([corners[numbers]], even_odd=False) if len(numbers) > 2 else None
        if area is not None:
            found.append(area)
    return found


def _tables(table: YamlTable, key: str) -> list[YamlTable]:
    return table.tables(key) if key in table and not table.is_null(key) else []


def _scale(drawing: Drawing, level: YamlTable, reference: YamlTable, flip: float) -> None:
    """Set the length of a pixel: by the level's measurements, or by fiducials on the reference level."""
    scale = _measured(reference, flip)
    own, shared = _fiducials(level, flip), _fiducials(reference, flip)
    common = [name for name in own if name in shared]
    if level is not reference and scale is not None and len(common) > 1:
        here, there = (np.array([points[name] for name in common]) for points in (own, shared))
        lengths = [np.sqrt(((one[:, None] - one[None]) ** 2).sum(axis=-1)) for one in (here, there)]
        apart = lengths[0] > 0
        scale *= float((lengths[1][apart] / lengths[0][apart]).mean()) if apart.any() else 1.0
        offset = (there * (_measured(reference, flip) or 1.0) - here * scale).mean(axis=0)
        drawing.origin = float(offset[0]), float(offset[1])
        source = "the fiducials"
    else:
        scale = _measured(level, flip) or scale
        source = "the measurements"
    if scale is not None:
        drawing.unit, drawing.unit_from = float(f"{scale:.9g}"), source


def _measured(level: YamlTable, flip: float) -> float | None:
    """Return the mean length of a unit by a level's measurements, m, as Open-RMF does."""
    corners = _vertices(level, flip)
    scales = []
    for ends, table in _edges(level, "measurements", len(corners)):
        length = math.dist(*corners[ends])
        words = table.words("distance") if "distance" in table else None
        try:
            distance = float((words or [""])[-1])
        except ValueError:
            distance = math.nan
        if not (length > 0 and 0 < distance < 1e9):
            raise FormatError(
                "wrong-type",
                "a measurement must be between two places, with a distance above 0 m",
                line=level.line_of("measurements"),
            )
        scales.append(distance / length)
    return sum(scales) / len(scales) if scales else None


def _fiducials(level: YamlTable, flip: float) -> dict[str, tuple[float, float]]:
    found = {}
    for row in (
        level.lists("fiducials") if "fiducials" in level and not level.is_null("fiducials") else []
    ):
        try:
            found[str(row[2])] = (float(str(row[0])), flip * float(str(row[1])))
        except (ValueError, IndexError):
            continue
    return found
