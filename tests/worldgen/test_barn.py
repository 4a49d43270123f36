"""Gazebo worlds of posts: reading and writing BARN's form, shapes in other files, and malicious
XML.
"""

import numpy as np
import pytest

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import export_world, find_format, read_map
from worldgen.interop.readers.xml_tree import read_xml

POST = """    <model name='unit_cylinder_0'>
      <static>1</static>
      <pose>1.25 0.15 0 0 0 0</pose>
      <link name='link'>
        <collision name='collision'><geometry><cylinder><radius>0.05</radius><length>1</length></cylinder></geometry>"""
BODY = (
    "<model name='{name}'><pose frame=''>{pose}</pose><link name='link'>{inner}"
    "<collision name='c'>{shape}</collision></link></model>"
)
CYLINDER = "<geometry><cylinder><radius>{}</radius><length>1</length></cylinder></geometry>"
BOX = "<geometry><box><size>{}</size></box></geometry>"


def body(shape, pose="0 0 0 0 0 0", name="m", inner=""):
    return BODY.format(name=name, pose=pose, shape=shape, inner=inner)


def posts(places, radius="0.075000"):
    return "".join(
        body(CYLINDER.format(radius), f"{x} {y} 0 0 0 0", f"p{n}")
        for n, (x, y) in enumerate(places)
    )


@pytest.fixture
def found(tmp_path):
    """Read a world with these models."""

    def read(models, **options):
        path = tmp_path / "w.world"
        path.write_text(
            f"<?xml version='1.0'?>\n<!-- a world -->\n<sdf version='1.6'>\n<world "
            f"name='w'>{models}</world></sdf>"
        )
        assert find_format(path).name == "sdf"
        return read_map(path, options=options)

    return read


def rows(found):
    return ["".join("#" if cell else "." for cell in row) for row in found.walls[::-1]]


def test_each_solid_cell_is_a_post_and_the_rest_is_in_marks_and_elements():
    export = export_world(drawn("#S..G", target_radius=0.05), "barn", origin=(1.2, 0.1))
    text = export.data.decode()
    assert POST in text and text.count("unit_cylinder_") == 1 + 16
    assert "<worldgen:grid>1.2 0.1 0.5 0.1 0.1</worldgen:grid>" in text
    assert "INIT_POSITION = [1.35, 0.15, 0], GOAL_POSITION = [0.3, 0]" in export.notes[0]


def test_barns_posts_become_the_squares_that_they_came_from_and_the_challenges_ends(found):
    back = found(posts([(-4.425, 0.075), (-2.175, 7.425), (-0.075, 14.925)]))
    assert back.walls.shape == (100, 30) and back.cell_size == 0.15 and back.origin == (-4.5, 0.0)
    assert np.argwhere(back.walls).tolist() == [[0, 0], [49, 15], [99, 29]]
    assert back.robot.start == (2.25, 3.0, 1.57) and back.robot.target == (2.25, 13.0, 1.0)


def test_an_inner_raster_lies_in_the_outer_one(found):
    places = posts([(-2.175, 7.425), (-2.025, 7.425)])
    inner, outer = found(places, raster="inner", cell_size=0.025), found(places, cell_size=0.025)
    assert 0 < np.count_nonzero(inner.walls) < np.count_nonzero(outer.walls) == 2 * 36
    assert not (inner.walls & ~outer.walls).any()


def test_boxes_of_others_are_exact_and_their_frame_is_all_that_stands_there(found):
    table = body(BOX.format("0.4 0.2 1"), "3 1 0.5 0 0 1.5708")
    wall = body(BOX.format("0.2 0.2 3"), "2 0 0 0 0 0", "w", inner="<pose>0.5 0.3 0 0 0 0</pose>")
    back = found(table + wall)
    assert back.cell_size == 0.1 and back.origin == (2.4, 0.2) and back.robot.start is None
    assert rows(back) == [*[".....##"] * 4, *["......."] * 4, *["##....."] * 2]


def test_a_state_moves_a_model_and_slanted_boxes_are_taken_whole(found):
    state = "<state world_name='w'><model name='m'><pose>5 5 0 0 0 0.785398</pose></model></state>"
    back = found(body(BOX.format("0.4 0.02 1")) + state, cell_size=0.1)
    assert back.origin == pytest.approx((4.8515, 4.8515), abs=1e-3)
    assert rows(back) == [".##", "###", "##."]


def test_what_stops_no_robot_is_left_out_and_what_is_not_read_is_named(found):
    flat, high = body(BOX.format("9 9 0.01")), body(BOX.format("9 9 1"), "0 0 5 0 0 0")
    tilted, mesh = (
        body(
            "<geometry><capsule><radius>1</radius><length>1</length></capsule></geometry>",
            "0 0 0 0.3 0 0",
        ),
        body("<geometry><mesh><uri>x</uri></mesh></geometry>"),
    )
    include = "<include><uri>model://sun</uri></include><include><uri>model://table</uri></include>"
    back = found(body(BOX.format("1 1 1")) + flat + high + tilted + mesh + include)
    assert (
        back.walls.all()
        and "2 shapes that lie flat on the floor, or above 2 m, are ignored" in back.notes
    )
    assert back.unread == (
        "1 body above 2 m that may fall", "1 mesh not found", "1 model not found",
        "1 shape of <capsule>, tilted",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("models", "expected"),
    [
        ("<model>", {"code": "not-xml", "line": 4}),
        ("", {"code": "empty"}),
        (
            "\n" + body(CYLINDER.format("-1")),
            {"code": "not-positive", "line": 5, "name": "cylinder", "child": "radius"},
        ),
        (
            "\n" + body(CYLINDER.format("wide")),
            {"code": "wrong-count", "line": 5, "name": "<radius>", "text": "wide", "count": 1},
        ),
        (
            body(BOX.format("1 1")),
            {"code": "wrong-count", "line": 4, "name": "<size>", "text": "1 1", "count": 3},
        ),
        (
            body(BOX.format("1 1 1"), "0 0 0"),
            {"code": "wrong-count", "line": 4, "name": "<pose>", "text": "0 0 0", "count": 6},
        ),
        (
            body(BOX.format("1 1 1")).replace("frame=''", "relative_to='x'"),
            {"code": "no-such-frame", "line": 4, "name": "x"},
        ),
        (
            body(BOX.format("1 1 1")) + body(BOX.format("1 1 1"), "1e7 0.01 0 0 0 0"),
            {"code": "wrong-size", "cell_size": 0.1},
        ),
        ("<a>" * 70 + "</a>" * 70, {"code": "too-large", "line": 4, "most_depth": 64}),
    ],
)
def test_a_fault_is_one_sentence_with_its_line(found, models, expected):
    with raises(FormatError, **expected):
        found(models)


BOMB = (
    b"<?xml version='1.0'?>\n<!DOCTYPE a [\n<!ENTITY x 'xxxxxxxx'>\n<!ENTITY y "
    b"'&x;&x;&x;&x;'>\n]>\n"
    b"<sdf><world>&y;</world></sdf>"
)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (BOMB, {"code": "unsupported", "line": 2, "name": "a"}),
        (
            b"<!DOCTYPE sdf SYSTEM 'file:///etc/passwd'><sdf/>",
            {"code": "unsupported", "line": 1, "name": "sdf"},
        ),
        (b"<sdf>&nbsp;</sdf>", {"code": "not-xml", "line": 1}),
        (b"<?xml version='1.0' encoding='klingon'?><sdf/>", {"code": "not-xml", "line": 1}),
        (b"", {"code": "not-xml", "line": 1, "column": 1}),
        (b"<sdf>\n\x00</sdf>", {"code": "not-xml", "line": 2}),
    ],
)
def test_xml_that_is_meant_to_hurt_is_refused_with_its_line(data, expected):
    with raises(FormatError, **expected):
        read_xml(data)


def test_text_and_attributes_are_read_whatever_piece_they_came_in():
    root = read_xml(b"<a b='1'><c>" + b"x" * 200_000 + b"<d/>y&amp;z</c></a>")
    assert root.attributes == {"b": "1"} and root.word("c") == "x" * 200_000 + "y&z"
