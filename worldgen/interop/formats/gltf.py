"""glTF in its text form, with buffers inside or beside it.

Read only, because the binary form is one file.
"""

from __future__ import annotations

from worldgen.interop.foreign_map import FLOOR_ROBOT
from worldgen.interop.format import Format
from worldgen.interop.formats.mesh_readers import metric_reader

__all__ = ["gltf"]

gltf = Format(
    "gltf",
    "mesh or scene, cut at a height, glTF, .gltf",
    (".gltf",),
    read=metric_reader("gltf"),
    client="browsers, Blender, game engines",
    usual_robot=FLOOR_ROBOT,
)
