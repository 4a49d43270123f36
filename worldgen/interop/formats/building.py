"""Buildings of Open-RMF's traffic editor."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from worldgen.interop.format import Format
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap
from worldgen.interop.geometry.drawing_options import DrawingOptions

# A parsed node takes a kilobyte.
MAX_BUILDING_BYTES = 4 << 20


@dataclass(frozen=True)
class BuildingOptions(DrawingOptions):
    """Options of a building.

    Args:
        layer: Which of walls, doors, holes and "outside the floors" are solid; if omitted, all but
            doors.
        free: Which of them are open, in the same form.
        unit: Length of a pixel, m; if omitted, by the measurements.
        thickness: Thickness of walls, m.
        level: Name of the level; if omitted, the reference level, or the first.
    """

    thickness: float = 0.1
    level: str = ""


def read_building(path: Path, options: BuildingOptions) -> ForeignMap:
    """Read one level of a ``building.yaml``: walls are solid, doors are open.

    Raises:
        FormatError: If it is not such a file, or the level has no walls.
        InvalidParameter: If an option is out of range, or there is no such level.
    """
    from worldgen.interop.geometry.drawing import geometry_errors
    from worldgen.interop.readers.building_plan import read_building_plan

    with geometry_errors():
        return read_building_plan(path, options, options.level, MAX_BUILDING_BYTES)


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
    options=BuildingOptions,
)
