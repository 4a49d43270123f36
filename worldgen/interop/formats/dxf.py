"""Drawings of CAD programs in DXF."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap

# ezdxf takes about thirty times the file's size.
MAX_DXF_BYTES = 48 << 20


def read_dxf(
    path: Path,
    *,
    layer: str = "",
    free: str = "",
    unit: str = "",
    cell_size: float = 0.0,
    thickness: float = 0.0,
    areas: Literal["solid", "outline"] = "solid",
) -> ForeignMap:
    """Read the model space of a DXF file: visible lines, hatches, solids and blocks are walls.

    Args:
        path: The file.
        layer: Names of the layers that are walls, with commas between them; * stands for any
            letters. If omitted, all that are visible.
        free: Names of those that are openings, such as doors, in the same form.
        unit: Length of a unit: m, cm, mm, in, ft, or a number of metres; if omitted, the file's.
        cell_size: Side of a cell, m; 0 means 0.05, or more for a large drawing.
        thickness: Thickness of lines without a width, m.
        areas: Whether hatches are solid, or only outlined by walls.

    Raises:
        FormatError: If it is not DXF, or has no walls.
        InvalidParameter: If an option is out of range.
    """
    from worldgen.interop.geometry.drawing import Choice, geometry_errors
    from worldgen.interop.readers.dxf_drawing import read_dxf_drawing

    choice = Choice(layer, free, unit, cell_size, thickness, areas == "outline")
    with geometry_errors():
        return read_dxf_drawing(path, choice, MAX_DXF_BYTES)


dxf = Format(
    "dxf",
    "drawing of a CAD program, .dxf",
    (".dxf",),
    re.compile(rb"(?s)\s*(?:999\s[^\n]*\n\s*)*0\s*\r?\n\s*SECTION\s*\r?\n|AutoCAD Binary DXF"),
    read_dxf,
    usual_robot=FLOOR_ROBOT,
    most_bytes=MAX_DXF_BYTES,
)
