"""Unknown obstacles, put into plain files of each format, and plain files with usual metadata."""

import io
import json
import struct
import zlib

import numpy as np
from PIL import Image

from tests.helpers.buildings import BUILDING_BOXES, building, building_file
from tests.helpers.foreign_samples import picture, samples


def _replaced(old, new, count=1):
    """Return a change of the main file that replaces some bytes."""

    def change(files):
        name, data = next(iter(files.items()))
        assert old in data, (old, data[:400])
        return {**files, name: data.replace(old, new, count)}

    return change


def _appended(more):
    def change(files):
        name, data = next(iter(files.items()))
        return {**files, name: data + more}

    return change


def _instead(data):
    """Return a change that has other contents for the main file."""
    return lambda files: {next(iter(files)): data}


# Gazebo

_MODEL = b"""<model name='new'><static>1</static><link name='l'><collision name='c'>
<geometry>%b</geometry></collision></link></model>"""


def _in_world(part):
    return _replaced(b"</world>", part + b"</world>")


_CLASSIC = b"""<?xml version="1.0"?><!-- saved by a program --><sdf version="1.6"><world name="default">
<gravity>0 0 -9.8</gravity><magnetic_field>6e-06 2.3e-05 -4.2e-05</magnetic_field><atmosphere type="adiabatic"/>
<physics name="p" default="0" type="ode"><max_step_size>0.001</max_step_size></physics>
<scene><ambient>0.4 0.4 0.4 1</ambient><shadows>1</shadows></scene><wind/>
<spherical_coordinates><latitude_deg>0</latitude_deg></spherical_coordinates>
<gui fullscreen="0"><camera name="c"><pose>0 0 9 0 1.5 0</pose></camera></gui>
<light name="sun" type="directional"><cast_shadows>1</cast_shadows><pose>0 0 10 0 0 0</pose></light>
<include><uri>model://ground_plane</uri></include><include><uri>model://sun</uri></include>
<plugin filename="gz-sim-physics-system" name="gz::sim::systems::Physics"/>
<model name="room"><static>1</static><pose frame="">0 0 0 0 0 0</pose><link name="l">%b<gravity>1</gravity>
<self_collide>0</self_collide><kinematic>0</kinematic><inertial><mass>1</mass></inertial>
<enable_wind>0</enable_wind><velocity_decay/>
</link></model>
<state world_name="default"><sim_time>1 2</sim_time><real_time>1 2</real_time><wall_time>1 2</wall_time>
<iterations>4</iterations><model name="room"><pose>0 0 0 0 0 0</pose><scale>1 1 1</scale>
<link name="l"><pose>0 0 0 0 0 0</pose><velocity>0 0 0 0 0 0</velocity><wrench>0 0 0 0 0 0</wrench></link></model>
<light name="sun"><pose>0 0 10 0 0 0</pose></light></state></world></sdf>"""
_WALL = b"""<collision name="c%d"><pose>%b 0.5 0 0 0</pose><geometry><box><size>%b 1</size></box></geometry>
<max_contacts>10</max_contacts><laser_retro>0</laser_retro>
<surface><contact><ode/></contact><friction><ode><mu>1</mu></ode></friction></surface></collision>
<visual name="v%d"><geometry><box><size>1 1 1</size></box></geometry>
<material><script><name>Gazebo/Grey</name></script></material></visual>"""
_SIDES = ((b"0 3", b"8 0.2"), (b"0 -3", b"8 0.2"), (b"4 0", b"0.2 6"), (b"-4 0", b"0.2 6"))
_SAVED = _CLASSIC % b"".join(
    _WALL % (number, pose, size, number) for number, (pose, size) in enumerate(_SIDES)
)

_GAZEBO = {
    "unknown geometry": _in_world(_MODEL % b"<ellipsoid><radii>1 1 1</radii></ellipsoid>"),
    "mesh": _in_world(_MODEL % b"<mesh><uri>model://x.dae</uri></mesh>"),
    "attribute of a shape": _in_world(_MODEL % b"<box scale='5 5 5'><size>0.1 0.1 1</size></box>"),
    "element of a shape": _in_world(
        _MODEL % b"<box><size>0.1 0.1 1</size><more>5 5 5</more></box>"
    ),
    "second size": _in_world(_MODEL % b"<box><size>0.1 0.1 1</size><size>5 5 5</size></box>"),
    "second pose": _in_world(
        (_MODEL % b"<box><size>0.1 0.1 1</size></box>").replace(
            b"<link", b"<pose>0.2 0.2 0 0 0 0</pose><pose>0.5 0.2 0 0 0 0</pose><link"
        )
    ),
    "new element": _in_world(b"<obstacle><size>1 1 1</size></obstacle>"),
    "actor": _in_world(b"<actor name='a'><skin/></actor>"),
    "include": _in_world(b"<include><uri>model://shelf</uri></include>"),
    "xinclude": _in_world(b"<xi:include xmlns:xi='x' href='more.sdf'/>"),
    "state scales a model": _in_world(
        _MODEL % b"<box><size>0.1 0.1 1</size></box>"
        + b"<state><model name='new'><pose>0 0 0 0 0 0</pose><scale>5 5 5</scale></model></state>"
    ),
    "state moves a link": _in_world(
        _MODEL
        % b"<box><size>0.1 0.1 1</size></box>"
        + b"<state><model name='new'><pose>0 0 0 0 0 0</pose><link name='l'><pose>0.3 0 0 0 0 0"
        b"</pose></link></model></state>"
    ),
    "state deletes": _in_world(b"<state><deletions><name>x</name></deletions></state>"),
    "pose in another frame": _in_world(
        (_MODEL % b"<box><size>0.1 0.1 1</size></box>").replace(
            b"<link", b"<pose relative_to='x'>0 0 0 0 0 0</pose><link"
        )
    ),
    "placement frame": _in_world(
        (_MODEL % b"<box><size>0.1 0.1 1</size></box>")
        .replace(b"name='new'", b"name='new' placement_frame='l'")
        .replace(b"<static>", b"<pose>0.15 0.15 0.5 0 0 0</pose><static>")
        .replace(b"<link name='l'>", b"<link name='l'><pose>5 5 0 0 0 0</pose>")
    ),
    "joint": _in_world(
        (_MODEL % b"<box><size>0.1 0.1 1</size></box>")
        .replace(b"<static>1</static>", b"")
        .replace(b"</model>", b"<joint name='j' type='prismatic'/></model>")
    ),
    "plugin": _in_world(b"<plugin filename='libspawn_walls.so' name='spawn'/>"),
    "second world": _replaced(b"</world>", b"</world><world name='b'/>"),
    "model next to the world": _replaced(b"</world>", b"</world><model name='m'/>"),
    "text": _in_world(_MODEL % b"box 5 5 5"),
}

# Tiled


def _json(change):
    """Return a change of the main file's JSON."""

    def changed(files):
        name, data = next(iter(files.items()))
        document = json.loads(data)
        change(document)
        return {**files, name: json.dumps(document).encode()}

    return changed


def _tiled(*layers, **more):
    def change(document):
        document["layers"] += layers
        document.update(more)

    return _json(change)


_RECTANGLE = {
    "id": 9,
    "name": "",
    "type": "",
    "x": 32,
    "y": 32,
    "width": 16,
    "height": 16,
    "rotation": 0,
    "visible": True,
}
_OBJECTS = {"type": "objectgroup", "name": "Collisions", "objects": [_RECTANGLE], "id": 9}


def _tiles(document, name="more"):
    return {
        "type": "tilelayer", "name": name, "width": document["width"], "height": document["height"], "id": 7,
        "data": [1] * (document["width"] * document["height"]), "x": 0, "y": 0, "opacity": 1, "visible": True,
    }  # fmt: skip


def _walls(document):
    return next(layer for layer in document["layers"] if layer["name"] == "walls")


_TILED = {
    "rectangle": _tiled(_OBJECTS),
    "polygon": _tiled(
        {
            **_OBJECTS,
            "objects": [
                {
                    "x": 32,
                    "y": 32,
                    "polygon": [{"x": 0, "y": 0}, {"x": 9, "y": 0}, {"x": 0, "y": 9}],
                }
            ],
        }
    ),
    "objects of a layer that may be walls": _tiled({**_OBJECTS, "name": "things"}),
    "tiles of a set that is missing": _json(
        lambda d: (
            d["tilesets"].append({"firstgid": 5, "source": "../up.tsx"})
            or d["layers"].append({**_tiles(d, "Ground"), "data": [5] * (d["width"] * d["height"])})
        )
    ),
    "template": _tiled({**_OBJECTS, "objects": [{"id": 3, "template": "wall.tx", "x": 1}]}),
    "second layer": _json(lambda d: d["layers"].append(_tiles(d))),
    "a few tiles of terrain": _json(
        lambda d: d["layers"].append(
            {
                **_tiles(d, "Terrain"),
                "data": [int(k % d["width"] == 1) for k in range(d["width"] * d["height"])],
            }
        )
    ),
    "second layer, packed": _json(
        lambda d: d["layers"].append(
            {**_tiles(d), "encoding": "base64", "compression": "zstd", "data": "AAAA"}
        )
    ),
    "layer in a group": _json(
        lambda d: d["layers"].append({"type": "group", "name": "g", "layers": [_tiles(d)]})
    ),
    "objects in a group": _tiled({"type": "group", "name": "g", "layers": [_OBJECTS]}),
    "offset in tiles": _json(lambda d: _walls(d).update(x=1)),
    "image layer": _tiled({"type": "imagelayer", "name": "i", "image": "walls.png"}),
    "unknown layer": _tiled({"type": "blocklayer", "blocks": [1]}),
    "unknown key": _tiled(obstacles=[{"x": 1}]),
    "unknown key of the walls": _json(lambda d: _walls(d).update(extrudes=2)),
    "large tiles": _json(lambda d: d["tilesets"][0].update(tileheight=32)),
    "layers twice": _replaced(b"{", b'{"layers": [{"type": "tilelayer", "data": [1]}],'),
}


def _tiled_with_metadata(document):
    document["layers"] = [
        _tiles(document, "Ground"),
        {**_tiles(document, "empty"), "data": [0] * (document["width"] * document["height"])},
        {"type": "group", "name": "all", "id": 12, "layers": document["layers"], "opacity": 1, "visible": True},
        {
            "type": "objectgroup", "name": "labels", "color": "#ff0000", "draworder": "index", "opacity": 1, "id": 8,
            "objects": [
                {"id": 4, "name": "Kitchen", "x": 3, "y": 4, "text": {"text": "Kitchen"}, "width": 9, "height": 9},
                {"id": 5, "name": "dock", "point": True, "x": 3, "y": 4},
            ],
        },
    ]  # fmt: skip
    document |= {
        "backgroundcolor": "#112233", "class": "", "editorsettings": {"export": {"target": "x.json"}}, "locked": False,
        "parallaxoriginx": 0,
    }  # fmt: skip
    document["tilesets"].append({"firstgid": 90, "source": "furniture.tsx"})


# Drawings

_SVG = {
    "foreign object": _replaced(b"</svg>", b"<foreignObject width='1' height='1'/></svg>"),
    "picture": _replaced(b"</svg>", b"<image href='walls.png' width='1' height='1'/></svg>"),
    "unknown element": _replaced(b"</svg>", b"<wall x='1'/></svg>"),
    "shape": _replaced(b"</svg>", b"<rect x='.2' y='-.3' width='.1' height='.1'/></svg>"),
    "use of another file": _replaced(b"</svg>", b"<use href='other.svg#wall'/></svg>"),
    "mask": _replaced(b'<g id="world"', b'<g mask="url(#m)" id="world"'),
    "markers": _replaced(b"</svg>", b"<line x2='.1' stroke='red' marker-end='url(#m)'/></svg>"),
    "animation": _replaced(b"</svg>", b"<animateMotion path='M0 0L1 1'/></svg>"),
}  # fmt: skip
_GEOJSON = {
    "polygon": _json(
        lambda d: d["features"].append(
            {
                "type": "Feature", "properties": {},
                "geometry": {"type": "Polygon", "coordinates": [[[0.2, 0.2], [0.3, 0.2], [0.3, 0.3], [0.2, 0.2]]]},
            }
        )
    ),
    "unknown geometry": _json(
        lambda d: d["features"].append({"type": "Feature", "geometry": {"type": "Circle", "coordinates": [1, 1]}})
    ),
    "unknown key": _json(lambda d: d.update(obstacles=[{"x": 1}])),
    "unknown key of a feature": _json(lambda d: d["features"][0].update(extrudes=2)),
}  # fmt: skip


def _entity(*tags):
    return _replaced(
        b"  0\nENDSEC", "".join(f"{tag}\n" for tag in (0, *tags)).encode() + b"  0\nENDSEC"
    )


_DXF = {
    "line": _entity("LINE", 8, "Furniture", 10, 1, 20, 1, 11, 3, 21, 2),
    "unknown entity": _entity("WALLSEGMENT", 8, "0", 10, 1, 20, 1),
    "point cloud": _entity("ACDBPOINTCLOUD", 8, "0"),
    "block that is not there": _entity("INSERT", 8, "0", 2, "CHAIR", 10, 1, 20, 1),
}
_BUILDING = {
    "wall": _replaced(b"    walls:\n", b"    walls:\n      - [0, 5, {}]\n"),
    "model": _appended(
        b"    models:\n      - {model_name: Chair, name: c, x: 1, y: 1, yaw: 0, z: 0}\n"
    ),
    "lift": _appended(b"lifts:\n  Lift1: {depth: 2, width: 2, x: 1, y: 1, yaw: 0}\n"),
    "unknown key": _appended(b"obstacles:\n  - [1, 1]\n"),
    "unknown key of the level": _appended(b"    pillars:\n      - [1, {}]\n"),
}


# Webots

_WEBOTS = {
    "unknown PROTO": _appended(b"WoodenBox { size 0.2 0.2 0.2 }"),
    "empty PROTO": _appended(b"Group { children [ E-puck { } ] }"),
    "PROTO in a body": _replaced(b"boundingObject", b"children [ Chair { } ] boundingObject"),
    "PROTO of the project with a known name": _replaced(b"webots://projects/objects/", b"../"),
    "mesh": _appended(b'Shape { geometry Mesh { url "a.dae" } }'),
    "mesh that bounds": _appended(b"Solid { boundingObject IndexedFaceSet { } }"),
    "box without a size": _appended(b"Solid { boundingObject Box { } }"),
    "field of a used shape": _replaced(b"size 0.1,", b"inflate 2 size 0.1,"),
    "joint": _appended(b"HingeJoint { endPoint Solid { boundingObject Box { size 1 1 1 } } }"),
    "moving body": _replaced(b"boundingObject", b"linearVelocity 1 0 0 boundingObject"),
    "supervisor": _appended(b"Robot { supervisor TRUE }"),
    "second robot": _appended(2 * b"Robot { children [ Camera { } ] }"),
    "skewed": _appended(
        b"Transform { scale 1 2 1 children [ Pose { rotation 0 0 1 0.5 children [ Shape { geometry Box "
        b"{ size 0.1 0.1 0.1 } } ] } ] }"
    ),
    "plane on edge": _appended(b"Solid { rotation 1 0 0 1.5708 boundingObject Plane { } }"),
    "floor below": _appended(b"Floor { translation 0 0 -0.2 }"),
    "body that falls": _appended(
        b"Solid { translation 0 0 3 boundingObject Sphere { radius 0.2 } physics Physics { } }"
    ),
    "box": _appended(b"Shape { geometry Box { size 0.2 0.2 0.4 } }"),
}

# glTF


def _gltf_parts(data):
    """Return the document and the rest of a binary file."""
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[20 + size :]


def _glb(document, rest):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    size = 20 + len(text) + len(rest)
    return struct.pack("<4sIIII4s", b"glTF", 2, size, 0, len(text), b"JSON"[:4])[:12] + (
        struct.pack("<I4s", len(text), b"JSON") + text + rest
    )


def _scene(change):
    """Return a change of a glTF document, in either form."""

    def changed(files):
        name, data = next(iter(files.items()))
        document, rest = _gltf_parts(data) if data[:4] == b"glTF" else (json.loads(data), None)
        change(document)
        made = json.dumps(document).encode() if rest is None else _glb(document, rest)
        return {**files, name: made}

    return changed


def _primitive(document):
    return document["meshes"][0]["primitives"][0]


def _node(document):
    return next(node for node in document["nodes"] if "mesh" in node)


def _second_scene(document):
    document.setdefault("scenes", []).append({"nodes": [len(document["nodes"])]})
    document["nodes"].append({"mesh": 0, "translation": [1, 0, 0]})


_SPARSE = {
    "count": 1,
    "indices": {"bufferView": 0, "componentType": 5123},
    "values": {"bufferView": 0},
}
_SCENE = {
    "draco": _scene(lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"])),
    "unknown requirement": _scene(lambda d: d.update(extensionsRequired=["VND_hidden_walls"])),
    "unknown extension": _scene(lambda d: d.update(extensionsUsed=["VND_more_walls"])),
    "extension of a node": _scene(lambda d: _node(d).update(extensions={"VND_wall": {"h": 2}})),
    "extension of the file": _scene(lambda d: d.update(extensions={"VND_walls": [1]})),
    "sparse accessor": _scene(lambda d: d["accessors"][0].update(sparse=_SPARSE)),
    "morph target": _scene(
        lambda d: _primitive(d).update(
            targets=[{"POSITION": _primitive(d)["attributes"]["POSITION"]}]
        )
    ),
    "skin": _scene(lambda d: (_node(d).update(skin=0), d.update(skins=[{"joints": [0]}]))),
    "animation": _scene(
        lambda d: d.update(animations=[{"channels": [{"sampler": 0, "target": {"node": 0}}]}])
    ),
    "second scene": _scene(_second_scene),
    "node outside the scene": _scene(lambda d: d["nodes"].append({"mesh": 0})),
    "unknown key": _scene(lambda d: d.update(walls=[{"from": 1}])),
    "unknown key of a node": _scene(lambda d: _node(d).update(repeat=4)),
    "fan": _scene(lambda d: d["meshes"][0]["primitives"].append({**_primitive(d), "mode": 6})),
    "points": _scene(lambda d: d["meshes"][0]["primitives"].append({**_primitive(d), "mode": 0})),
    "lines": _scene(lambda d: d["meshes"][0]["primitives"].append({**_primitive(d), "mode": 1})),
}


def _scene_with_metadata(document):
    document["asset"] |= {"copyright": "somebody", "generator": "Blender"}
    document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    document["nodes"].append({"name": "camera", "camera": 0})
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    document["extensionsUsed"] = ["KHR_materials_unlit", "KHR_lights_punctual"]
    document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}}
    document["materials"] = [{"name": "m", "extensions": {"KHR_materials_unlit": {}}}]
    document["images"] = [{"uri": "x.png"}]
    document["textures"] = [{"source": 0}]
    document["extras"] = {"made": "by hand"}
    _node(document)["extras"] = {"layer": 4}
    _primitive(document)["material"] = 0


def _chunk(data):
    """Return a binary file with one more chunk."""
    whole = data + struct.pack("<I4s", 8, b"WALL") + b"\1" * 8
    return whole[:8] + struct.pack("<I", len(whole)) + whole[12:]


# Meshes


def holed(kind):
    """A building of which 3 % of the triangles of its walls at the lidar's height are missing."""
    mesh = building()
    heights = mesh.vertices[mesh.faces][:, :, 2]
    at_lidar = np.flatnonzero((heights.min(axis=1) < 0.2) & (heights.max(axis=1) > 0.2))
    kept = np.ones(len(mesh.faces), np.bool_)
    kept[at_lidar[:: max(len(at_lidar) // (3 * len(mesh.faces) // 100), 1)]] = False
    mesh.update_faces(kept)
    return building_file(kind, mesh)


def _npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


# Pictures

_DARK = np.zeros((5, 7), np.uint8)


def _frames(files, which):
    """Return the files with a picture of two frames, the second one all walls."""
    first = Image.open(io.BytesIO(files[which])).convert("L")
    data = picture(first, save_all=True, append_images=[Image.fromarray(np.zeros_like(first))])
    return {**files, which: data}


def png_chunk(kind, body):
    """A chunk of a PNG."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def _with_chunk(data, chunk):
    at = data.index(b"IDAT") - 4
    return data[:at] + chunk + data[at:]


def _main(files):
    return next(iter(files))


_PNG = {
    "frames": lambda files: _frames(files, _main(files)),
    "unknown chunk": lambda files: {
        _main(files): _with_chunk(files[_main(files)], png_chunk(b"waLl", b"layer"))
    },
    "layers of an editor": lambda files: {
        _main(files): _with_chunk(files[_main(files)], png_chunk(b"mkBS", b"layer"))
    },
    "second picture": lambda files: {_main(files): 2 * files[_main(files)]},
}
_ROS_PNG = {
    f"picture: {label}": lambda files, change=change: {
        **files, "i.png": change({"i.png": files["i.png"]})["i.png"]
    }
    for label, change in _PNG.items()
}  # fmt: skip


# The index of the sample that is changed, and the changes by what they add.
INJECTIONS = {
    "sdf": (0, _GAZEBO),
    "tiled": (0, _TILED),
    "svg": (0, _SVG),
    "geojson": (0, _GEOJSON),
    "dxf": (0, _DXF),
    "building": (0, _BUILDING),
    "webots": (0, _WEBOTS),
    "glb": (
        0,
        _SCENE
        | {
            "chunk": lambda f: {_main(f): _chunk(f[_main(f)])},
            "bytes after the last chunk": _appended(b"wall"),
            "hole": _instead(holed("glb")),
        },
    ),
    "gltf": (0, _SCENE | {"hole": _instead(holed("gltf"))}),
    "dae": (
        0,
        {
            "skin": _replaced(b"</node>", b'<instance_controller url="#c"/></node>'),
            "missing mesh": _replaced(b"</node>", b'<instance_geometry url="#h"/></node>'),
            "missing node": _replaced(b"</node>", b'<instance_node url="other.dae#n"/></node>'),
            "hole": _instead(holed("dae")),
        },
    ),
    "obj": (
        0,
        {
            "point": _appended(b"\np 1 2\n"),
            "line": _appended(b"\nl 1 2\n"),
            "curve": _appended(b"\ncstype bezier\ncurv 0 1 1 2 3 4\nend\n"),
            "unknown line": _appended(b"\nwall 0 0 0 1 1 1\n"),
            "continued line": _appended(b"\nsurf 0 1 \\\n 1 2 3\n"),
            "hole": _instead(holed("obj")),
        },
    ),
    "stl": (
        0,
        {
            "bytes at the end": _appended(b"more walls"),
            "hole": _instead(holed("stl")),
            "unknown words": _instead(
                b"solid a\nwall 1 2 3\n"
                + b"".join(
                    b"facet normal 0 0 1\nouter loop\n"
                    + b"".join(b"vertex %g %g %g\n" % tuple(corner) for corner in triangle)
                    + b"endloop\nendfacet\n"
                    for triangle in building(BUILDING_BOXES[:9]).triangles
                )
                + b"endsolid a\n"
            ),
        },
    ),
    "ros": (
        1,
        {
            "unknown key": _appended(b"obstacles: [[1, 1, 2, 2]]\n"),
            "second picture": _appended(b"image2: more.png\n"),
            "layers": _appended(b"layers:\n  - {image: keepout.png}\n"),
            **_ROS_PNG,
        },
    ),
    "png": (0, _PNG),
    "irsim": (
        0,
        {
            "unknown key": _appended(b"walls:\n  - [0, 0, 1, 1]\n"),
            "unknown key of the world": _replaced(b"world:\n", b"world:\n  blocks: [1, 2]\n"),
            "unknown key of an obstacle": _replaced(b"  - number:", b"  - scale: 4\n    number:"),
            "unknown key of a shape": _replaced(
                b"{name: rectangle,", b"{name: rectangle, inflate: 2,"
            ),
            "moving obstacle": _appended(
                b"  - kinematics: {name: diff}\n    state: [0.2, 0.2, 0]\n"
            ),
            "random obstacle": _appended(b"  - number: 2\n    distribution: {name: random}\n"),
            "unknown shape": _appended(b"  - shape: {name: blob}\n    state: [0.2, 0.2, 0]\n"),
        },
    ),
    "pogema": (
        0,
        {
            "unknown sign": _replaced(b".", b"%"),
            "longer row": _replaced(b"\n", b"#\n"),
            "unknown key": _instead(
                b"map: |-\n  a..\n  ..A\nnum_agents: 1\nobstacles:\n  - [0, 1]\n"
            ),
        },
    ),
    "text": (0, {"unknown sign": _replaced(b".", b"%"), "longer row": _replaced(b"\n", b"#\n")}),
    "movingai": (
        0,
        {
            "unknown sign": _replaced(b"..", b".%"),
            "more rows": _appended(b"@@@@@\r\n"),
            "longer row": _appended(b"@"),
            "other type": _replaced(b"octile", b"octile-corner"),
        },
    ),
    "micromouse": (
        0,
        {"unknown wall": _replaced(b"---", b"-=-"), "unknown square": _replaced(b"    ", b"  % ")},
    ),
    "minigrid": (
        0,
        {
            "unknown thing": _replaced(b"  ", b"XG"),
            "half a cell": _replaced(b"\n", b"W\n"),
            "box": _replaced(b"  ", b"BR"),
        },
    ),
    "npy": (
        0,
        {
            "bytes at the end": _appended(b"\1\1"),
            "third axis": _instead(_npy(np.ones((5, 7, 2), np.bool_))),
        },
    ),
    "thesis": (
        0,
        {
            "bytes at the end": _appended(b"\x77\x04\xff\xff\xff\xfe"),
            "object": _appended(b"\x73"),
            "wall": _replaced(struct.pack(">i", 0), struct.pack(">i", -3)),
        },
    ),
    "grid": (
        0,
        {
            "unknown section": _replaced(b"%end", b"%walls\n1 1\n%end"),
            "unknown key": _replaced(b"cell_size", b"walls = [1]\ncell_size"),
            "unknown sign": _replaced(b"#.", b"#%"),
            "what another import left unread": _replaced(
                b"%cells",
                b'[provenance]\nfamily = "import"\nversion = 3\nseed = 0\n'
                b'params = { unread = ["1 wall"] }\n%cells',
            ),
        },
    ),
}
"""For each format, the number of a sample and changes of it, by what they add."""

WITH_METADATA = {
    "saved by Gazebo": {"saved.world": _SAVED},
    "Webots": {
        "w.wbt": samples("webots")[0]["room.wbt"]
        + b'TexturedBackground { texture "mountains" } TexturedBackgroundLight { }\n'
        b"PointLight { location 0 0 1 } Floor { size 9 9 tileSize 1 1 appearance Parquetry { } }\n"
        b'Robot { children [ DEF BODY Shape { geometry Mesh { url "r.dae" } } Camera { } ] '
        b'boundingObject USE BODY name "mine" hidden position_0_0 1.5 controller "c" }\n'
    },
    "Tiled": _json(_tiled_with_metadata)(samples("tiled")[0]),
    "glTF of Blender": _scene(_scene_with_metadata)(samples("gltf")[0]),
    "binary glTF of Blender": _scene(_scene_with_metadata)(samples("glb")[0]),
    "OBJ of Blender": {
        "b.obj": b"# Blender\nmtllib b.mtl\no Cube\nusemtl None\ns off\nvt 0 0\nvn 0 0 1\n"
        + building_file("obj")
    },
    "picture of GIMP": {
        "p.png": _with_chunk(
            picture(Image.fromarray(np.where(_DARK == 0, 255, 0).astype(np.uint8)), dpi=(72, 72)),
            png_chunk(b"tIME", bytes([7, 230, 1, 1, 1, 1, 1]))
            + png_chunk(b"tEXt", b"Comment\0made with GIMP"),
        )
    },
    "ROS map with names": {
        **samples("ros")[1],
        "i.yaml": samples("ros")[1]["i.yaml"]
        + b"mode: trinary\n# a comment\nname: office\nframe_id: map\n",
    },
    "IR-SIM with colours": {
        "w.yaml": b"world:\n  name: w\n  height: 4\n  width: 4\n  step_time: 0.1\n  control_mode: auto\n"
        b"  collision_mode: stop\ngui:\n  keyboard: {global_listener: true}\nrobot:\n"
        b"  - kinematics: {name: diff}\n    shape: {name: circle, radius: 0.2}\n    state: [1, 1, 0]\n"
        b"    goal: [3, 3, 0]\n    behavior: {name: dash}\n    color: g\n    plot: {show_trajectory: true}\n"
        b"    sensors:\n      - {name: lidar2d, range_min: 0, number: 100, noise: false}\n"
        b"obstacle:\n  - shape: {name: circle, radius: 0.3}\n    state: [2, 2, 0]\n    color: k\n"
    },
    "POGEMA with a seed": {
        "p.yaml": b"map: |-\n  a..\n  ..A\nnum_agents: 1\nobs_radius: 5\nseed: 3\nmax_episode_steps: 64\n"
    },
}
"""Plain files with what programs usually write besides walls."""
