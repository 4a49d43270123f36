"""ROS map_server pairs: published values, thresholds, pictures, and the code of each error."""

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop import read_map
from worldgen.interop.formats.ros import RosMetadata, occupancy, read_ros_map
from worldgen.interop.readers.grey_image import GreyImage, read_grey_image

KEYS = {
    "image": "m.pgm", "resolution": "0.05", "origin": "[-1.5, 2.25, 0.0]", "negate": "0",
    "occupied_thresh": "0.65", "free_thresh": "0.196",
}  # fmt: skip


def yaml_text(**changes):
    keys = {**KEYS, **changes}
    return "".join(f"{key}: {value}\n" for key, value in keys.items() if value is not None)


def pgm(pixels, maximum=255, comment=b""):
    pixels = np.asarray(pixels)
    raster = pixels.astype(np.uint8 if maximum < 256 else ">u2").tobytes()
    return b"P5\n" + comment + b"%d %d\n%d\n" % (pixels.shape[1], pixels.shape[0], maximum) + raster


def plain_pgm(pixels, maximum=255):
    words = "\n".join(" ".join(map(str, row)) for row in np.asarray(pixels).tolist())
    return f"P2\n{np.shape(pixels)[1]} {np.shape(pixels)[0]}\n{maximum}\n{words}\n".encode()


def picture(image, kind="PNG", **options):
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()


@pytest.fixture
def pair(tmp_path):
    """Write a pair and return the YAML file's path."""

    def write(pixels=None, text=None, **changes):
        if pixels is not None:
            (tmp_path / "m.pgm").write_bytes(pixels)
        path = tmp_path / "m.yaml"
        path.write_bytes(text if text is not None else yaml_text(**changes).encode())
        return path

    return write


def published(values, **changes):
    metadata = {
        "mode": "trinary",
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
        "negate": False,
        **changes,
    }
    image = GreyImage(np.array([values], np.uint8))
    return occupancy(image, RosMetadata(None, 0.05, (0.0, 0.0), **metadata))[0].tolist()


def test_trinary_thresholds_fall_between_89_and_90_and_between_205_and_206():
    assert published([0, 89, 90, 205, 206, 254, 255]) == [100, 100, -1, -1, 0, 0, 0]


def test_negate_turns_black_and_white_round():
    assert published([0, 49, 50, 165, 166, 255], negate=True) == [0, 0, -1, -1, 100, 100]


def test_a_free_threshold_of_a_quarter_frees_the_grey_of_unknown():
    assert published([191, 192, 205], free_thresh=0.25) == [-1, 0, 0]


@pytest.mark.parametrize(("grey", "threshold"), [(204, 0.2), (51, 0.8), (102, 0.6)])
def test_thresholds_are_inclusive_and_exact_decimals(grey, threshold):
    assert published([grey], free_thresh=threshold, occupied_thresh=0.9) == [0]
    assert published([grey], free_thresh=0.1, occupied_thresh=threshold) == [100]


def test_scale_stretches_what_lies_between_the_thresholds():
    assert published([0, 89, 90, 128, 205, 206, 255], mode="scale") == [100, 100, 99, 67, 0, 0, 0]


def test_raw_takes_bytes_up_to_100_as_they_are():
    assert published([0, 1, 100, 101, 255], mode="raw", negate=True) == [0, 1, 100, -1, -1]


def trinary_twin(pixels, occupied, free, negate):
    """A second implementation of map_server's rule, in floats over whole arrays."""
    filled = pixels / 255.0 if negate else (255.0 - pixels) / 255.0
    return np.select([filled >= occupied, filled <= free], [100, 0], -1)


@given(
    hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2, max_side=12)),
    st.integers(1, 99), st.integers(0, 98), st.booleans(),
)  # fmt: skip
def test_trinary_agrees_with_a_second_implementation(pixels, occupied, free, negate):
    free = min(free, occupied - 1)
    metadata = RosMetadata(None, 0.05, (0.0, 0.0), occupied / 100, free / 100, negate)
    twin = trinary_twin(pixels.astype(float), occupied / 100, free / 100, negate)
    assert np.array_equal(occupancy(GreyImage(pixels), metadata), twin)


def test_the_first_row_of_the_picture_is_the_highest_of_the_world(pair):
    found = read_ros_map(pair(pgm([[0, 254], [254, 254]])))
    assert found.walls.tolist() == [[False, False], [True, False]]


def test_resolution_and_origin_are_kept(pair):
    found = read_ros_map(pair(pgm([[254]])))
    assert (found.cell_size, found.params["origin"]) == (0.05, [-1.5, 2.25])
    assert "(-1.5, 2.25) m" in found.notes[0]


def test_unknown_cells_are_solid_unless_asked_otherwise(pair):
    path = pair(pgm([[0, 205, 254]]))
    assert read_ros_map(path).walls.tolist() == [[True, True, False]]
    assert read_ros_map(path, unknown="free").walls.tolist() == [[True, False, False]]
    with raises(InvalidParameter, "unknown-name", name="unknown", value="maybe"):
        read_map(path, "ros+unknown=maybe")


def test_raw_values_are_parted_by_the_thresholds(pair):
    path = pair(pgm([[0, 19, 20, 64, 65, 100, 101]]), mode="raw")
    assert read_ros_map(path).walls.tolist() == [[False, False, True, True, True, True, True]]
    assert read_ros_map(path, unknown="free").walls.tolist() == [
        [False, False, False, False, True, True, False]
    ]


def test_grey_205_taken_as_free_is_warned_of(pair):
    assert (
        "free_thresh is 0.25"
        in read_ros_map(pair(pgm([[205, 254]]), free_thresh="0.25")).warnings[0]
    )
    assert read_ros_map(pair(pgm([[205, 254]]))).warnings == ()
    assert read_ros_map(pair(pgm([[204, 254]]), free_thresh="0.25")).warnings == ()


def test_a_picture_with_maximum_1_is_read_right_and_warned_of(pair):
    found = read_ros_map(pair(pgm([[0, 1]], maximum=1)))
    assert found.walls.tolist() == [[True, False]]
    assert "ROS itself misreads" in found.warnings[0]


PIXELS = np.array([[0, 89, 90], [205, 206, 254]], np.uint8)
SAME_PICTURE = {
    "P5 with comments": pgm(PIXELS, comment=b"# CREATOR: map_saver\n# 0.05 m\n"),
    "P2": plain_pgm(PIXELS),
    "P2 with comments": b"P2 # grey\n3 2 # size\n255\n0 89 90 # top\n205 206 254",
    "P5, 16 bits": pgm(PIXELS.astype(int) * 257, maximum=65535),
    "P2, 16 bits": plain_pgm(PIXELS.astype(int) * 257, maximum=65535),
    "PNG": picture(Image.fromarray(PIXELS)),
    "PNG, 16 bits": picture(Image.fromarray(PIXELS.astype(np.uint16) * 257)),
    "PNG, colour": picture(Image.fromarray(PIXELS).convert("RGB")),
    "PNG, palette": picture(Image.fromarray(PIXELS).convert("P")),
    "PNG, opaque": picture(Image.fromarray(PIXELS).convert("RGBA")),
    "BMP": picture(Image.fromarray(PIXELS), "BMP"),
    "TIFF": picture(Image.fromarray(PIXELS), "TIFF"),
    "TIFF, 16 bits": picture(Image.fromarray(PIXELS.astype(np.uint16) * 257), "TIFF"),
    "JPEG": picture(Image.fromarray(PIXELS.repeat(8, 0).repeat(8, 1)), "JPEG", quality=100),
}


@pytest.mark.parametrize("name", SAME_PICTURE)
def test_the_same_greys_in_any_file_give_the_same_map(name):
    metadata = RosMetadata(None, 0.05, (0.0, 0.0), 0.65, 0.196)
    cells = occupancy(read_grey_image(SAME_PICTURE[name]), metadata)
    scale = cells.shape[0] // 2
    assert cells[::scale, ::scale].tolist() == [[100, 100, -1], [-1, 0, 0]]


@settings(max_examples=30)
@given(
    hnp.arrays(np.uint16, hnp.array_shapes(min_dims=2, max_dims=2, max_side=9)),
    st.integers(1, 65535),
)
def test_plain_and_binary_pgm_hold_the_same_pixels(pixels, maximum):
    pixels = np.minimum(pixels, maximum)
    for data in (pgm(pixels, maximum), plain_pgm(pixels, maximum)):
        image = read_grey_image(data)
        assert (image.maximum, image.values.tolist()) == (maximum, pixels.tolist())


def test_a_black_and_white_png_is_black_and_white():
    image = read_grey_image(picture(Image.fromarray(np.array([[0, 255]], np.uint8)).convert("1")))
    assert image.values.tolist() == [[0, 255]]


@pytest.mark.parametrize(
    ("mode", "expected"), [("trinary", [-1, 0]), ("scale", [-1, 0]), ("raw", [-1, -1])]
)
def test_transparent_pixels_are_unknown_except_in_raw(mode, expected):
    clear = Image.fromarray(np.array([[[255, 255, 255, 254], [255, 255, 255, 255]]], np.uint8))
    metadata = RosMetadata(None, 0.05, (0.0, 0.0), 0.65, 0.196, mode=mode)
    assert occupancy(read_grey_image(picture(clear)), metadata)[0].tolist() == expected


def bomb():
    """A PNG of a few kB that claims 9000 x 9000 pixels."""
    return picture(Image.new("1", (9000, 9000)), optimize=True)


BAD_PICTURES = [
    (b"", {"code": "unknown-format"}),
    (b"P6\n1 1\n255\n\0\0\0", {"code": "unknown-format"}),
    (picture(Image.new("L", (2, 2)), "GIF"), {"code": "unknown-format"}),
    (picture(Image.new("F", (2, 2)), "TIFF"), {"code": "unsupported"}),
    (picture(Image.new("I", (2, 2), 70_000), "TIFF"), {"code": "out-of-range", "most": 70_000}),
    (b"P5\n", {"code": "wrong-form", "name": "width", "came": "''"}),
    (b"P5\n3 x\n255\n", {"code": "wrong-form", "name": "height", "came": "'x'"}),
    (b"P5\n3 2 # no line end", {"code": "wrong-form", "name": "maximum"}),
    (b"P5\n0 2\n255\n", {"code": "wrong-size", "height": 2}),
    (b"P5\n20001 1\n255\n", {"code": "wrong-size", "width": 20001, "height": 1}),
    (
        b"P5\n999999999 999999999\n255\n",
        {"code": "wrong-size", "width": 999999999, "height": 999999999},
    ),
    (b"P5\n9999999999999 1\n255\n", {"code": "wrong-form", "name": "height"}),
    (b"P5\n3 2\n0\n", {"code": "out-of-range"}),
    (b"P5\n3 2\n65536\n", {"code": "out-of-range", "maximum": 65536}),
    (pgm(PIXELS)[:-1], {"code": "wrong-length", "bytes": 5, "needed": 6}),
    (pgm(PIXELS) + b"\x01", {"code": "wrong-length", "excess": 1}),
    (b"P5\n1 1\n255", {"code": "wrong-length"}),
    (b"P5\n1 1\n7\n\x08", {"code": "above-maximum", "pixel": 8, "maximum": 7}),
    (b"P2\n1 1\n7\n8", {"code": "above-maximum", "pixel": 8, "maximum": 7}),
    (b"P2\n2 2\n255\n1 2 3", {"code": "wrong-length", "pixels": 3, "needed": 4}),
    (b"P2\n2 1\n255\n1 -2", {"code": "not-a-pixel", "line": 4, "word": "'-2'"}),
    (b"P2\n2 1\n255\n# c\n1\n123456", {"code": "not-a-pixel", "line": 6, "word": "'123456'"}),
    (picture(Image.effect_noise((60, 60), 90))[:2000], {"code": "damaged-file"}),
    (b"\x89PNG\r\n\x1a\n" + b"\0" * 40, {"code": "unknown-format"}),
    (bomb(), {"code": "wrong-size", "width": 9000, "height": 9000}),
]


@pytest.mark.parametrize(("data", "expected"), BAD_PICTURES, ids=range(len(BAD_PICTURES)))
def test_a_bad_picture_is_refused(data, expected):
    with raises(FormatError, **expected):
        read_grey_image(data)


BAD_YAML = [
    ({"image": None, "negate": None}, None, {"code": "missing-key"}),
    ({"mode": "foo"}, 7, {"code": "unknown-name", "name": "mode", "value": "foo"}),
    ({"resolution": "0"}, 2, {"code": "out-of-range"}),
    ({"resolution": "-0.05"}, 2, {"code": "out-of-range", "resolution": -0.05}),
    ({"resolution": "1e300"}, 2, {"code": "out-of-range", "low": 1e-06}),
    ({"resolution": ".inf"}, 2, {"code": "not-a-number", "key": "resolution", "word": ".inf"}),
    ({"resolution": "1" * 9000}, 2, {"code": "not-a-number", "key": "resolution"}),
    ({"resolution": "[1]"}, 2, {"code": "wrong-type", "key": "resolution"}),
    ({"origin": "[0, 0]"}, 3, {"code": "wrong-type"}),
    ({"origin": "0"}, 3, {"code": "wrong-type"}),
    ({"origin": "[0, [0], 0]"}, 3, {"code": "wrong-type"}),
    ({"origin": "[0, 0, .inf]"}, 3, {"code": "wrong-type"}),
    ({"free_thresh": "-.inf"}, 6, {"code": "not-a-number", "key": "free_thresh"}),
    ({"negate": "2"}, 4, {"code": "not-a-number", "key": "negate", "word": "2"}),
    ({"free_thresh": "0.7"}, 6, {"code": "wrong-order"}),
    ({"occupied_thresh": "65"}, 6, {"code": "wrong-order"}),
    ({"image": '""'}, 1, {"code": "wrong-type", "key": "image"}),
    ({"image": "none.pgm"}, 1, {"code": "no-such-file", "key": "image", "name": "'none.pgm'"}),
    ({"image": "n" * 5000}, 1, {"code": "no-such-file", "key": "image"}),
    ({"image": '"a\\0b"'}, 1, {"code": "not-a-file-name", "key": "image"}),
    ({"image": "../secret.pgm"}, 1, {"code": "outside-folder", "key": "image"}),
    ({"image": "/etc/hostname"}, 1, {"code": "outside-folder", "key": "image"}),
    ({"image": "."}, 1, {"code": "no-such-file", "key": "image"}),
    ({"other": "&a [1]"}, 7, {"code": "unsupported"}),
    ({"other": "*a"}, 7, {"code": "unsupported"}),
    ({"other": "[" * 20 + "]" * 20}, 7, {"code": "nested-too-deep", "most": 8}),
    ({"other": '"\\UFFFFFFFF"'}, 7, {"code": "not-yaml"}),
    ({"other": "'open"}, 8, {"code": "not-yaml"}),
]


@pytest.mark.parametrize(("changes", "line", "expected"), BAD_YAML, ids=range(len(BAD_YAML)))
def test_a_bad_key_is_named_with_its_line(pair, changes, line, expected):
    with raises(FormatError, **expected) as caught:
        read_ros_map(pair(pgm([[254]]), **changes))
    assert caught.value.line == line


def test_lists_nested_by_the_thousand_are_refused_with_their_line(pair):
    # Newer releases of libyaml look ahead and refuse these before the depth is counted.
    with pytest.raises(FormatError) as caught:
        read_ros_map(pair(pgm([[254]]), other="[" * 5000))
    assert caught.value.code in ("nested-too-deep", "not-yaml")
    assert caught.value.line == 7


BAD_TEXT = [
    (b"", 1, {"code": "empty"}),
    (b"- 1\n- 2\n", 1, {"code": "empty"}),
    (b"image: a\n\xff\n", 2, {"code": "not-utf8"}),
    (b"image: a\nimage: b\n", 2, {"code": "twice", "name": "image"}),
    (b"image: a\n---\nimage: b\n", 2, {"code": "not-yaml"}),
    (b"image: a\nx: \x01\n", 2, {"code": "forbidden-character"}),
    (b"? [1]\n: 2\n" * 2, 3, {"code": "twice", "name": "a list or mapping"}),
    (b"#" * 70_000, None, {"code": "too-large", "most": 65536}),
]


@pytest.mark.parametrize(("text", "line", "expected"), BAD_TEXT, ids=range(len(BAD_TEXT)))
def test_text_that_is_no_map_file_is_refused(pair, text, line, expected):
    with raises(FormatError, **expected) as caught:
        read_ros_map(pair(text=text))
    assert caught.value.line == line


def test_a_link_may_not_lead_out_of_the_folder(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "m.pgm").write_bytes(pgm([[254]]))
    (inner / "m.pgm").symlink_to(tmp_path / "m.pgm")
    (inner / "m.yaml").write_text(yaml_text())
    with raises(FormatError, "outside-folder", key="image", name="'m.pgm'"):
        read_ros_map(inner / "m.yaml")


@pytest.mark.parametrize("name", ["./m.pgm", "sub/m.pgm", "{folder}/m.pgm", "sub/../m.pgm"])
def test_any_path_within_the_folder_is_followed(pair, tmp_path, name):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "m.pgm").write_bytes(pgm([[254]]))
    (tmp_path / "m.pgm").write_bytes(pgm([[254]]))
    assert read_ros_map(pair(image=name.format(folder=tmp_path))).walls.shape == (1, 1)


def test_quirks_of_files_in_the_wild_are_read(pair):
    odd = {
        "origin": "[-78.21853769831466, -44.37590462453829, 0.000000]",
        "occupied_thresh": "0.45",
        "cell_size": "1",
    }
    found = read_ros_map(pair(pgm([[0, 254]]), negate="false", mode="Trinary", **odd))
    assert found.params["origin"] == [-78.21853769831466, -44.37590462453829]


@given(st.binary(max_size=120))
def test_any_bytes_give_a_map_or_a_fault(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("ros")
    (folder / "m.pgm").write_bytes(pgm([[254]]))
    (folder / "m.yaml").write_bytes(yaml_text().encode() + data)
    try:
        assert read_map(folder / "m.yaml", "ros").walls.shape == (1, 1)
    except FormatError as error:
        assert "m.yaml" in str(error)
