"""MovingAI maps and scenarios: the meaning of each character, and the code of each error."""

import importlib.resources

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop import ImportedRobot, import_world, read_map, read_scenario
from worldgen.interop.formats.movingai import read_movingai

MAPS = importlib.resources.files("corpora") / "maps"
MAZE, PROBLEMS = MAPS / "maze-32-32-2.map", MAPS / "maze-32-32-2-even-1.scen"


def text_map(*rows, kind="octile", height=None, width=None, end="\n"):
    lines = [
        f"type {kind}",
        f"height {height or len(rows)}",
        f"width {width or len(rows[0])}",
        "map",
        *rows,
    ]
    return "".join(line + end for line in lines).encode()


@pytest.fixture
def write(tmp_path):
    def write_file(data, name="a.map"):
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write_file


def rows_of(found):
    """Return the map as drawn in the file, top row first, # solid."""
    return ["".join("#" if solid else "." for solid in row) for row in found.walls[::-1]]


@pytest.mark.parametrize(
    ("character", "solid"), [*((c, False) for c in ".GS"), *((c, True) for c in "@OTW")]
)
def test_each_character_is_free_or_solid(write, character, solid):
    assert read_movingai(write(text_map(f".{character}"))).walls.tolist() == [[False, solid]]


def test_the_first_row_of_the_file_is_the_highest(write):
    found = read_movingai(write(text_map("@@.", "...")))
    assert found.walls.tolist() == [[False, False, False], [True, True, False]]


def test_height_comes_before_width(write):
    assert read_movingai(write(text_map("...", "..@"))).walls.shape == (2, 3)


def test_line_ends_of_windows_give_the_same_map(write):
    rows = ("@.T", ".W.")
    unix, windows = write(text_map(*rows), "u.map"), write(text_map(*rows, end="\r\n"), "w.map")
    assert np.array_equal(read_movingai(unix).walls, read_movingai(windows).walls)


def test_the_last_line_needs_no_line_end_and_blank_lines_may_follow(write):
    plain = text_map("@.", ".@")
    for data in (plain.rstrip(b"\n"), plain + b"\n\n"):
        assert rows_of(read_movingai(write(data))) == ["#.", ".#"]


@given(
    st.integers(1, 12).flatmap(
        lambda n: st.lists(st.text(".GS@OTW", min_size=n, max_size=n), min_size=1, max_size=9)
    )
)
def test_any_rows_come_back_as_they_were_drawn(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("maps") / "a.map"
    path.write_bytes(text_map(*rows))
    drawn = [row.translate(str.maketrans(".GS@OTW", "...####")) for row in rows]
    assert rows_of(read_movingai(path)) == drawn


FAULTS = [
    (b"", 1, {"code": "wrong-form", "came": "the end of the file"}),
    (b"octile\nheight 1\nwidth 1\nmap\n.\n", 1, {"code": "wrong-form", "came": "'octile'"}),
    (b"\xff\xfe\x00garbage", 1, {"code": "wrong-form"}),
    (text_map("..", kind="octile-corner"), 1, {"code": "unsupported"}),
    (text_map("..", kind="tile"), 1, {"code": "unsupported", "kind": "tile"}),
    (b"type octile\nwidth 2\nwidth 2\nmap\n..\n", 3, {"code": "wrong-form", "came": "'width 2'"}),
    (text_map("..", height="two"), 2, {"code": "not-a-number", "key": "height", "word": "two"}),
    (text_map("..", height="-1"), 2, {"code": "not-a-number", "key": "height", "word": "-1"}),
    (text_map("..", height="9" * 400), 2, {"code": "not-a-number", "key": "height"}),
    (text_map("..", height="99999999"), 3, {"code": "wrong-size", "max_side": 20000}),
    (text_map("..", width="20001"), 3, {"code": "wrong-size", "height": 1, "max_side": 20000}),
    (
        text_map("..", width="20000", height="20000"),
        3,
        {"code": "wrong-size", "max_cells": 64000000},
    ),
    (b"type octile\nheight 1\nwidth 2\n..\n", 4, {"code": "wrong-form", "came": "'..'"}),
    (b"type octile\nheight 1\nwidth 2", 4, {"code": "wrong-form", "came": "the end of the file"}),
    (b"type octile\nheight 1\nwidth 2\nmap", 5, {"code": "wrong-size", "height": 1}),
    (text_map("..", "..", height=3), 7, {"code": "wrong-size", "rows": 2, "height": 3}),
    (text_map("..", "..", height=1), 6, {"code": "wrong-size", "height": 1}),
    (text_map("..", "."), 6, {"code": "ragged-rows", "cells": 1, "width": 2}),
    (text_map("..", "..."), 6, {"code": "ragged-rows", "cells": 3, "width": 2}),
    (text_map("..", "", ".."), 6, {"code": "ragged-rows"}),
    (text_map("..", ".x"), 6, {"code": "unknown-sign", "sign": "x", "column": 2}),
    (text_map("..", ".#"), 6, {"code": "unknown-sign", "sign": "#", "column": 2}),
    (text_map("..", "s."), 6, {"code": "unknown-sign", "sign": "s", "column": 1}),
    (text_map("..", ".\xe9"), 6, {"code": "unknown-sign", "column": 2}),
]


@pytest.mark.parametrize(("data", "line", "expected"), FAULTS, ids=range(len(FAULTS)))
def test_a_fault_is_named_with_its_line(write, data, line, expected):
    with raises(FormatError, **expected) as caught:
        read_movingai(write(data))
    assert caught.value.line == line


@given(st.binary(max_size=200))
def test_any_bytes_give_a_map_or_a_fault_with_a_line(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("maps") / "a.map"
    path.write_bytes(b"type octile\nheight 2\nwidth 2\nmap\n" + data)
    try:
        assert read_movingai(path).walls.shape == (2, 2)
    except FormatError as error:
        assert error.line is not None


def test_a_missing_file_is_named(tmp_path):
    with raises(FormatError, "no-such-file"):
        read_map(tmp_path / "none.map")


def test_a_scenario_gives_cell_centres_with_y_up():
    problem = read_scenario(PROBLEMS, 1, 32, 32, 0.5)
    assert (problem.start, problem.goal) == ((8.75, 5.25), (7.75, 7.75))
    assert (problem.optimal, problem.map_name) == (13.82842712, "maze-32-32-2.map")


@pytest.mark.parametrize("version", [b"version 1", b"version 1.0", b"version 1.2"])
def test_scenario_fields_may_be_parted_by_spaces(write, version):
    path = write(version + b"\r\n0 maps/dao/a.map 4 3 1 0 2 2 2.41\r\n", "a.scen")
    assert read_scenario(path, 1, 4, 3, 1.0).start == (1.5, 2.5)


def test_tabs_part_fields_even_where_a_name_has_a_space(write):
    path = write(b"version 1\n0\tmy maps/a.map\t4\t3\t1\t0\t2\t2\t2.41\n", "a.scen")
    assert read_scenario(path, 1, 4, 3, 1.0).map_name == "my maps/a.map"


SCENARIO_FAULTS = [
    (b"", 1, {"code": "wrong-form"}),
    (b"version 2\n0 a 4 3 0 0 1 1 1\n", 1, {"code": "wrong-form", "came": "version 2"}),
    (b"version 1\n", None, {"code": "out-of-range", "row": 1}),
    (
        b"version 1\n0 a 3 4 0 0 1 1 1\n",
        2,
        {"code": "wrong-size", "problem_width": 3, "problem_height": 4, "width": 4},
    ),
    (b"version 1\n0 a 4 3 4 0 1 1 1\n", 2, {"code": "outside-grid", "column": 4, "width": 4}),
    (
        b"version 1\n0 a 4 3 0 0 1 3 1\n",
        2,
        {"code": "outside-grid", "column": 1, "row": 3, "height": 3},
    ),
    (b"version 1\n0 a 4 3 0 0 1 1\n", 2, {"code": "wrong-form"}),
    (b"version 1\n0 a 4 3 0 0 1 -1 1\n", 2, {"code": "wrong-form"}),
    (b"version 1\n0 a 4 3 0 0 1 1 nan\n", 2, {"code": "wrong-form"}),
    (b"version 1\n" + b"9" * 100_000 + b"\n", 2, {"code": "wrong-form"}),
]


@pytest.mark.parametrize(
    ("data", "line", "expected"), SCENARIO_FAULTS, ids=range(len(SCENARIO_FAULTS))
)
def test_a_scenario_fault_is_named_with_its_line(write, data, line, expected):
    with raises(FormatError, **expected) as caught:
        read_scenario(write(data, "a.scen"), 1, 4, 3, 1.0)
    assert caught.value.line == line


def test_scenario_rows_count_from_one(write):
    with raises(InvalidParameter, "out-of-range", name="row", low=1):
        read_scenario(PROBLEMS, 0, 32, 32, 1.0)


@pytest.mark.parametrize("row", [1, 77, 153, 230])
def test_the_benchmarks_problems_are_reachable_by_a_path_no_longer_than_its_own(row):
    robot = ImportedRobot(scenario=PROBLEMS, row=row, radius=0.05)
    imported = import_world(MAZE, robot)
    optimal = imported.world.provenance.params["optimal"] * imported.world.cell_size
    assert imported.decision.result == "reachable"
    assert 0.9 * optimal < imported.world.certificate.length <= optimal + 1e-8
