"""Walls as boxes: STL, OBJ, GLB and USD."""

import hashlib
import math
import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.exported_meshes import (
    TINY,
    any_worlds,
    glb_parts,
    solid_volume,
    stl_triangles,
    volume,
)
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.interop import Destination, export_world
from worldgen.interop.formats.gltf import _disc, _sine_cosine
from worldgen.interop.geometry.placed_boxes import solid_boxes
from worldgen.lattice import exact
from worldgen.world import Pose, Target


@given(any_worlds())
def test_the_shells_of_an_stl_file_are_closed_and_hold_the_walls_volume(drawn):
    world, origin = drawn
    triangles = stl_triangles(export_world(world, "stl+height=0.5", origin=origin).data)
    for shell in triangles["corners"].reshape(-1, 12, 3, 3):
        edges = [
            (tuple(face[k]), tuple(face[k - 2]))
            for face in shell.tolist()
            for k in range(3)
            for face in [list(map(tuple, face))]
        ]
        assert len(set(edges)) == 36 and all((b, a) in edges for a, b in edges)
    assert volume(triangles["corners"].astype(float)) == pytest.approx(
        solid_volume(world, 0.5), rel=1e-4
    )


@given(any_worlds())
def test_the_normals_of_an_stl_file_point_outwards(drawn):
    triangles = stl_triangles(export_world(drawn[0], "stl", origin=drawn[1]).data)
    corners = triangles["corners"].astype(float)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.allclose(
        across / np.linalg.norm(across, axis=1, keepdims=True), triangles["normal"], atol=1e-4
    )


@given(any_worlds())
def test_an_obj_file_has_a_closed_object_a_box_at_exact_decimals(drawn):
    world, origin = drawn
    text = export_world(world, "obj+floor", origin=origin).data.decode()
    boxes = solid_boxes(world, Destination("x", origin), height=1.0, floor=True)
    objects = text.split("\no ")[1:]
    assert [part.split("\n")[0] for part in objects] == [box.name for box in boxes]
    for number, (part, box) in enumerate(zip(objects, boxes, strict=True)):
        corners = [
            tuple(map(Fraction, words.split()))
            for words in re.findall(r"^v (.+)$", part, re.MULTILINE)
        ]
        assert min(corners) == box.low and max(corners) == box.high and len(set(corners)) == 8
        faces = [
            [int(word) - 1 - 8 * number for word in words.split()]
            for words in re.findall(r"^f (.+)$", part, re.M)
        ]
        edges = [(face[k - 1], face[k]) for face in faces for k in range(4)]
        assert len(set(edges)) == 24 and all((b, a) in edges for a, b in edges)


@pytest.mark.gate
@given(any_worlds())
def test_a_glb_file_has_a_node_a_box_with_y_up(drawn):
    world, origin = drawn
    document, _ = glb_parts(export_world(world, "glb+height=0.5", origin=origin).data)
    root, *nodes = document["nodes"]
    boxes = solid_boxes(world, Destination("x", origin), height=0.5, floor=False)
    assert root["children"] == list(range(1, len(document["nodes"])))
    for node, box in zip(nodes, boxes, strict=False):
        (x, y, z), (across, tall, deep) = node["translation"], node["scale"]
        assert (x, -z - deep, y) == pytest.approx(tuple(map(float, box.low)), abs=1e-12)
        assert (across, deep, tall) == tuple(map(float, box.size)) and node["name"] == box.name


def test_the_meshes_of_a_glb_file_are_closed_with_outward_faces():
    document, data = glb_parts(export_world(TINY, "glb+markers").data)
    views = [data[view["byteOffset"] :][: view["byteLength"]] for view in document["bufferViews"]]
    volumes = []
    for faces, corners in zip(views[::2], views[1::2], strict=True):
        triangles = np.frombuffer(faces, "<u4").reshape(-1, 3)
        edges = {(int(face[k - 1]), int(face[k])) for face in triangles for k in range(3)}
        assert len(edges) == triangles.size and all((b, a) in edges for a, b in edges)
        volumes.append(
            volume(np.frombuffer(corners, "<f4").reshape(-1, 3)[triangles].astype(float))
        )
    assert volumes == pytest.approx([1.0, 24 * math.sin(2 * math.pi / 48)])  # cube, prism


def test_a_glb_file_has_start_and_target_as_nodes_and_the_rest_as_extras():
    document, _ = glb_parts(export_world(TINY, "glb+markers", origin=(1.0, 2.0)).data)
    nodes = {node["name"]: node for node in document["nodes"]}
    assert nodes["start"]["translation"] == [1.15, 0.0, -2.15] and nodes["start"]["extras"] == {
        "heading": 0.5
    }
    assert nodes["start"]["rotation"] == pytest.approx([0, math.sin(0.25), 0, math.cos(0.25)])
    assert nodes["target"]["translation"] == [1.35, 0.0, -2.15] and nodes["target"]["extras"] == {
        "radius": 0.05
    }
    assert (
        nodes["worldgen"]["extras"]["robot_speed"] == 1.5
        and nodes["worldgen"]["extras"]["origin_y"] == 2.0
    )
    assert document["nodes"][nodes["start"]["children"][0]]["name"] == "start_disc"


@pytest.mark.gate
@given(st.floats(-6.3, 6.3))
def test_sine_and_cosine_are_those_of_the_math_library_to_its_last_bit(angle):
    assert _sine_cosine(angle) == pytest.approx((math.sin(angle), math.cos(angle)), abs=1.2e-16)


def test_a_disc_is_as_round_as_its_corners_say():
    corners, _ = _disc()
    assert [math.hypot(x, z) for x, _, z in corners] == pytest.approx([1.0] * len(corners))


@settings(max_examples=20)
@given(any_worlds())
def test_the_cubes_of_a_usd_stage_are_the_boxes(drawn):
    world, origin = drawn
    text = export_world(world, "usd+floor", origin=origin).data.decode()
    found = re.findall(
        r"double3 xformOp:scale = \((.+)\)\n +double3 xformOp:translate = \((.+)\)", text
    )
    boxes = solid_boxes(world, Destination("x", origin), height=1.0, floor=True)
    assert [tuple(tuple(map(Fraction, words.split(", "))) for words in pair) for pair in found] == [
        (box.size, box.centre) for box in boxes
    ]


def test_a_floor_lies_below_walls_and_border():
    floor = solid_boxes(TINY, Destination("x"), height=1.0, floor=True)[-1]
    assert (
        floor.name == "floor"
        and floor.low == (exact(-0.1),) * 3
        and floor.high == (exact(0.5), exact(0.4), 0)
    )


# The programs of tests/clients have read these files; after a change here, they have to read them
# again.
@pytest.mark.parametrize(
    ("name", "digest"),
    [
        ("stl", "85c74886bb49cac9"),
        ("obj+floor", "13d500fdd8b44ff7"),
        ("glb+markers", "e7fc99a6bf0f8548"),
        ("usd", "be9d122be669783c"),
    ],
)
def test_the_bytes_of_a_scene_are_the_same_everywhere(name, digest):
    data = export_world(TINY, name, origin=(-1.0, 0.25)).data
    assert hashlib.sha256(data).hexdigest()[:16] == digest


@pytest.mark.parametrize("name", ["stl", "glb"])
def test_a_frame_in_which_32_bits_would_move_walls_is_refused(name):
    with raises(InvalidWorld, "too-many-digits", bits=24):
        export_world(TINY, name, origin=(500000.0, 5400000.0))


@pytest.mark.parametrize("name", ["obj", "usd", "geojson", "svg", "sdf", "mjcf", "irsim"])
def test_a_frame_in_which_64_bits_would_move_walls_is_refused(name):
    with raises(InvalidWorld, "too-many-digits", bits=53):
        small = replace(
            TINY, cell_size=1e-5, robot_radius=1e-5, start=Pose(0, 0), target=Target(0, 0, 1e-5)
        )
        export_world(small, name, origin=(1e12, 0))


def test_heights_that_are_no_lengths_are_refused():
    with raises(InvalidParameter, "out-of-range", name="height"):
        export_world(TINY, "usd+height=0")
