"""Export a world as a PLY file: every wall is a closed box of triangles.

The world's other facts are in comments.

Source: Greg Turk, "The PLY Polygon File Format", Stanford University, 1994; binary form.
"""

from __future__ import annotations

from worldgen.interop.format import HELD, Destination, Format, held_lines
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry.placed_boxes import PlacedBox, box_mesh, box_writer
from worldgen.interop.readers.mesh_slice import unitless_reader
from worldgen.world import World


def _contents(world: World, destination: Destination, boxes: list[PlacedBox]) -> bytes:
    """Return the binary form: eight vertices and twelve triangles per box, m, z up."""
    data = box_mesh(boxes).export(file_type="ply", vertex_normal=False)

    # Facts that trimesh cannot store go into comments, after the line with the format.
    magic, form, _, rest = data.split(b"\n", 3)
    lines = ["worldgen: m, z up, one closed box a wall.", *held_lines(world, destination)]
    comments = [f"comment {line}".encode() for line in lines]
    return b"\n".join([magic, form, *comments, rest])


ply = Format(
    "ply",
    "walls as triangles; meshes, cut at a height, .ply",
    (".ply",),
    read=unitless_reader("ply"),
    write=box_writer(_contents, bits=24),
    holds=frozenset(HELD),
    client="MeshLab, Open3D, point cloud programs",
    usual_robot=FLOOR_ROBOT,
)
