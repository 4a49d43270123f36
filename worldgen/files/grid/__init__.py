"""The ``.grid`` file: one world as text, with the same bytes for the same world.

Version 1 holds one robot, version 2 several.

Contents:
    dumps, loads: convert between a world and its text.
    read_world, write_world: convert between a world and a file, compressed if its name ends in
        ``.gz``.
    world_digest: a world's id.

``docs/reference/grid-format.md`` is the normative description.
"""

from worldgen.files.grid.disk import read_world, write_world
from worldgen.files.grid.reader import loads
from worldgen.files.grid.writer import dumps, world_digest

__all__ = ["dumps", "loads", "read_world", "world_digest", "write_world"]
