"""IR-SIM worlds: the exported form, and the import of other files."""

import io
import math

import numpy as np
import pytest
from PIL import Image

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import export_world, import_world, read_map, write_export

TINY = """\
# A world made by worldgen for IR-SIM; m, rad, s.
world:
  width: 0.4
  height: 0.2
  offset: [1.5, -2]
  step_time: 0.1
  sample_time: 0.1
  control_mode: auto
  collision_mode: stop
robot:
  - kinematics: {name: diff}
    shape: {name: circle, radius: 0.07}
    state: [1.55, -1.95, 0]
    goal: [1.85, -1.85, 0]
    goal_threshold: 0.05
    vel_min: [-2, -6.2832]
    vel_max: [2, 6.2832]
obstacle:
  - number: 2
    distribution: {name: manual}
    shape: {name: rectangle, length: 0.1, width: 0.2}
    state:
      - [1.45, -1.9, 0]
      - [1.95, -1.9, 0]
  - number: 1
    distribution: {name: manual}
    shape: {name: rectangle, length: 0.2, width: 0.2}
    state:
      - [1.7, -1.9, 0]
  - number: 2
    distribution: {name: manual}
    shape: {name: rectangle, length: 0.6, width: 0.1}
    state:
      - [1.7, -2.05, 0]
      - [1.7, -1.75, 0]
"""


def test_a_tiny_world_is_these_bytes():
    world = drawn(".##G\nS##.", target_radius=0.05)
    assert export_world(world, "irsim", origin=(1.5, -2.0)).data.decode() == TINY


def test_as_a_picture_the_walls_are_black_and_the_lidar_is_there_if_wanted():
    export = export_world(drawn(".##G\nS##."), "irsim+walls=image+lidar+robot=omni", file="w.yaml")
    picture = np.asarray(Image.open(io.BytesIO(export.files["w.png"])))
    assert picture.tolist() == [[255, 0, 0, 255]] * 2
    text = export.data.decode()
    assert "  obstacle_map: 'w.png'\n  mdownsample: 1\n" in text and "{name: omni}" in text
    assert "vel_max: [2, 2]" in text and "sensors: [{type: lidar2d, " in text


def test_a_world_whose_walls_fit_larger_cells_keeps_its_cell_size_in_the_sidecar(tmp_path):
    closed = drawn("######\n######\n##S.##\n##.G##\n######\n######", radius=0.04)
    export = export_world(closed, "irsim")
    assert export.lost == ("the cell size, 0.1 m, is not stored; the walls fit larger cells too",)
    path = write_export(export, tmp_path)[0]
    assert np.array_equal(import_world(path).world.walls, closed.walls)


def test_a_step_longer_than_a_cell_is_said():
    notes = export_world(drawn("S..G"), "irsim").notes
    assert any(
        "moves 0.2 m per step and checks for collisions only at its end" in note for note in notes
    )
    assert not export_world(drawn("S..G"), "irsim+step_time=0.05").notes


@pytest.fixture
def found(tmp_path):
    """Read a world of 1 m x 0.6 m with additional lines."""

    def read(text, head="world:\n  width: 1\n  height: 0.6\n", **options):
        path = tmp_path / "w.yaml"
        path.write_text(head + text)
        return read_map(path, "irsim", options=options)

    return read


def rows(found):
    return ["".join("#" if cell else "." for cell in row) for row in found.walls[::-1]]


def obstacle(shape, state="[0.5, 0.3, 0]", more=""):
    return f"obstacle:\n  - shape: {{{shape}}}\n    state: {state}\n{more}"


def test_rectangles_turned_by_quarters_lie_on_cells_exactly(found):
    back = found(
        obstacle("name: rectangle, length: 0.4, width: 0.2", "[0.5, 0.3, 1.57]"), cell_size=0.1
    )
    assert rows(back) == ["." * 10, *["....##...."] * 4, "." * 10]
    assert any("turned by 1.57 rad counts as turned by 1 quarters" in note for note in back.notes)


def test_walls_turned_alike_are_said_once(found):
    more = "      - [0.2, 0.3, 1.57]\n      - [0.8, 0.3, 1.57]\n"
    back = found(
        obstacle("name: rectangle, length: 0.4, width: 0.2", f"\n{more}", "    number: 2\n")
    )
    assert sum("counts as turned" in note for note in back.notes) == 1


SLANTED = ["..........", ".....##...", "....###...", "...###....", "...##.....", ".........."]
DISC = ["..........", *["...####..."] * 4, ".........."]
NOTCHED = ["..........", *["......##.."] * 2, *["..######.."] * 2, ".........."]
LINE = [".......##.", "......###.", "....###...", "...###....", ".###......", ".##......."]
PARTS = [*[".........."] * 2, *[".##....##."] * 2, *[".........."] * 2]


@pytest.mark.parametrize(
    ("shape", "state", "cells", "partly"),
    [
        ("name: rectangle, length: 0.4, width: 0.02", "[0.5, 0.3, 0.785398]", SLANTED, 10),
        ("name: circle, radius: 0.2", "[0.5, 0.3]", DISC, 12),
        (
            "name: polygon, vertices: [[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [0.1, 0.2], [0.1, "
            "0], [-0.3, 0]]",
            "[0.5, 0.3, 0]", NOTCHED, 0,
        ),
        ("name: linestring, vertices: [[-0.3, -0.2], [0.3, 0.2]]", "[0.5, 0.3, 0]", LINE, 16),
        (
            "name: compound, parts: [{name: circle, radius: 0.1, pose: [0.3, 0, 0]}, "
            "{name: rectangle, length: 0.2, width: 0.2, pose: [-0.3, 0, "
            "0]}]", "[0.5, 0.3, 0]", PARTS, 4,
        ),
    ],
)  # fmt: skip
def test_every_cell_that_a_shape_reaches_into_is_solid(found, shape, state, cells, partly):
    back = found(obstacle(shape, state), cell_size=0.1)
    said = [note for note in back.notes if "are only partly covered" in note]
    assert rows(back) == cells
    assert bool(said) == bool(partly) and all(note.startswith(f"{partly} of ") for note in said)


def test_cells_are_as_large_as_the_rectangles_let_them_be(found):
    assert found(obstacle("name: rectangle, length: 0.3, width: 0.2")).cell_size == 0.05
    assert (
        found(obstacle("name: rectangle, length: 0.3, width: 0.2", "[0.5, 0.31, 0]")).cell_size
        == 0.01
    )
    assert found(obstacle("name: circle, radius: 0.2")).cell_size == 0.1


@pytest.fixture
def picture(tmp_path):
    """Write an obstacle map of 4 x 2 pixels and return the lines of a 2 m x 1 m world with it."""
    grey = np.array([[0, 127, 128, 255], [255, 255, 100, 255]], np.uint8)
    Image.fromarray(grey).save(tmp_path / "m.png")
    return "world:\n  width: 2\n  height: 1\n  obstacle_map: 'm.png'\n"


def test_a_pixel_darker_than_half_is_solid_and_the_threshold_can_be_asked_for(found, picture):
    assert rows(found("", picture)) == ["##..", "..#."]
    assert rows(found("", picture, threshold=0.4)) == ["###.", "..#."]
    assert rows(found("", picture, threshold=0.9)) == ["#...", "...."]


def test_a_picture_is_thinned_out_as_irsim_does_and_fits_cells_that_are_no_squares(found, picture):
    thinned = found("  mdownsample: 2\n", picture)
    assert rows(thinned) == [".#"] and thinned.cell_size == 1.0
    stretched = found("", picture.replace("width: 2", "width: 4"))
    assert rows(stretched) == ["####....", "....##.."] and stretched.cell_size == 0.5


def test_the_first_robot_is_taken_with_its_shape(found):
    text = (
        "robot:\n  - number: 2\n    kinematics: {name: acker}\n"
        "    shape: {name: rectangle, length: 0.4, width: 0.3, wheelbase: 0.2}\n"
        "    state: [[0.2, 0.1, 0.5], [0.7, 0.5]]\n    goal: [[0.1, 0.5], [0.9, 0.5, 1]]\n    "
        "vel_max: [0.5, 1]\n"
    )
    back = found(text)
    start, target, radius, speed, footprint, *_ = back.robot
    assert (start, target, radius, speed) == ((0.2, 0.1, 0.5), (0.9, 0.5, 0.1), None, 0.5)
    assert footprint == ((-0.1, -0.15), (0.3, -0.15), (0.3, 0.15), (-0.1, 0.15))
    assert "the file has 2 robots; only the first was used" in back.notes
    assert any("--drive car --turning-radius 0.1284" in note for note in back.notes)


def test_a_shape_that_is_no_convex_polygon_becomes_a_disc_that_holds_it(found):
    arrow = "[[0.3, 0], [-0.2, 0.2], [-0.1, 0], [-0.2, -0.2]]"
    back = found(f"robot:\n  - shape: {{name: polygon, vertices: {arrow}}}\n")
    assert back.robot.radius == pytest.approx(0.3) and back.robot.footprint == ()
    assert any("not convex" in note for note in back.notes)


def test_a_goal_has_a_heading_if_the_robot_arrives_by_its_state(found):
    text = "robot:\n  - goal: [0.9, 0.5, 1.5]\n    goal_threshold: 0.2\n"
    assert found(text).robot.goal is None
    goal = found(text + "    arrive_mode: state\n").robot.goal
    assert (goal.heading, goal.heading_tolerance, goal.arrival) == (1.5, 0.2, "step")


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ("    kinematics: {name: diff}\n", "1 obstacle at line 5 that can move"),
        ("    distribution: {name: random}\n", "1 obstacle at line 5 placed at random"),
    ],
)
def test_obstacles_that_drive_or_are_drawn_count_as_not_read(found, more, sentence):
    back = found(obstacle("name: circle, radius: 0.2", more=more))
    assert not back.walls.any() and back.unread == (sentence,)


def test_an_obstacle_with_a_random_shape_counts_as_not_read(found):
    back = found(obstacle("name: polygon, random_shape: true"))
    assert back.unread == ("1 obstacle at line 5 with a random shape",)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("world:\n  width: -1\n", {"code": "not-positive", "line": 2, "key": "width"}),
        (
            "world:\n  width: wide\n",
            {"code": "not-a-number", "line": 2, "key": "width", "word": "wide"},
        ),
        ("world:\n  offset: [1, 2, 3]\n", {"code": "wrong-type", "line": 2}),
        ("world:\n  offset: [1, [2]]\n", {"code": "wrong-type", "line": 2, "key": "offset"}),
        (
            "world:\n  width: 1000000\n  height: 1000000\n",
            {"code": "wrong-size", "width": 10000000, "height": 10000000, "cell_size": 0.1},
        ),
        (
            "world:\n  obstacle_map: ../m.png\n",
            {"code": "outside-folder", "line": 2, "key": "obstacle_map", "name": "'../m.png'"},
        ),
        (
            "world:\n  obstacle_map: {name: perlin}\n",
            {"code": "unsupported", "line": 2, "kind": "perlin"},
        ),
        ("world:\nobstacle:\n  - number: -3\n", {"code": "out-of-range", "line": 3, "number": -3}),
        (
            "world:\nobstacle:\n  - shape: {name: map}\n",
            {"code": "unsupported", "line": 3, "shape": "map"},
        ),
        (
            "world:\nobstacle:\n  - shape: {name: polygon, vertices: [[1, 2]]}\n",
            {"code": "wrong-count", "line": 3, "least": 3},
        ),
        ("world:\nobstacle: 3\n", {"code": "wrong-type", "line": 2, "key": "obstacle"}),
        ("world:\nrobot:\n  - vel_max: [0, 1]\n", {"code": "not-positive", "line": 3}),
        ("world:\nrobot:\n  - state: []\n", {"code": "wrong-type", "line": 3, "key": "state"}),
        ("robot:\n  - state: [1, 2]\n", {"code": "missing-key"}),
    ],
)
def test_a_fault_is_one_sentence_with_its_line(found, text, expected):
    with raises(FormatError, **expected):
        found("", text)


def test_a_million_obstacles_as_large_as_the_world_are_refused_in_time(found):
    text = obstacle("name: rectangle, length: 900, width: 900", "[450, 450, 0]").replace(
        "- shape", "- number: 9\n    shape"
    )
    with raises(FormatError, "too-large"):
        found(
            text.replace("[450, 450, 0]", str([[450, 450, 0]] * 9)),
            "world:\n  width: 800\n  height: 800\n",
            cell_size=0.1,
        )


@pytest.mark.gate
@pytest.mark.parametrize(
    ("corners", "expected"),
    [(500, {"code": "crosses-itself", "corners": 500}), (20_000, {"code": "too-large"})],
)
def test_outlines_that_would_take_minutes_are_refused_at_once(tmp_path, corners, expected):
    angle = 2 * math.pi / corners
    turns = (
        7 if corners == 500 else 1
    )  # a path that winds around several times crosses itself; one that winds once, in and out, does not
    points = [
        f"[{50 + far * math.cos(turns * angle * n):.5f}, "
        f"{50 + far * math.sin(turns * angle * n):.5f}]"
        for n in range(corners)
        for far in [20 + 25 * (n % 2)]
    ]
    shape = f"{{name: polygon, vertices: [{', '.join(points)}]}}"
    text = (
        f"world: {{width: 100, height: 100}}\nobstacle:\n  - {{shape: {shape}, state: [0, 0, 0]}}\n"
    )
    (tmp_path / "w.yaml").write_text(text)
    with raises(FormatError, **expected):
        read_map(tmp_path / "w.yaml", "irsim+cell_size=0.1")
