"""Map files of the thesis's simulator: reading, writing to the byte, and the code of each error."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.command_line import worldgen
from tests.helpers.raising import check_says, raises
from tests.helpers.thesis_editor import Editor
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld
from worldgen.files.grid import read_world, write_world
from worldgen.generation import generate
from worldgen.interop import ImportedRobot, export_world, import_world, read_map
from worldgen.interop.formats.thesis import MAX_SIZE, filtered, read_thesis_map, signal
from worldgen.interop.readers.java_stream import read_ints, write_ints
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Target, World

SAMPLES = Path(__file__).parents[1] / "data" / "thesis" / "maps"
HEADER = b"\xac\xed\x00\x05"
every_sample = pytest.mark.parametrize("name", ["map10", "map30", "map30noise", "map100"])


@pytest.fixture
def write(tmp_path):
    def write_file(data, name="old.gex"):
        path = tmp_path / name
        path.write_bytes(write_ints(data.ravel()) if isinstance(data, np.ndarray) else data)
        return path

    return write_file


def room(size=10, target=(5, 5), walls=()):
    """An editor with a closed room, some walls drawn."""
    editor = Editor(size, target)
    for x, y in walls:
        editor.draw_wall(x, y)
    return editor


def changed(values, x, y, value):
    values = values.copy()
    values[y, x] = value
    return values


def blocks(*parts):
    """A stream of short records."""
    return HEADER + b"".join(bytes([0x77, len(part)]) + part for part in parts)


# In and out


@every_sample
def test_a_sample_comes_back_to_the_byte(tmp_path, name):
    original = SAMPLES / f"{name}.map"
    assert worldgen("import", original, "--out", tmp_path / "w.grid").code == 0
    result = worldgen(
        "export", tmp_path / "w.grid", "--to", "thesis", "--out", tmp_path / "old.gex"
    )
    assert (result.code, result.err) == (0, "")
    assert (tmp_path / "old.gex").read_bytes() == original.read_bytes()


@every_sample
def test_a_sample_is_imported_as_the_program_would_run_it(name):
    world = import_world(SAMPLES / f"{name}.map").world
    assert world.start == Pose(0.35, float(f"{world.height / 10 - 0.35:.2f}"), math.pi - 4.5)
    assert (world.target.radius, world.robot_radius, world.robot_speed) == (0.05, 0.07, 2.0)


def test_rows_go_down_and_columns_go_right(write):
    found = read_thesis_map(write(room(target=(8, 1), walls=[(2, 3)]).values))
    assert [tuple(cell) for cell in np.argwhere(found.walls[1:-1, 1:-1])] == [(10 - 1 - 3 - 1, 1)]
    assert found.robot.target == (0.85, 0.85, 0.05)


def test_the_cell_size_scales_start_target_and_robot(write):
    world = import_world(write(room().values), options={"cell_size": 0.5}).world
    assert (world.start.x, world.start.y) == (1.75, 3.25)
    assert (world.target, world.robot_radius) == (Target(2.75, 2.25, 0.25), 0.35)


@pytest.mark.parametrize("name", ["old.gex", "old.map", "old", "old.pgm"])
def test_a_thesis_map_is_known_by_its_first_bytes(write, name):
    assert import_world(write(room().values, name)).world.provenance.params["format"] == "thesis"


def test_a_start_that_is_not_clear_is_placed_elsewhere_and_said(write):
    imported = import_world(write(room(size=20, target=(15, 15), walls=[(3, 3)]).values))
    assert any("(0.35, 1.65) m has no room for the robot" in note for note in imported.notes)
    assert imported.decision.result == "reachable"


def test_start_and_target_given_come_before_the_files(write):
    robot = ImportedRobot(start=(0.25, 0.25, 1.0), target=(0.75, 0.75, 0.02))
    world = import_world(write(room().values), robot).world
    assert (world.start, world.target) == (Pose(0.25, 0.25, 1.0), Target(0.75, 0.75, 0.02))


def test_a_seed_asks_for_another_start_and_keeps_the_target(write):
    path = write(room(size=20, target=(16, 16)).values)
    there = import_world(path, ImportedRobot(seed=5)).world
    assert there.target == import_world(path).world.target and (there.start.x, there.start.y) != (
        0.35,
        1.65,
    )


@pytest.mark.parametrize("size", [3, 4, 8, 9, 11, 31, 101, 102])
def test_a_size_that_the_program_does_not_load_is_imported_and_said(write, size):
    found = read_thesis_map(write(room(size, target=(1, 1)).values))
    assert found.walls.shape == (size, size)
    assert f"does not load {size} x {size} cells" in found.notes[0]


@pytest.mark.parametrize("size", [10, 12, 100])
def test_a_size_that_the_program_loads_goes_without_saying(write, size):
    assert read_thesis_map(write(room(size).values)).notes == ()


# Values


def test_a_map_drawn_at_once_and_then_filtered_is_remembered_as_noisy(write):
    editor = room(20, (12, 9), [(5, 5), (6, 5), (13, 10)])
    editor.switch_noise(True)
    found = read_thesis_map(write(editor.values))
    assert found.params["noise"] is True and "noise filter" in found.notes[0] and not found.warnings


def test_a_map_drawn_with_the_filter_on_is_warned_about_and_exported_plain(write, tmp_path):
    editor = room(20, (12, 9))
    editor.switch_noise(True)
    for x, y in [(8, 5), (7, 5), (6, 5), (5, 5)]:
        editor.draw_wall(x, y)
    imported = import_world(write(editor.values))
    plain = signal(editor.values == -2, (12, 9))
    unlike = (editor.values != plain) & (editor.values != filtered(plain, (12, 9)))
    assert unlike.any() and f"({unlike.sum()} cells fit neither)" in imported.warnings[0]
    assert export_world(imported.world, "thesis").data == write_ints(plain.ravel())


def test_a_shifted_map_is_warned_about(write):
    values = room(12, (3, 8)).values
    values[3, 8], values[8, 3] = values[8, 3], values[3, 8]
    found = read_thesis_map(write(values))
    assert "cells fit neither" in found.warnings[0] and "noise" not in found.params


def test_minus_one_is_a_free_cell_with_a_warning(write):
    found = read_thesis_map(write(changed(room().values, 2, 2, -1)))
    assert "(1 cells fit neither)" in found.warnings[0] and not found.walls[7, 2]


MAPS = st.integers(5, 16).flatmap(
    lambda size: st.tuples(
        st.just(size),
        st.tuples(st.integers(1, size - 2), st.integers(1, size - 2)),
        st.lists(st.tuples(st.integers(1, size - 2), st.integers(1, size - 2)), max_size=30),
    )
)


@given(MAPS)
def test_the_filter_is_the_editors_switched_on_when_all_is_drawn(drawn):
    size, target, walls = drawn
    editor = room(size, target, walls)
    plain = editor.values
    assert np.array_equal(plain, signal(plain == -2, target))
    editor.switch_noise(True)
    assert np.array_equal(filtered(plain, target), editor.values)
    editor.switch_noise(False)
    assert np.array_equal(plain, editor.values)


@given(MAPS, st.booleans())
def test_any_map_comes_back_to_the_byte(tmp_path_factory, drawn, noise):
    size, target, walls = drawn
    editor = room(size, target, walls)
    if noise:
        editor.switch_noise(True)
    path = tmp_path_factory.mktemp("maps") / "old.gex"
    path.write_bytes(write_ints(editor.values.ravel()))
    try:
        world = import_world(path).world
    except InvalidWorld as error:  # walled in so that no robot fits
        check_says(error, "no-room")
    else:
        assert export_world(world, "thesis").data == path.read_bytes()


# The editor's own rules, from the listing


def test_a_wall_drawn_with_the_filter_on_changes_the_cells_within_two_of_it():
    editor = room(20, (10, 10))
    before = editor.values
    editor.switch_noise(True)
    editor.draw_wall(5, 5)
    rows, columns = np.nonzero(editor.values != before)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (3, 7, 3, 7)
    assert (editor.values[3, 3], editor.values[7, 7]) == (int(1.5 * 98), int(0.9 * 18))


def test_erasing_one_cell_leaves_the_noise_of_its_wall():
    editor = room(20, (10, 10))
    plain = editor.values
    editor.switch_noise(True)
    editor.draw_wall(5, 5)
    editor.erase_cell(5, 5)
    assert editor.values[5, 5] == plain[5, 5] and (editor.values != plain).sum() == 24


def test_erasing_a_rectangle_filters_the_map_afresh():
    editor = room(20, (10, 10))
    editor.switch_noise(True)
    for x, y in [(8, 5), (7, 5), (6, 5), (14, 14)]:
        editor.draw_wall(x, y)
    editor.erase_rectangle(15, 15, 14, 14)
    plain = signal(editor.values == -2, (10, 10))
    assert editor.values[14, 14] == plain[14, 14] == 32
    assert np.array_equal(editor.values, filtered(plain, (10, 10)))


def test_moving_the_target_filters_the_map_afresh():
    editor = room(20, (10, 10))
    editor.switch_noise(True)
    for x, y in [(8, 5), (7, 5), (6, 5)]:
        editor.draw_wall(x, y)
    editor.move_target(3, 14)
    assert np.array_equal(editor.values, filtered(signal(editor.values == -2, (3, 14)), (3, 14)))


def test_moving_the_target_onto_a_wall_loses_it_and_import_says_so(write):
    editor = room(walls=[(3, 3)])
    editor.move_target(3, 3)
    with raises(FormatError, "wrong-count"):
        read_thesis_map(write(editor.values))


# Bytes as Java writes them


@pytest.mark.parametrize(
    ("count", "heads"),
    [
        (0, []),
        (1, ["7704"]),
        (63, ["77fc"]),
        (64, ["7a00000100"]),
        (256, ["7a00000400"]),
        (257, ["7a00000400", "7704"]),
        (512, ["7a00000400", "7a00000400"]),
    ],
)
def test_blocks_have_1024_bytes_and_what_is_left_has_the_shorter_head_that_fits(count, heads):
    stream, at = write_ints(np.arange(count)), 4
    for head in heads:
        raw = bytes.fromhex(head)
        assert stream[at : at + len(raw)] == raw
        at += len(raw) + int.from_bytes(raw[1:], "big")
    assert at == len(stream) and read_ints(stream).tolist() == list(range(count))


@given(st.lists(st.integers(-(2**31), 2**31 - 1), max_size=40), st.integers(1, 99))
def test_blocks_of_any_length_are_read(numbers, length):
    payload = write_ints(np.array(numbers, np.int64))[6:] if len(numbers) < 64 else b""
    parts = [payload[at : at + length] for at in range(0, len(payload), length)]
    assert read_ints(blocks(*parts)).tolist() == numbers


# Faults

GOOD = room(10).values
FAULTS = [
    (b"", {"code": "unknown-format", "came": "nothing"}),
    (b"\xac", {"code": "cut-short", "bytes": 1}),
    (HEADER[:3], {"code": "cut-short", "bytes": 3}),
    (b"PK\x03\x04" + bytes(396), {"code": "unknown-format", "came": "50 4B"}),
    (b"\xac\xed\x00\x04" + write_ints(GOOD.ravel())[4:], {"code": "unknown-version", "version": 4}),
    (HEADER, {"code": "empty"}),
    (HEADER + b"\x73\x72\x00", {"code": "not-numbers", "at": 4, "what": "an object"}),
    (HEADER + b"\x74\x00\x03abc", {"code": "not-numbers", "at": 4, "what": "a string"}),
    (blocks(bytes(36)) + b"\x79", {"code": "not-numbers", "at": 42, "what": "a reset"}),
    (HEADER + b"\x00", {"code": "not-numbers", "at": 4, "what": "not a record of Java"}),
    (HEADER + b"\x77", {"code": "cut-short"}),
    (HEADER + b"\x7a\x00\x00", {"code": "cut-short"}),
    (HEADER + b"\x77\x00", {"code": "empty-block", "at": 4}),
    (HEADER + b"\x77\x08\x00\x00", {"code": "cut-short", "length": 8, "left": 2}),
    (HEADER + b"\x7a\xff\xff\xff\xff\x00", {"code": "cut-short", "length": 4294967295, "left": 1}),
    (write_ints(GOOD.ravel())[:-1], {"code": "cut-short", "length": 400, "left": 399}),
    (blocks(bytes(35)), {"code": "cut-short", "count": 35}),
    (GOOD.ravel()[:-1], {"code": "not-square", "numbers": 99}),
    (np.full((2, 2), -2), {"code": "wrong-size", "size": 2, "min_size": 3, "max_size": 2000}),
    (np.full((1, 1), 0), {"code": "wrong-size", "size": 1}),
    (changed(GOOD, 4, 2, -3), {"code": "wrong-values", "value": -3, "column": 4, "row": 2}),
    (
        changed(GOOD, 4, 2, -(2**31)),
        {"code": "wrong-values", "value": -2147483648, "column": 4, "row": 2},
    ),
    (changed(GOOD, 0, 7, 9), {"code": "open-border", "row": 7}),
    (changed(GOOD, 9, 9, -1), {"code": "open-border", "column": 9, "row": 9}),
    (changed(GOOD, 2, 3, 0), {"code": "wrong-count", "targets": 2}),
    (changed(GOOD, 5, 5, 1), {"code": "wrong-count"}),
]


@pytest.mark.gate
@pytest.mark.parametrize(("data", "expected"), FAULTS, ids=range(len(FAULTS)))
def test_a_damaged_file_is_refused_in_one_line(write, tmp_path, data, expected):
    path = write(data)
    with raises(FormatError, **expected) as caught:
        read_map(path, "thesis")
    assert str(caught.value).startswith(f"{path}: ") and "\n" not in str(caught.value)
    result = worldgen("import", path, "--from", "thesis", "--out", tmp_path / "w.grid")
    assert (result.code, result.err.count("\n")) == (2, 1) and not (tmp_path / "w.grid").exists()


def test_a_file_larger_than_any_map_is_not_read(write):
    data = HEADER + bytes(4 * MAX_SIZE * MAX_SIZE + 100_000)
    with raises(FormatError, "too-large"):
        read_thesis_map(write(data))


def test_a_map_of_nothing_but_one_byte_blocks_is_read(write):
    size = 200
    payload = room(size).values.astype(">i4").tobytes()
    data = HEADER + b"".join(b"\x77\x01" + payload[at : at + 1] for at in range(len(payload)))
    assert read_thesis_map(write(data)).walls.shape == (size, size)


def read_or_refuse(path):
    try:
        found = read_thesis_map(path)
    except FormatError as error:
        assert "\n" not in str(error)
    else:
        assert found.walls.shape[0] == found.walls.shape[1]


@given(st.binary(max_size=60), st.booleans())
def test_any_bytes_give_a_map_or_one_message(tmp_path_factory, data, headed):
    path = tmp_path_factory.mktemp("maps") / "old.gex"
    path.write_bytes(HEADER + data if headed else data)
    read_or_refuse(path)


@given(st.data())
def test_a_sample_with_bytes_changed_and_cut_gives_a_map_or_one_message(tmp_path_factory, data):
    raw = bytearray((SAMPLES / "map10.map").read_bytes())
    for _ in range(data.draw(st.integers(0, 3))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("maps") / "old.gex"
    path.write_bytes(raw[: data.draw(st.integers(0, len(raw)))])
    read_or_refuse(path)


# Export


def closed(width=10, height=10, **changes):
    walls = np.ones((height, width), bool)
    walls[1:-1, 1:-1] = False
    parts = {
        "start": Pose(0.35, height / 10 - 0.35, math.pi - 4.5),
        "target": Target(0.55, 0.55, 0.05),
    } | changes
    return World(walls, **parts)


@pytest.mark.parametrize(
    ("world", "expected"),
    [
        (closed(12), {"code": "not-square", "width": 12, "height": 10}),
        (
            World(np.zeros((10, 10), bool), Pose(0.5, 0.5), Target(0.8, 0.8, 0.05)),
            {"code": "open-border"},
        ),
        (closed(target=Target(0.05, 0.5, 0.05)), {"code": "target-in-a-wall", "x": 0.05, "y": 0.5}),
        (closed(target=Target(1.0, 0.5, 0.05)), {"code": "target-in-a-wall"}),
        (
            closed(2, 2, target=Target(0.1, 0.1, 0.05), start=Pose(0.1, 0.1)),
            {"code": "wrong-size", "width": 2, "height": 2, "min_size": 3},
        ),
    ],
    ids=["square", "border", "wall", "edge", "small"],
)
def test_what_a_thesis_map_cannot_hold_is_refused(world, expected):
    with raises(InvalidWorld, **expected):
        export_world(world, "thesis")


def test_a_world_as_the_program_has_it_leaves_nothing_to_say():
    assert export_world(closed(), "thesis").lost == ()


@pytest.mark.parametrize(
    ("changes", "note"),
    [
        ({"start": Pose(0.35, 0.65, 0.0)}, "the start pose is not stored"),
        ({"start": Pose(0.45, 0.65, math.pi - 4.5)}, "the start pose is not stored"),
        ({"robot_radius": 0.05}, "the robot's radius is not stored"),
        ({"robot_speed": 1.0}, "the robot's speed is not stored"),
        ({"target": Target(0.5, 0.5, 0.05)}, "the whole cell in column 5, row 4 from the top"),
        ({"target": Target(0.55, 0.55, 0.1)}, "the whole cell in column 5, row 4 from the top"),
    ],
    ids=["heading", "start", "radius", "speed", "target", "target-radius"],
)
def test_what_a_thesis_map_leaves_out_is_said(changes, note):
    lost = export_world(closed(**changes), "thesis").lost
    assert len(lost) == 1 and note in lost[0]


def test_a_world_that_changes_is_refused_until_a_time_is_given():
    changing = closed(timeline=Timeline.of([(1.0, 4, 4, CellState.SOLID)]))
    with raises(InvalidWorld, "world-changes"):
        export_world(changing, "thesis")
    still = export_world(changing, "thesis", at=0.0)
    assert (
        still.data == export_world(closed(), "thesis").data
        and "1 changes are not stored" in still.notes[0]
    )


def test_the_cell_size_and_a_size_that_the_program_does_not_load_are_said(tmp_path):
    write_world(generate("trap", 1, size=31, cell_size=0.2), tmp_path / "w.grid")
    result = worldgen(
        "export", tmp_path / "w.grid", "--to", "thesis", "--out", tmp_path / "old.gex"
    )
    assert result.code == 0
    assert (
        "not stored: the cell size 0.2 m" in result.err
        and "does not load 31 x 31 cells" in result.err
    )


def test_noise_is_added_and_left_out_on_demand(tmp_path):
    plain, noisy = ((SAMPLES / f"{name}.map").read_bytes() for name in ("map30", "map30noise"))
    for name, noise, data in [("map30", "on", noisy), ("map30noise", "off", plain)]:
        write_world(import_world(SAMPLES / f"{name}.map").world, tmp_path / "w.grid", force=True)
        out = tmp_path / f"{name}.gex"
        done = worldgen(
            "export", tmp_path / "w.grid", "--to", f"thesis+noise={noise}", "--out", out
        )
        assert done.code == 0
        assert out.read_bytes() == data


@pytest.mark.parametrize("name", ["trap", "corridor", "maze", "shift"])
def test_a_world_of_a_family_survives_the_way_out_and_back(tmp_path, name):
    world = generate(name, 4, size=40)
    path = tmp_path / "old.gex"
    path.write_bytes(export_world(world, "thesis").data)
    found = read_thesis_map(path)
    assert np.array_equal(found.walls, world.walls) and found.notes == found.warnings == ()
    assert (
        max(
            abs(a - b)
            for a, b in zip(found.robot.target[:2], (world.target.x, world.target.y), strict=True)
        )
        < 0.051
    )


def test_export_prints_one_object_and_overwrites_only_when_forced(tmp_path):
    write_world(closed(robot_speed=1.0), tmp_path / "w.grid")
    args = [
        "export",
        tmp_path / "w.grid",
        "--to",
        "thesis",
        "--out",
        tmp_path / "old.gex",
        "--json",
    ]
    shown = json.loads(worldgen(*args).out)
    assert set(shown) == {"file", "format", "bytes", "sha256", "files", "lost", "notes"}
    assert (
        shown["bytes"] == (tmp_path / "old.gex").stat().st_size == 409 and len(shown["lost"]) == 1
    )
    again = worldgen(*args)
    assert again.code == 2 and again.error_code == "file-exists"
    assert worldgen(*args, "--force").code == 0


def test_an_exporter_of_ones_own_is_found_by_its_path(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from worldgen.interop import Exported, Format\n"
        "def write(world, to): return Exported({to.name: b'%d' % world.walls.size})\n"
        "count = Format('count', 'cells', ('.txt',), write=write)\n"
    )
    write_world(closed(), tmp_path / "w.grid")
    args = [
        "export",
        tmp_path / "w.grid",
        "--to",
        f"{tmp_path / 'mine.py'}:count",
        "--out",
        tmp_path / "n.txt",
    ]
    assert worldgen(*args).code == 0 and (tmp_path / "n.txt").read_bytes() == b"100"
    args[3] += "+noise=on"
    refused = worldgen(*args, "--force")
    assert refused.code == 2 and refused.error_code == "unknown-name"


def test_an_unknown_exporter_is_refused_with_the_nearest_name():
    with raises(InvalidParameter, "unknown-name", name="thesys", noun="format", near="thesis"):
        export_world(closed(), "thesys")


def test_what_is_no_exporter_is_refused():
    with raises(InvalidParameter, "wrong-type", name="worldgen.world:World"):
        export_world(closed(), "worldgen.world:World")


def test_a_file_read_back_is_the_world_that_was_written(tmp_path):
    imported = import_world(SAMPLES / "map30noise.map").world
    write_world(imported, tmp_path / "w.grid")
    assert read_world(tmp_path / "w.grid").provenance.params["noise"] is True
