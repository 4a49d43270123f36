"""Worlds as text: letters without colours, half blocks with them."""

import dataclasses
import io
import re

import numpy as np
import pytest

from worldgen.render import EventMark, Trail, draw_terminal, wants_color
from worldgen.render.marks import hue, rgb
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Pose, Robot, Target, World

ANSI = re.compile("\x1b\\[[0-9;]*m")


def tiny_world(**changes):
    walls = np.zeros((5, 8), bool)
    walls[0] = walls[-1] = walls[:, 0] = walls[:, -1] = True
    walls[1:3, 5] = True
    world = World(walls, Pose(0.15, 0.35), Target(0.65, 0.15, 0.05), robot_radius=0.04)
    return dataclasses.replace(world, **changes)


def test_a_tiny_world_is_the_letters_of_its_file():
    assert draw_terminal(tiny_world(), color=False, width=80).splitlines() == [
        "########",
        "#S.....#",
        "#....#.#",
        "#....#G#",
        "########",
        "S start  G target",
        "0.8 x 0.5 m, cell 0.1 m, robot radius 0.04 m; cell (0, 0) is at the bottom left",
    ]


def test_a_world_without_walls_around_it_has_a_frame():
    walls = np.zeros((2, 3), bool)
    walls[0, 0] = True
    world = World(walls, Pose(0.25, 0.05), Target(0.05, 0.15, 0.02), 0.1, robot_radius=0.04)
    assert draw_terminal(world, color=False, width=80).splitlines()[:4] == [
        "+---+",
        "|G..|",
        "|#.S|",
        "+---+",
    ]


def test_starts_and_targets_of_several_robots_are_numbered():
    # Robot 3 has its target where robot 1 starts, so only the start can be seen.
    second = Robot(Pose(0.35, 0.15), Target(0.15, 0.15, 0.05), 0.04)
    third = Robot(Pose(0.65, 0.35), Target(0.15, 0.35, 0.05), 0.04)
    picture = draw_terminal(
        tiny_world(robots=(tiny_world().robots[0], second, third)), color=False, width=80
    )
    assert picture.splitlines()[:6] == [
        "########",
        "#1....3#",
        "#....#.#",
        "#B.2.#A#",
        "########",
        "1-3 starts  A-B their targets",
    ]


def test_more_than_nine_robots_share_a_letter():
    walls = np.zeros((3, 25), bool)
    robots = [
        Robot(Pose(0.05 + 0.2 * column, 0.05), Target(0.05 + 0.2 * column, 0.25, 0.02), 0.04)
        for column in range(10)
    ]
    picture = draw_terminal(World(walls, robots=robots), color=False, width=80)
    assert picture.count("S") == 10 + 1 and "S start  G target" in picture


def test_trail_loop_and_tunnel_have_letters_of_their_own():
    trail = Trail(
        [0.15, 0.25, 0.25, 0.45, 0.45, 0.25],
        [0.35, 0.35, 0.25, 0.25, 0.15, 0.15],
        2,
        [EventMark(0.55, 0.25, "tunnel")],
    )
    assert draw_terminal(tiny_world(), trail=trail, color=False, width=80).splitlines()[:6] == [
        "########",
        "#S*....#",
        "#.ooo!.#",
        "#.ooo#G#",
        "########",
        "S start  G target  * trail  o loop  ! through a wall",
    ]


def test_cells_that_change_have_letters_and_words():
    events = [
        Event(1.0, 2, 2, CellState.BURNING),
        Event(1.0, 3, 2, CellState.SOLID),
        Event(1.0, 5, 1, CellState.FREE),
    ]
    lines = draw_terminal(
        tiny_world(timeline=Timeline.of(events)), color=False, width=80
    ).splitlines()
    assert lines[2:4] == ["#.^x.#.#", "#....-G#"]
    assert lines[5] == "S start  G target  x closes later  - opens later  ^ burns"


def test_a_large_world_is_scaled_down_and_says_so():
    walls = np.zeros((200, 200), bool)
    walls[:100, :100] = True
    walls[150, 150] = True
    text = draw_terminal(
        World(walls, Pose(19.0, 1.0), Target(1.0, 19.0, 0.05)), color=False, width=50
    )
    lines = text.splitlines()
    assert len(lines[0]) == 42
    assert len(lines) == 42 + 2
    assert lines[40 - 150 // 5][1 + 150 // 5] == "%"
    assert lines[40][:21] == "|" + "#" * 20
    assert lines[-1].endswith("; 1 character is 5 x 5 cells")
    assert "% partly solid" in lines[-2]


@pytest.mark.parametrize("color", [True, False])
@pytest.mark.parametrize("shape", [(1, 1), (3, 3), (10, 10), (61, 61), (10, 300), (2000, 7)])
def test_no_line_of_the_map_is_wider_than_asked_for(shape, color):
    text = draw_terminal(
        World(np.zeros(shape, bool), Pose(0.05, 0.05), Target(0.05, 0.05, 0.01)),
        width=40,
        color=color,
    )
    lines = [ANSI.sub("", line) for line in text.splitlines()[:-2]]
    assert len({len(line) for line in lines}) == 1
    assert len(lines[0]) <= 40
    assert len(lines) <= 100


def test_without_colour_there_is_nothing_but_ascii():
    draw_terminal(tiny_world(), trail=Trail([0.2, 0.4], [0.2, 0.2], 0), color=False).encode("ascii")


def test_with_colour_two_rows_share_a_line_and_every_line_ends_plain():
    world = World(np.zeros((61, 61), bool), Pose(1.0, 1.0), Target(2.0, 2.0, 0.05))
    lines = draw_terminal(world, width=61, truecolor=True).splitlines()[:-2]
    assert len(lines) == 31
    assert all(line.endswith("\x1b[0m") for line in lines)
    assert {ANSI.sub("", line) for line in lines} == {"\u2580" * 61}


def test_the_upper_half_of_a_character_is_the_upper_cell():
    walls = np.array([[False], [True]])
    world = World(walls, Pose(0.05, 0.05), Target(0.05, 0.05, 0.01), robot_radius=0.01)
    first = draw_terminal(world, width=8, truecolor=True).splitlines()[0]
    red, green, blue = rgb(hue("wall"))
    assert first.startswith(f"\x1b[38;2;{red};{green};{blue}m")


def test_256_colours_are_used_where_more_are_not_known():
    assert "38;2;" not in draw_terminal(tiny_world(), truecolor=False)
    assert "38;5;" in draw_terminal(tiny_world(), truecolor=False)


class Terminal(io.StringIO):
    def __init__(self, encoding="utf-8", tty=True):
        super().__init__()
        self._encoding, self._tty = encoding, tty

    @property
    def encoding(self):
        return self._encoding

    def isatty(self):
        return self._tty


@pytest.mark.parametrize(
    ("stream", "environment", "wanted"),
    [
        (Terminal(), {}, True),
        (Terminal(tty=False), {}, False),
        (Terminal(tty=False), {"FORCE_COLOR": "1"}, True),
        (Terminal(), {"NO_COLOR": "1"}, False),
        (Terminal(), {"NO_COLOR": "1", "FORCE_COLOR": "1"}, False),
        (Terminal(), {"TERM": "dumb"}, False),
        (Terminal(encoding="ascii"), {"FORCE_COLOR": "1"}, False),
    ],
)
def test_colour_is_for_terminals_that_can_show_it(monkeypatch, stream, environment, wanted):
    for name in ("NO_COLOR", "FORCE_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert wants_color(stream) is wanted


def test_a_cell_that_the_text_names_has_its_own_sign():
    trail = Trail([0.15], [0.35], named=((5, 2),))
    lines = draw_terminal(tiny_world(), trail=trail, color=False, width=80).splitlines()
    assert lines[1:4] == ["#S.....#", "#....?.#", "#....#G#"]
    assert "? cell named in the text" in lines[5]


def test_a_named_cell_is_filled_in_a_coloured_picture():
    yellow = "\x1b[38;2;240;228;66m"
    picture = draw_terminal(
        tiny_world(), trail=Trail([0.15], [0.35], named=((5, 2),)), width=80, truecolor=True
    )
    rows = [line for line in picture.splitlines()[:-2] if yellow in line]
    assert len(rows) > 1
    assert yellow not in draw_terminal(tiny_world(), width=80, truecolor=True)
