"""Drawings of CAD programs in DXF."""

from __future__ import annotations

import re
from pathlib import Path

from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap
from worldgen.interop.geometry.drawing_options import DrawingOptions

# ezdxf takes about thirty times the file's size.
MAX_DXF_BYTES = 48 << 20


def read_dxf(path: Path, options: DrawingOptions) -> ForeignMap:
    """Read the model space of a DXF file: visible lines, hatches, solids and blocks are walls.

    Raises:
        FormatError: If it is not DXF, or has no walls.
        InvalidParameter: If an option is out of range.
    """
    from worldgen.interop.geometry.drawing import geometry_errors
    from worldgen.interop.readers.dxf_drawing import read_dxf_drawing

    with geometry_errors():
        return read_dxf_drawing(path, options, MAX_DXF_BYTES)


dxf = Format(
    "dxf",
    "drawing of a CAD program, .dxf",
    (".dxf",),
    re.compile(rb"(?s)\s*(?:999\s[^\n]*\n\s*)*0\s*\r?\n\s*SECTION\s*\r?\n|AutoCAD Binary DXF"),
    read_dxf,
    usual_robot=FLOOR_ROBOT,
    most_bytes=MAX_DXF_BYTES,
    options=DrawingOptions,
)
