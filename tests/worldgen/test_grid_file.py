"""The .grid file: any world is read back as written; canonical bytes; files on disk."""

import gzip
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.grid_strategies import damaged_files, values, worlds_with_everything
from tests.helpers.raising import raises
from worldgen.domain import CELL_SIZES, LATEST, RADII, SPEEDS
from worldgen.errors import FormatError, InvalidWorld, OutputError
from worldgen.files.grid import disk, dumps, loads, read_world, world_digest, write_world
from worldgen.files.grid.schema import EXPANSION_FLOOR, MAX_HEADER_BYTES
from worldgen.support.rows import flip_rows
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Cut, FailureRecord, Pose, Provenance, Target, Witness, World

GOLDEN = Path(__file__).parent / "golden" / "everything.grid"
GOLDEN_DIGEST = "813168cca219dc68508b2d4f33a1dfd2bfb3910617507bf8a8ed6923a908efa3"


def everything():
    walls = np.ones((5, 7), bool)
    walls[1:4, 1:6] = False
    walls[2, 2:5] = walls[1, 4] = True
    return World(
        walls,
        Pose(0.75, 0.75, -1.5708),
        Target(2.75, 1.75, 0.25),
        cell_size=0.5,
        robot_radius=0.2,
        robot_speed=1.5,
        timeline=Timeline.of(
            [
                Event(4.5, 3, 1, CellState.SOLID),
                Event(2.0, 3, 3, CellState.BURNING),
                (4.5, 3, 3, CellState.FREE),
            ]
        ),
        certificate=Witness(
            [0.0, 1.0, 5.0, 8.0], [0.75, 0.75, 0.75, 2.75], [0.75, 1.75, 1.75, 1.75], 0.25
        ),
        provenance=Provenance(
            "fire",
            1,
            2**64 - 1,
            {"width": 7, "over": "maze", "spread": 0.25, "odd key": [True, -3, 1e-07, {}]},
        ),
        failure=FailureRecord(
            "turn-right",
            "swept",
            7,
            "loop",
            "0123456789abcdef",
            {"steps": 20000},
            {"entry": 212},
            {"note": 'a "b"\n\\'},
        ),
    )


def small(**changes):
    return replace(
        World(np.zeros((2, 3), bool), Pose(0.05, 0.05), Target(0.25, 0.15, 0.05)), **changes
    )


def complaint(data):
    with pytest.raises(FormatError) as caught:
        loads(data)
    return caught.value


def world_or_complaint(data):
    try:
        world = loads(data)
    except FormatError as error:
        assert error.line is not None and 1 <= error.line <= data.count(b"\n") + 1
        assert "\n" not in str(error) and len(str(error)) < 400
        return error
    assert loads(dumps(world)) == world
    return None


@given(worlds_with_everything())
def test_reading_what_was_written_gives_an_equal_world(world):
    assert loads(dumps(world)) == world


@pytest.mark.gate
@given(worlds_with_everything())
def test_writing_what_was_read_gives_the_same_bytes(world):
    assert dumps(loads(dumps(world))) == dumps(world)


@given(values())
def test_values_keep_their_types(value):
    world = small(provenance=Provenance("maze", 1, 2, {"v": value}))
    back = loads(dumps(world)).provenance.params["v"]
    assert json.dumps(back, sort_keys=True) == json.dumps(_no_minus_zero(value), sort_keys=True)


def _no_minus_zero(value):
    if isinstance(value, dict):
        return {key: _no_minus_zero(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_no_minus_zero(item) for item in value]
    return value + 0.0 if isinstance(value, float) else value


@settings(max_examples=300)
@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_any_bytes_give_a_world_or_a_complaint_with_a_line(data):
    assert world_or_complaint(data) is not None  # chance would never find the magic


_PIECES = [
    "cell_size = 0.1",
    "robot_radius = 0.07",
    "start = [0.1, 0.1, 0]",
    "target = [0.1, 0.1, 1]",
    "[provenance]",
    "[certificate]",
    'kind = "cut"',
    "clearance = 1",
    "[failure]",
    "seed = 1",
    "params = { a = [",
    "%cells",
    "...",
    "S.G",
    "%timeline",
    "0 1 0 solid",
    "%witness",
    "0 0.1 0.1",
    "%cut",
    "-1 0",
    "%end",
    "",
    '"""',
    "é",
    "\x00",
]


@pytest.mark.gate
@settings(max_examples=120)
@given(st.lists(st.sampled_from(_PIECES) | st.text(max_size=6), max_size=14))
def test_any_text_behind_the_magic_gives_a_world_or_a_complaint_with_a_line(pieces):
    world_or_complaint("\n".join(["%worldgen-grid 1", *pieces, ""]).encode())


@pytest.mark.gate
@settings(max_examples=150)
@given(damaged_files())
def test_a_damaged_file_gives_a_world_or_a_complaint_with_a_line(data):
    world_or_complaint(data)


def test_a_file_cut_off_anywhere_is_refused():
    data = dumps(everything())
    assert all(world_or_complaint(data[:end]) is not None for end in range(len(data)))


def test_the_golden_world_is_written_as_ever():
    assert dumps(everything()) == GOLDEN.read_bytes()


def test_the_golden_world_is_read_as_ever():
    assert read_world(GOLDEN) == everything()


def test_the_golden_world_has_its_digest():
    assert world_digest(everything()) == GOLDEN_DIGEST


def test_the_digest_knows_neither_provenance_nor_failure():
    assert world_digest(replace(everything(), provenance=None, failure=None)) == GOLDEN_DIGEST


@pytest.mark.parametrize(
    "change",
    [
        {"robot_speed": 1.25},
        {"robot_radius": 0.1},
        {"certificate": None},
        {"start": Pose(0.75, 0.75)},
        {"timeline": Timeline()},
    ],
    ids=lambda change: next(iter(change)),
)
def test_the_digest_knows_everything_else(change):
    assert world_digest(replace(everything(), **change)) != GOLDEN_DIGEST


def test_one_cell_changes_the_digest():
    walls = everything().walls.copy()
    walls[0, 0] = False
    assert world_digest(replace(everything(), walls=walls)) != GOLDEN_DIGEST


def test_the_top_row_is_written_first():
    world = small(walls=[[True, False, False], [False, False, False]])
    assert b"%cells\n...\n#..\n%end\n" in dumps(world)


@pytest.mark.gate
@given(worlds_with_everything())
def test_flipping_rows_twice_changes_nothing(world):
    assert np.array_equal(flip_rows(flip_rows(world.walls)), world.walls)


def test_the_usual_speed_is_not_written():
    assert b"robot_speed" not in dumps(small(robot_speed=2.0))


def test_minus_zero_is_written_as_zero():
    world = small(start=Pose(-0.0, 0.05, -0.0), certificate=Witness([-0.0], [-0.0], [-0.0], -0.0))
    assert b"-0" not in dumps(world)


def test_minus_zero_is_read_as_zero():
    data = dumps(small()).replace(b"start = [0.05, 0.05, 0.0]", b"start = [-0.0, 0.05, -0.0]")
    assert repr(loads(data).start) == "Pose(x=0.0, y=0.05, heading=0.0)"


@pytest.mark.parametrize("cell_size", [0.1, 0.05, 0.3, 1.0])
def test_marks_stand_for_cell_centres(cell_size):
    text = (
        f"%worldgen-grid 1\ncell_size = {cell_size}\nrobot_radius = 0.01\n%cells\n..G\nS..\n%end\n"
    )
    world = loads(text.encode())
    assert world.start == Pose(
        float(f"{cell_size * 0.5:.12g}"), float(f"{cell_size * 0.5:.12g}"), 0.0
    )
    centre = [float(f"{cell_size * k:.12g}") for k in (2.5, 1.5, 0.5)]
    assert world.target == Target(*centre)


def test_marked_cells_are_free_and_never_written():
    world = loads(b"%worldgen-grid 1\ncell_size = 1\nrobot_radius = 0.1\n%cells\nS#G\n%end\n")
    assert world.walls.tolist() == [[False, True, False]]
    assert b"%cells\n.#.\n%end\n" in dumps(world)


@pytest.mark.parametrize("x", [float("inf"), float("nan"), -1e-9])
def test_a_start_outside_the_grid_is_refused(x):
    with raises(InvalidWorld, "outside-grid", name="start"):
        World(np.zeros((5, 5), bool), Pose(x, 0.0), Target(0.0, 0.0, 1.0))


@pytest.mark.parametrize("cell_size", CELL_SIZES)
@pytest.mark.parametrize("share", RADII)
@pytest.mark.parametrize("pace", SPEEDS)
def test_a_world_at_the_ends_of_its_domain_comes_back_from_its_file(cell_size, share, pace):
    target = Target(0.0, 0.0, share * cell_size)
    timeline = Timeline.of([(LATEST, 1, 1, CellState.SOLID)])
    numbers = {
        "cell_size": cell_size,
        "robot_radius": share * cell_size,
        "robot_speed": pace * cell_size,
    }
    world = World(np.zeros((3, 3), bool), Pose(0.0, 0.0), target, timeline=timeline, **numbers)
    assert loads(dumps(world)) == world


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("cell_size", 0.9e-6),
        ("cell_size", 1.1e6),
        ("robot_radius", 0.9e-7),
        ("robot_radius", 2001.0),
        ("robot_speed", 0.9e-7),
        ("robot_speed", 1.1e8),
        ("target radius", 0.9e-7),
        ("target radius", 2001.0),
    ],
)
def test_a_number_that_no_robot_has_is_refused(name, value):
    radius = value if name == "target radius" else 0.05
    numbers = {} if name == "target radius" else {name: value}
    with raises(InvalidWorld, "out-of-range", name=name, value=value):
        World(np.zeros((3, 3), bool), Pose(0.15, 0.15), Target(0.25, 0.25, radius), **numbers)


def test_a_change_after_31_years_is_refused():
    with raises(InvalidWorld, "out-of-range", name="time", value=1.1e9):
        Timeline.of([(1.1e9, 0, 0, CellState.SOLID)])


def test_an_empty_certificate_is_kept():
    world = small(certificate=Cut(np.zeros((0, 2)), 0.1))
    assert dumps(world).endswith(b"%cut\n%end\n")


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (float("nan"), {"code": "not-finite"}),
        ([1, float("inf")], {"code": "not-finite"}),
        ((1, 2), {"code": "wrong-type", "kind": "tuple"}),
        (None, {"code": "wrong-type", "kind": "NoneType"}),
        (np.int64(3), {"code": "wrong-type", "kind": "int64"}),
        ({3: 4}, {"code": "wrong-type", "key": 3}),
        (1 << 1024, {"code": "too-large", "most": 1024}),
        ("\ud800", {"code": "not-utf8"}),
        ({"\ud800": 1}, {"code": "not-utf8"}),
        ("x" * MAX_HEADER_BYTES, {"code": "too-large"}),
    ],
    ids=[
        "nan",
        "inf",
        "tuple",
        "none",
        "numpy",
        "key",
        "integer",
        "surrogate",
        "surrogate-key",
        "long",
    ],
)
def test_what_the_format_cannot_hold_is_refused(value, expected):
    with raises(InvalidWorld, **expected):
        dumps(small(provenance=Provenance("maze", 1, 2, {"v": value})))


def nested(levels):
    value = 1
    for _ in range(levels):
        value = [value]
    return small(provenance=Provenance("maze", 1, 2, {"v": value}))


def test_values_nest_up_to_the_limit():
    assert loads(dumps(nested(31))) == nested(31)


@pytest.mark.parametrize("levels", [32, 5000])
def test_values_nested_deeper_are_refused(levels):
    with raises(InvalidWorld, "nested-too-deep", most=32):
        dumps(nested(levels))


def test_a_witness_with_nan_is_refused():
    with raises(InvalidWorld, "not-finite"):
        dumps(small(certificate=Witness([0.0], [np.nan], [0.0], 0.1)))


def test_an_integer_at_the_limit_survives():
    world = small(provenance=Provenance("maze", 1, 2**1024 - 1, {}))
    assert loads(dumps(world)) == world


def test_reading_imports_no_heavy_library():
    code = (
        "import sys; from worldgen.files.grid import read_world; read_world(sys.argv[1]);"
        "print(*{'numba', 'scipy', 'shapely', 'PIL', 'click'} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, GOLDEN], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("name", ["w.grid", "w.grid.gz", "w.GZ"])
def test_a_world_survives_the_disk(tmp_path, name):
    write_world(everything(), tmp_path / name)
    assert read_world(tmp_path / name) == everything()


def test_compressed_files_hold_the_canonical_text_without_name_or_time(tmp_path):
    write_world(everything(), tmp_path / "w.grid.gz")
    packed = (tmp_path / "w.grid.gz").read_bytes()
    assert packed[:8] == b"\x1f\x8b\x08\0\0\0\0\0"
    assert gzip.decompress(packed) == dumps(everything())


def test_a_file_that_is_there_stays_without_force(tmp_path):
    path = tmp_path / "w.grid"
    write_world(small(), path)
    with raises(OutputError, "file-exists"):
        write_world(everything(), path)
    assert read_world(path) == small()


def test_force_overwrites(tmp_path):
    write_world(small(), tmp_path / "w.grid")
    write_world(everything(), tmp_path / "w.grid", force=True)
    assert read_world(tmp_path / "w.grid") == everything()


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("", "is-a-folder"),
        ("no/w.grid", "no-such-folder"),
        ("a\0b", "unwritable"),
        ("n" * 300, "unwritable"),
    ],
    ids=["folder", "no-folder", "nul", "long-name"],
)
def test_an_impossible_place_is_a_sentence(tmp_path, name, code):
    with raises(OutputError, code):
        write_world(small(), tmp_path / name)


def test_a_full_disk_is_a_sentence():
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    with raises(OutputError, "unwritable"):
        write_world(small(), "/dev/full", force=True)


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("", "is-a-folder"),
        ("no.grid", "no-such-file"),
        ("a\0b", "unreadable"),
        ("n" * 300, "unreadable"),
    ],
    ids=["folder", "missing", "nul", "long-name"],
)
def test_a_file_that_cannot_be_read_is_a_sentence(tmp_path, name, code):
    with raises(FormatError, code):
        read_world(tmp_path / name)


def test_a_device_without_end_is_refused(monkeypatch):
    monkeypatch.setattr(disk, "MAX_FILE_BYTES", 1 << 22)
    with raises(FormatError, "too-large", most=4194304):
        read_world("/dev/zero")


def test_complaints_name_file_and_line(tmp_path):
    (tmp_path / "w.grid").write_bytes(dumps(small()).replace(b"...", b"..x", 1))
    with raises(FormatError, "unknown-sign", line=7, sign="x", column=3):
        read_world(tmp_path / "w.grid")


def packed_golden():
    return gzip.compress(GOLDEN.read_bytes(), mtime=0)


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (packed_golden()[:-9], "cut-short"),
        (packed_golden()[:40], "cut-short"),
        (packed_golden()[:-6] + b"xxxxxx", "damaged-file"),
        (packed_golden()[:20] + b"\xff" * 20 + packed_golden()[40:], "damaged-file"),
        (packed_golden() + b"more", "damaged-file"),
        (GOLDEN.read_bytes(), "damaged-file"),
        (b"", "empty"),
    ],
    ids=["no-trailer", "cut", "crc", "broken", "trailing", "plain", "empty"],
)
def test_unsound_gzip_is_a_sentence(tmp_path, data, code):
    (tmp_path / "w.grid.gz").write_bytes(data)
    with raises(FormatError, code):
        read_world(tmp_path / "w.grid.gz")


@pytest.mark.gate
def test_a_gzip_bomb_is_stopped(tmp_path):
    bomb = gzip.compress(b"." * (EXPANSION_FLOOR + 1), 9)
    (tmp_path / "w.grid.gz").write_bytes(bomb)
    with raises(FormatError, "too-large", most=EXPANSION_FLOOR):
        read_world(tmp_path / "w.grid.gz")


def test_what_reading_would_refuse_as_a_bomb_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(disk, "EXPANSION_FLOOR", 1000)
    monkeypatch.setattr(disk, "EXPANSION_RATIO", 10)
    with raises(OutputError, "packed-too-tightly"):
        write_world(small(walls=np.zeros((200, 200), bool)), tmp_path / "w.grid.gz")


def test_a_file_beyond_the_limit_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(disk, "MAX_FILE_BYTES", 100)
    with raises(OutputError, "too-large", most=100):
        write_world(everything(), tmp_path / "w.grid")


def test_a_world_of_2000_cells_a_side_survives():
    walls = np.arange(4_000_000).reshape(2000, 2000) % 7 == 0
    assert np.array_equal(loads(dumps(small(walls=walls))).walls, walls)


@pytest.mark.gate
def test_many_events_and_points_survive_in_pieces():
    count = 120_000  # 2.5 MB of lines, more than one piece
    times = np.arange(count) / 7
    line = Timeline(times, np.arange(count) % 3, np.arange(count) % 2, np.arange(count) % 3)
    world = small(timeline=line, certificate=Witness(times, times, -times, 0.1))
    assert loads(dumps(world)) == world
