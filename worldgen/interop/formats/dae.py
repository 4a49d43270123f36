"""Read COLLADA meshes, cut at a height.

Source: The Khronos Group, "COLLADA 1.4.1 Specification", 2008.
"""

from __future__ import annotations

import re

from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.readers.mesh_slice import read_collada

dae = Format(
    "dae",
    "mesh or scene, cut at a height, COLLADA, .dae",
    (".dae",),
    re.compile(rb"(?s)\s*+(?:<\?(?:(?!\?>).)*+\?>\s*+|<!--(?:(?!-->).)*+-->\s*+)*+<COLLADA\b"),
    read_collada,
    client="Blender, SketchUp, Gazebo",
    usual_robot=FLOOR_ROBOT,
)
