"""Where ``import`` places start and target on pictures, and what a refusal says."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tests.helpers.command_line import worldgen
from tests.helpers.foreign_samples import picture
from tests.helpers.raising import raises
from worldgen.errors import InvalidWorld, WorldgenError
from worldgen.interop import ImportedRobot, import_world
from worldgen.interop.readers.grey_image import pgm_bytes
from worldgen.robot_overrides import RobotOverrides

SIDE = 90
CELL = 0.1
# The radii, cells, of a race track's walls around the picture's centre.
INNER, OUTER = 20, 32
RING = (INNER + OUTER) / 2


def track(*, framed=False):
    """A race track: two circles of black pixels on white; a frame of black pixels around it."""
    y, x = np.indices((SIDE, SIDE)) - (SIDE - 1) / 2
    away = np.hypot(x, y)
    walls = (np.abs(away - INNER) < 1) | (np.abs(away - OUTER) < 1)
    if framed:
        walls[[0, -1]] = walls[:, [0, -1]] = True
    return np.where(walls, 0, 255).astype(np.uint8)


def ros_map(folder, greys, origin=(0.0, 0.0), **keys):
    """A ROS map of a picture."""
    keys = {"occupied_thresh": 0.65, "free_thresh": 0.196, "negate": 0, "resolution": CELL} | keys
    data = picture(greys) if isinstance(greys, Image.Image) else pgm_bytes(greys)
    (folder / "m.pgm").write_bytes(data)
    lines = [f"{key}: {value}" for key, value in keys.items()]
    path = folder / "m.yaml"
    path.write_text("\n".join(["image: m.pgm", f"origin: [{origin[0]}, {origin[1]}, 0]", *lines]))
    return path


def away(world):
    """Distances of start and target from the centre, cells."""
    return [
        np.hypot(place.x / CELL - SIDE / 2, place.y / CELL - SIDE / 2)
        for place in (world.start, world.target)
    ]


def is_on_track(imported):
    return all(INNER < distance < OUTER for distance in away(imported.world))


@pytest.mark.parametrize("framed", [False, True])
def test_start_and_target_are_in_the_region_of_the_maps_origin(framed, tmp_path):
    # The origin of the coordinates is on the track, right of the centre.
    corner = (-CELL * (SIDE / 2 + RING), -CELL * SIDE / 2)
    imported = import_world(ros_map(tmp_path, track(framed=framed), corner))
    assert is_on_track(imported)
    assert "longest path in the region with the map's origin" in imported.placement
    assert not any("border" in sentence for sentence in imported.warnings)


@pytest.mark.parametrize("suffix", [".yaml", ".pgm"])
def test_without_an_origin_a_region_that_reaches_the_border_is_avoided(suffix, tmp_path):
    path = ros_map(tmp_path, track()).with_suffix(suffix)
    imported = import_world(path, ImportedRobot(radius=0.22))
    assert all(distance < OUTER for distance in away(imported.world))
    assert "does not reach the picture's border" in imported.placement


def test_a_region_that_reaches_the_border_is_warned_about(tmp_path):
    open_room = np.full((30, 40), 255, np.uint8)
    open_room[10:12, 5:30] = 0
    imported = import_world(ros_map(tmp_path, open_room))
    assert any("reaches the picture's border" in sentence for sentence in imported.warnings)


def test_a_frame_around_the_picture_does_not_hide_the_surroundings(tmp_path):
    imported = import_world(ros_map(tmp_path, track(framed=True)))
    assert is_on_track(imported) or any(
        "picture's border, along its frame" in one for one in imported.warnings
    )


def test_a_robot_that_does_not_fit_at_the_maps_origin_is_warned_about(tmp_path):
    corner = (-CELL * (SIDE / 2 + RING), -CELL * SIDE / 2)
    narrow = track()
    y, x = np.indices((SIDE, SIDE))
    # Bars across the track leave a pocket at the origin.
    narrow[(np.abs(y - SIDE // 2) == 6) & (x > SIDE // 2)] = 0
    imported = import_world(ros_map(tmp_path, narrow, corner), ImportedRobot(radius=0.5))
    assert any("the map's origin" in sentence for sentence in imported.warnings)


@pytest.mark.parametrize("kind", ["room", "room without a frame of its own"])
def test_a_plain_room_is_neither_warned_about_nor_explained(kind, tmp_path):
    room = np.full((30, 40), 255, np.uint8)
    thick = 1 if kind == "room" else 4
    room[:thick] = room[-thick:] = room[:, :thick] = room[:, -thick:] = 0
    imported = import_world(ros_map(tmp_path, room))
    assert imported.warnings == () and "in the largest region" in imported.placement


@pytest.mark.parametrize(
    ("grey", "keys", "expected"),
    [
        (206, {}, "grey 206 covers 80 % of the map and counts as free"),
        (205, {}, None),
        (205, {"free_thresh": 0.25}, "grey 205"),
        (90, {}, "grey 90 covers 80 % of the map and counts as unknown"),
        (254, {}, None),
        (204, {"negate": 1, "occupied_thresh": 0.8}, "grey 204 covers 80 % of the map and counts as occupied"),
    ],
)  # fmt: skip
def test_one_grey_near_a_threshold_that_covers_most_of_the_map_is_warned_about(
    grey, keys, expected, tmp_path
):
    greys = np.full((50, 50), grey, np.uint8)
    greys[20:30, :] = 0 if keys.get("negate") else 255
    greys[0] = greys[-1] = greys[:, 0] = greys[:, -1] = 255 if keys.get("negate") else 0
    greys[20:40, 1:20] = 0 if keys.get("negate") else 255
    share = (greys == grey).mean()
    warnings = import_world(ros_map(tmp_path, greys, **keys), ImportedRobot(radius=0.05)).warnings
    found = [sentence for sentence in warnings if f"grey {grey}" in sentence]
    wanted = None if expected is None else expected.replace("80 %", f"{100 * share:.0f} %")
    assert share > 0.5 and (found[0].startswith(wanted) if wanted else not found)


def transparent(folder):
    """A room whose floor is transparent, as some editors save it."""
    pixels = np.zeros((30, 40, 4), np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = pixels[8:22, 20] = 255
    image = Image.fromarray(pixels)
    return ros_map(folder, image, negate=1, occupied_thresh=0.8, free_thresh=0.2)


def test_a_refusal_keeps_the_notes_that_explain_it(tmp_path):
    done = worldgen("import", transparent(tmp_path), "--out", tmp_path / "w.grid")
    assert (done.code, done.error_code) == (2, "no-room")
    assert "1,050 of 1,200 cells are transparent, hence unknown" in done.err
    assert "neither occupied nor free" not in done.err  # the same cells
    # The largest disc of the room: between the wall in its middle and one at its side.
    expected = "--from ros+unknown=free) a radius of up to 0.95 m fits, at 1.05,1.05"
    assert expected in done.err
    assert not (tmp_path / "w.grid").exists()


def test_a_body_without_room_is_refused_in_its_own_words(tmp_path):
    done = worldgen(
        "import", transparent(tmp_path), "--from", "ros+unknown=free", "--footprint", "3x2.5",
        "--out", tmp_path / "w.grid",
    )  # fmt: skip
    assert (done.code, done.error_code) == (2, "no-room")
    assert "the body of 3 x 2.5 m does not fit anywhere in the map" in done.err
    assert "use a smaller footprint; a disc of up to 0.95 m fits, at 1.05,1.05" in done.err


def test_an_error_of_the_library_has_the_notes_too(tmp_path):
    with raises(InvalidWorld, "no-room") as caught:
        import_world(transparent(tmp_path))
    assert any("1,050 of 1,200 cells are transparent" in note for note in caught.value.notes)


def test_transparent_pixels_of_a_picture_are_counted(tmp_path):
    transparent(tmp_path)
    (tmp_path / "m.pgm").rename(tmp_path / "m.png")
    done = worldgen("import", tmp_path / "m.png", "--out", tmp_path / "w.grid", "--json")
    notes = json.loads(done.out)["notes"] if done.code == 0 else done.err.splitlines()
    assert any("1,050 of 1,200 pixels are transparent" in sentence for sentence in notes)


def room(folder):
    """A room of 4 x 3 m with a wall across it that leaves a gap of 0.6 m at the top."""
    greys = np.full((30, 40), 254, np.uint8)
    greys[[0, -1]] = greys[:, [0, -1]] = 0
    greys[7:, 20:22] = 0
    return ros_map(folder, greys, (-1.0, -1.0))


@pytest.mark.parametrize(
    ("given", "at", "expected"),
    [
        ({"near": (3.0, 0.5)}, {"start": (3.0, 0.5)}, "start at the nearest place"),
        ({"near": (0.0, 0.0)}, {"start": (0.3, 0.3)}, "0.424 m away"),
        ({"near": (0.0, 0.0), "clearance": 0.5}, {"start": (0.6, 0.6)}, "0.849 m away"),
        ({"near": (3.0, 0.5), "start": (0.5, 0.5)}, {"target": (3.0, 0.5)}, "start as given; target at"),
        ({"near": (3.0, 0.5), "target": (0.5, 0.5)}, {"start": (3.0, 0.5)}, "target as given; start at"),
        ({"start": (0.5, 0.5), "target": (3.0, 0.5)}, {}, "start and target as given"),
        ({"start": (0.5, 0.5), "clearance": 0.7}, {}, "and 0.7 m from the nearest walls"),
        ({"near": (2.0, -0.5), "in_file_frame": True}, {"start": (3.0, 0.5)}, "0 m away"),
    ],
)  # fmt: skip
def test_a_sentence_says_where_start_and_target_went_and_why(given, at, expected, tmp_path):
    imported = import_world(room(tmp_path), ImportedRobot(radius=0.2, **given))
    assert expected in imported.placement
    for name, place in at.items():
        found = getattr(imported.world, name)
        assert (found.x, found.y) == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize(
    ("given", "code", "facts"),
    [
        ({"radius": 2.0}, "no-room", {"fits": 0.95, "clear": (1.05, 1.05)}),
        ({"clearance": 3.0}, "no-room", {"fits": 0.95}),
        ({"clearance": 3.0, "near": (3.0, 0.5), "radius": 0.3}, "no-room", {"fits": 0.95}),
        ({"start": (1.0, 1.0), "radius": 2.0}, "not-clear", {"fits": 0.95}),
        ({"near": (9.0, 9.0)}, "outside-grid", {"name": "near"}),
        ({"start": (1.0, 1.0), "target": (3.0, 1.0), "near": (2.0, 2.0)}, "conflict", {}),
    ],
)  # fmt: skip
def test_a_placement_that_fails_says_what_would_work(given, code, facts, tmp_path):
    with raises(WorldgenError, code, **facts):
        import_world(room(tmp_path), ImportedRobot(**{"radius": 0.2, **given}))


@pytest.mark.parametrize(("target", "warned"), [((1.15, 1.0), True), ((1.25, 1.0), False)])
def test_a_start_in_the_target_is_warned_of(target, warned, tmp_path):
    path = ros_map(tmp_path, np.full((SIDE, SIDE), 255, np.uint8))
    robot = ImportedRobot(radius=0.2, start=(1.0, 1.0), target=target)
    warnings = import_world(path, robot).warnings
    assert any("there is no way to go" in one for one in warnings) == warned


def three_rooms(folder):
    """Three rooms of 1.2 m without doors, as a map."""
    free = np.full((14, 41), 255, np.uint8)
    free[[0, -1]] = free[:, [0, 13, 27, 40]] = 0
    return ros_map(folder, free)


@pytest.mark.parametrize(
    ("footprint", "warned", "refused"),
    [
        (
            None,
            "for a disc of radius 0.15 m there are 3 separate regions; ",
            "; the robot's radius is 0.15 m",
        ),
        (
            "0.4x0.3",
            "for a disc of radius 0.25 m (around the body of 0.4 x 0.3 m) there are 3 separate regions; ",
            "; the disc in the body of 0.4 x 0.3 m has a radius of 0.15 m",
        ),
    ],
)
def test_a_disc_that_stands_for_a_footprint_is_told_as_one(footprint, warned, refused, tmp_path):
    path = three_rooms(tmp_path)
    robot = (
        ImportedRobot(radius=0.15)
        if footprint is None
        else ImportedRobot(overrides=RobotOverrides(footprint=footprint))
    )
    [warning] = import_world(path, robot=robot).warnings
    smaller = "radius" if footprint is None else "footprint"
    assert warning.startswith(warned) and warning.endswith(f"; a smaller {smaller} may join them")
    with raises(InvalidWorld, "not-clear") as caught:
        import_world(path, robot=replace(robot, start=(0.2, 0.6)))
    assert refused in str(caught.value)
    with raises(InvalidWorld, "no-room") as caught:
        import_world(path, robot=replace(robot, target=(0.0, 0.6)))
    assert f"choose both start and target, or a smaller {smaller}" in str(caught.value)
