"""Foreign formats.

Contents:
    import_world: a foreign map becomes a world with a proof (``importing``).
    read_map, FORMATS: the formats by name (``formats``), each read in a file of its own:
    read_movingai, read_scenario (``movingai``), read_ros_map (``ros_map``, ``grey_image``),
    read_thesis_map (``thesis_map``, ``java_stream``), read_numpy_map (``numpy_map``), read_text_map (``text_map``).
    EXPORTERS, export_world: the way back (``exporting``; ``thesis_export``).
    place: start and target for a map that has none (``place``).
"""

from worldgen.interop.exporting import EXPORTERS, Exported, Exporter, ExportOptions, export_world
from worldgen.interop.foreign_map import ForeignMap
from worldgen.interop.formats import FORMATS, ReadOptions, read_map
from worldgen.interop.importing import Imported, RobotOptions, as_json, describe, import_world, parse_point
from worldgen.interop.movingai import Scenario, read_movingai, read_scenario
from worldgen.interop.numpy_map import read_numpy_map
from worldgen.interop.place import Placement, place
from worldgen.interop.ros_map import occupancy, read_ros_map
from worldgen.interop.text_map import read_text_map
from worldgen.interop.thesis_map import read_thesis_map

__all__ = [
    "EXPORTERS",
    "FORMATS",
    "ExportOptions",
    "Exported",
    "Exporter",
    "ForeignMap",
    "Imported",
    "Placement",
    "ReadOptions",
    "RobotOptions",
    "Scenario",
    "as_json",
    "describe",
    "export_world",
    "import_world",
    "occupancy",
    "parse_point",
    "place",
    "read_map",
    "read_movingai",
    "read_numpy_map",
    "read_ros_map",
    "read_scenario",
    "read_text_map",
    "read_thesis_map",
]
