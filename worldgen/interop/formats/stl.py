"""Export a world as an STL file: every wall is a closed box of triangles.

Source: 3D Systems, "StereoLithography Interface Specification", 1989; binary form.
"""

from __future__ import annotations

import base64
import struct

from worldgen.interop.format import Destination, Format, decimal
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry.placed_boxes import PlacedBox, box_mesh, box_writer
from worldgen.interop.readers.mesh_slice import unitless_reader
from worldgen.world import World

# The header must not begin with "solid", as the text form does.
_HEADER = 80


def _contents(world: World, destination: Destination, boxes: list[PlacedBox]) -> bytes:
    """Return the binary form: twelve triangles per box, m, z up."""
    triangles: bytes = box_mesh(boxes).export(file_type="stl")
    return _header(world, destination) + triangles[_HEADER:]


def _header(world: World, destination: Destination) -> bytes:
    """Return the grid's facts for ``import``, as decimals if these fit into 80 bytes."""
    x, y = (decimal(value) for value in destination.origin)
    size = f"worldgen: m, z up; size {world.width} {world.height}; "
    whole = f"{size}cell {decimal(world.cell_size)}; origin {x} {y}"
    if len(whole) > _HEADER:
        # The bits of the three numbers always fit.
        bits = struct.pack("<3d", world.cell_size, *destination.origin)
        whole = f"{size}bits {base64.b64encode(bits).decode()}"
    return whole.encode().ljust(_HEADER)


stl = Format(
    "stl",
    "walls as triangles; meshes, cut at a height, binary or text, .stl",
    (".stl",),
    read=unitless_reader("stl"),
    write=box_writer(_contents, bits=24),
    client="CAD programs, slicers",
    usual_robot=FLOOR_ROBOT,
)
