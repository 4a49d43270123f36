"""Read our own worlds as maps, to try another robot or other places in them."""

from __future__ import annotations

import re
from pathlib import Path

from worldgen.files.grid import read_world
from worldgen.interop.format import HELD, Format
from worldgen.interop.format.foreign_map import ForeignMap, origin_of, read_bounded
from worldgen.world import Value


def _read(path: Path) -> ForeignMap:
    params: dict[str, Value] = {}
    # read_world would wait for a pipe, and read a file of any size.
    read_bounded(path)
    world = read_world(path)
    if world.provenance is not None:
        made = world.provenance
        params["made_by"] = {
            "family": made.family, "version": made.version, "seed": made.seed, "params": dict(made.params),
        }  # fmt: skip
    return ForeignMap(
        world.walls, world.cell_size, params, world=world, origin=origin_of(world), unread=world.unread
    )  # fmt: skip


grid = Format(
    "grid",
    "worldgen's own format, .grid or .grid.gz",
    (".grid", ".gz"),
    re.compile(rb"%worldgen-grid"),
    _read,
    holds=frozenset(HELD),
    changes=True,
    client="worldgen",
)
