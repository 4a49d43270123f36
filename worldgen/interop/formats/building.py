"""Buildings of Open-RMF's traffic editor."""

from __future__ import annotations

import re
from pathlib import Path

from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap

# A parsed node takes a kilobyte.
MAX_BUILDING_BYTES = 4 << 20


def read_building(
    path: Path,
    *,
    level: str = "",
    layer: str = "",
    free: str = "",
    unit: str = "",
    cell_size: float = 0.0,
    thickness: float = 0.1,
) -> ForeignMap:
    """Read one level of a ``building.yaml``: walls are solid, doors are open.

    Args:
        path: The file.
        level: Name of the level; if omitted, the reference level, or the first.
        layer: Which of walls, doors, holes and "outside the floors" are solid; if omitted, all but
            doors.
        free: Which of them are open, in the same form.
        unit: Length of a pixel, m; if omitted, by the measurements.
        cell_size: Side of a cell, m; 0 means 0.05, or more for a large building.
        thickness: Thickness of walls, m.

    Raises:
        FormatError: If it is not such a file, or the level has no walls.
        InvalidParameter: If an option is out of range, or there is no such level.
    """
    from worldgen.interop.geometry.drawing import Choice, geometry_errors
    from worldgen.interop.readers.building_plan import read_building_plan

    choice = Choice(layer, free, unit, cell_size, thickness)
    with geometry_errors():
        return read_building_plan(path, choice, level, MAX_BUILDING_BYTES)


# Lanes, places and pictures stop no robot.
_HARMLESS = frozenset({
    "crowd_sim", "graphs", "name", "building_name", "parameters", "map_version", "levels/lanes", "human_lanes",
    "constraints", "drawing", "elevation", "features", "fiducials", "flattened_x_offset", "flattened_y_offset",
    "layers", "x_meters", "y_meters", "measurements", "lanes", "zones", "images", "environment_zones",
    "rendezvous_zones", "robot_zones",
})  # fmt: skip

building = Format(
    "building",
    "building of Open-RMF, building.yaml",
    (".yaml", ".yml"),
    re.compile(
        rb"(?ms)(?=.*^(?:(?:levels|crowd_sim):[ \t]*\r?$"
        rb"|coordinate_system:[ \t]*[\"']?(?:reference_image|cartesian_meters|web_mercator|wgs84)\b))"
    ),
    read_building,
    usual_robot=FLOOR_ROBOT,
    most_bytes=MAX_BUILDING_BYTES,
    harmless=_HARMLESS,
)
