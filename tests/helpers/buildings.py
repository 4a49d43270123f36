"""A building with two floors as a trimesh mesh, and in files as other programs write them."""

import numpy as np
import trimesh

LEGS = [((x, y, 0.0), (x + 0.1, y + 0.1, 0.7)) for x in (1.0, 1.9) for y in (1.0, 1.9)]
BUILDING_BOXES = [
    # The ground floor: a slab, outer walls, a partition whose doorway has a lintel, and a table.
    ((0.0, 0.0, -0.1), (6.0, 4.0, 0.0)),
    ((0.0, 0.0, 0.0), (6.0, 0.1, 2.5)),
    ((0.0, 3.9, 0.0), (6.0, 4.0, 2.5)),
    ((0.0, 0.1, 0.0), (0.1, 3.9, 2.5)),
    ((5.9, 0.1, 0.0), (6.0, 3.9, 2.5)),
    ((3.0, 0.1, 0.0), (3.1, 1.5, 2.5)),
    ((3.0, 2.5, 0.0), (3.1, 3.9, 2.5)),
    ((3.0, 1.5, 2.0), (3.1, 2.5, 2.5)),
    ((1.0, 1.0, 0.7), (2.0, 2.0, 0.75)),
    *LEGS,
    # The upper floor: a partition without a door.
    ((0.0, 0.0, 2.5), (6.0, 4.0, 2.6)),
    ((0.0, 0.0, 2.6), (6.0, 0.1, 5.0)),
    ((0.0, 3.9, 2.6), (6.0, 4.0, 5.0)),
    ((0.0, 0.1, 2.6), (0.1, 3.9, 5.0)),
    ((5.9, 0.1, 2.6), (6.0, 3.9, 5.0)),
    ((4.0, 0.1, 2.6), (4.1, 3.9, 5.0)),
    ((0.0, 0.0, 5.0), (6.0, 4.0, 5.1)),
]
"""Low and high corner of each body, m, z up."""


def building(boxes=BUILDING_BOXES):
    """One mesh of boxes, m, z up."""
    return trimesh.util.concatenate([trimesh.creation.box(bounds=np.array(box)) for box in boxes])


def turned_y_up(mesh):
    """The same mesh with y up, as in glTF."""
    mesh = mesh.copy()
    mesh.vertices = np.stack(
        [mesh.vertices[:, 0], mesh.vertices[:, 2], -mesh.vertices[:, 1]], axis=1
    )
    return mesh


def building_file(kind, mesh=None):
    """The bytes that trimesh writes of a building."""
    mesh = building() if mesh is None else mesh
    if kind in ("glb", "gltf"):
        mesh = turned_y_up(mesh)
    if kind == "gltf":
        files = trimesh.Scene(mesh).export(file_type="gltf", merge_buffers=True, embed_buffers=True)
        return files["model.gltf"] if isinstance(files, dict) else files
    if kind == "dae":
        return _collada(mesh)
    data = mesh.export(file_type=kind)
    return data.encode() if isinstance(data, str) else data


def _collada(mesh):
    """A file of COLLADA in centimetres, z up, as a program might write it."""
    corners = " ".join(f"{value * 100:.9g}" for value in mesh.vertices.reshape(-1))
    faces = " ".join(map(str, mesh.faces.reshape(-1).tolist()))
    axes = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="s">
<float_array id="f" count="{mesh.vertices.size}">{corners}</float_array><technique_common>
<accessor source="#f" count="{len(mesh.vertices)}" stride="3">{axes}</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices><triangles count="{len(mesh.faces)}">
<input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="x"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#x"/></scene></COLLADA>""".encode()


def ground_floor(height, cell=0.1):
    """The ground floor's cells, according to the boxes."""
    solid = np.zeros((40, 60), np.bool_)
    for low, high in BUILDING_BOXES:
        if low[2] <= height < high[2]:
            left, bottom, right, top = (round(value / cell) for value in (*low[:2], *high[:2]))
            solid[bottom:top, left:right] = True
    return solid
