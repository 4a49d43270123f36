"""Export a world as a 3MF file: one box, and an item per wall that puts it into place.

The archive is written here because trimesh 5.2 gives its parts random identifiers, so that no two
files are the same, writes millimetres whatever the unit is, and needs two more libraries.

Source: 3MF Consortium, "3D Manufacturing Format Core Specification", version 1.3, 2021.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from worldgen.interop.format import HELD, Destination, Format, decimal_text, held_lines
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap
from worldgen.interop.geometry.placed_boxes import BOX_CORNERS, BOX_TRIANGLES, PlacedBox, box_writer
from worldgen.interop.readers.mesh_slice import Plane, read_slice
from worldgen.world import World

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_OWN = "urn:worldgen:3mf"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
# The earliest time that an archive can store, so that the bytes do not depend on the clock.
_EPOCH = (1980, 1, 1, 0, 0, 0)
_TYPES = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<Types xmlns="{_PACKAGE}/content-types">'
    f'<Default Extension="rels" '
    f'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n'
)
_RELATIONS = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<Relationships xmlns="{_PACKAGE}/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
)


def _contents(world: World, destination: Destination, boxes: list[PlacedBox]) -> bytes:
    """Return a model in metres, z up; walls are named by part numbers."""
    lines = [*_head(world, destination), *map(_item, boxes), "  </build>", "</model>"]
    parts = {
        "[Content_Types].xml": _TYPES,
        "_rels/.rels": _RELATIONS,
        "3D/3dmodel.model": "\n".join(lines) + "\n",
    }
    # Entries are stored, not deflated, because compressed bytes depend on the machine's zlib.
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
        for name, text in parts.items():
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = 0
            archive.writestr(entry, text)
    return stream.getvalue()


def _head(world: World, destination: Destination) -> Iterator[str]:
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield f'<model unit="meter" xml:lang="en" xmlns="{_CORE}" xmlns:worldgen="{_OWN}">'
    yield '  <metadata name="worldgen:world" preserve="1">'
    for line in held_lines(world, destination):
        yield line if " = " in line else f"# {line}"
    yield "  </metadata>"
    yield '  <resources><object id="1" type="model" name="box"><mesh><vertices>'
    yield from (f'    <vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in BOX_CORNERS)
    yield "  </vertices><triangles>"
    yield from (f'    <triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in BOX_TRIANGLES)
    yield "  </triangles></mesh></object></resources>"
    yield "  <build>"


def _item(box: PlacedBox) -> str:
    across, along, up = map(decimal_text, box.size)
    low = " ".join(map(decimal_text, box.low))
    return (
        f'    <item objectid="1" partnumber="{box.name}" transform="{across} 0 0 0 {along} 0 0 '
        f'0 {up} {low}"/>'
    )


def read_3mf(
    path: Path,
    *,
    slice_height: float = 0.2,
    cell_size: float = 0.0,
    up: Literal["z", "y"] = "z",
    floor: int = 0,
) -> ForeignMap:
    """Read a mesh, cut at a height; the file gives its unit.

    Args:
        path: The file.
        slice_height: Height of the cut above the floor, m, such as the lidar's.
        cell_size: Side of a cell, m; 0 means the file's own if worldgen wrote it, otherwise 0.05.
        up: The axis that points up in the file.
        floor: Number of the floor, from 0, the lowest.
    """
    return read_slice(path, "3mf", Plane(slice_height, cell_size, up, 1.0, floor))


_HARMLESS = frozenset({
    "metadata", "metadatagroup", "basematerials", "colorgroup", "texture2d", "texture2dgroup", "m:colorgroup",
    "object/name", "object/partnumber", "object/pid", "object/pindex", "object/thumbnail", "object/UUID",
    "item/partnumber", "item/printable", "item/UUID", "component/UUID", "build/UUID", "p:UUID", *(f"triangle/{name}"
    for name in ("pid", "p1", "p2", "p3")),
})  # fmt: skip

threemf = Format(
    "3mf",
    "walls as boxes in an archive; meshes, cut at a height, .3mf",
    (".3mf",),
    read=read_3mf,
    write=box_writer(_contents, bits=24),
    holds=frozenset(HELD),
    client="slicers, CAD programs",
    usual_robot=FLOOR_ROBOT,
    harmless=_HARMLESS,
)
