"""Gazebo worlds of several files: included models, meshes, frames; and files that mean harm."""

import importlib.util
import math

import numpy as np
import pytest
import shapely
import trimesh

from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import ImportedRobot, import_world, read_map
from worldgen.interop.readers.gazebo_models import Model

SDF = "<sdf version='1.9'>{}</sdf>"
WORLD = "<sdf version='1.9'><world name='w'>{}</world></sdf>"
CONFIG = "<model><name>m</name><sdf version='1.6'>model.sdf</sdf></model>"
BOX = "<box><size>{}</size></box>"


def collision(geometry, pose=""):
    place = f"<pose>{pose}</pose>" if pose else ""
    return f"<collision name='c'>{place}<geometry>{geometry}</geometry></collision>"


def model(name, inner, pose="", **attributes):
    place = f"<pose>{pose}</pose>" if pose else ""
    more = "".join(f" {key}='{value}'" for key, value in attributes.items())
    return f"<model name='{name}'{more}><static>1</static>{place}{inner}</model>"


def link(inner, pose="", name="l"):
    place = f"<pose>{pose}</pose>" if pose else ""
    return f"<link name='{name}'>{place}{inner}</link>"


def include(uri, inner=""):
    return f"<include><uri>{uri}</uri>{inner}</include>"


def mesh(uri, scale=""):
    size = f"<scale>{scale}</scale>" if scale else ""
    return f"<mesh><uri>{uri}</uri>{size}</mesh>"


def solid(size, move=(0, 0, 0), scale=1.0):
    box = trimesh.creation.box(np.array(size) * scale)
    box.apply_translation(np.array(move) * scale)
    return box


def put_down(folder, files):
    """Write files by their path, and return the path of the first."""
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data.encode() if isinstance(data, str) else data)
    return folder / next(iter(files))


def rows(found):
    return ["".join("#" if cell else "." for cell in row) for row in found.walls[::-1]]


# A wall of 1.0 x 0.2 m about (0.5, 0.1), and a post of 0.2 x 0.4 m about (0.9, 0.6).
SEEN = ["........##"] * 4 + [".........."] * 2 + ["##########"] * 2
WALL = collision(BOX.format("1 0.2 1"))
POST = collision(BOX.format("0.2 0.4 1"))
ROOM = SDF.format(
    model("room", link(WALL, "0.5 0.1 0.5 0 0 0") + link(POST, "0.9 0.6 0.5 0 0 0", "m"))
)
IN_FOLDER = {"room/model.config": CONFIG, "room/model.sdf": ROOM}
IN_MODELS = {f"models/{name}": data for name, data in IN_FOLDER.items()}
AWAY = ROOM.replace("1 0.2 1", "5 5 5")
TWO_VERSIONS = CONFIG.replace(
    "</sdf>", "</sdf><sdf version='1.10'>new.sdf</sdf><sdf version='2.0'>later.sdf</sdf>"
)
OUTER = model("outer", include("model://room", "<pose>0 0 0 0 0 -1.5707963267949</pose>"))
BARE = SDF.format(model("wall", link(WALL)))
POST_AT = link(POST, "0.9 0.6 0.5 0 0 0", "m")
FRAMES = (
    "<frame name='far'><pose degrees='true'>0.9 0.1 0.5 0 0 90</pose></frame>"
    "<frame name='here' attached_to='far'><pose>0.4 0 0 0 0 0</pose></frame>"
)
RING = "".join(
    f"<polyline>{''.join(f'<point>{x} {y}</point>' for x, y in ring)}<height>1</height></polyline>"
    for ring in (
        [(0, 0), (1, 0), (1, 0.8), (0, 0.8), (0, 0)],
        [(0, 0.2), (0, 0.8), (0.8, 0.8), (0.8, 0.4), (1, 0.4), (1, 0.2)],
    )
)
BOTH = trimesh.util.concatenate(
    [solid((1, 0.2, 1), (0.5, 0.1, 0.5)), solid((0.2, 0.4, 1), (0.9, 0.6, 0.5))]
)
MIRRORED = BOTH.copy().apply_transform(np.diag([100.0, -100.0, 100.0, 1.0]))


def of_mesh(kind, data, scale="", pose=""):
    """Files of a model of one mesh, and of a world that includes it."""
    inner = link(collision(mesh(f"model://room/meshes/a.{kind}", scale), pose))
    return {
        "w.sdf": WORLD.format(include("model://room")),
        "room/model.sdf": SDF.format(model("room", inner)),
        f"room/meshes/a.{kind}": data,
    }


SAME = {
    "beside": {"w.world": WORLD.format(include("model://room")), **IN_FOLDER},
    "in models": {
        "w.world": WORLD.format(include("model://room/") + include("model://sun")),
        "models/sun/model.sdf": SDF.format("<light type='directional' name='sun'/>"),
        **IN_MODELS,
    },
    "in models next to worlds": {
        "worlds/w.world": WORLD.format(include("file://models/room")), **IN_MODELS,
    },
    "of the server": {
        "w.world": WORLD.format(include("https://fuel.gazebosim.org/1.0/Me/models/Room/3")),
        "models/room/3/model.sdf": ROOM,
    },
    "relative": {"w.world": WORLD.format(include("./room/model.sdf")), **IN_FOLDER},
    "alone": {"room/model.sdf": ROOM},
    "newest version that exists": {
        "w.world": WORLD.format(include("model://room")),
        "room/model.config": TWO_VERSIONS,
        "room/model.sdf": AWAY,
        "room/new.sdf": ROOM,
        "room/later.sdf": AWAY,
    },
    "description that is not XML": {
        "w.world": WORLD.format(include("model://room")),
        "room/model.config": CONFIG.replace("<name>m", "<!-- <sdf>x.sdf</sdf> --><name>this & that"),
        "room/model.sdf": ROOM,
    },
    "in a model in a file": {
        "w.world": WORLD.format(include("outer", "<pose>0 0 0 0 0 1.5707963267949</pose>")),
        "outer/model.sdf": SDF.format(OUTER),
        **IN_FOLDER,
    },
    "under another name and pose": {
        "w.world": WORLD.format(
            include("wall", "<name>a</name><pose>0.5 0.1 0.5 0 0 0</pose>")
            + model("b", POST_AT)
        ),
        "wall/model.sdf": BARE.replace("<static>", "<pose>9 9 9 0 0 0</pose><static>"),
    },
    "moved by a state": {
        "w.world": WORLD.format(
            include("wall", "<name>a</name>") + model("b", POST_AT)
            + "<state><model name='a'><pose>0.5 0.1 0.5 0 0 0</pose></model></state>"
        ),
        "wall/model.sdf": BARE,
    },
    "placed by a frame": {
        "w.world": WORLD.format(
            model("a", link(WALL, "7 7 7 0 0 0"), "0.5 0.1 0.5 0 0 0", placement_frame="l")
            + model("b", POST_AT)
        ),
    },
    "relative to frames": {
        "w.world": WORLD.format(
            model(
                "a",
                FRAMES
                + link(WALL, "0.5 0.1 0.5 0 0 0")
                + link(POST, "0.1 0 0 0 0 -1.5707963267949", "m").replace(
                    "<pose>", "<pose relative_to='here'>", 1
                ),
            )
        ),
    },
    "relative to another model": {
        "w.world": WORLD.format(
            model("a", link(WALL), "0.5 0.1 0.5 0 0 0")
            + model("b", link(POST), "0.4 0.5 0 0 0 0").replace(
                "<pose>", "<pose relative_to='a::l'>", 1
            )
        ),
    },
    "turned by quaternions": {
        "w.world": WORLD.format(
            model("a", link(WALL, "0.5 0.1 0.5 0 0 0") + link(POST, "@", "m")).replace(
                "<pose>@", "<pose rotation_format='quat_xyzw'>0.9 0.6 0.5 0 0 1 0"
            )
        ),
    },
    "standing on an end": {
        "w.world": WORLD.format(
            model(
                "a",
                link(collision(BOX.format("1 1 0.2"), "0.5 0.1 0.5 1.5707963267949 0 0"))
                + link(collision(BOX.format("1 0.4 0.2"), "0.9 0.6 0.5 0 1.5707963267949 0"), "", "m"),
            )
        ),
    },
    "outlines with a hole": {"w.world": WORLD.format(model("a", link(collision(RING))))},
    "declaration after a comment": {
        "w.world": "<!-- by hand -- not -->\n<?xml version='1.0'?>" + WORLD.format(include("room")),
        **IN_FOLDER,
    },
    "choice of xacro": {
        "w.sdf.xacro": WORLD.format(
            include("room") + "<xacro:unless value='$(arg headless)'>"
            "<plugin filename='gz-sim-sensors-system' name='gz::sim::systems::Sensors'/></xacro:unless>"
        ).replace("<world", "<xacro:arg name='headless' default='1'/><world"),
        **IN_FOLDER,
    },
    "what looks like a comment": {
        "w.sdf": WORLD.format(
            "<plugin filename='libgazebo_ros_x'><![CDATA[ <!-- ]]></plugin>"
            + include("room")
            + "<!-- -- --><plugin filename='libgazebo_ros_x'><![CDATA[ --> ]]></plugin>"
        ),
        **IN_FOLDER,
    },
    "stl": of_mesh("stl", BOTH.export(file_type="stl")),
    "glb": of_mesh("glb", BOTH.export(file_type="glb")),
    "obj in cm, mirrored": of_mesh("obj", MIRRORED.export(file_type="obj"), "0.01 -0.01 0.01"),
}  # fmt: skip


@pytest.mark.parametrize("label", SAME)
def test_a_world_of_several_files_is_the_world_of_one(label, tmp_path, monkeypatch):
    monkeypatch.delenv("GZ_SIM_RESOURCE_PATH", raising=False)
    found = read_map(put_down(tmp_path, SAME[label]), options={"cell_size": 0.1})
    assert found.unread == ()
    assert rows(found) == SEEN


def test_a_slab_that_is_the_floor_is_named_and_can_be_the_floor(tmp_path):
    slab = model("slab", link(collision(BOX.format("8 8 0.1"))) + link("", "1 1 1 0 0 0", "bare"))
    path = put_down(tmp_path, {"w.sdf": WORLD.format(slab + model("a", link(WALL)))})
    on_it = read_map(path, options={"floor_height": 0.05})
    assert on_it.walls.shape == (1, 5) and (on_it.unread, on_it.warnings) == ((), ())
    assert "+floor_height=0.05" in read_map(path).warnings[0]


def test_a_needle_still_takes_a_cell(tmp_path):
    needle = model("a", link(collision(BOX.format("1e-9 1e-9 1"))), "0 0 0 0 0 0.3")
    found = read_map(put_down(tmp_path, {"w.sdf": WORLD.format(needle)}))
    assert rows(found) == ["#"]


def test_folders_of_models_can_be_listed_as_for_gazebo(tmp_path, monkeypatch):
    """Links may lead out of a listed folder, as those of a workspace that was built do."""
    put_down(tmp_path / "source", IN_FOLDER)
    (tmp_path / "listed").mkdir()
    (tmp_path / "listed" / "room").symlink_to(tmp_path / "source" / "room")
    path = put_down(tmp_path / "world", {"w.world": WORLD.format(include("model://room"))})
    for name in ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH"):
        monkeypatch.setenv(name, f"/nowhere:{tmp_path}/listed")
        assert rows(read_map(path, options={"cell_size": 0.1})) == SEEN
        monkeypatch.delenv(name)


def test_what_is_missing_is_named_with_the_way_out(tmp_path, monkeypatch):
    monkeypatch.delenv("GZ_SIM_RESOURCE_PATH", raising=False)
    usual = [
        "model://sun", "model://ground_plane", "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground Plane/2",
    ]  # fmt: skip
    others = ["model://walls/sun", "https://fuel.gazebosim.org/1.0/Me/models/Sun"]
    world = WORLD.format("".join(map(include, [*usual, *others])) + model("a", link(WALL)))
    found = read_map(put_down(tmp_path, {"w.world": world}))
    assert found.unread == ("2 models not found",)
    assert f"not found: {', '.join(others)}; put" in found.warnings[0]


def test_a_wall_in_an_included_model_blocks(tmp_path):
    across = model("wall", link(collision(BOX.format("0.2 4 1"))), "2 0 0.5 0 0 0")
    ends = model("ends", link(collision(BOX.format("0.1 4 1")))
        + link(collision(BOX.format("0.1 4 1")), "4 0 0 0 0 0", "m"))  # fmt: skip
    files = {
        "w.world": WORLD.format(include("model://wall") + ends),
        "models/wall/model.sdf": SDF.format(across),
    }
    robot = ImportedRobot((1.0, 0.0), (3.0, 0.0), in_file_frame=True)
    assert import_world(put_down(tmp_path, files), robot).decision.result == "blocked"


def test_a_hole_of_an_outline_and_of_a_mesh_is_free(tmp_path):
    outlines = "".join(
        f"<polyline><point>{a} {a}</point><point>{b} {a}</point><point>{b} {b}</point>"
        f"<point>{a} {b}</point><height>1</height></polyline>"
        for a, b in ((0, 1), (0.2, 0.8))
    )
    path = put_down(tmp_path, {"w.sdf": WORLD.format(model("a", link(collision(outlines))))})
    ring = ["#####", "#...#", "#...#", "#...#", "#####"]
    assert rows(read_map(path, options={"cell_size": 0.2})) == ring


@pytest.mark.parametrize("raster", ["outer", "inner"])
def test_a_tilted_cylinder_is_what_is_seen_of_it_from_above(raster, tmp_path):
    """A pipe of radius 0.2 m and length 0.9 m that lies on its side."""
    pipe = "<cylinder><radius>0.2</radius><length>0.9</length></cylinder>"
    lying = model("a", link(collision(pipe)), "0 0 0.3 0 1.5708 0.3")
    path = put_down(tmp_path, {"w.sdf": WORLD.format(lying)})
    found = read_map(path, options={"cell_size": 0.2, "raster": raster})
    turned = shapely.Polygon(
        [
            (x * math.cos(0.3) - y * math.sin(0.3), x * math.sin(0.3) + y * math.cos(0.3))
            for x, y in ((-0.45, -0.2), (0.45, -0.2), (0.45, 0.2), (-0.45, 0.2))
        ]
    )
    left, low = found.origin
    cells = [
        shapely.Polygon(
            [
                (left + 0.2 * (ix + dx), low + 0.2 * (iy + dy))
                for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
        )
        for iy in range(found.walls.shape[0])
        for ix in range(found.walls.shape[1])
    ]
    wanted = [
        turned.contains(cell) if raster == "inner" else turned.intersection(cell).area > 1e-6
        for cell in cells
    ]
    assert found.walls.reshape(-1).tolist() == wanted


def test_what_a_state_or_gravity_moves_is_reported(tmp_path):
    """A body falls unless it is fixed, joined to another that stands, or has no gravity."""
    high = link(WALL, "0 0 3 0 0 0")
    joint = "<joint name='j' type='fixed'><parent>{}</parent><child>l</child></joint>"
    loose = f"<model name='a'>{high}{{}}</model>"
    state = "<state><model name='a'><link name='{}'><pose>0 0 0 0 0 0</pose></link></model></state>"
    falls, moved = ("1 body above 2 m that may fall",), ("1 link moved by <state>",)
    inner = model("i", high)
    cases = {
        model("a", high): (),
        model("a", high) + state.format("l"): moved,
        model("a", inner) + state.format("i::l"): moved,
        loose.format(""): falls,
        loose.format(link(POST, "0 0 0.5 0 0 0", "low")): falls,
        loose.format(link(POST, "0 0 0.5 0 0 0", "low") + joint.format("low")): (),
        loose.format(link(POST, "0 0 3 0 0 0", "low") + joint.format("low")): falls,
        loose.format(joint.format("world")): (),
        loose.format("").replace("</link>", "<gravity>0</gravity></link>"): (),
    }
    for inside, expected in cases.items():
        path = put_down(tmp_path, {"w.sdf": WORLD.format(model("b", link(WALL)) + inside)})
        assert read_map(path).unread == expected, inside


def test_the_place_of_a_frame_is_found_once(tmp_path, monkeypatch):
    found = []
    find = Model._find_frame
    monkeypatch.setattr(
        Model,
        "_find_frame",
        lambda self, name, *more: found.append(name) or find(self, name, *more),
    )
    frames = "<frame name='f0'/>" + "".join(
        f"<frame name='f{n}' attached_to='f{n - 1}'/>" for n in range(1, 5)
    )
    links = "".join(f"<link name='l{n}'><pose relative_to='f4'/>{WALL}</link>" for n in range(5))
    read_map(put_down(tmp_path, {"w.sdf": WORLD.format(model("a", frames + links))}))
    assert len(found) == len(set(found))


BOMB = {f"m{n}/model.sdf": SDF.format(model("m", include(f"m{n + 1}") * 12)) for n in range(12)} | {
    "m12/model.sdf": BARE
}
HARMFUL = {
    "cycle": (
        {"w.sdf": WORLD.format(include("a")),
         "a/model.sdf": SDF.format(model("a", include("model://b"))),
         "b/model.sdf": SDF.format(model("b", include("model://a")))},
        {"code": "cycle", "name": "a/model.sdf", "line": 1},
    ),
    "cycle of frames": (
        {"w.sdf": WORLD.format(model("a", "<frame name='f'><pose relative_to='g'/></frame>"
            "<frame name='g' attached_to='f'/>" + link("<pose relative_to='f'/>" + WALL)))},
        {"code": "cycle", "name": "f"},
    ),
    "bomb of files": ({"w.sdf": WORLD.format(include("m0")), **BOMB}, {"code": "too-large"}),
    "nothing is a number": (
        {"w.sdf": WORLD.format(model("a", link(WALL), "0 0 nan 0 0 0"))},
        {"code": "wrong-count", "text": "0 0 nan 0 0 0"},
    ),
    "far away": (
        {"w.sdf": WORLD.format(model("a", link(WALL), "1e300 0 0 0 0 0"))},
        {"code": "out-of-range"},
    ),
    "outlines that cancel each other": (
        {"w.sdf": WORLD.format(model("a", link(collision(RING[: RING.index("</polyline>") + 11] * 2))))},
        {"code": "empty"},
    ),
    "expression of xacro": (
        {"w.sdf": WORLD.format(model("a", link(WALL), "${x} 0 0 0 0 0"))}, {"code": "unsupported"},
    ),
    "wall between attributes like a comment": (
        {"w.sdf": WORLD.format(model("a' b='<!--", "") + ROOM + model("c' d='-->", ""))},
        {"code": "not-xml"},
    ),
    "comments without an end": (
        {"w.sdf": "<sdf>" + "<!--" * 100_000}, {"code": "not-xml"},
    ),
    "mesh of another kind": (
        of_mesh("stl", b"hello " * 30), {"code": "no-triangles"},
    ),
    "outline that crosses itself": (
        {"w.sdf": WORLD.format(model("a", link(collision(
            "<polyline><point>0 0</point><point>1 1</point><point>1 0</point><point>0 1</point>"
            "<height>1</height></polyline>" * 2))))},
        {"code": "crosses-itself"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("label", HARMFUL)
def test_a_file_that_means_harm_is_one_sentence(label, tmp_path, monkeypatch):
    monkeypatch.setattr("worldgen.interop.readers.gazebo_models._MOST_MODELS", 500)
    files, expected = HARMFUL[label]
    with raises(FormatError, **expected):
        read_map(put_down(tmp_path, files))


@pytest.mark.parametrize(
    "uri",
    [
        "../room",
        "model://../room",
        "model://room/../../x",
        "/etc",
        "file:///etc",
        "https://a/models/..%2froom",
    ],
)
@pytest.mark.parametrize("kind", ["model", "mesh"])
def test_nothing_outside_the_folders_is_opened(uri, kind, tmp_path):
    part = include(uri) if kind == "model" else model("a", link(collision(mesh(uri))))
    with raises(FormatError, "outside-folder"):
        read_map(put_down(tmp_path, {"w/w.sdf": WORLD.format(part), **IN_FOLDER}))


def test_a_link_does_not_lead_out_of_the_folders_either(tmp_path):
    path = put_down(tmp_path, {"w/w.sdf": WORLD.format(include("room")), **IN_FOLDER})
    (tmp_path / "w" / "room").symlink_to(tmp_path / "room")
    with raises(FormatError, "outside-folder"):
        read_map(path)


# COLLADA

QUADS = "3 2 1 0 4 5 6 7 0 1 5 4 1 2 6 5 2 3 7 6 3 0 4 7"
DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01" name="cm"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="24">
0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1</float_array><technique_common>
<accessor source="#f" count="8" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/>
<vcount>4 4 4 4 4 4</vcount><p>{quads}</p></polylist>{more}
</mesh></geometry></library_geometries>
<library_nodes>{nodes}</library_nodes>
<library_visual_scenes><visual_scene id="x">
<node id="wall"><matrix>100 0 0 0 0 20 0 0 0 0 100 0 0 0 0 1</matrix><instance_geometry url="#g"/></node>
<node id="post"><translate>80 40 0</translate><scale>20 40 100</scale><instance_node url="#n"/></node>
{scene}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#x"/></scene></COLLADA>"""
CUBE = '<node id="n"><instance_geometry url="#g"/></node>'


LINES = '<lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1</p></lines>'


def collada(more="", nodes=CUBE, scene=""):
    return of_mesh("dae", DAE.format(quads=QUADS, more=more, nodes=nodes, scene=scene))


@pytest.mark.parametrize(
    ("changes", "unread"),
    [
        ({}, ()),
        ({"more": LINES}, ()),
        (
            {"scene": "<node><instance_controller url='#c'/></node>"},
            ("1 part of COLLADA other than plain meshes",),
        ),
        (
            {"scene": "<node><instance_geometry url='#missing'/></node>"},
            ("1 part of COLLADA other than plain meshes",),
        ),
    ],
)
def test_a_mesh_of_collada_is_read_in_its_unit_and_as_gazebo_turns_it(changes, unread, tmp_path):
    pytest.importorskip("collada", reason="pip install 'worldgen[collada]'")
    found = read_map(put_down(tmp_path, collada(**changes)), options={"cell_size": 0.1})
    assert (found.unread, rows(found)) == (unread, SEEN)


TWICE = [
    f"<node id='n{n}'>" + 8 * f"<instance_node url='#n{n + 1}'/>" + "</node>" for n in range(12)
]


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (collada(nodes="<node id='n'><instance_node url='#n'/></node>"), "too-large"),
        (collada(nodes=CUBE + "".join(TWICE), scene="<node><instance_node url='#n0'/></node>"), "too-large"),
        (of_mesh("dae", "<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA>&b;</COLLADA>"), "unsupported"),
        (of_mesh("dae", "<svg/>"), "wrong-root"),
        (of_mesh("dae", DAE.format(quads="9 9 9", more="", nodes=CUBE, scene="")), "no-triangles"),
        (of_mesh("dae", DAE.replace("0.01", "nan")), "out-of-range"),
    ],
    ids=["itself", "bomb of nodes", "entity", "other root", "no such corner", "unit"],
)  # fmt: skip
def test_a_mesh_of_collada_that_means_harm_is_one_sentence(data, expected, tmp_path, monkeypatch):
    pytest.importorskip("collada", reason="pip install 'worldgen[collada]'")
    monkeypatch.setattr("worldgen.interop.readers.collada_tree._MOST_PLACED", 2000)
    with raises(FormatError, expected):
        read_map(put_down(tmp_path, data))


def test_without_the_package_a_mesh_of_collada_is_unread_and_the_command_is_given(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    files = collada() | {"w.sdf": WORLD.format(include("room") + model("a", link(WALL)))}
    found = read_map(put_down(tmp_path, files))
    assert found.unread == ("1 mesh of .dae",) and "[collada]" in found.warnings[0]
