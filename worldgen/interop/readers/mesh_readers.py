"""How mesh formats are read.

A cut at a height, with the options that each kind of file leaves open. Source of the axes: glTF
    2.0, section 3.3 (y up, metres); ROS REP 103 (z up), which STL, OBJ and PLY files of
robotics follow, though their formats say nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from worldgen.interop.foreign_map import ForeignMap

__all__ = ["cut_mesh", "metric_reader", "unitless_reader"]

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}


def unitless_reader(kind: str) -> Callable[..., ForeignMap]:
    """Return the reader of a format that has neither unit nor up axis.

    Args:
        kind: ``stl``, ``obj`` or ``ply``.
    """

    def read(
        path: Path,
        *,
        slice_height: float = 0.2,
        cell_size: float = 0.0,
        unit: Literal["m", "cm", "mm", "in"] = "m",
        up: Literal["z", "y"] = "z",
        floor: int = 0,
    ) -> ForeignMap:
        """Return a mesh, cut at a height.

        Args:
            path: The file.
            slice_height: Height of the cut above the floor, m: that of the lidar.
            cell_size: Side of a cell, m; 0: as the file says if worldgen wrote it, else 0.05.
            unit: The file's unit of length.
            up: The axis that points up in the file; Blender's OBJ files have y.
            floor: Which floor, from 0, the lowest.
        """
        return cut_mesh(path, kind, slice_height, cell_size, _METRES[unit], up, floor)

    return read


def metric_reader(kind: str) -> Callable[..., ForeignMap]:
    """Return the reader of glTF, which is in metres, y up.

    Args:
        kind: ``glb`` or ``gltf``.
    """

    def read(
        path: Path,
        *,
        slice_height: float = 0.2,
        cell_size: float = 0.0,
        up: Literal["y", "z"] = "y",
        floor: int = 0,
    ) -> ForeignMap:
        """Return a mesh, cut at a height.

        Args:
            path: The file.
            slice_height: Height of the cut above the floor, m: that of the lidar.
            cell_size: Side of a cell, m; 0: as the file says if worldgen wrote it, else 0.05.
            up: The axis that points up in the file; glTF's is y, but not all exporters heed it.
            floor: Which floor, from 0, the lowest.
        """
        return cut_mesh(path, kind, slice_height, cell_size, 1.0, up, floor)

    return read


def cut_mesh(
    path: Path, kind: str, slice_height: float, cell_size: float, unit: float, up: str, floor: int
) -> ForeignMap:
    """Cut a mesh file; trimesh is imported no sooner.

    Args:
        path: The file.
        kind: Its format.
        slice_height: Above the floor, m.
        cell_size: m; 0: as the file says, or the usual one.
        unit: Metres in the file's unit, where the file does not say it.
        up: ``z`` or ``y``.
        floor: From 0.
    """
    from worldgen.interop.readers.mesh_slice import Plane, read_slice

    return read_slice(path, kind, Plane(slice_height, cell_size, up, unit, floor))
