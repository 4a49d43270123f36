"""Stage worlds: the exported form, the place of the walls in Stage itself, and the import of other
files.
"""

import io
import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from tests.helpers.drawn_worlds import drawn, still_worlds
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop import export_world, find_format, read_map
from worldgen.interop.format import degrees_text, radians

PLACES = """\
floorplan
(
  name "walls-in-a-ring"
  bitmap "w.png"
  size [ 0.6 0.4 0.8 ]
  pose [ 1.7 -1.9 0 0 ]
)

disc
(
  name "robot"
  size [ 0.14 0.14 0.2 ]
  pose [ 1.55 -1.95 0 0 ]
  velocity_bounds [ -2 2 0 0 0 0 -360 360 ]
)

goal
(
  name "target"
  size [ 0.1 0.1 0.01 ]
  pose [ 1.85 -1.85 0 0 ]
)
"""


def test_a_tiny_world_is_these_bytes():
    export = export_world(
        drawn(".##G\nS##.", target_radius=0.05), "stage", file="w.world", origin=(1.5, -2.0)
    )
    text = export.data.decode()
    picture = np.asarray(Image.open(io.BytesIO(export.files["w.png"])))
    assert text.endswith(PLACES) and text.startswith("# A world made by worldgen for Stage")
    assert (picture == 0).tolist() == [
        [True] * 6,
        *[[True, False, True, True, False, True]] * 2,
        [True] * 6,
    ]
    assert all(len(line) < 255 for line in text.splitlines())  # Stage's own buffer


def walls_in_stage(export):
    """Return lower-left corners and size, m, of the wall pixels, exactly, by Stage's rule."""
    text = export.data.decode()
    size, pose = (
        [
            Fraction(word)
            for word in re.search(rf"^floorplan\n.*?^  {key} \[ (.+?) \]", text, re.M | re.S)[
                1
            ].split()
        ]
        for key in ("size", "pose")
    )
    picture = np.asarray(
        Image.open(
            io.BytesIO(next(data for name, data in export.files.items() if name[-4:] == ".png"))
        )
    )
    points = [(int(column), -int(row) - 1) for row, column in np.argwhere(picture <= 127)]
    low = [min(point[axis] for point in points) for axis in (0, 1)]
    spans = [max(point[axis] for point in points) + 1 - low[axis] for axis in (0, 1)]
    sides = [size[axis] / spans[axis] for axis in (0, 1)]
    corners = {
        tuple((point[a] - low[a] - Fraction(spans[a], 2)) * sides[a] + pose[a] for a in (0, 1))
        for point in points
    }
    return corners, sides


@given(still_worlds(), st.sampled_from([(0.0, 0.0), (-3.25, 100.1)]))
def test_stage_has_its_walls_where_the_world_has_them_and_a_ring_where_it_is_open(world, origin):
    corners, sides = walls_in_stage(export_world(world, "stage", origin=origin))
    side, shift = Fraction(repr(world.cell_size)), [Fraction(repr(value)) for value in origin]
    solid = np.pad(world.walls, 1, constant_values=True)
    expected = {
        ((ix - 1) * side + shift[0], (iy - 1) * side + shift[1])
        for iy, ix in np.argwhere(solid).tolist()
    }
    inside = {
        ((ix) * side + shift[0], (iy) * side + shift[1])
        for iy, ix in np.argwhere(world.walls).tolist()
    }
    closed = bool(world.walls[[0, -1]].all() and world.walls[:, [0, -1]].all())
    assert sides == [side, side] and corners == (inside if closed else expected)


@given(st.floats(-7.0, 7.0))
def test_a_heading_in_degrees_comes_back_to_the_bit(angle):
    assert radians(Fraction(degrees_text(angle))) == angle


def test_headings_that_people_know_are_written_as_they_write_them():
    words = [degrees_text(angle) for angle in (0.0, np.pi / 2, -np.pi / 4, np.pi, 1.0)]
    assert words == ["0", "90", "-45", "180", "57.29577951308232"]


OTHERS = """\
include "nowhere.inc"  # not here
define building model ( color "gray" obstacle_return 1 boundary 1
  gui_nose 0 )
define hall building ( size [ 8 4 1 ] )
unit_length "{unit}"
define cart position ( size [ 0.6 0.8 0.3 ] block ( points 4 point[0] [ 3 0 ] point[1] [ 0 4 ] point[2] [ -3 0 ]
  point[3] [ 0 -4 ] z [ 0 1 ] ) )
hall
(
  name "hall" pose [ 1 2 0 0 ] bitmap "m.png"
)
cart ( pose [ -1.5 1.5 0 -90 ] velocity_bounds [ -0.4 0.5 0 0 0 0 -90 90 ] sensor ( pose [ 0 0 0 0 ] ) )
cart ( pose [ 0 0 0 0 ] )
model ( name "crate" pose [ 0 0 0 0 ] )
"""


@pytest.fixture
def found(tmp_path):
    """Read a world with a picture of 6 x 4 pixels, of which a block of 4 x 2 is black."""

    def read(text, **options):
        grey = np.full((4, 6), 255, np.uint8)
        grey[1, 1] = grey[2, 4] = 0
        grey[2, 1], grey[1, 4] = 127, 128
        Image.fromarray(grey).save(tmp_path / "m.png")
        path = tmp_path / "w.world"
        path.write_text(text)
        return read_map(path, "stage", options=options)

    return read


@pytest.mark.parametrize(
    "text", ['include "x.inc"', "# a world\ndefine a model ( )", "resolution 0.1\nfloorplan (\n)"]
)
def test_a_world_of_stage_is_told_from_one_of_gazebo(tmp_path, text):
    (tmp_path / "w.world").write_text(text)
    assert find_format(tmp_path / "w.world").name == "stage"


def test_the_black_part_of_the_picture_is_what_the_size_is_of(found):
    back = found(OTHERS.format(unit="m"))
    assert back.cell_size == 2.0 and back.origin == (-5.0, -2.0)
    assert back.walls[::-1].tolist() == [
        [False] * 6, [False, True, *[False] * 4], [False, True, False, False, True, False], [False] * 6
    ]  # fmt: skip
    assert any("black takes 4 x 2 of the picture's 6 x 4 pixels" in note for note in back.notes)


def test_definitions_build_on_each_other_and_the_first_robot_is_taken(found):
    back = found(OTHERS.format(unit="m"))
    assert (
        back.start == (3.5, 3.5, -np.pi / 2)
        and back.robot_radius == 0.4
        and back.robot_speed == 0.5
    )
    assert back.target is None and "the file has 2 robots; only the first was used" in back.notes
    assert any(
        "'nowhere.inc' does not exist" in note and "are unknown" in note for note in back.notes
    )
    assert back.unread == (
        "1 thing besides the floor plan: model",
        "1 file that cannot be included",
    )


def test_units_of_the_file_count(found):
    back = found(OTHERS.format(unit="cm"))
    assert back.cell_size == 0.02 and back.origin == (-0.05, -0.02) and back.robot_radius == 0.004


def test_what_an_included_file_beside_it_defines_counts(found, tmp_path):
    (tmp_path / "cart.inc").write_text(
        "define hall model ( size [ 4 2 1 ] )\r\ndefine car position ( size [ 1 1 1 ] )\r\n"
    )
    back = found('include "cart.inc"\nhall ( bitmap "m.png" )\ncar ( pose [ 0 0 0 45 ] )\n')
    assert back.start[2] == np.pi / 4 and back.robot_radius == pytest.approx(0.5**0.5)


def test_pixels_that_are_no_squares_become_the_cells_that_they_reach_into(found):
    back = found('floorplan ( size [ 8 2 1 ] bitmap "m.png" )', cell_size=1.0)
    assert back.walls.shape == (4, 12) and back.walls[2].tolist() == [
        False,
        False,
        True,
        True,
        *[False] * 8,
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("floorplan ( size [ 1 1 ]", {"code": "wrong-form", "line": 1}),
        ("floorplan (\n size [ 1 a ]\n)", {"code": "wrong-form", "line": 2}),
        ("floorplan (\n size )\n)", {"code": "missing-value", "line": 2, "name": "size"}),
        ('floorplan ( name "x\n" )', {"code": "wrong-form", "line": 1}),
        ("floorplan ( )", {"code": "no-map-found"}),
        ('floorplan (\n bitmap "m.png" )', {"code": "wrong-type", "line": 1}),
        ('floorplan (\n bitmap "m.png"\n size [ 1e5 2 ] )', {"code": "wrong-form", "line": 3}),
        (
            'floorplan (\n bitmap "m.png"\n size [ 1-5 2 ] )',
            {"code": "not-a-number", "line": 3, "key": "size", "text": "1-5"},
        ),
        (
            'floorplan (\n bitmap "m.png" size [ 1 1 1 ]\n pose [ 0 0 0 30 ] )',
            {"code": "unsupported", "line": 3},
        ),
        (
            'floorplan (\n bitmap "../m.png" size [ 1 1 1 ] )',
            {"code": "outside-folder", "line": 2, "key": "bitmap", "name": "'../m.png'"},
        ),
        (
            'unit_length "inch"\nfloorplan ( bitmap "m.png" )',
            {"code": "unknown-name", "line": 1, "name": "inch"},
        ),
        ("define floorplan\n( )", {"code": "wrong-form", "line": 1}),
        ('include "w.world"', {"code": "nested-too-deep", "line": 1, "most": 16}),
    ],
)
def test_a_fault_is_one_sentence_with_its_line(found, text, expected):
    with raises(FormatError, **expected):
        found(text)


@pytest.mark.gate
def test_six_hundred_robots_of_a_definition_of_500_words_are_read(found):
    robot = "define robot position ( " + "ranger ( pose [ 0 0 0 30 ] ) " * 50 + ")\n"
    notes = found(OTHERS.format(unit="m") + robot + "robot ( )\n" * 600).notes
    assert "the file has 602 robots; only the first was used" in notes


@pytest.mark.gate
def test_definitions_that_grow_without_end_are_refused(found):
    lines = ["define a0 model ( color 1 )"]
    lines += [f"define a{n} model ( {f'a{n - 1} ( ) ' * 30} )" for n in range(1, 6)]
    with raises(FormatError, "too-large", most=700000):
        found("\n".join([*lines, "a5 ( )"]))
    nested = "floorplan ( " * 20 + ") " * 20
    with raises(FormatError, "nested-too-deep", most=16):
        found(nested)


def test_a_name_that_stage_cannot_read_is_refused():
    with raises(InvalidParameter, "not-a-file-name", picture='a"b.png'):
        export_world(drawn("S..G"), "stage", file='a"b.world')
