"""The contents of picture files: colours at places, sizes, captions."""

import dataclasses
import io
import re
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream
from worldgen.render import EventMark, Frame, Trail, draw_html, draw_png, draw_svg
from worldgen.render.marks import MARKS, hue, mix, rgb
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Cut, FailureRecord, Pose, Provenance, Target, Witness, World


def small_world(**changes):
    walls = np.zeros((12, 20), bool)
    walls[2:5, 10] = True
    world = World(walls, Pose(0.35, 0.35, 0.0), Target(1.75, 0.95, 0.05))
    return dataclasses.replace(world, **changes)


def square_trail(**changes):
    x = [0.35, 0.6, 0.9, 0.9, 0.6, 0.6]
    y = [0.35, 0.8, 0.8, 1.1, 1.1, 0.8]
    return dataclasses.replace(Trail(x, y, 1), **changes)


def large_maze(cells):
    walls = np.ones((2 * cells + 1, 2 * cells + 1), bool)
    walls[1::2, 1::2] = False
    rng = RandomStream(5)
    for row in range(1, 2 * cells, 2):
        for column in range(1, 2 * cells, 2):
            dy, dx = rng.choice(((0, 1), (1, 0)))
            walls[min(row + dy, 2 * cells - 1), min(column + dx, 2 * cells - 1)] = False
    return World(walls, Pose(0.15, 0.15), Target(0.35, 0.35, 0.05))


def decoded(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), np.int64)


def pixel(world, x, y, **options):
    column, row = Frame.of(world, options.get("pixels", 900)).to_pixels(x, y)
    return tuple(decoded(draw_png(world, **options))[int(row), int(column)])


def near(colour, other, tolerance=6):
    return max(abs(a - b) for a, b in zip(colour, rgb(other), strict=True)) <= tolerance


def test_walls_are_dark_where_the_world_has_them_and_not_mirrored():
    world = small_world()
    assert near(pixel(world, 1.05, 0.35), hue("wall"))
    assert not near(pixel(world, 1.05, 1.2 - 0.35), hue("wall"), 60)


def test_the_map_stands_in_a_wall_for_outside_everything_is_solid():
    world = small_world()
    frame = Frame.of(world)
    picture = decoded(draw_png(world))
    assert near(picture[frame.top - 2, frame.left + 300], hue("wall"))
    assert near(picture[frame.bottom + 2, frame.left - 2], hue("wall"))


@pytest.mark.gate
def test_the_floor_is_bluer_near_the_target_and_clear_far_away():
    world = small_world()
    red = [pixel(world, x, 0.95, witness=False)[0] for x in (1.62, 1.38, 0.73, 0.02)]
    assert red == sorted(red)
    assert red[-1] - red[0] > 60
    assert near(pixel(world, 0.01, 0.01), hue("floor"), 12)


def test_without_signal_the_floor_is_plain():
    world = small_world()
    assert (
        pixel(world, 1.55, 0.95, signal=False)
        == pixel(world, 0.05, 0.05, signal=False)
        == rgb(hue("floor"))
    )


def test_equal_ratios_of_distance_are_equal_steps_of_tint():
    world = World(np.zeros((4, 400), bool), Pose(39.0, 0.2), Target(0.0, 0.2, 0.05))
    red = [pixel(world, x, 0.31)[0] for x in (1.5, 4.5, 13.5)]
    assert red[1] - red[0] == pytest.approx(red[2] - red[1], abs=2)


def test_the_start_is_a_disc_of_the_robots_true_radius():
    world = small_world(certificate=None)
    assert near(
        pixel(world, 0.35, 0.35 + 0.061), mix(hue("floor"), hue("start"), MARKS["start"].fill)
    )
    assert near(pixel(world, 0.35, 0.35 + 0.07), hue("start"), 60)
    assert pixel(world, 0.35, 0.35 + 0.09)[0] > 200


def test_a_robot_too_small_to_see_is_ringed():
    world = World(np.zeros((900, 900), bool), Pose(45.0, 45.0), Target(80.0, 80.0, 0.05))
    column, row = Frame.of(world).to_pixels(45.0, 45.0)
    ring = decoded(draw_png(world))[int(row) - 12 : int(row) - 8, int(column)]
    assert any(near(colour, hue("start"), 40) for colour in ring)


def test_the_loop_is_drawn_in_its_strong_colour_and_the_approach_is_not():
    world, trail = small_world(), square_trail()
    assert near(pixel(world, 0.75, 0.8, trail=trail), hue("loop"))
    assert near(pixel(world, 0.6, 0.95, trail=trail), hue("loop"))
    assert not near(pixel(world, 0.5, 0.62, trail=trail), hue("loop"))


def test_a_light_band_sets_the_loop_off_from_the_path_into_it():
    world, trail = small_world(), square_trail()
    band, bare = (pixel(world, 0.75, 0.8 - gap, trail=trail) for gap in (0.009, 0.03))
    assert band[0] > band[2]
    assert bare[0] <= bare[2]


def test_a_loop_on_one_spot_is_still_seen():
    trail = Trail([0.35, 0.75, 0.75], [0.35, 0.8, 0.8], 1)
    assert near(pixel(small_world(), 0.75, 0.87, trail=trail), hue("loop"), 30)
    assert "forever on this spot" in draw_svg(small_world(), trail=trail)


def test_a_run_without_a_loop_ends_in_a_footprint():
    trail = square_trail(loop_from=None)
    assert near(pixel(small_world(), 0.6, 0.8 - 0.07, trail=trail), hue("robot"), 30)


def test_a_wall_that_a_tunnel_goes_through_is_crossed_out():
    trail = square_trail(marks=[EventMark(1.05, 0.35, "tunnel")])
    assert near(pixel(small_world(), 1.05, 0.35, trail=trail), hue("pierced"), 20)


def test_a_run_ends_in_a_ring_below_its_path():
    trail = square_trail(loop_from=None, marks=[EventMark(0.9, 1.0, "end")])
    assert near(pixel(small_world(), 0.9 + 0.07, 1.0, trail=trail), hue("robot"), 60)


def test_a_bump_marks_the_sides_of_walls_that_the_robot_touches():
    trail = square_trail(marks=[EventMark(0.93, 0.35, "bump")])
    world = small_world()
    assert near(pixel(world, 1.0045, 0.35, trail=trail), hue("touched"), 20)
    # Walls that it does not touch have no line, nor have the other sides.
    assert near(pixel(world, 1.05, 0.35, trail=trail), hue("wall"))
    assert near(pixel(world, 1.0955, 0.35, trail=trail), hue("wall"))
    assert near(pixel(world, 1.0045, 0.45, trail=trail), hue("wall"))


def test_the_border_is_marked_where_a_robot_touches_it():
    trail = square_trail(marks=[EventMark(0.35, 0.07, "bump")])
    frame = Frame.of(small_world())
    picture = decoded(draw_png(small_world(), trail=trail))
    column = int(frame.to_pixels(0.35, 0.0)[0])
    assert near(picture[frame.bottom + 2, column], hue("touched"), 20)


def test_an_overlap_shows_the_robots_disc_over_the_wall():
    trail = square_trail(marks=[EventMark(0.95, 0.35, "overlap")])
    assert near(pixel(small_world(), 0.95 + 0.07, 0.35, trail=trail), hue("pierced"), 20)


def test_the_witness_is_dashed_green_and_can_be_left_out():
    world = small_world(certificate=Witness([0, 1], [0.35, 1.75], [1.1, 1.1], 0.1))
    with_path, without = (decoded(draw_png(world, witness=shown)) for shown in (True, False))
    row = int(Frame.of(world).to_pixels(0.0, 1.1)[1])
    left, right = (int(Frame.of(world).to_pixels(x, 0.0)[0]) for x in (0.45, 1.65))
    green = [near(colour, hue("start"), 30) for colour in with_path[row, left:right]]
    assert 0.3 < np.mean(green) < 0.9
    assert not any(near(colour, hue("start"), 30) for colour in without[row, left:right])


def test_a_cut_is_drawn_through_its_cells():
    world = small_world(certificate=Cut([[10, 2], [10, 4], [14, 4]], 0.0))
    assert near(pixel(world, 1.05, 0.40), hue("breach"))
    assert "every gap too narrow" in draw_svg(world)


def test_cells_that_change_are_tinted_by_what_they_become():
    events = [
        Event(1.0, 3, 9, CellState.BURNING),
        Event(2.0, 6, 9, CellState.SOLID),
        Event(3.0, 10, 3, CellState.FREE),
    ]
    world = small_world(timeline=Timeline.of(events))
    picture, frame = decoded(draw_png(world, signal=False)), Frame.of(world)
    for x, colour in ((0.35, hue("fire")), (0.65, hue("quiet"))):
        column, row = (int(value) for value in frame.to_pixels(x, 0.95))
        patch = picture[row - 15 : row + 15, column - 15 : column + 15].reshape(-1, 3)
        assert any(near(spot, mix(hue("floor"), colour, 0.30), 8) for spot in patch)
        assert any(near(spot, mix(hue("floor"), colour, 0.89), 12) for spot in patch)
    # A wall that opens is light below its stripes.
    row, left, right = (
        int(frame.to_pixels(1.0, 0.33)[1]),
        *(int(frame.to_pixels(x, 0.33)[0]) for x in (1.0, 1.1)),
    )
    light = mix(hue("wall"), hue("floor"), MARKS["opens"].fill)
    assert any(near(spot, light, 8) for spot in picture[row, left:right])


@pytest.mark.parametrize(("width", "height"), [(100, 10), (10, 100), (60, 60), (7, 3)])
def test_the_map_keeps_its_aspect(width, height):
    frame = Frame.of(
        World(np.zeros((height, width), bool), Pose(0.05, 0.05), Target(0.2, 0.2, 0.05))
    )
    assert frame.width * height == frame.height * width
    assert 800 <= max(frame.width, frame.height) <= 900


@pytest.mark.gate
def test_twice_the_pixels_is_twice_the_picture():
    small, large = (decoded(draw_png(small_world(), pixels=pixels)).shape for pixels in (900, 1800))
    assert (large[0], large[1]) == pytest.approx((2 * small[0], 2 * small[1]), abs=4)


@pytest.mark.parametrize("pixels", [-1, 0, 99, 8001, 10**9])
def test_absurd_sizes_are_refused(pixels):
    with raises(InvalidParameter, "out-of-range", low=100, high=8000):
        draw_png(small_world(), pixels=pixels)


@pytest.mark.gate
def test_two_thousand_cells_a_side_give_a_picture_of_the_usual_size():
    walls = np.zeros((2000, 2000), bool)
    walls[500] = True
    world = World(walls, Pose(20.0, 20.0), Target(150.0, 150.0, 0.05))
    assert max(decoded(draw_png(world)).shape) < 1100
    assert pixel(world, 100.0, 50.05)[0] < pixel(world, 100.0, 49.0)[0] - 50


def test_one_cell_is_a_world_with_a_picture():
    world = World(
        np.zeros((1, 1), bool), Pose(0.05, 0.05), Target(0.05, 0.05, 0.01), robot_radius=0.01
    )
    assert decoded(draw_png(world)).shape[1] >= 900


def test_equal_worlds_give_equal_bytes():
    assert draw_png(small_world(), trail=square_trail()) == draw_png(
        small_world(), trail=square_trail()
    )


def test_svg_is_xml_with_title_scale_and_key():
    svg = draw_svg(small_world(), trail=square_trail(), title='<b>"A & B"</b>')
    texts = [
        element.text
        for element in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")
    ]
    # What is written on the map comes before the caption.
    title = texts.index('<b>"A & B"</b>')
    assert texts[title + 1] == "2 x 1.2 m, cell 0.1 m, robot radius 0.07 m"
    assert {
        MARKS[name].label for name in ("began", "target", "approach", "loop", "nearest")
    } <= set(texts)


def test_titles_that_no_file_can_hold_are_made_harmless():
    svg = draw_svg(small_world(), title="a\x00b\udcffc\nd")
    assert (
        ElementTree.fromstring(svg.encode()).find("{http://www.w3.org/2000/svg}title").text
        == "a?b?c d"
    )
    draw_png(small_world(), title="a\x00b\udcffc\nd" * 100)


def test_a_long_title_is_wrapped_and_cut_off():
    svg = draw_svg(small_world(), title="word " * 1000)
    lines = [text for text in re.findall(">(word[^<]*)<", svg) if len(text) < 1000]
    assert len(lines) == 3
    assert lines[-1].endswith("...")


def test_svg_walls_lie_where_the_frame_puts_them():
    world = small_world()
    frame, svg = Frame.of(world), ElementTree.fromstring(draw_svg(world))
    (walls,) = [
        path
        for path in svg.iter("{http://www.w3.org/2000/svg}path")
        if path.get("fill") == hue("wall")
    ]
    left, bottom, across, up = (
        float(number) for number in re.findall(r"-?[\d.]+", walls.get("transform"))
    )
    x, y, steps = re.fullmatch(r"M(\d+) (\d+)([hv\d-]+)z", walls.get("d")).groups()
    assert (left + across * int(x), bottom + up * int(y)) == pytest.approx(
        frame.to_pixels(1.0, 0.2)
    )
    assert steps == "h1v3h-1"


def test_the_signal_halves_from_ring_to_ring():
    circles = ElementTree.fromstring(draw_svg(small_world())).iter(
        "{http://www.w3.org/2000/svg}circle"
    )
    radii = [float(circle.get("r")) for circle in circles if circle.get("clip-path")]
    strength = [1.0 / radius**2 for radius in radii]
    assert len(strength) > 5
    assert all(weak / strong == pytest.approx(0.5, rel=1e-3) for strong, weak in pairwise(strength))


def test_svg_of_a_large_maze_stays_small():
    assert len(draw_svg(large_maze(100))) < 200_000


def test_svg_of_noise_holds_an_image_and_not_a_million_corners():
    walls = RandomStream(1).floats(1000 * 1000).reshape(1000, 1000) < 0.3
    svg = draw_svg(World(walls, Pose(1.0, 1.0), Target(5.0, 5.0, 0.05)))
    assert 'href="data:image/png;base64,' in svg
    assert len(svg) < 1_000_000


def test_html_asks_the_network_for_nothing():
    page = draw_html(small_world(), trail=square_trail(), title="a world")
    assert "http" not in page
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", page)
    assert "<title>a world</title>" in page


def test_html_tells_what_failed_and_escapes_it():
    failure = FailureRecord(
        "<script>", "swept", 3, "loop", "00ff", evidence={"entry": 12, "period": 104}
    )
    page = draw_html(
        small_world(failure=failure, provenance=Provenance("maze", 1, 7, {"size": 60}))
    )
    assert "&lt;script&gt; under swept, seed 3: loop" in page
    assert "<script>" not in page
    assert "<th>period</th><td>104</td>" in page
    assert "<th>maze: size</th><td>60</td>" in page


@pytest.mark.parametrize(
    ("x", "y", "loop_from", "expected"),
    [
        ([], [], None, {"code": "wrong-shape"}),
        ([1.0, 2.0], [1.0], None, {"code": "wrong-shape"}),
        ([[1.0]], [[1.0]], None, {"code": "wrong-shape"}),
        ([float("nan")], [1.0], None, {"code": "not-finite"}),
        ([1.0], [1.0], 1, {"code": "out-of-range", "name": "loop_from", "value": 1}),
        ([1.0], [1.0], -1, {"code": "out-of-range", "name": "loop_from", "value": -1}),
    ],
)
def test_a_trail_that_makes_no_sense_is_refused(x, y, loop_from, expected):
    with raises(InvalidParameter, **expected):
        Trail(x, y, loop_from)


@pytest.mark.parametrize(
    ("x", "kind", "expected"),
    [
        (0.0, "crash", {"code": "unknown-name", "kind": "crash"}),
        (float("inf"), "end", {"code": "not-finite"}),
    ],
)
def test_a_mark_that_makes_no_sense_is_refused(x, kind, expected):
    with raises(InvalidParameter, **expected):
        EventMark(x, 0.0, kind)


@pytest.mark.gate
def test_a_trail_outside_the_map_and_one_of_one_point_are_drawn():
    for trail in (Trail([-5.0, 9.0], [-5.0, 9.0]), Trail([0.35], [0.35]), Trail([0.35], [0.35], 0)):
        draw_png(small_world(), trail=trail)
        draw_svg(small_world(), trail=trail)


def test_the_floor_ends_where_the_wall_around_it_begins():
    world = small_world()
    frame, picture = Frame.of(world), decoded(draw_png(world, signal=False))
    row, column, end = frame.top + frame.height // 2, frame.left + 300, frame.left + frame.width
    assert [tuple(picture[row, x]) for x in (end - 1, end)] == [rgb(hue("floor")), rgb(hue("wall"))]
    assert [tuple(picture[y, column]) for y in (frame.bottom - 1, frame.bottom)] == [
        rgb(hue("floor")),
        rgb(hue("wall")),
    ]
    assert [tuple(picture[row, x]) for x in (frame.left - 1, frame.left)] == [
        rgb(hue("wall")),
        rgb(hue("floor")),
    ]


def test_named_cells_are_marked_and_the_columns_and_rows_are_numbered():
    world = small_world()
    trail = square_trail(named=((10, 3), (4, 9)))
    picture = decoded(draw_png(world, trail=trail, pixels=900))
    frame = Frame.of(world, 900, is_numbered=True)
    for x, y in ((1.05, 0.35), (0.45, 0.95)):
        column, row = (int(at) for at in frame.to_pixels(x, y))
        around = picture[row - 15 : row + 16, column - 15 : column + 16].reshape(-1, 3)
        assert sum(near(colour, hue("named")) for colour in around) > 50
    texts = re.findall("<text[^>]*>([^<]*)</text>", draw_svg(world, trail=trail))
    assert "cell named in the text" in texts
    assert {str(number) for number in range(20)} <= set(texts)
    # Only pictures with named cells have numbers.
    assert not {"0", "cell named in the text"} & set(
        re.findall("<text[^>]*>([^<]*)</text>", draw_svg(world, trail=square_trail()))
    )


def test_the_numbers_of_a_large_world_do_not_overlap():
    world = large_maze(100)
    svg = draw_svg(world, trail=Trail([0.15], [0.15], named=((0, 0),)), pixels=400)
    texts = re.findall(r'<text x="([^"]*)" y="([^"]*)"[^>]*>(\d+)</text>', svg)
    above = sorted(float(x) for x, y, _ in texts if y == texts[0][1])
    assert len(above) > 5
    assert min(b - a for a, b in pairwise(above)) > 15.0


def test_the_caption_names_the_options_of_the_controller():
    parameters = {"beams": 36, "repaired": True, "steps": 9, "time_step": 0.015}
    record = FailureRecord("vfh", "swept", 0, "loop", "0" * 16, parameters)
    svg = draw_svg(small_world(failure=record))
    assert "vfh under swept with beams=36, repaired: loop" in svg
