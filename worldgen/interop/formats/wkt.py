"""Export walls as one geometry in Well-Known Text, for shapely, GDAL and spatial databases.

Source: OGC 06-103r4, "Simple Feature Access, part 1: Common Architecture", 2011, section 7.
"""

from __future__ import annotations

import numpy as np

from worldgen.interop.format import Destination, Exported, Format, decimal_text
from worldgen.interop.geometry.placed_boxes import GridLines
from worldgen.interop.geometry.polygons import Ring, border_cells, cell_polygons
from worldgen.world import World


def write_wkt(world: World, destination: Destination) -> Exported:
    """Return one MULTIPOLYGON on one line, coordinates as exact decimals.

    Raises:
        InvalidWorld: If the coordinates need more than 64 bits.
    """
    lines = GridLines(world, destination)
    xs, ys = (
        {at: decimal_text(value) for at, value in axis.items()} for axis in (lines.x, lines.y)
    )

    def ring_text(ring: Ring) -> str:
        return "(" + ", ".join(f"{xs[x]} {ys[y]}" for x, y in [*ring, ring[0]]) + ")"

    polygons = cell_polygons(border_cells(world) | np.pad(world.walls, 1), -1)
    body = ", ".join("(" + ", ".join(map(ring_text, polygon)) + ")" for polygon in polygons)
    return Exported(
        {destination.name: f"MULTIPOLYGON {f'({body})' if body else 'EMPTY'}\n".encode()}
    )


wkt = Format(
    "wkt",
    "walls as one geometry, .wkt",
    (".wkt",),
    write=write_wkt,
    client="shapely, GDAL, PostGIS",
)
