"""Read and write the file formats of other programs.

Contents:
    FORMATS, Format, Exported, Destination, HELD: the formats by name, and the definition of a
        format (``format``). Each format is read and written in its own module, such as ``ros`` or
        ``movingai``.
    import_world, read_map: turn a foreign map into a world with a proof (``importing``,
        ``recognising``).
    export_world, write_export: the other direction (``exporting``).
    place: choose start and target for a map that has none (``place``).

Facts that a file cannot store are written to a sidecar next to it (``sidecar``). A reader reports
what is wrong, and in which line; the importer adds the file's name, and records it with format and
digest (``foreign_map``, ``recognising``). The formats share code for boxes and the coordinates of
cells (``boxes``, ``placed_boxes``), polygons (``polygons``), shapes that become cells (``raster``),
pictures (``grey_image``), YAML (``yaml_table``), XML (``xml_tree``) and meshes (``mesh_slice``).
"""

from worldgen.interop.exporting import Export, export_world, guess_format, write_export
from worldgen.interop.format import FORMATS, HELD, Destination, Exported, Format
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot
from worldgen.interop.formats.movingai import Problem, read_scenario
from worldgen.interop.importing import (
    Imported,
    ImportedRobot,
    as_json,
    describe,
    import_world,
    parse_point,
)
from worldgen.interop.place import Placement, place
from worldgen.interop.recognising import find_format, looks_like_a_map, read_map, readable_formats

__all__ = [
    "FORMATS",
    "HELD",
    "Destination",
    "Export",
    "Exported",
    "ForeignMap",
    "ForeignRobot",
    "Format",
    "Imported",
    "ImportedRobot",
    "Placement",
    "Problem",
    "as_json",
    "describe",
    "export_world",
    "find_format",
    "guess_format",
    "import_world",
    "looks_like_a_map",
    "parse_point",
    "place",
    "read_map",
    "read_scenario",
    "readable_formats",
    "write_export",
]
