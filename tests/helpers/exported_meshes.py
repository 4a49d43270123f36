"""Worlds of any cells, and the triangles and nodes of the files that they were exported to."""

import json
import struct

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from worldgen.interop.geometry.boxes import closing_boxes
from worldgen.world import Pose, Target, World

SHAPES = st.tuples(st.integers(1, 7), st.integers(1, 7))
TINY = World(
    np.array([[1, 1, 1, 1], [1, 0, 0, 0], [1, 0, 1, 1]], np.bool_), Pose(0.15, 0.15, 0.5), Target(0.35, 0.15, 0.05),
    robot_radius=0.04, robot_speed=1.5,
)  # fmt: skip


@st.composite
def any_worlds(draw):
    """A world of any cells, and its corner; its border may be open."""
    walls = draw(hnp.arrays(np.bool_, SHAPES, fill=st.nothing()))
    cell = draw(st.sampled_from([0.1, 0.05, 0.3, 1.0]))
    origin = draw(st.tuples(*[st.sampled_from([0.0, -3.7, 12.125])] * 2))
    return World(
        walls, Pose(cell / 2, cell / 2), Target(cell / 2, cell / 2, cell), cell_size=cell
    ), origin


def volume(triangles):
    """Return the volume inside closed shells of (n, 3, 3) corners, from tetrahedra around one of
    the corners.
    """
    triangles = triangles - triangles[:1, :1]
    return np.linalg.det(triangles).sum() / 6.0


def covered_cells(world):
    """Return how many cells the walls cover, including the ring around an open border."""
    ring = closing_boxes(world)
    return world.solid_cells + int(((ring[:, 2] - ring[:, 0]) * (ring[:, 3] - ring[:, 1])).sum())


def solid_volume(world, height):
    """Of the walls, m³."""
    return covered_cells(world) * world.cell_size**2 * height


def stl_triangles(data):
    """The records of a binary STL file: normal, corners, attribute."""
    (count,) = struct.unpack_from("<I", data, 80)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    assert len(data) == 84 + 50 * count
    return np.frombuffer(data, record, offset=84)


def glb_parts(data):
    """The document and the buffer of a binary glTF file."""
    magic, version, length, size = struct.unpack_from("<4sIII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data)) and size % 4 == 0
    return json.loads(data[20 : 20 + size]), data[28 + size :]
