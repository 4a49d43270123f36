"""Export a world as a PLY file: every wall is a closed box of triangles.

The world's other facts are in comments.

Source: Greg Turk, "The PLY Polygon File Format", Stanford University, 1994; binary form.
"""

from __future__ import annotations

from worldgen.interop.foreign_map import FLOOR_ROBOT
from worldgen.interop.format import HELD, Destination, Exported, Format, held_lines
from worldgen.interop.geometry.placed_boxes import solid_boxes
from worldgen.interop.readers.mesh_readers import unitless_reader
from worldgen.world import World

__all__ = ["ply", "write_ply"]


def write_ply(
    world: World, destination: Destination, *, height: float = 1.0, floor: bool = False
) -> Exported:
    """Return the binary form: eight vertices and twelve triangles per box, m, z up.

    Args:
        world: A static world.
        destination: Where the file is written.
        height: Height of the walls, m.
        floor: Whether to add a floor, a box one cell thick below z = 0.

    Raises:
        InvalidParameter: If the height isn't a valid length.
        InvalidWorld: If the coordinates need more than 32 bits.
    """
    from worldgen.interop.geometry.box_mesh import box_mesh

    boxes = solid_boxes(world, destination, height=height, floor=floor, bits=24)
    data = box_mesh(boxes).export(file_type="ply", vertex_normal=False)

    # Facts that trimesh cannot store go into comments, after the line with the format.
    magic, form, _, rest = data.split(b"\n", 3)
    lines = ["worldgen: m, z up, one closed box a wall.", *held_lines(world, destination)]
    comments = [f"comment {line}".encode() for line in lines]
    return Exported({destination.name: b"\n".join([magic, form, *comments, rest])})


ply = Format(
    "ply",
    "walls as triangles; meshes, cut at a height, .ply",
    (".ply",),
    read=unitless_reader("ply"),
    write=write_ply,
    holds=frozenset(HELD),
    client="MeshLab, Open3D, point cloud programs",
    usual_robot=FLOOR_ROBOT,
)
