"""Pieces: operations that undo each other, and combinations of two pieces."""

import dataclasses
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.pieces import pieces, states_at
from tests.helpers.raising import raises
from worldgen.compose import Piece, drawn, of_family, of_world, read, rectangle
from worldgen.compose.marks import Mark
from worldgen.errors import InvalidParameter
from worldgen.files.grid import write_world
from worldgen.generation import generate
from worldgen.lattice import TURN

HOW = ("over", "union", "intersection", "carve")
TIMES = (0.0, 0.7, 1.0, 9.0)
FREE, SOLID, BURNING, SILENT = range(4)


@given(pieces(), st.integers(-9, 9))
def test_four_quarter_turns_change_nothing(piece, first):
    assert piece.rotate(first).rotate(4 - first) == piece


@given(pieces(), st.sampled_from("xy"))
def test_two_mirrors_change_nothing(piece, axis):
    assert piece.mirror(axis).mirror(axis) == piece


@given(pieces())
def test_both_mirrors_are_half_a_turn(piece):
    assert piece.mirror("x").mirror("y") == piece.rotate(2)


@given(
    pieces(),
    pieces(),
    st.integers(-8, 8),
    st.integers(-8, 8),
    st.sampled_from(HOW),
    st.sampled_from("xy"),
)
def test_placing_commutes_with_mirroring(host, piece, x, y, how, axis):
    placed = host.place(piece, at=(x, y), how=how, outside="clip").mirror(axis)
    mirrored = (
        (host.width - x - piece.width, y) if axis == "x" else (x, host.height - y - piece.height)
    )
    assert (
        host.mirror(axis).place(piece.mirror(axis), at=mirrored, how=how, outside="clip") == placed
    )


@given(pieces(), pieces(), st.integers(-8, 8), st.integers(-8, 8), st.sampled_from(HOW))
def test_placing_commutes_with_turning(host, piece, x, y, how):
    placed = host.place(piece, at=(x, y), how=how, outside="clip").rotate(1)
    turned = (host.height - y - piece.height, x)
    assert host.rotate(1).place(piece.rotate(1), at=turned, how=how, outside="clip") == placed


def together(host, piece, how):
    """The documented rule for one cell at one time."""
    if piece == SILENT or (host == SILENT and how == "carve"):
        return host
    if host == SILENT or how == "over":
        return piece
    if how == "carve":
        return FREE if piece == SOLID else host
    if how == "union":
        return max(host, piece, key=(FREE, BURNING, SOLID).index)
    return SOLID if host == piece == SOLID else BURNING if BURNING in (host, piece) else FREE


@given(pieces(), pieces(), st.integers(-4, 4), st.integers(-4, 4), st.sampled_from(HOW))
def test_cells_at_any_time_are_what_both_pieces_have_at_that_time(host, piece, x, y, how):
    placed = host.place(piece, at=(x, y), how=how, outside="clip")
    for time in TIMES:
        below, above_it = states_at(host, time), states_at(piece, time)
        for (iy, ix), state in np.ndenumerate(states_at(placed, time)):
            inside = 0 <= ix - x < piece.width and 0 <= iy - y < piece.height
            said = above_it[iy - y, ix - x] if inside else SILENT
            assert state == together(below[iy, ix], said, how)


@given(pieces(), st.integers(1, 3))
def test_what_a_border_adds_a_crop_takes_away(piece, cells):
    bordered = piece.border(cells)
    assert bordered.crop(cells, cells, piece.width, piece.height) == piece
    assert bordered.solid.sum() - piece.solid.sum() == bordered.solid.size - piece.solid.size


def test_turning_is_counter_clockwise_for_cells_marks_and_headings():
    turned = drawn("S.#").with_start(0.5, 0.5, degrees=0).rotate(1)
    assert turned.solid[:, 0].tolist() == [False, False, True]
    start = turned.marks["start"]
    assert (start.x, start.y, start.heading) == (0.5, 0.5, TURN // 4)


def test_a_mirrored_heading_looks_the_other_way():
    piece = rectangle(4, 2).with_start(1, 1, degrees=30)
    assert (
        piece.mirror("x").marks["start"].heading
        == piece.with_start(1, 1, degrees=150).marks["start"].heading
    )
    assert (
        piece.mirror("y").marks["start"].heading
        == piece.with_start(1, 1, degrees=-30).marks["start"].heading
    )


def test_a_piece_cannot_be_changed():
    piece = drawn("#.\n.S")
    with pytest.raises(ValueError, match="read-only"):
        piece.solid[0, 0] = False
    with pytest.raises(TypeError, match="item assignment"):
        piece.marks["a"] = piece.marks["start"]


def test_a_world_goes_through_a_piece_unchanged():
    for name in ("trap", "fire", "shift"):
        world = generate(name, 3)
        made = of_world(world).layout()
        assert (
            dataclasses.replace(world, certificate=None, provenance=None, timeline=made.timeline)
            == made
        )
        assert of_world(made) == of_world(world)


def test_start_and_target_are_the_hosts_unless_said_otherwise():
    host, piece = drawn("S..G"), drawn("GS")
    assert host.place(piece).marks == host.marks
    assert host.place(piece, start="piece").marks["start"].x == 1.5
    assert drawn("...G").place(piece).marks["start"].x == 1.5


def marked(piece, name, x, y):
    return dataclasses.replace(piece, marks={**piece.marks, name: Mark(Fraction(x), Fraction(y))})


@pytest.mark.parametrize(
    ("where", "corner"),
    [
        ("lower-left", (1, 1)),
        ("upper-right", (5, 4)),
        ("centre", (3, 2)),
        ("left", (1, 2)),
        ("b", (4, 3)),
    ],
)
def test_a_word_says_where_a_piece_goes(where, corner):
    host = marked(rectangle(8, 6), "b", 5, 3)
    assert host.place(rectangle(2, 1, solid=True), at=where) == host.place(
        rectangle(2, 1, solid=True), at=corner
    )


@pytest.mark.parametrize(
    ("where", "anchor", "corner"),
    [
        ((4, 3), "centre", (3, 3)),
        ((6.5, 2), "upper-right", (5, 1)),
        ("b", "lower-left", (5, 3)),
        ((3, 3), "a", (2, 3)),
    ],
)
def test_an_anchor_says_what_of_the_piece_goes_there(where, anchor, corner):
    host, piece = (
        marked(rectangle(8, 6), "b", 5, 3),
        marked(rectangle(2, 1, solid=True), "a", 1, 0),
    )
    assert host.place(piece, at=where, anchor=anchor) == host.place(piece, at=corner)


def test_a_piece_keeps_clear_of_the_sides_and_of_start_and_target_wherever_it_is_drawn():
    host = of_family("rooms", 2, size=24)
    block = rectangle(5, 5, solid=True)
    for seed in range(20):
        placed = host.place(block, at="anywhere", seed=seed)
        assert placed.solid[0].all() and placed.layout().start == host.layout().start
        assert placed == host.place(block, at="anywhere", seed=seed)


def test_a_block_on_the_way_makes_the_way_another():
    host = rectangle(20, 20).border().with_start(2.5, 10.5).with_target(18.5, 10.5)
    for seed in range(8):
        world = host.place(rectangle(3, 3, solid=True), at="way", seed=seed).world()
        assert world.certificate.length > 1.6


def test_a_grid_file_becomes_the_piece_of_its_world(tmp_path):
    world = generate("fire", 4)
    write_world(world, tmp_path / "w.grid")
    assert read(tmp_path / "w.grid") == of_world(world)


def test_a_foreign_map_becomes_a_piece_without_start():
    piece = read("corpora/maps/maze-32-32-2.map")
    assert (piece.width, piece.height, dict(piece.marks)) == (32, 32, {})


WRONG = {
    "axis": (lambda p: p.mirror("z"), {"code": "unknown-name", "name": "mirror", "value": "z"}),
    "quarters": (lambda p: p.rotate(0.5), {"code": "not-a-number", "name": "rotate", "value": 0.5}),
    "crop": (
        lambda p: p.crop(2, 2, 4, 1),
        {"code": "outside-grid", "width": 4, "height": 1, "x": 2},
    ),
    "empty-crop": (lambda p: p.crop(0, 0, 0, 1), {"code": "not-a-number", "name": "crop width"}),
    "border": (lambda p: p.border(-1), {"code": "not-a-number", "name": "border", "value": -1}),
    "huge": (
        lambda p: p.border(3000),
        {"code": "too-large", "what": "border", "width": 6004, "height": 6003},
    ),
    "sticks-out": (
        lambda p: p.place(p, at=(1, 0)),
        {"code": "outside-grid", "width": 4, "height": 3, "x": 1},
    ),
    "how": (
        lambda p: p.place(p, how="under"),
        {"code": "unknown-name", "name": "how", "value": "under"},
    ),
    "word": (lambda p: p.place(p, at="middle"), {"code": "unknown-name", "at": "middle"}),
    "anchor": (
        lambda p: p.place(p, at=(0, 0), anchor="c"),
        {"code": "unknown-name", "anchor": "c"},
    ),
    "anchored": (
        lambda p: p.place(p, at="left", anchor="left"),
        {"code": "conflict", "anchor": "left", "at": "left"},
    ),
    "half": (
        lambda p: p.place(p, at=(0.5, 0)),
        {"code": "not-a-number", "name": "at x", "value": 0.5},
    ),
    "no-seed": (lambda p: p.place(p, at="anywhere"), {"code": "needs-seed", "at": "anywhere"}),
    "no-room": (
        lambda p: p.place(p, at="anywhere", seed=1),
        {"code": "no-room", "width": 4, "height": 3, "where": "anywhere"},
    ),
    "no-start": (lambda p: p.place(p, start="piece"), {"code": "missing-mark", "name": "start"}),
    "cell-sizes": (
        lambda p: dataclasses.replace(p, cell_size=0.1).place(
            dataclasses.replace(p, cell_size=0.2)
        ),
        {"code": "cell-sizes-differ", "host": 0.1, "piece": 0.2},
    ),
    "mark": (
        lambda p: p.with_start(4.5, 0),
        {"code": "outside-grid", "name": "start", "x": 4.5, "width": 4},
    ),
    "nan": (lambda p: p.with_start(float("nan"), 0), {"code": "not-a-number"}),
    "ragged": (lambda p: drawn("##\n#"), {"code": "ragged-rows", "row": 2, "signs": 1, "width": 2}),
    "sign": (lambda p: drawn("#?"), {"code": "unknown-sign", "row": 1, "sign": "?", "column": 2}),
    "twice": (lambda p: drawn("SS"), {"code": "twice", "row": 1, "sign": "S"}),
    "empty": (lambda p: drawn(""), {"code": "empty"}),
    "shape": (lambda p: Piece(np.zeros((2, 2)), np.zeros((3, 2))), {"code": "wrong-shape"}),
}


@pytest.mark.parametrize(("act", "expected"), WRONG.values(), ids=WRONG)
def test_what_makes_no_sense_is_refused_with_the_way_out(act, expected):
    with raises(InvalidParameter, **expected):
        act(rectangle(4, 3))
