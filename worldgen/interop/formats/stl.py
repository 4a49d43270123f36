"""A world as an STL file: every wall a closed box of triangles, and nothing else.

Source: 3D Systems, "StereoLithography Interface Specification", 1989; binary form.
"""

from __future__ import annotations

import numpy as np

from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.geometry.placed_boxes import BOX_CORNERS, BOX_QUADS, solid_boxes
from worldgen.world import World

__all__ = ["stl", "write_stl"]

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = b"worldgen: m, z up, one closed box a wall"  # 80 bytes; must not begin with "solid", as the text form does
_NORMALS = ((0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0))


def write_stl(world: World, destination: Destination, *, height: float = 1.0, floor: bool = False) -> Exported:
    """The binary form: twelve triangles a box, m, z up.

    Args:
        world: A world that stands still.
        destination: Where it goes.
        height: Of the walls, m.
        floor: Whether there is a floor, a box as thick as a cell below z = 0.

    Raises:
        InvalidParameter: If the height is no length.
        InvalidWorld: If 32 bits are too few for the coordinates.
    """
    boxes = solid_boxes(world, destination, height=height, floor=floor, bits=24)
    ends = np.array([[*map(float, box.low), *map(float, box.high)] for box in boxes], np.float64).reshape(-1, 2, 3)
    corners = np.stack([ends[:, pick, range(3)] for pick in BOX_CORNERS], axis=1)  # (n, 8, 3)
    halves = [(quad[0], *pair) for quad in BOX_QUADS for pair in (quad[1:3], quad[2:4])]
    triangles = np.zeros((len(boxes), len(halves)), _TRIANGLE)
    triangles["corners"] = corners[:, halves]
    triangles["normal"] = np.repeat(np.array(_NORMALS, np.float32), 2, axis=0)
    count = np.array(triangles.size, "<u4").tobytes()
    return Exported({destination.name: _HEADER.ljust(80) + count + triangles.tobytes()})


stl = Format("stl", "walls as triangles, binary .stl", (".stl",), write=write_stl, client="CAD programs, slicers")
