"""Unusual files found in practice.

Each gives the right world, or an error message that explains what to do.
"""

import cmath
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from tests.helpers.foreign_samples import picture
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import read_map
from worldgen.support.rows import flip_rows

PIXELS = np.array([[0, 254, 205], [254, 254, 0]], np.uint8)
SOLID = PIXELS < 206  # what is unknown is solid
OCTILE = b"type octile\nheight 2\nwidth 3\nmap\n@.T\n..@\n"
YAML = (
    "image: p.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: "
    "0.65\nfree_thresh: 0.196\n"
)
PGM = b"P5\n3 2\n255\n" + PIXELS.tobytes()
BOM = b"\xef\xbb\xbf"


@pytest.fixture
def ros(tmp_path):
    """Read a pair in which one or both files are unusual."""

    def read(text=YAML, pixels=PGM):
        (tmp_path / "p.pgm").write_bytes(pixels)
        (tmp_path / "m.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_map(tmp_path / "m.yaml")

    return read


@pytest.mark.parametrize(
    "data",
    [
        BOM + OCTILE,
        OCTILE.replace(b"\n", b"\r"),
        OCTILE.replace(b"\n", b"\r\n", 3),
        OCTILE.replace(b" ", b"\t  ").replace(b"height\t", b"height   \t"),
        OCTILE.replace(b"T\n", b"T \t\n"),
        OCTILE.rstrip() + b"\n \n\n",
        OCTILE + b"\x1a",
        b"Type Octile\nHEIGHT 2\nWidth 3\nMAP\n@.T\n..@\n",
        b"type octile\nwidth 3\nheight 2\nmap\n@.T\n..@\n",
    ],
    ids=[
        "bom",
        "cr",
        "some-crlf",
        "tabs",
        "blanks-behind-rows",
        "blank-lines",
        "dos-end",
        "capitals",
        "width-first",
    ],
)
def test_an_odd_octile_map_is_the_same_map(data, tmp_path):
    (tmp_path / "m.map").write_bytes(data)
    assert np.array_equal(flip_rows(read_map(tmp_path / "m.map").walls), SOLID)


@pytest.mark.parametrize("end", ["bom", "crlf", "cr", "dos-end", "no-end"])
@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("m.txt", b"####\n#S.#\n####\n"),
        ("m.pogema", b"####\n#aA#\n####\n"),
        ("m.minigrid", b"WGWGWGWG\nWG>>GGWG\nWGWGWGWG\n"),
        ("m.maze", b"o---o---o\n| S   G |\no---o---o\n"),
    ],
    ids=["text", "pogema", "minigrid", "micromouse"],
)
def test_a_drawing_from_another_system_is_the_same_drawing(tmp_path, name, data, end):
    odd = {
        "bom": BOM + data, "crlf": data.replace(b"\n", b"\r\n"), "cr": data.replace(b"\n", b"\r"),
        "dos-end": data + b"\x1a", "no-end": data.rstrip(),
    }  # fmt: skip
    (tmp_path / name).write_bytes(data)
    as_usual = read_map(tmp_path / name)
    (tmp_path / name).write_bytes(odd[end])
    found = read_map(tmp_path / name)
    assert np.array_equal(found.walls, as_usual.walls)
    assert (found.robot.start, found.robot.target) == (as_usual.robot.start, as_usual.robot.target)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (
            OCTILE.replace(b"2", b"x").replace(b"3", b"2").replace(b"x", b"3"),
            {"code": "ragged-rows"},
        ),
        (
            OCTILE.replace(b"height 2", b"height -2"),
            {"code": "not-a-number", "key": "height", "word": "-2"},
        ),
        (OCTILE.decode().encode("utf-16"), {"code": "not-utf8"}),
        (OCTILE.replace(b"octile", b"octile-corner"), {"code": "unsupported"}),
        (b"\n" * 5_000_000, {"code": "wrong-form"}),
        (OCTILE.replace(b"width 3", b"width 999999999"), {"code": "wrong-size", "max_side": 20000}),
    ],
    ids=["swapped", "negative", "utf-16", "corners", "white-space", "huge"],
)
def test_a_wrong_octile_map_is_told_what_to_do(data, expected, tmp_path):
    (tmp_path / "m.map").write_bytes(data)
    with raises(FormatError, **expected):
        read_map(tmp_path / "m.map")


@pytest.mark.parametrize(
    "text",
    [
        YAML.replace("\n", "\r\n"),
        YAML.replace("\n", "\r"),
        BOM + YAML.encode(),
        f"%YAML 1.1\n---\n{YAML}...\n",
        YAML.replace("[0.0, 0.0, 0.0]", "\n- 0.0\n- 0.0\n- 0.0"),
        YAML.replace("p.pgm", "'./p.pgm'  # saved by hand"),
        YAML.replace("negate: 0", "negate: False") + "mode: Trinary\ncell_size: 3\nfoo: {a: [1]}\n",
    ],
    ids=["crlf", "cr", "bom", "directive", "list-in-lines", "comment", "more-keys"],
)
def test_an_odd_yaml_file_is_the_same_map(text, ros):
    assert np.array_equal(flip_rows(ros(text).walls), SOLID)


@pytest.mark.parametrize(
    "pixels",
    [
        b"P2\r\n3 2\r\n255\r\n0 254 205\r\n254 254 0\r\n",
        b"P2 3 2 255 0 254 205 254 254\t0",
        b"P5#by hand\n3 # wide\n2\n#\n255\n" + PIXELS.tobytes(),
        PGM + b"\n",
        b"P5\n3 2\n65535\n" + (PIXELS.astype(">u2") * 257).tobytes(),
    ],
    ids=["plain-crlf", "one-line", "comments", "one-byte-more", "16-bit"],
)
def test_an_odd_pgm_is_the_same_map(pixels, ros):
    assert np.array_equal(flip_rows(ros(pixels=pixels).walls), SOLID)


def interlaced(pixels):
    """Return a PNG in Adam7's seven passes, which Pillow can read but not write."""
    passes = [
        (0, 0, 8, 8),
        (4, 0, 8, 8),
        (0, 4, 4, 8),
        (2, 0, 4, 4),
        (0, 2, 2, 4),
        (1, 0, 2, 2),
        (0, 1, 1, 2),
    ]
    parts = [pixels[y::down, x::right] for x, y, right, down in passes]
    raster = b"".join(b"\0" + row.tobytes() for part in parts if part.size for row in part)
    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 0, 0, 0, 1)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(raster)), (b"IEND", b"")]
    framed = [
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(framed)


GREY = Image.fromarray(PIXELS)
PICTURES = {
    **{mode: picture(GREY.convert(mode)) for mode in ("P", "RGB", "RGBA", "LA")},
    "16-bit": picture(Image.fromarray(PIXELS.astype(np.uint16) * 257)),
    "interlaced": interlaced(PIXELS),
    "bmp": picture(GREY, "BMP"),
    "palette-bmp": picture(GREY.convert("P"), "BMP"),
}


@pytest.mark.parametrize("kind", PICTURES)
def test_a_picture_of_any_kind_is_the_same_map(kind, ros):
    assert np.array_equal(flip_rows(ros(pixels=PICTURES[kind]).walls), SOLID)


def test_grey_between_the_thresholds_of_an_anti_aliased_picture_is_said_and_solid(ros):
    found = ros(pixels=b"P5\n3 2\n255\n" + bytes([254, 120, 0, 254, 199, 1]))
    assert found.walls.sum() == 4 and any(
        "2 of 6 cells are neither occupied nor free" in note for note in found.notes
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (YAML.replace("negate: 0\n", ""), {"code": "missing-key"}),
        (
            YAML.replace("0.05", "0,05"),
            {"code": "not-a-number", "key": "resolution", "word": "0,05"},
        ),
        (YAML.replace("0.65", "65"), {"code": "wrong-order"}),
        (YAML.replace("p.pgm", "/home/me/maps/q.pgm"), {"code": "outside-folder", "key": "image"}),
        (
            YAML.replace("p.pgm", "'C:\\maps\\q.pgm'"),
            {"code": "no-such-file", "key": "image", "name": "'C:\\\\maps\\\\q.pgm'"},
        ),
        (YAML.replace("negate", "\tnegate"), {"code": "not-yaml"}),
        (YAML.encode("utf-16"), {"code": "not-utf8"}),
    ],
    ids=["missing", "comma", "percent", "absolute", "windows", "tab", "utf-16"],
)
def test_a_wrong_yaml_file_is_told_what_to_do(text, expected, ros):
    with raises(FormatError, **expected):
        ros(text)


def test_a_picture_that_moves_is_refused(ros):
    with raises(FormatError, "unknown-format"):
        ros(pixels=picture(GREY, "GIF"))


@pytest.mark.parametrize(
    ("yaw", "corner"),
    [
        ("1.57079632679", (-0.1, 0.0)),
        ("1.57", (-0.1, 0.0)),
        ("-4.712389", (-0.1, 0.0)),
        ("3.14159", (-0.15, -0.1)),
        ("-1.5708", (0.0, -0.15)),
        ("1e-10", (0.0, 0.0)),
    ],
)
def test_a_map_turned_by_quarters_lies_where_its_yaw_says(yaw, corner, ros):
    """Each cell's centre, rotated by the yaw, is solid if the cell is."""
    found = ros(
        YAML.replace("0.0]", f"{yaw}]"), b"P5\n3 2\n255\n" + bytes([0, 254, 254, 254, 254, 254])
    )
    assert found.origin == pytest.approx(corner, abs=1e-12)
    turn = cmath.exp(1j * float(yaw))
    solid = complex(0.025, 0.075) * turn - complex(*found.origin)  # the picture's upper-left pixel
    expected = np.zeros_like(found.walls)
    expected[int(solid.imag / 0.05), int(solid.real / 0.05)] = True
    assert np.array_equal(found.walls, expected)


def test_a_yaw_too_coarse_for_the_pictures_size_is_no_quarter_turn(ros):
    pixels = b"P5\n400 400\n255\n" + b"\xfe" * 160_000
    assert ros(YAML.replace("0.0]", "1.57]"), pixels).walls.shape == (400, 400)
    assert ros(YAML.replace("0.0]", "3.14]"), pixels).is_resampled
