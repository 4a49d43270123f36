"""ROS maps with a yaw, with numbers that are none, with a picture elsewhere, and with more walls."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image
from shapely import affinity
from shapely.geometry import box
from shapely.ops import unary_union

from tests.helpers.command_line import worldgen
from tests.helpers.foreign_samples import picture
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import ImportedRobot, export_world, import_world, read_map
from worldgen.interop.formats.ros import read_ros_map
from worldgen.interop.geometry.turned_pixels import PixelFrame, cells_reached
from worldgen.interop.readers.grey_image import pgm_bytes

# A room of 3 x 2 m with a wall across it that leaves a gap at the top.
ROOM = np.full((20, 30), 254, np.uint8)
ROOM[[0, -1]] = ROOM[:, [0, -1]] = 0
ROOM[8:, 14:16] = 0


def ros_map(folder, greys=ROOM, name="m", **changes):
    keys = {
        "image": f"{name}.pgm", "resolution": 0.1, "origin": "[-3.0, 2.5, 0.0]", "negate": 0,
        "occupied_thresh": 0.65, "free_thresh": 0.196,
    } | changes  # fmt: skip
    (folder / f"{name}.pgm").write_bytes(pgm_bytes(greys))
    path = folder / f"{name}.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items()))
    return path


def placed(shape, frame):
    """A shape of the picture, in pixels, where the frame puts it, in cells."""
    scaled = affinity.scale(shape, float(frame.side), float(frame.side), origin=(0, 0))
    angle = frame.quarters * math.pi / 2 + frame.rest
    turned = affinity.rotate(scaled, angle, origin=(0, 0), use_radians=True)
    return affinity.translate(turned, float(frame.x), float(frame.y))


@settings(max_examples=25)
@given(
    hnp.arrays(bool, hnp.array_shapes(min_dims=2, max_dims=2, max_side=5)),
    st.builds(
        PixelFrame,
        st.fractions(-3, 5, max_denominator=10),
        st.fractions(-3, 5, max_denominator=10),
        st.sampled_from([Fraction(1), Fraction(2, 5), Fraction(7, 3)]),
        st.integers(-1, 4),
        st.sampled_from([0.0, 0.3, -0.7, 0.01]),
    ),
    st.booleans(),
)
def test_a_cell_is_solid_if_it_shares_an_area_with_the_turned_picture(solid, frame, outside):
    height, width = solid.shape
    squares = [placed(box(i, j, i + 1, j + 1), frame) for j, i in np.argwhere(solid)]
    walls = unary_union(squares)
    if outside:
        everything = box(-99, -99, 99, 99)
        walls = walls.union(everything.difference(placed(box(0, 0, width, height), frame)))
    found = cells_reached(solid, frame, (6, 6), outside=outside)
    for j, i in np.ndindex(found.shape):
        shared = box(i, j, i + 1, j + 1).intersection(walls).area
        # Between these, shapely and the rounding of a picture's origin may differ.
        if shared > 1e-5 or shared < 1e-12:
            assert found[j, i] == (shared > 1e-5)


def test_what_is_free_in_the_cells_of_a_turned_map_is_free_in_the_map(tmp_path):
    found = read_ros_map(ros_map(tmp_path, origin="[-3.0, 2.5, 0.4]"))
    # Take the corners of all free cells back into the picture.
    rows, columns = np.nonzero(~found.walls)
    assert len(rows) > 100
    free = np.flipud(ROOM) == 254
    for di, dj in ((0.01, 0.01), (0.99, 0.01), (0.01, 0.99), (0.99, 0.99)):
        x = found.origin[0] + (columns + di) * 0.1 + 3.0
        y = found.origin[1] + (rows + dj) * 0.1 - 2.5
        i = np.floor((math.cos(0.4) * x + math.sin(0.4) * y) / 0.1).astype(int)
        j = np.floor((math.cos(0.4) * y - math.sin(0.4) * x) / 0.1).astype(int)
        assert free[j, i].all()


@pytest.mark.parametrize(
    ("yaw", "shape"),
    [
        ("1.57", (30, 20)), ("1.5707", (30, 20)), ("-1.5708", (30, 20)), ("3.14159", (20, 30)),
        ("1e-17", (20, 30)), ("6.28", (20, 30)), ("1.56", None), ("1.6", None), ("0.01", None),
        ("2", None),
    ],
)  # fmt: skip
def test_only_a_rounded_quarter_turn_counts_as_one(yaw, shape, tmp_path):
    found = read_ros_map(ros_map(tmp_path, origin=f"[0, 0, {yaw}]"))
    assert found.is_resampled == (shape is None)
    if shape is not None:
        assert found.walls.shape == shape and found.walls.sum() == (ROOM == 0).sum()


def test_a_turned_map_says_for_what_its_answer_holds(tmp_path):
    path = ros_map(tmp_path, origin="[-3.0, 2.5, 0.4]")
    reachable = import_world(path, ImportedRobot(radius=0.1))
    assert reachable.decision.reason.split(". ")[1].startswith("This holds for the file too")
    # A wall from side to side of the picture.
    shut = ROOM.copy()
    shut[:, 14:16] = 0
    places = {"start": (-2.43, 3.66), "target": (-1.3, 4.3), "in_file_frame": True}
    blocked = import_world(
        ros_map(tmp_path, shut, origin="[-3.0, 2.5, 0.4]"), ImportedRobot(radius=0.1, **places)
    )
    assert blocked.decision.result == "blocked"
    assert "not for the file" in blocked.decision.reason
    assert "--frame picture" in blocked.decision.reason


def test_the_pictures_own_frame_leaves_its_cells_and_turns_the_places_of_the_file(tmp_path):
    plain = import_world(
        ros_map(tmp_path, worldgen="{start: [-2.5, 3.0, 0.5], target: [-0.5, 3.0, 0.2]}")
    )
    # The same two places, turned about the corner with the picture.
    c, s = math.cos(0.4), math.sin(0.4)
    places = [(-3 + c * dx - s * dy, 2.5 + s * dx + c * dy) for dx, dy in ((0.5, 0.5), (2.5, 0.5))]
    keys = "{{start: [{}, {}, 0.9], target: [{}, {}, 0.2]}}".format(*places[0], *places[1])
    path = ros_map(tmp_path, origin="[-3.0, 2.5, 0.4]", worldgen=keys)
    turned = import_world(path, options={"frame": "picture"})
    assert np.array_equal(turned.world.walls, plain.world.walls)
    for name in ("start", "target"):
        one, other = getattr(turned.world, name), getattr(plain.world, name)
        assert (one.x, one.y) == pytest.approx((other.x, other.y), abs=1e-3)
    assert turned.world.start.heading == pytest.approx(0.5, abs=1e-3)
    assert turned.world.provenance.params["picture"] == [-3.0, 2.5, 0.4]
    # In the map's frame the same places are found by the grid's corner alone.
    mapped = import_world(path, ImportedRobot(radius=0.1)).world
    corner = mapped.provenance.origin
    assert (mapped.start.x + corner[0], mapped.start.y + corner[1]) == pytest.approx(
        places[0], abs=1e-3
    )


def test_the_pictures_own_cells_are_exported_to_where_they_were(tmp_path):
    options = {"frame": "picture"}
    path = ros_map(tmp_path, origin="[-3.0, 2.5, 0.4]")
    world = import_world(path, ImportedRobot(start=(0.5, 0.5, 0.3)), options=options).world
    export = export_world(world, "ros", file="back.yaml")
    for name, data in export.files.items():
        (tmp_path / name).write_bytes(data)
    assert b"origin: [-3, 2.5, 0.4]" in export.data
    again = import_world(tmp_path / "back.yaml", options=options).world
    assert np.array_equal(again.walls, world.walls)
    for place in ("start", "target"):
        one, other = getattr(again, place), getattr(world, place)
        assert (one.x, one.y) == pytest.approx((other.x, other.y), abs=1e-9)
    assert again.start.heading == pytest.approx(0.3, abs=1e-9)


def test_a_frame_of_the_picture_is_refused_where_there_is_none(tmp_path):
    (tmp_path / "m.txt").write_text("....\n....\n")
    done = worldgen(
        "import", tmp_path / "m.txt", "--frame", "picture", "--out", tmp_path / "w.grid"
    )
    assert done.code == 2 and "--frame picture is for ROS maps" in done.err


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"origin": "[-3.0, 2.5, -nan]"}, "the origin's yaw: not a number, counted as 0"),
        ({"origin": "[.nan, NaN, 0]"}, "the origin's x and y: not a number, counted as 0"),
        ({"free_thresh": "nan"}, "free_thresh is not a number; it counts as 0.196"),
        ({"occupied_thresh": "-nan(ind)"}, "occupied_thresh is not a number; it counts as 0.65"),
        ({"origin": "[0, 0, 90]"}, "if these are degrees, write 1.57079633"),
    ],
)  # fmt: skip
def test_numbers_that_are_none_are_counted_as_the_usual_ones_and_told(changes, expected, tmp_path):
    found = read_ros_map(ros_map(tmp_path, **changes))
    assert any(expected in sentence for sentence in found.warnings)
    if "90" not in changes.get("origin", ""):
        assert np.array_equal(found.walls, np.flipud(ROOM == 0))


@pytest.mark.parametrize(
    "name", ["/home/somebody/maps/m.pgm", "../maps/m.pgm", "C:\\maps\\m.pgm", "maps/M.PGM"]
)
def test_a_picture_next_to_the_file_is_found_and_told(name, tmp_path):
    found = read_ros_map(ros_map(tmp_path, image=f"'{name}'"))
    assert found.walls.shape == ROOM.shape
    assert any("m.pgm next to m.yaml was read" in sentence for sentence in found.notes)


def test_a_missing_picture_is_told_with_the_one_of_another_suffix(tmp_path):
    path = ros_map(tmp_path, image="m.png")
    with raises(FormatError, "no-such-file") as caught:
        read_ros_map(path)
    assert caught.value.message.remedy.endswith("or write `image: m.pgm` for the one that is there")


@pytest.mark.parametrize(("orientation", "unread"), [(1, False), (6, True)])
def test_a_tag_that_turns_the_picture_is_unread(orientation, unread, tmp_path):
    image = Image.fromarray(ROOM)
    exif = image.getexif()
    exif[274] = orientation
    path = ros_map(tmp_path, image="m.jpg")
    (tmp_path / "m.jpg").write_bytes(picture(image, "JPEG", exif=exif, quality=100))
    assert ("1 orientation of the picture" in read_map(path).unread) == unread


@pytest.mark.parametrize(
    ("changes", "shape", "closed"),
    [
        ({}, (20, 30), 20),  # the same pixels
        ({"resolution": 0.2, "origin": "[-3.0, 2.5, 0]"}, (10, 15), 40),  # pixels of two cells
        ({"origin": "[-2.95, 2.5, 0]"}, (20, 30), 40),  # half a cell aside
        ({"origin": "[-4.0, 2.5, 0]"}, (20, 30), 20),  # ten cells to the left
    ],
)  # fmt: skip
def test_another_maps_occupied_cells_become_walls(changes, shape, closed, tmp_path):
    mask = np.full(shape, 205, np.uint8)
    mask[:, shape[1] // 2 - 2] = 0
    ros_map(tmp_path, mask, "keepout", **changes)
    open_floor = ros_map(tmp_path, np.full((20, 30), 254, np.uint8))
    found = read_ros_map(open_floor, walls="keepout.yaml")
    assert found.walls.sum() == closed
    assert f"keepout.yaml closes {closed} more cells" in found.notes
    assert found.is_resampled == (changes.get("origin", "").startswith("[-2.95"))


def test_what_another_map_has_unread_leaves_the_world_without_a_proof(tmp_path):
    ros_map(tmp_path, name="keepout", layer="upstairs")
    path = ros_map(tmp_path)
    done = worldgen(
        "import", path, "--from", "ros+walls=keepout.yaml", "--out", tmp_path / "w.grid"
    )
    assert done.code == 2
    assert "not read, and not in this world: 1 key layer" in done.err
