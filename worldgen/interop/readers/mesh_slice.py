"""Cut a mesh at the height of a robot's lidar: find the floors, the plane and the cells.

As with a real lidar, anything lower or higher than the plane is not seen: only the legs of a table
appear.

Each format has the options that its kind of file leaves open. Source of the axes: glTF 2.0, section
3.3 (y up, metres); ROS REP 103 (z up), which STL and OBJ files in robotics follow although their
formats do not require it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from worldgen.domain import CELL_SIZES
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop.account import report_unread
from worldgen.interop.format import HELD, LENGTHS, PAIRS, fact_numbers
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot, check_sides
from worldgen.interop.geometry.section import (
    Bodies,
    Section,
    cut,
    open_count,
    paint,
    slack,
    sort_bodies,
)
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import Value

if TYPE_CHECKING:
    from worldgen.interop.readers.mesh_file import RawMesh

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}

# Default, m, if neither the user nor the file gives one.
_USUAL_CELL = 0.05
# Cosine of the steepest slope that counts as a floor.
_FLAT = 0.99
# Levels less than this apart, m, are one floor, with a step or a platform.
_SAME_FLOOR = 0.5
# Fraction of the largest floor's area; a smaller level is a landing or furniture.
_SMALL = 0.25
# Largest number in a file from worldgen.
_FURTHEST = 1e15
# Sizes in m; a smaller or larger building is probably in another unit.
_ODD_SIDES = (0.5, 1000.0)


@dataclass(frozen=True)
class Plane:
    """Where and how to cut a mesh.

    Args:
        height: Height above the floor, m.
        cell_size: Side of a cell, m; 0 means the file's own if worldgen wrote it, otherwise 0.05.
        up: The axis that points up in the file; ``file`` if the file says it.
        unit: Metres per unit of length in the file.
        floor: Number of the floor, from 0, the lowest.
    """

    height: float
    cell_size: float
    up: str
    unit: float
    floor: int


def unitless_reader(kind: str) -> Callable[..., ForeignMap]:
    """Return the reader of a format without unit or up axis.

    Args:
        kind: ``stl`` or ``obj``.
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
        return read_slice(path, kind, Plane(slice_height, cell_size, up, _METRES[unit], floor))

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
        return read_slice(path, kind, Plane(slice_height, cell_size, up, 1.0, floor))

    return read


def read_collada(
    path: Path,
    *,
    slice_height: float = 0.2,
    cell_size: float = 0.0,
    up: Literal["file", "y", "z"] = "file",
    floor: int = 0,
) -> ForeignMap:
    """Read a mesh in COLLADA, which has its unit, cut at a height.

    Args:
        path: The file.
        slice_height: Height of the cut above the floor, m, such as the lidar's.
        cell_size: Side of a cell, m; 0 means 0.05.
        up: The axis that points up; not all exporters write the right one into the file.
        floor: Number of the floor, from 0, the lowest.
    """
    return read_slice(path, "dae", Plane(slice_height, cell_size, up, 1.0, floor))


def read_slice(path: Path, kind: str, plane: Plane) -> ForeignMap:
    """Cut a mesh file and return the cells that are solid in the plane.

    Args:
        path: The file.
        kind: Its format, as for :func:`~worldgen.interop.readers.mesh_file.load_mesh`.
        plane: The cut to make.

    Raises:
        FormatError: If the file breaks its format's rules, or nothing crosses the plane.
        InvalidParameter: If there is no such floor, or a number is out of range.
        InvalidWorld: If there are too many cells.
    """
    # trimesh takes a second to import, so it is imported when a mesh is read.
    from worldgen.interop.readers.mesh_file import load_mesh

    check_between("slice_height", plane.height, 0.0, 1000.0, "m")
    mesh = load_mesh(path, kind)
    plane = replace(plane, up=mesh.up) if plane.up == "file" else plane
    held = _checked(mesh.held) if _as_written(mesh, plane) else {}
    cell_size = plane.cell_size or held.get("cell_size", _USUAL_CELL)
    check_between("cell_size", cell_size, *CELL_SIZES, "m")

    # Convert to metres, z up, and cut.
    vertices = mesh.vertices * plane.unit
    if plane.up == "y":
        vertices = np.stack([vertices[:, 0], 0.0 - vertices[:, 2], vertices[:, 1]], axis=1)
    bodies = sort_bodies(vertices, mesh.faces)
    floors = [0.0] if held else _floors(vertices, mesh.faces, plane.height)
    if not 0 <= plane.floor < len(floors):
        raise InvalidParameter(
            "out-of-range",
            "floor={floor}: the mesh has {count} floors, at {heights} m",
            "use a number from 0",
            floor=plane.floor,
            count=len(floors),
            heights=_listed(floors),
        )
    level = floors[plane.floor]
    section = cut(bodies, level + plane.height)
    report_unread("bodies with holes", open_count(bodies, level + plane.height))
    if not len(section.closed) and not len(section.sheets):
        raise FormatError(
            "nothing-there",
            "there is nothing {height:g} m above floor {floor}, which is at {level:g} m; the mesh "
            "reaches from {low:g} "
            "to {high:g} m",
            "use another slice height, floor, unit or up axis",
            height=plane.height,
            floor=plane.floor,
            level=level,
            low=vertices[:, 2].min(),
            high=vertices[:, 2].max(),
        )

    # Convert to cells.
    size = held.get("size") if held.get("cell_size") == cell_size else None
    origin, width, height = _frame(vertices, cell_size, held.get("origin"), size)
    solid = _cells(section, cell_size, origin, width, height)
    params: dict[str, Value] = {"slice_height": plane.height, "floor": plane.floor, "up": plane.up}
    found = ForeignMap(solid, cell_size, params, origin=origin)
    if not held:
        notes = _notes(plane, floors, bodies)
        return replace(found, notes=notes, warnings=_warnings(vertices))

    # A file from worldgen may have start, target and robot too.
    start = held.get("start")
    target = held.get("target")
    radius = [held["target_radius"]] if "target_radius" in held else []
    robot = ForeignRobot(
        None if start is None else (*start, held.get("heading", 0.0)),
        None if target is None else (*target, *radius),
        held.get("robot_radius"),
        held.get("robot_speed"),
    )
    return replace(found, robots=(robot,))


def _as_written(mesh: RawMesh, plane: Plane) -> bool:
    """Return whether a file from worldgen is read with the up axis and the unit it was written in.

    In any other frame, the facts in the file would describe a different world.
    """
    return plane.up == mesh.up and plane.unit == 1.0


def _checked(held: dict[str, Any]) -> dict[str, Any]:
    """Return the facts in a file from worldgen, if all of them have the right form.

    Otherwise the file is read like any other.
    """
    facts: dict[str, Any] = {}
    for name in ("size", *HELD):
        if held.get(name) is None:
            continue
        numbers = fact_numbers(name, held[name])
        if numbers is None or max(map(abs, numbers)) >= _FURTHEST:
            return {}
        if name in LENGTHS and min(numbers) <= 0:
            return {}
        facts[name] = list(numbers) if name in PAIRS else numbers[0]
    # The grid needs all three of its facts.
    if not {"size", "cell_size", "origin"} <= facts.keys():
        return {}
    facts["size"] = [int(side) for side in facts["size"]]
    return facts


def _floors(vertices: Floats, faces: Ints, height: float) -> list[float]:
    """Return heights, m, of large level surfaces that face up and have something above them.

    If there are none, return the mesh's lowest point.
    """
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(across, axis=1) / 2.0
    level = (across[:, 2] > _FLAT * 2.0 * areas) & (areas > 0.0)
    top = float(vertices[faces.reshape(-1), 2].max())
    lowest = float(vertices[faces.reshape(-1), 2].min())

    # Sum the area by height, to the millimetre. Heights near each other are one floor, at the
    # height of its largest part.
    heights, place = np.unique(np.round(corners[level, :, 2].mean(axis=1), 3), return_inverse=True)
    by_height = np.bincount(place.reshape(-1), weights=areas[level], minlength=len(heights))
    groups: list[list[int]] = []
    for number, one in enumerate(heights.tolist()):
        if one + height >= top:
            continue
        if groups and one - heights[groups[-1][0]] < _SAME_FLOOR:
            groups[-1].append(number)
        else:
            groups.append([number])
    found = [
        (max(group, key=lambda number: by_height[number]), by_height[group].sum())
        for group in groups
    ]
    largest = max((area for _, area in found), default=0.0)
    floors = [float(heights[number]) for number, area in found if area >= _SMALL * largest]
    return floors or [lowest]


def _frame(
    vertices: Floats, cell_size: float, origin: list[float] | None, size: list[int] | None
) -> tuple[tuple[float, float], int, int]:
    """Return the grid's corner, m, and its sides, cells.

    They are the file's own if worldgen wrote it; otherwise they surround the mesh, on whole cells.
    """
    if origin is not None and size is not None:
        check_sides(size[0], size[1])
        return (origin[0], origin[1]), size[0], size[1]
    cell = exact(cell_size)
    ends = np.stack([vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)]) / cell_size
    off = slack(np.abs(ends).max())
    low = [math.floor(value + off) for value in ends[0].tolist()]
    high = [math.ceil(value - off) for value in ends[1].tolist()]
    width, height = (max(b - a, 1) for a, b in zip(low, high, strict=True))
    check_sides(width, height, remedy="use larger cells, or the file's unit if it is not the metre")
    return (float(low[0] * cell), float(low[1] * cell)), width, height


def _cells(
    section: Section, cell_size: float, origin: tuple[float, float], width: int, height: int
) -> Bools:
    corner = np.array([float(exact(value) / exact(cell_size)) for value in origin])
    in_cells = Section(*(segments / cell_size - corner for segments in section))
    furthest = (
        max((float(np.abs(segments).max()) for segments in section if len(segments)), default=0.0)
        / cell_size
    )
    return paint(in_cells, width, height, slack(furthest))


def _notes(plane: Plane, floors: list[float], bodies: Bodies) -> tuple[str, ...]:
    level = floors[plane.floor]
    notes = [
        f"cut {plane.height:g} m above the floor at {level:g} m; parts that end below it or begin "
        "above it are ignored"
    ]
    if len(floors) > 1:
        notes.append(
            f"the mesh has {len(floors)} floors, at {_listed(floors)} m; this is floor "
            f"{plane.floor}"
        )
    if bodies.open_count:
        notes.append(
            f"{bodies.open_count} of {bodies.open_count + bodies.closed_count} bodies are not "
            "closed; their surfaces are walls, and their insides stay free"
        )
    return (*notes, "everything beyond these cells is solid")


def _warnings(vertices: Floats) -> tuple[str, ...]:
    sides = (vertices.max(axis=0) - vertices.min(axis=0)).tolist()
    if _ODD_SIDES[0] <= max(sides[:2]) <= _ODD_SIDES[1]:
        return ()
    return (
        f"the mesh is {sides[0]:g} x {sides[1]:g} x {sides[2]:g} m; if that is wrong, use the "
        "file's unit with +unit",
    )


def _listed(floors: list[float]) -> str:
    return ", ".join(f"{height:g}" for height in floors)
