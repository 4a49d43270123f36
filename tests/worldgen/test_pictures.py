"""Pictures without a map file: dark pixels are solid, and our own pictures store more."""

import io

import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop import (
    export_world,
    find_format,
    import_world,
    looks_like_a_map,
    read_map,
    write_export,
)

GREYS = np.array([[0, 100, 127], [128, 200, 255]], np.uint8)
SOLID = [[False, False, False], [True, True, True]]  # row 0 is the lowest


def png(pixels, **text):
    said = PngImagePlugin.PngInfo()
    for key, value in text.items():
        said.add_text(key, value)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG", pnginfo=said)
    return stream.getvalue()


@pytest.fixture
def write(tmp_path):
    def write_file(data, name="p.png"):
        (tmp_path / name).write_bytes(data)
        return tmp_path / name

    return write_file


def test_the_picture_is_grey_black_and_white_and_says_the_rest_in_words():
    export = export_world(drawn("###\n#SG\n###"), "png", origin=(-1.5, 0.25))
    with Image.open(io.BytesIO(export.data)) as image:
        assert (image.mode, np.asarray(image).tolist()) == (
            "L",
            [[0, 0, 0], [0, 255, 255], [0, 0, 0]],
        )
        assert image.text == {
            "worldgen": "1", "resolution": "0.1", "origin": "-1.5 0.25", "start": "-1.35 0.4 0",
            "target": "-1.25 0.4 0.005", "robot_radius": "0.07", "robot_speed": "2",
        }  # fmt: skip


@pytest.mark.parametrize(
    "pixels",
    [GREYS, GREYS.astype(np.uint16) * 257, np.dstack([GREYS] * 3)],
    ids=["8 bits", "16 bits", "colour"],
)
def test_pixels_darker_than_the_middle_are_solid(write, pixels):
    found = read_map(write(png(pixels)))
    assert found.walls.tolist() == SOLID
    assert "4 of 6 pixels are neither black nor white" in found.notes[0]


def test_the_threshold_is_the_first_grey_that_is_free(write):
    path = write(png(GREYS))
    assert read_map(path, "png+threshold=128").walls.tolist() == SOLID
    assert read_map(path, "png+threshold=127").walls[1].tolist() == [True, True, False]
    assert read_map(path, "png+threshold=255").walls[0].tolist() == [True, True, False]
    with raises(InvalidParameter, "out-of-range", name="threshold", value=256, low=1):
        read_map(path, "png+threshold=256")


def test_what_is_transparent_is_free_unless_asked_otherwise(write):
    black = np.zeros((1, 3, 4), np.uint8)
    black[0, :, 3] = (0, 100, 255)
    path = write(png(black))
    assert read_map(path).walls.tolist() == [[False, False, True]]
    assert read_map(path, "png+background=solid").walls.tolist() == [[True, True, True]]


@pytest.mark.parametrize("kind", ["pgm", "bmp"])
def test_other_kinds_of_pictures_have_the_scale_that_is_asked_for(write, kind):
    stream = io.BytesIO()
    Image.fromarray(GREYS).save(stream, {"pgm": "PPM", "bmp": "BMP"}[kind])
    path = write(stream.getvalue(), f"p.{kind}")
    assert read_map(path, options={"cell_size": 0.05}).cell_size == 0.05
    found = read_map(path)
    assert (found.cell_size, found.walls.tolist()) == (0.1, SOLID)
    assert any("the picture has no scale" in note for note in found.notes)


def test_the_picture_of_a_ros_pair_says_where_its_scale_may_be(tmp_path):
    path = write_export(export_world(drawn("###\n#SG\n###"), "ros"), tmp_path)[1]
    assert any("world.yaml next to it may be the map" in note for note in read_map(path).notes)


def test_a_folders_pictures_are_maps_only_if_they_say_so(write, tmp_path):
    assert not looks_like_a_map(write(png(GREYS)))
    ours = write_export(export_world(drawn("###\n#SG\n###"), "png"), tmp_path)[0]
    assert looks_like_a_map(ours) and find_format(ours.rename(tmp_path / "no-ending")).name == "png"


def test_words_of_other_programs_are_passed_over(write):
    assert read_map(write(png(GREYS, resolution="many", start="here"))).cell_size == 0.1


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ({"resolution": "0"}, {"code": "out-of-range", "name": "resolution"}),
        ({"resolution": "1 2"}, {"code": "wrong-form"}),
        ({"origin": "1"}, {"code": "wrong-form"}),
        ({"start": "1 2"}, {"code": "wrong-count", "key": "start", "values": 2}),
        ({"robot_radius": "-1"}, {"code": "not-positive", "key": "robot_radius"}),
        ({"target": "1 2 nan"}, {"code": "not-a-number", "word": "nan"}),
    ],
)
def test_words_of_ours_that_cannot_be_are_refused(write, text, expected):
    with raises(FormatError, **expected):
        read_map(write(png(GREYS, worldgen="1", **text)))


def test_a_picture_painted_over_keeps_its_places(tmp_path):
    world = drawn("#####\n#S.G#\n#####", radius=0.04)
    path = write_export(export_world(world, "png"), tmp_path)[0]
    with Image.open(path) as image:
        said, pixels = image.text, np.asarray(image).copy()
    pixels[1, 2] = 0
    path.write_bytes(png(pixels, **said))
    again = import_world(path)
    assert again.world.start == world.start and again.decision.result == "blocked"


def test_another_kind_of_picture_is_not_written():
    with raises(InvalidParameter, "wrong-suffix", name="w.pgm"):
        export_world(drawn("SG"), "png", file="w.pgm")
