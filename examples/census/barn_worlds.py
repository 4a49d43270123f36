"""The static worlds of the BARN Challenge: Gazebo files of round posts.

Source: github.com/Daffan/the-barn-challenge, jackal_helper/worlds/BARN (MIT licence).

The posts are circles, cells are squares, so the truth lies between two rasters. With ``raster=outer`` a cell is solid
if a post reaches into it: what is reachable there is reachable. With ``raster=inner`` it is solid if it lies in a
post: what is blocked there is blocked. With ``cell=0.15`` the outer raster is the grid that the worlds were made from.

The frame is 4.5 m x 15 m, as wide as the posts stand; beyond is solid here and open ground in Gazebo, where a robot
could drive round all posts. Start and goal are those of the challenge; it counts as there within 1 m.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from worldgen.census import CensusMap, Ends
from worldgen.world import Pose, Target

LEFT, WIDTH, HEIGHT = -4.5, 4.5, 15.0  # m
START, GOAL = (-2.25, 3.0), (-2.25, 13.0)


def maps(seed: int, *, folder: str = "BARN", cell: float = 0.025, raster: str = "outer") -> Iterator[CensusMap]:
    """The worlds of a folder, by number; ``seed`` makes no difference."""
    files = sorted(Path(folder).glob("world_*.world"), key=lambda file: int(file.stem.partition("_")[2]))
    if not files:
        raise FileNotFoundError(f"{folder} has no world_*.world; name the challenge's jackal_helper/worlds/BARN")
    shift = (-LEFT, 0.0)
    ends = Ends(
        Pose(START[0] + shift[0], START[1], 1.5707963), Target(GOAL[0] + shift[0], GOAL[1], 1.0)
    )  # fmt: skip
    for file in files:
        posts = _posts(file)
        yield CensusMap(file.stem, _raster(posts, cell, outer=raster == "outer"), cell, (ends,), {"raster": raster})


def _posts(file: Path) -> list[tuple[float, float, float]]:
    """x, y and radius, m, of every upright cylinder."""
    posts = []
    for model in ET.parse(file).getroot().iterfind("world/model"):
        radius = model.findtext("link/collision/geometry/cylinder/radius")
        if radius is not None:
            x, y, *_ = model.findtext("pose", "0 0").split()
            posts.append((float(x), float(y), float(radius)))
    return posts


def _raster(posts: Any, cell: float, *, outer: bool) -> Any:
    """(rows, columns) bool, row 0 the lowest: cells whose nearest (or, inner, farthest) point is in a post."""
    rows, columns = round(HEIGHT / cell), round(WIDTH / cell)
    low_x, low_y = np.arange(columns) * cell + LEFT, np.arange(rows) * cell
    solid = np.zeros((rows, columns), np.bool_)
    for x, y, radius in posts:
        across = _distance(x, low_x, low_x + cell, outer=outer)
        along = _distance(y, low_y, low_y + cell, outer=outer)
        squared = along[:, None] ** 2 + across[None, :] ** 2
        # A cell that a post only touches is not in its way: rounding must not make it so, nor lose one that lies in it.
        solid |= squared < radius**2 - 1e-9 if outer else squared <= radius**2 + 1e-9
    return solid


def _distance(centre: float, low: Any, high: Any, *, outer: bool) -> Any:
    if outer:
        return np.maximum(np.maximum(low - centre, centre - high), 0.0)
    return np.maximum(np.abs(low - centre), np.abs(high - centre))
