"""Readers of the mesh formats.

Each cuts at a height, with the options that its kind of file leaves open. Source of the axes: glTF
    2.0, section 3.3 (y up, metres); ROS REP 103 (z up), which STL, OBJ and PLY files in robotics
    follow although their formats do not require it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from worldgen.interop.foreign_map import ForeignMap

__all__ = ["cut_mesh", "metric_reader", "unitless_reader"]

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}


def unitless_reader(kind: str) -> Callable[..., ForeignMap]:
    """Return the reader of a format without unit or up axis.

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
        """Read a mesh, cut at a height.

        Args:
            path: The file.
            slice_height: Height of the cut above the floor, m, such as the lidar's.
            cell_size: Side of a cell, m; 0 means the file's own if worldgen wrote it, otherwise
                0.05.
            unit: The file's unit of length.
            up: The axis that points up in the file; in Blender's OBJ files it is y.
            floor: Number of the floor, from 0, the lowest.
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
        """Read a mesh, cut at a height.

        Args:
            path: The file.
            slice_height: Height of the cut above the floor, m, such as the lidar's.
            cell_size: Side of a cell, m; 0 means the file's own if worldgen wrote it, otherwise
                0.05.
            up: The axis that points up in the file; glTF's is y, but not all exporters follow it.
            floor: Number of the floor, from 0, the lowest.
        """
        return cut_mesh(path, kind, slice_height, cell_size, 1.0, up, floor)

    return read


def cut_mesh(
    path: Path, kind: str, slice_height: float, cell_size: float, unit: float, up: str, floor: int
) -> ForeignMap:
    """Cut a mesh file; trimesh is not imported before.

    Args:
        path: The file.
        kind: Its format.
        slice_height: Height above the floor, m.
        cell_size: Side of a cell, m; 0 means the file's own, or the default.
        unit: Metres per unit of the file, if the file does not give it.
        up: ``z`` or ``y``.
        floor: Number of the floor, from 0.
    """
    from worldgen.interop.readers.mesh_slice import Plane, read_slice

    return read_slice(path, kind, Plane(slice_height, cell_size, up, unit, floor))
