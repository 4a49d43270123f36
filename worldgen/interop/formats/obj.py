"""Export a world as a Wavefront OBJ file: one object per wall, coordinates as exact decimals.

The text is written here because trimesh 5.2 rounds to a fixed number of decimals, splits each face
in two, and takes six times as long for an object per wall (1.6 s rather than 0.3 s for 1,900).

Source: Wavefront, "Object Files", Advanced Visualizer Manual, appendix B1, 1990.
"""

from __future__ import annotations

from collections.abc import Iterator

from worldgen.interop.format import PLAIN_FACTS, Destination, Format, decimal_text, held_lines
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry.placed_boxes import BOX_CORNERS, BOX_QUADS, PlacedBox, box_writer
from worldgen.interop.readers.mesh_slice import unitless_reader
from worldgen.world import World


def _contents(world: World, destination: Destination, boxes: list[PlacedBox]) -> bytes:
    """Return one object per box, four corners per face, m, z up.

    The world's other facts are in comments, as TOML.
    """
    lines = ["worldgen: m, z up, one closed box per object.", *held_lines(world, destination)]
    lines = [*(f"# {line}" for line in lines), "s off"]
    for number, box in enumerate(boxes):
        lines += _object(box, 8 * number + 1)
    return ("\n".join(lines) + "\n").encode()


obj = Format(
    "obj",
    "walls as boxes; meshes, cut at a height, .obj",
    (".obj",),
    read=unitless_reader("obj"),
    write=box_writer(_contents),
    holds=PLAIN_FACTS,
    client="CAD and modelling programs, PyBullet",
    usual_robot=FLOOR_ROBOT,
)


def _object(box: PlacedBox, first: int) -> Iterator[str]:
    """Yield an object whose corners are numbered from ``first``."""
    yield f"o {box.name}"
    ends = [[decimal_text(value) for value in end] for end in (box.low, box.high)]
    for pick in BOX_CORNERS:
        yield "v " + " ".join(ends[end][axis] for axis, end in enumerate(pick))
    for quad in BOX_QUADS:
        yield "f " + " ".join(str(first + corner) for corner in quad)
