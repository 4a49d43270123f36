"""Maps of POGEMA, MiniGrid, micromouse contests and PointMaze.

Writing, reading, and each error.
"""

import json
import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld
from worldgen.generation import generate
from worldgen.interop import export_world, find_format, import_world, read_map, write_export
from worldgen.world import Pose

ROOM = "#####\n#S.G#\n#..##\n#####"
POGEMA = "#####\n#a.A#\n#..##\n#####\n"
MINIGRID = "WGWGWGWGWG\nWG>>  GGWG\nWG    WGWG\nWGWGWGWGWG\n"
MOUSE = "o---o---o\n| S   G |\no   o---o\n|       |\no---o---o\n"


def small_maze():
    return drawn("#####\n#S.G#\n#.###\n#...#\n#####", radius=0.04)


@pytest.fixture
def write(tmp_path):
    def write_file(text, name="m.txt"):
        (tmp_path / name).write_bytes(text.encode())
        return tmp_path / name

    return write_file


def rows_of(found):
    return ["".join(".#"[int(solid)] for solid in row) for row in found.walls[::-1]]


@pytest.mark.parametrize(
    ("name", "world", "text"),
    [
        ("pogema", drawn(ROOM), POGEMA),
        ("minigrid", drawn(ROOM), MINIGRID),
        ("micromouse", small_maze(), MOUSE),
    ],
)
def test_each_is_drawn_in_its_own_letters(name, world, text):
    assert export_world(world, name).data.decode() == text


@pytest.mark.parametrize(
    ("name", "text"), [("pogema", POGEMA), ("minigrid", MINIGRID), ("micromouse", MOUSE)]
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_each_is_told_from_a_drawing_and_read(write, name, text, end):
    path = write(text.replace("\n", end))
    assert find_format(path).name == name
    found = read_map(path)
    assert rows_of(found)[1][1:3] == ".." and found.walls.shape == (text.count("\n"), 5)
    assert found.robot.start[:2] == (0.15, pytest.approx(0.1 * text.count("\n") - 0.15))
    assert found.robot.target[0] == pytest.approx(0.35)


def test_pogemas_at_sign_is_free(write):
    found = read_map(write("  #####\n  #a@$#\n\n  #A!.#\n  #####  \n"))
    assert rows_of(found) == ["#####", "#...#", "#...#", "#####"]


def test_another_agent_can_be_the_robot(write):
    path = write("a.bB\nA...\n")
    assert read_map(path).robot.start == (0.05, pytest.approx(0.15))
    other = read_map(path, "pogema+agent=b")
    assert other.robot.start[0] == pytest.approx(0.25) and "agent b of 2" in other.notes[0]
    with raises(FormatError, "unknown-name", agent="c"):
        read_map(path, "pogema+agent=c")


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("#a#\n#A\n", 2, {"code": "ragged-rows", "cells": 2, "width": 3}),
        ("#a#\n\n#0A\n", 3, {"code": "unknown-sign", "sign": "0", "column": 2}),
        ("#a.\n#aA\n", 2, {"code": "twice", "letter": "a"}),
    ],
)
def test_a_fault_in_a_pogema_map_has_its_line(write, text, line, expected):
    with raises(FormatError, **expected) as caught:
        read_map(write(text), "pogema")
    assert caught.value.line == line


def test_start_and_target_in_one_cell_or_a_wall_are_left_to_the_sidecar():
    export = export_world(replace(drawn(ROOM), start=Pose(0.35, 0.25)), "pogema")
    assert export.data == POGEMA.replace("a", ".").replace("A", ".").encode()
    assert "start and target are not drawn, because they are the same cell" in export.lost


@pytest.mark.parametrize(
    ("word", "heading"), [(">>", 0.0), ("VV", -math.pi / 2), ("<<", math.pi), ("^^", math.pi / 2)]
)
def test_the_agents_direction_is_the_heading(write, word, heading):
    assert read_map(write(MINIGRID.replace(">>", word))).robot.start[2] == heading
    world = replace(drawn(ROOM), start=Pose(0.15, 0.25, heading))
    assert word in export_world(world, "minigrid").data.decode().splitlines()[1]


def test_doors_things_and_lava_of_minigrid(write):
    path = write("WGWGWGWGWGWGWG\nWG__DRLYKBVRWB\nWGWGWGWGWGWGWG\n")
    assert rows_of(read_map(path))[1] == "#...###"
    assert rows_of(read_map(path, "minigrid+doors=solid+things=free"))[1] == "#.##.##"
    assert "2 cells are closed doors; they count as free" in read_map(path).notes[0]


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("WGWG\nWGXX\n", 2, {"code": "unknown-sign", "sign": "XX", "column": 3}),
        ("WGWG\n>><<\n", 2, {"code": "twice", "agents": 2}),
    ],
)
def test_a_fault_in_a_minigrid_has_its_line(write, text, line, expected):
    with raises(FormatError, **expected) as caught:
        read_map(write(text), "minigrid")
    assert caught.value.line == line


def test_blanks_that_an_editor_took_away_are_no_fault(write):
    assert rows_of(read_map(write("WGWGWG\nWG\nWGWGWG\n"), "minigrid"))[1] == "#.."
    assert (
        rows_of(read_map(write(MOUSE.replace("| S   G |", "| S   G")), "micromouse"))[1] == "#...."
    )


def test_a_maze_comes_back_from_a_micromouse_file(tmp_path):
    world = generate("maze", 2, size=17, robot_radius=0.04)
    path = write_export(export_world(world, "micromouse"), tmp_path)[0]
    again = import_world(path).world
    assert (again.walls == world.walls).all() and (again.start, again.target) == (
        world.start,
        world.target,
    )


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ("######\n#S..G#\n######", {"code": "not-a-micromouse-maze", "width": 6, "height": 3}),
        ("#####\n#S.G#\n#...#\n#...#\n#####", {"code": "not-a-maze", "ix": 2, "iy": 2}),
        ("#####\n#S..#\n###.#\n#G###\n#####", {"code": "not-a-maze", "ix": 3, "iy": 1}),
    ],
)
def test_a_world_that_is_no_micromouse_maze_is_refused(rows, expected):
    with raises(InvalidWorld, **expected):
        export_world(drawn(rows), "micromouse")


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        (
            MOUSE.replace("o   o---o", "o   x---o"),
            3,
            {"code": "wrong-form", "came": "x", "column": 5},
        ),
        (
            MOUSE.replace("o   o---o", "o - o---o"),
            3,
            {"code": "wrong-form", "came": " - ", "column": 2},
        ),
        (MOUSE.replace(" S ", " X "), 2, {"code": "wrong-form", "came": " X ", "column": 2}),
        (MOUSE.replace(" G ", " S "), 2, {"code": "twice", "starts": 2}),
        ("o---o\n|   |\n", None, {"code": "wrong-size", "rows": 2}),
    ],
)
def test_a_fault_in_a_micromouse_maze_has_its_line(write, text, line, expected):
    with raises(FormatError, **expected) as caught:
        read_map(write(text), "micromouse")
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("name", "text"), [("pogema", POGEMA), ("minigrid", MINIGRID), ("micromouse", MOUSE)]
)
@given(
    st.lists(
        st.tuples(st.integers(0, 60), st.sampled_from("#.aAbB@WG>oV-| S\n\r0é"), st.booleans()),
        max_size=5,
    )
)
def test_any_text_gives_a_map_or_a_fault_in_one_line(tmp_path, name, text, edits):
    for at, letter, instead in edits:
        text = text[:at] + letter + text[at + instead :]
    (tmp_path / "m.txt").write_bytes(text.encode())
    try:
        found = read_map(tmp_path / "m.txt", name)
    except (FormatError, InvalidParameter) as error:
        assert "m.txt" in str(error) and "\n" not in str(error)
    else:
        assert found.robot.start is None or 0 < found.robot.start[0] < 0.1 * found.walls.shape[1]


def test_a_maze_map_is_a_list_of_rows_with_a_wall_all_round():
    assert json.loads(export_world(drawn(ROOM), "pointmaze").data)[1] == [1, "r", 0, "g", 1]
    assert json.loads(export_world(drawn("S.G"), "pointmaze").data) == [
        [1] * 5,
        [1, "r", 0, "g", 1],
        [1] * 5,
    ]
