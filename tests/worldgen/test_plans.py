"""Walls as polygons: GeoJSON and SVG."""

import hashlib
import json
import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.helpers.exported_meshes import TINY, any_worlds, covered_cells
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.generation import generate
from worldgen.interop import export_world
from worldgen.interop.geometry.polygons import cell_polygons
from worldgen.timeline import CellState, Timeline

SVG = "{http://www.w3.org/2000/svg}"


def area(ring):
    """Return twice the area of a ring with integer coordinates; negative if it runs clockwise."""
    return sum(
        ax * by - bx * ay for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True)
    )


@given(hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9)), fill=st.nothing()))
def test_polygons_are_valid_and_cover_exactly_the_solid_cells(walls):
    polygons = cell_polygons(walls)
    shape = shapely.MultiPolygon([(outline, holes) for outline, *holes in polygons])
    assert shape.is_valid and shape.area == walls.sum()
    y, x = np.nonzero(walls)
    assert shape.equals(shapely.union_all(shapely.box(x, y, x + 1, y + 1)))
    assert all(
        area(outline) > 0 and all(area(hole) < 0 for hole in holes) for outline, *holes in polygons
    )


@given(hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9)), fill=st.nothing()))
def test_the_corners_of_a_polygon_are_where_it_turns_and_its_beginning_is_fixed(walls):
    polygons = cell_polygons(walls)
    rings = [ring for polygon in polygons for ring in polygon]
    for ring in rings:
        straight = [
            (a[0] == b[0] == c[0]) or (a[1] == b[1] == c[1])
            for a, b, c in zip(ring[-2:] + ring, ring[-1:] + ring, ring, strict=False)
        ]
        assert not any(straight) and ring[0] == min(ring, key=lambda corner: corner[::-1])


@given(any_worlds())
def test_the_walls_of_a_geojson_file_have_the_walls_area_at_the_origin(drawn):
    world, origin = drawn
    walls = [
        shapely.geometry.shape(feature["geometry"])
        for feature in features(world, origin=origin)
        if feature["properties"]["kind"] in ("walls", "border")
    ]
    shape = shapely.union_all(walls)
    assert shape.is_valid and shape.area == pytest.approx(covered_cells(world) * world.cell_size**2)
    y, x = (np.mgrid[: world.height, : world.width] + 0.5) * world.cell_size
    assert np.array_equal(shapely.contains_xy(shape, x + origin[0], y + origin[1]), world.walls)


def test_an_empty_open_world_has_its_border_and_a_closed_one_none():
    free = replace(TINY, walls=np.zeros((2, 4), np.bool_))
    border = features(free)[1]
    assert border["properties"]["kind"] == "border"
    assert border["geometry"]["coordinates"] == [
        [
            [[-0.1, -0.1], [0.5, -0.1], [0.5, 0.3], [-0.1, 0.3], [-0.1, -0.1]],
            [[0, 0], [0, 0.2], [0.4, 0.2], [0.4, 0], [0, 0]],
        ]
    ]
    kinds = [feature["properties"]["kind"] for feature in features(generate("maze", 1, size=13))]
    assert kinds == ["walls", "start", "target"]


def features(world, **options):
    return json.loads(export_world(world, "geojson", **options).data)["features"]


def test_geojson_has_places_with_what_belongs_to_them_and_says_that_its_frame_is_local():
    document = json.loads(export_world(TINY, "geojson", origin=(1.0, 2.0)).data)
    assert document["worldgen"]["frame"] == "local" and document["worldgen"]["units"] == "m"
    assert document["worldgen"]["cell_size"] == 0.1 and document["worldgen"]["origin"] == [1.0, 2.0]
    by_kind = {feature["properties"]["kind"]: feature for feature in document["features"]}
    assert by_kind["start"]["geometry"] == {"type": "Point", "coordinates": [1.15, 2.15]}
    assert by_kind["start"]["properties"] == {
        "kind": "start", "heading": 0.5, "robot_radius": 0.04, "robot_speed": 1.5,
    }  # fmt: skip
    assert by_kind["target"]["properties"] == {"kind": "target", "radius": 0.05}
    assert "border" in by_kind


def test_geojson_has_every_change_with_its_time_and_cell():
    line = Timeline.of([(1.5, 2, 1, CellState.BURNING), (4.0, 2, 1, CellState.FREE)])
    changes = [
        one
        for one in features(replace(TINY, timeline=line))
        if one["properties"]["kind"] == "change"
    ]
    assert [one["properties"] for one in changes] == [
        {"kind": "change", "time": 1.5, "state": "burning", "cell": [2, 1]},
        {"kind": "change", "time": 4.0, "state": "free", "cell": [2, 1]},
    ]
    square = [[0.2, 0.1], [0.3, 0.1], [0.3, 0.2], [0.2, 0.2], [0.2, 0.1]]
    assert changes[0]["geometry"] == {"type": "Polygon", "coordinates": [square]}


@given(any_worlds())
def test_the_paths_of_a_plan_are_the_polygons(drawn):
    world, origin = drawn
    root = ET.fromstring(export_world(world, "svg", origin=origin).data)
    paths = root.findall(f".//{SVG}path[@class='wall']")
    polygons = cell_polygons(world.walls)
    for path, polygon in zip(paths, polygons, strict=True):
        rings = [ring_of(data) for data in path.get("d").rstrip("z").split("z")]
        flat = [
            [
                (float(x) * world.cell_size + origin[0], y * world.cell_size + origin[1])
                for x, y in ring
            ]
            for ring in polygon
        ]
        assert rings == [[pytest.approx(corner) for corner in ring] for ring in flat]


def ring_of(data):
    """Corners of a path of M, H and V."""
    corners = []
    for letter, numbers in re.findall(r"([MHV])([^MHV]+)", data):
        values = list(map(float, numbers.split()))
        corners.append(
            tuple(values)
            if letter == "M"
            else (values[0], corners[-1][1])
            if letter == "H"
            else (corners[-1][0], values[0])
        )
    return corners


def test_a_plan_is_to_scale_in_metres_with_all_else_in_its_metadata():
    root = ET.fromstring(export_world(TINY, "svg+scale=10", origin=(1.0, 2.0)).data)
    assert root.get("viewBox") == "0.9 -2.4 0.6 0.5"  # with the border
    assert (root.get("width"), root.get("height")) == ("60.0mm", "50.0mm")
    circles = {circle.get("class"): circle for circle in root.iter(f"{SVG}circle")}
    assert [circles["robot"].get(key) for key in ("cx", "cy", "r")] == ["1.15", "2.15", "0.04"]
    assert [circles["target"].get(key) for key in ("cx", "cy", "r")] == ["1.35", "2.15", "0.05"]
    said = json.loads(root.find(f"{SVG}metadata").text)
    assert said["heading"] == 0.5 and said["robot_speed"] == 1.5 and said["size"] == [4, 3]
    assert f"rotate({math.degrees(0.5)} 1.15 2.15)" in root.find(
        f".//{SVG}path[@class='heading']"
    ).get("transform")


def test_a_plan_shows_the_witness_unless_it_is_not_wanted():
    world = generate("maze", 1, size=13)
    shown = export_world(world, "svg").data.decode()
    corners = re.search(r'class="witness".* points="([^"]+)"', shown)[1].split()
    assert [tuple(map(float, corner.split(","))) for corner in corners] == list(
        zip(world.certificate.x.tolist(), world.certificate.y.tolist(), strict=True)
    )
    assert 'class="witness"' not in export_world(world, "svg+witness=off").data.decode()


@pytest.mark.parametrize(
    ("name", "digest"), [("geojson", "a7edc4a47c1661c6"), ("svg", "7ba469b6ee490ad2")]
)
def test_the_bytes_of_a_plan_are_the_same_everywhere(name, digest):
    data = export_world(TINY, name, origin=(-1.0, 0.25)).data
    assert hashlib.sha256(data).hexdigest()[:16] == digest


def test_a_name_that_no_xml_can_hold_is_no_fault():
    root = ET.fromstring(export_world(TINY, "svg", file="a\x01\udcff<&.svg").data)
    assert root.find(f"{SVG}title").text == "a??<&.svg"


def test_a_scale_that_is_none_is_refused():
    with raises(InvalidParameter, "out-of-range", name="scale"):
        export_world(TINY, "svg+scale=0")
