"""Meshes cut at a height: STL, OBJ and glTF."""

import io
import json
import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings

from tests.helpers.buildings import BUILDING_BOXES, building, building_file, ground_floor
from tests.helpers.command_line import worldgen
from tests.helpers.exported_meshes import any_worlds, solid_volume
from tests.helpers.foreign_samples import LACKING
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.families import maze
from worldgen.files.grid import read_world
from worldgen.interop import export_world, import_world, read_map
from worldgen.interop.account import accounting
from worldgen.interop.readers.mesh_file import load_mesh
from worldgen.reach import REACHABLE, decide

KINDS = ["stl", "obj", "glb", "gltf", *({"dae"} - LACKING)]
WRITTEN = ["stl", "obj", "glb"]


def put(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_a_building_that_trimesh_wrote_is_cut_at_the_lidars_height(kind, tmp_path):
    found = read_map(put(tmp_path, f"b.{kind}", building_file(kind)), options={"cell_size": 0.1})
    assert found.cell_size == 0.1 and found.origin == (0.0, 0.0)
    assert np.array_equal(found.walls, ground_floor(0.2))


def test_a_table_is_its_legs_below_its_top_and_whole_at_the_top(tmp_path):
    path = put(tmp_path, "b.stl", building_file("stl"))
    legs, top = (
        read_map(path, options={"cell_size": 0.1, "slice_height": height}).walls[10:20, 10:20]
        for height in (0.2, 0.72)
    )
    assert legs.sum() == 4 and top.all()


def test_a_doorway_lets_the_robot_through_and_the_floor_above_is_parted(tmp_path):
    path = put(tmp_path, "b.glb", building_file("glb"))
    asked = {"cell_size": 0.1}
    ground = import_world(path, options=asked).world
    right = read_map(path, options={**asked, "floor": 1}).walls
    assert decide(ground).result == REACHABLE
    assert right[1:-1, 40].all() and not right[1:-1, 30].any()


def test_each_floor_is_listed_and_another_is_refused(tmp_path):
    path = put(tmp_path, "b.stl", building_file("stl"))
    assert any("2 floors, at 0, 2.6 m" in note for note in read_map(path).notes)
    with raises(InvalidParameter, "out-of-range", floor=2, count=2):
        read_map(path, options={"floor": 2})


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1000.0), ("cm", 100.0), ("in", 1 / 0.0254)])
def test_a_unit_that_is_given_is_heeded(unit, factor, tmp_path):
    mesh = building()
    mesh.apply_scale(factor)
    path = put(tmp_path, "b.stl", building_file("stl", mesh))
    assert np.array_equal(read_map(path, f"stl+unit={unit}+cell-size=0.1").walls, ground_floor(0.2))


def test_a_y_up_obj_file_is_turned(tmp_path):
    mesh = building()
    mesh.vertices = np.stack(
        [mesh.vertices[:, 0], mesh.vertices[:, 2], -mesh.vertices[:, 1]], axis=1
    )
    path = put(tmp_path, "b.obj", building_file("obj", mesh))
    assert np.array_equal(read_map(path, "obj+up=y+cell-size=0.1").walls, ground_floor(0.2))


@pytest.mark.parametrize(
    ("kind", "option", "value"), [("glb", "up", "z"), ("obj", "unit", "cm"), ("obj", "up", "y")]
)
def test_facts_of_a_worldgen_file_are_not_used_for_another_axis_or_unit(
    kind, option, value, tmp_path
):
    world = maze(seed=1, size=20)
    path = put(tmp_path, f"w.{kind}", export_world(world, kind, sidecar=False).data)
    assert read_map(path).robot.start is not None
    options = {option: value, "slice_height": 0.005, "cell_size": 0.01}
    turned = read_map(path, options=options)
    assert turned.robot.start is None and turned.params["format"] == kind


def test_a_mesh_of_odd_size_is_warned_of(tmp_path):
    mesh = trimesh.creation.box(bounds=[(0, 0, 0), (6000, 4000, 2500)])
    found = read_map(
        put(tmp_path, "b.stl", building_file("stl", mesh)), options={"cell_size": 10.0}
    )
    assert len(found.warnings) == 1


def test_surfaces_without_thickness_are_walls(tmp_path):
    sheet = trimesh.Trimesh(
        [(0, 0.55, 0), (2, 0.55, 0), (2, 0.55, 2), (0, 0.55, 2)], [(0, 1, 2), (0, 2, 3)]
    )
    floor = trimesh.creation.box(bounds=[(0, 0, -0.1), (2, 2, 0)])
    data = building_file("stl", trimesh.util.concatenate([floor, sheet]))
    found = read_map(put(tmp_path, "b.stl", data), options={"cell_size": 0.1})
    assert found.walls[5].all() and found.walls.sum() == 20


def test_rooms_that_are_cavities_of_one_body_are_free(tmp_path):
    outer = trimesh.creation.box(bounds=[(0, 0, 0), (2, 2, 2)])
    inner = trimesh.creation.box(bounds=[(0.5, 0.5, 0.1), (1.5, 1.5, 1.9)])
    inner.invert()
    data = building_file("obj", trimesh.util.concatenate([outer, inner]))
    found = read_map(put(tmp_path, "b.obj", data), options={"cell_size": 0.1, "slice_height": 1.0})
    assert found.walls.sum() == 300 and not found.walls[5:15, 5:15].any()


@pytest.mark.gate
@pytest.mark.parametrize("name", WRITTEN)
@settings(max_examples=12)
@given(drawn=any_worlds())
def test_cells_that_went_out_as_a_mesh_come_back(name, tmp_path_factory, drawn):
    world, origin = drawn
    data = export_world(world, name, origin=origin, sidecar=False).data
    path = put(tmp_path_factory.mktemp("mesh"), f"w.{name}", data)
    if world.walls.any():
        found = read_map(path)
        assert np.array_equal(found.walls, world.walls)
        assert found.origin == origin and found.cell_size == world.cell_size


@pytest.mark.parametrize("name", WRITTEN)
def test_trimesh_reads_what_was_written_with_the_walls_volume(name, tmp_path):
    world = read_world_of(building_file("stl"), tmp_path)
    scene = trimesh.load_scene(
        io.BytesIO(export_world(world, f"{name}+height=0.5").data), file_type=name
    )
    assert scene.to_geometry().volume == pytest.approx(solid_volume(world, 0.5), rel=1e-4)


def read_world_of(data, folder):
    return import_world(put(folder, "b.stl", data), options={"cell_size": 0.1}).world


def test_the_command_cuts_where_it_is_told(tmp_path):
    path = put(tmp_path, "b.glb", building_file("glb"))
    done = worldgen(
        "import",
        path,
        "--from",
        "glb+slice_height=0.2",
        "--cell",
        "0.1",
        "--out",
        tmp_path / "w.grid",
    )
    assert done.code == 0, done.err
    assert np.array_equal(read_world(tmp_path / "w.grid").walls, ground_floor(0.2))


def test_the_command_takes_unit_axis_and_floor(tmp_path):
    mesh = building(BUILDING_BOXES)
    mesh.apply_scale(1000.0)
    path = put(tmp_path, "b.stl", mesh.export(file_type="stl"))
    out = tmp_path / "w.grid"
    cut, words = "stl+slice_height=0.2+unit=mm+up=z", ("--cell", "0.1", "--out", out)
    done = worldgen("import", path, "--from", cut, *words)
    assert done.code == 0, done.err
    assert np.array_equal(read_world(out).walls, ground_floor(0.2))
    missing = worldgen("import", path, "--from", f"{cut}+floor=7", *words, "--force")
    assert missing.code == 2 and missing.error_code == "out-of-range"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.95])
def test_a_file_that_is_cut_off_is_refused(kind, share, tmp_path):
    data = building_file(kind)
    path = put(tmp_path, f"b.{kind}", data[: int(len(data) * share)])
    try:
        found = read_map(path, kind)
    except FormatError as error:
        assert error.code
    else:
        # A text without an end mark is read to its end.
        assert kind == "obj" and found.walls.size


def test_vertices_without_three_coordinates_are_refused(tmp_path):
    with raises(FormatError, "wrong-count"):
        read_map(put(tmp_path, "b.obj", b"v 0\nv 1\nv 2\nf 1 2 3\n"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_height_at_which_nothing_stands_is_refused(kind, tmp_path):
    path = put(tmp_path, f"b.{kind}", building_file(kind))
    with raises(FormatError, "nothing-there", height=30.0):
        read_map(path, kind, {"slice_height": 30.0})


def test_a_mesh_of_more_cells_than_a_world_has_is_refused(tmp_path):
    mesh = building(BUILDING_BOXES[:5])
    mesh.apply_scale(1e6)
    path = put(tmp_path, "b.stl", building_file("stl", mesh))
    with raises(FormatError, "wrong-size"):
        read_map(path)


def test_a_file_that_claims_more_triangles_than_it_holds_is_refused(tmp_path):
    path = put(tmp_path, "b.stl", b"x".ljust(80) + (2**32 - 1).to_bytes(4, "little") + bytes(50))
    with raises(FormatError, "no-triangles"):
        read_map(path)


def test_a_gltf_file_that_claims_more_numbers_than_are_read_is_refused(tmp_path):
    accessor = {"componentType": 5126, "count": 2_000_000_000, "type": "VEC3"}
    document = {
        "asset": {"version": "2.0"}, "accessors": [accessor], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    }  # fmt: skip
    with raises(FormatError, "too-large"):
        read_map(put(tmp_path, "b.gltf", json.dumps(document).encode()))


@pytest.mark.parametrize(
    ("part", "code", "words"),
    [
        ({"accessors": [{}]}, "wrong-structure", "'count' is missing"),
        ({"scene": 9}, "wrong-structure", "'accessors' is missing"),
        ({"meshes": [{}]}, "unreadable-mesh", "'primitives' is missing"),
        ({"nodes": ["mesh"]}, "wrong-structure", "a part of it is missing or of another kind"),
        ({"meshes": []}, "wrong-structure", "a number refers to something that is not in the file"),
    ],
    ids=["no-count", "no-accessors", "no-primitives", "no-node", "no-mesh"],
)
def test_a_damaged_gltf_file_is_refused_in_words_about_the_file(part, code, words, tmp_path):
    document = {
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    }  # fmt: skip
    with raises(FormatError, code, reason=words):
        read_map(put(tmp_path, "b.gltf", json.dumps(document | part).encode()))


def test_each_node_is_placed_by_those_around_it(tmp_path, monkeypatch):
    """In chains of nodes the time does not grow with each leaf's depth."""
    monkeypatch.setattr("trimesh.scene.transforms.SceneGraph.get", None)
    scene = trimesh.Scene()
    scene.graph.update(
        "turned", "world", matrix=trimesh.transformations.rotation_matrix(math.pi / 2, (0, 0, 1))
    )
    scene.graph.update("moved", "turned", matrix=np.diag([2.0, 1.0, 1.0, 1.0]))
    scene.graph.update(
        "leaf", "moved", matrix=trimesh.transformations.translation_matrix((3, 0, 0)), geometry="g"
    )
    scene.geometry["g"] = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    found = load_mesh(put(tmp_path, "b.glb", scene.export(file_type="glb")), "glb")
    assert found.vertices.round(9).tolist() == [[0, 6, 0], [0, 8, 0], [-1, 6, 0]]


def test_meshes_that_an_extension_places_are_refused_with_a_way_out(tmp_path):
    document = {"asset": {"version": "2.0"}, "extensionsUsed": ["EXT_mesh_gpu_instancing"]}
    with raises(FormatError, "instanced"):
        read_map(put(tmp_path, "b.gltf", json.dumps(document).encode()))


_CORNERS = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
_SQUARE = [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("faces", "expected"),
    [
        (b"f\t1\t2\t3\t4", _SQUARE),
        (b" \tf 1 2 3 4", _SQUARE),
        (b"\x0cf 1 2 3 4 # a face", _SQUARE),
        (b"f 1 2\\\r\n3\\\n 4", _SQUARE),
        (b"f 1 2 3 4 1 2\nf 1/1 2/2 4/4", [*_SQUARE, [0, 3, 0], [0, 0, 1], [0, 1, 3]]),
        (b"f -4 -3 -2\nv 5 5 5\nf -5 -3//1 -2//1", _SQUARE),
    ],
    ids=["tabs", "leading blanks", "form feed", "continued", "mixed", "relative"],
)
def test_the_faces_of_an_obj_file_are_read_however_they_are_spelled(faces, expected, tmp_path):
    found = load_mesh(put(tmp_path, "b.obj", _CORNERS + faces), "obj")
    assert found.faces.tolist() == expected


@pytest.mark.parametrize("word", [b"0", b"-5", b"9", b"1_0", b"x"])
def test_a_corner_that_is_not_there_is_refused(word, tmp_path):
    with pytest.raises(FormatError):
        load_mesh(put(tmp_path, "b.obj", _CORNERS + b"f 1 2 " + word), "obj")


_FACET = b"facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 1 1 0 endloop endfacet"


@pytest.mark.parametrize(
    ("data", "unread"),
    [
        (b"solid a\r" + _FACET.replace(b" ", b"\r\t") + b"\rendsolid a", ()),
        (b"solid vertex 1 2 3\n" + _FACET.upper() + b"\nendsolid\n", ()),
        (b"solid a\n" + _FACET + b" vertex\nendsolid a", ("1 word besides facets",)),
        (b"solid a " + _FACET + b"\n" + _FACET + b"\nendsolid", ("1 facet",)),
    ],
    ids=["one word a line", "name like a vertex", "another word", "facet in the name"],
)
def test_a_facet_of_text_is_read_or_reported(data, unread, tmp_path):
    with accounting() as account:
        found = load_mesh(put(tmp_path, "b.stl", data), "stl")
    assert found.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert account.total(()) == unread


def test_points_without_triangles_are_refused(tmp_path):
    with raises(FormatError, "no-triangles"):
        read_map(put(tmp_path, "b.obj", b"v 0 0 0\nv 1 1 1\n"))
