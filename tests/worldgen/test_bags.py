"""ROS bags: a world and a trajectory from one file, and damaged ones."""

import math
import os
import struct
import sys

import numpy as np
import pytest

from sim.audit import audit
from sim.audit.frames import MapFrame
from tests.helpers.bags import (
    GRID,
    KINDS,
    ODOMETRY,
    POLYGON,
    POSE,
    UPDATE,
    WHY_NOT,
    drive,
    grid,
    pose,
    room,
    stamped,
    write_bag,
)
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import FormatError, InvalidParameter, read_world
from worldgen.interop import import_world
from worldgen.logs import bag
from worldgen.logs.bag import is_bag, read_bag
from worldgen.logs.reading import read_log

needs_rosbags = pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT)
COSTMAP = "/global_costmap/costmap"


def without(messages, *topics):
    return [message for message in messages if message[0] not in topics]


def test_a_bag_without_the_extra_says_how_to_install_it(tmp_path, monkeypatch):
    (tmp_path / "run.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(50))
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with raises(FormatError, "not-installed") as raised:
        read_log(tmp_path / "run.mcap")
    assert "pip install" in str(raised.value) and "bags" in str(raised.value)


@pytest.mark.gate
@needs_rosbags
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("through", "code"), [(False, 0), (True, 1)])
def test_a_bag_becomes_a_world_in_which_its_drive_is_judged(tmp_path, kind, through, code):
    bag = write_bag(tmp_path / "run", drive(through), kind)
    done = worldgen("import", bag, "--out", tmp_path / "w.grid")
    assert (
        done.code == 0 and "the map is from /map; the start from /tf (map to base_link)" in done.err
    )
    world = read_world(tmp_path / "w.grid")
    assert np.array_equal(world.walls, room() > 0)
    assert (world.start.x, world.start.y, world.start.heading) == pytest.approx(
        (1.0, 1.05, math.pi / 2)
    )
    assert (world.target.x, world.target.y) == (5.0, 3.2)
    assert sorted(world.robots[0].footprint) == [(-0.2, -0.1), (-0.2, 0.1), (0.2, -0.1), (0.2, 0.1)]
    judged = worldgen("audit", tmp_path / "w.grid", bag)
    assert judged.code == code and ("1 tunnel, 1 overlap" in judged.out) == through
    assert "read as a bag" in judged.err


@pytest.mark.gate
@needs_rosbags
def test_a_bag_is_known_by_its_content(tmp_path):
    bag = write_bag(tmp_path / "run", drive())
    other = tmp_path / "recording.bin"
    other.write_bytes(bag.read_bytes())
    assert is_bag(other) and is_bag(bag.parent) and is_bag(bag.parent / "metadata.yaml")
    for path in (other, bag.parent, bag.parent / "metadata.yaml"):
        assert import_world(path).decision.result == "reachable"


@pytest.mark.gate
@needs_rosbags
def test_a_costmap_is_the_map_of_a_bag_without_one(tmp_path):
    cells = room()
    cells[5, 5:10] = [99, 50, 1, -1, 100]
    patch = {"x": 20, "y": 30, "width": 2, "height": 1, "data": [100, 0]}
    messages = [
        *without(drive(), "/map"),
        (COSTMAP, GRID, 3.0, grid(cells, time=3.0)),
        (f"{COSTMAP}_updates", UPDATE, 4.0, stamped(4.0, "map", **patch)),
    ]
    bag = write_bag(tmp_path / "run", messages)
    world = import_world(bag).world
    assert world.walls[5, 5:10].tolist() == [False, False, False, True, True]
    assert world.walls[30, 19:23].tolist() == [False, True, False, False]
    free = import_world(bag, name="bag+unknown=free").world
    assert free.walls[5, 5:10].tolist() == [False, False, False, False, True]
    with raises(FormatError, "no-such-topic", known=[COSTMAP]):
        import_world(bag, name="bag+topic=/map")


@pytest.mark.gate
@needs_rosbags
def test_the_last_map_counts_and_a_turned_one_is_turned(tmp_path):
    turned = grid(np.zeros((20, 40), np.int8), origin=(5.0, 5.0, math.pi / 2), time=9.0)
    poses = [("/pose", POSE, t, stamped(t, "map", pose=pose(4.5 - t, 6.0))) for t in (0.0, 1.0)]
    maps = [("/map", GRID, 9.0, turned), (COSTMAP, GRID, 9.0, grid(room()))]
    bag = write_bag(tmp_path / "run", [*drive()[:1], *poses, *maps])
    imported = import_world(bag)
    assert any(note.startswith(f"not used: {COSTMAP}") for note in imported.notes)
    # The lower-left corner of the turned map is 2 m to the left of its origin.
    assert imported.world.walls.shape == (40, 20) and imported.origin == pytest.approx((3.0, 5.0))
    assert (imported.world.start.x, imported.world.start.y) == pytest.approx((1.5, 1.0))
    own = MapFrame.of(imported.world).into_world(read_log(bag).trajectories[1])
    assert audit(imported.world, own).ok


@pytest.mark.gate
@needs_rosbags
def test_odometry_in_an_unknown_frame_is_not_taken_for_the_maps(tmp_path):
    lost = write_bag(tmp_path / "lost", without(drive(), "/tf", "/tf_static"))
    with raises(FormatError, "other-frame", topic="/odom", own="odom", frame="map"):
        read_log(lost)
    # The map is worth a world without them.
    assert "start and target were chosen" in " ".join(import_world(lost).notes)
    without_base = write_bag(tmp_path / "odom", without(drive(), "/tf"))
    found = read_log(without_base).trajectories[1]
    assert (found.x[0], found.y[0]) == pytest.approx((-1.0, -1.95))
    assert read_log(without_base, columns="topic=/odom").read_as.endswith("from /odom")
    for columns, error in (("topic=/scan", FormatError), ("x=1,y=2", InvalidParameter)):
        with pytest.raises(error):
            read_log(without_base, columns=columns)


@pytest.mark.gate
@needs_rosbags
def test_a_round_footprint_is_a_disc_and_a_bag_without_goal_ends_at_its_last_pose(tmp_path):
    around = [2.0 * math.pi * k / 16 for k in range(16)]
    points = [{"x": 0.3 * math.cos(a), "y": 0.3 * math.sin(a)} for a in around]
    values = stamped(1.0, "base_link", polygon={"points": points})
    messages = [*without(drive(), "/goal_pose", "/footprint"), ("/footprint", POLYGON, 1.0, values)]
    imported = import_world(write_bag(tmp_path / "run", messages))
    assert imported.world.robots[0].is_disc and imported.world.robot_radius == 0.3
    assert (imported.world.target.x, imported.world.target.y) == pytest.approx((5.0, 3.2))


def damaged(data, kind):
    """Return a bag's bytes with one kind of damage."""
    huge = struct.pack("<Q", 2**62)
    chunk = data.index(b"\x06")
    return {
        "truncated": data[: len(data) // 2],
        "only its beginning": data[:20],
        "a record of 2^62 bytes": data[:9] + huge + data[17:],
        "a chunk that becomes 2^62 bytes": data[: chunk + 25] + huge + data[chunk + 33 :],
        "zeros": data[:8] + bytes(len(data) - 8),
    }[kind]


@pytest.mark.gate
@needs_rosbags
@pytest.mark.parametrize(
    "kind",
    [
        "truncated",
        "only its beginning",
        "a record of 2^62 bytes",
        "a chunk that becomes 2^62 bytes",
        "zeros",
    ],
)
def test_a_damaged_bag_is_one_sentence(tmp_path, kind):
    bag = write_bag(tmp_path / "run", drive())
    (tmp_path / "bad.mcap").write_bytes(damaged(bag.read_bytes(), kind))
    done = worldgen("import", tmp_path / "bad.mcap", "--out", tmp_path / "w.grid")
    assert done.code == 2 and len(done.err.strip().splitlines()) == 1, done.err


@pytest.mark.gate
@needs_rosbags
@pytest.mark.parametrize(
    ("kind", "compression"),
    [
        ("bag", "bz2"),
        ("bag", "lz4"),
        ("db3", "file"),
        ("db3", "message"),
        ("mcap", "message"),
        ("mcap", "storage"),
    ],
)
def test_a_compressed_bag_is_read_unless_it_becomes_too_large(
    tmp_path, monkeypatch, kind, compression
):
    path = write_bag(tmp_path / "run", drive(), kind, compression)
    assert read_bag(path).grid_topic() == "/map"
    monkeypatch.setattr(bag, "_MOST_OF_A_CHUNK", 2000)
    monkeypatch.setattr(bag, "_MOST_OF_A_FILE", 2000)
    with raises(FormatError, "wrong-length", most=2000):
        read_bag(path)


@pytest.mark.gate
@needs_rosbags
@pytest.mark.parametrize(
    ("kind", "compression"), [("bag", "bz2"), ("db3", "message"), ("mcap", "storage")]
)
def test_what_all_compressed_parts_become_is_bounded_by_the_size_of_the_bag(
    tmp_path, monkeypatch, kind, compression
):
    path = write_bag(tmp_path / "run", drive(), kind, compression)
    monkeypatch.setattr(bag, "_FREE", 2000)
    assert read_bag(path).grid_topic() == "/map"
    monkeypatch.setattr(bag, "_MOST_TIMES", 0)
    with raises(FormatError, "too-large", most=2000):
        read_bag(path)


@pytest.mark.gate
@needs_rosbags
def test_an_mcap_of_other_programs_is_not_called_damaged(tmp_path):
    path = write_bag(tmp_path / "run", drive())
    path.write_bytes(path.read_bytes().replace(b"ros2", b"json", 1))
    with raises(FormatError, "unsupported", profile="json"):
        read_bag(path)


@pytest.mark.gate
@needs_rosbags
def test_the_list_and_the_files_of_a_bag_are_checked_before_they_are_opened(tmp_path):
    path = write_bag(tmp_path / "run", drive(), "db3")
    database = next(path.glob("*.db3"))
    database.unlink()
    os.mkfifo(database)
    with raises(FormatError, "damaged-bag", name=database.name):
        read_bag(path)
    with (path / "metadata.yaml").open("a") as metadata:
        metadata.write("deep: " + 1000 * "[")
    with raises(FormatError, "damaged-bag", name="metadata.yaml"):
        read_bag(path)


@pytest.mark.gate
@needs_rosbags
@pytest.mark.parametrize(
    ("messages", "code"),
    [
        ([("/map", POSE, 0.0, stamped(0.0, "map"))], "no-map-found"),
        ([("/map", GRID, 0.0, {**grid(room()), "data": np.zeros(7, np.int8)})], "wrong-size"),
        ([("/map", GRID, 0.0, grid(room(), origin=(math.nan, 0.0, 0.0)))], "not-finite"),
        ([("/map", GRID, 0.0, grid(room(), resolution=0.0))], "out-of-range"),
    ],
    ids=["no map", "too few cells", "an origin that is not a number", "a resolution of 0"],
)
def test_a_bag_without_a_whole_map_is_no_world(tmp_path, messages, code):
    bag = write_bag(tmp_path / "run", messages)
    with pytest.raises((FormatError, InvalidParameter)) as raised:
        import_world(bag)
    assert raised.value.code == code


@pytest.mark.gate
@needs_rosbags
def test_a_topic_with_another_type_than_its_name_says_is_ignored(tmp_path):
    odd = ("/goal_pose", ODOMETRY, 0.0, stamped(0.0, "map", pose={"pose": pose(0.0, 0.0)}))
    bag = read_bag(write_bag(tmp_path / "run", [odd]))
    assert bag.grid_topic() is None and not bag.poses and list(bag.goals) == ["/goal_pose"]
