"""Pieces: operations that undo each other, and placing one on another."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.pieces import pieces, states_at
from tests.helpers.raising import raises
from worldgen.compose import of_cells, of_family, of_world
from worldgen.errors import InvalidParameter
from worldgen.generation import generate
from worldgen.lattice import TURN

TIMES = (0.0, 0.7, 1.0, 9.0)


@given(pieces(), st.integers(-9, 9))
def test_four_quarter_turns_change_nothing(piece, first):
    assert piece.rotate(first).rotate(4 - first) == piece


@given(pieces(), st.sampled_from("xy"))
def test_two_mirrors_change_nothing(piece, axis):
    assert piece.mirror(axis).mirror(axis) == piece


@given(pieces())
def test_both_mirrors_are_half_a_turn(piece):
    assert piece.mirror("x").mirror("y") == piece.rotate(2)


@given(pieces(), st.integers(0, 3), st.integers(0, 3))
def test_placing_commutes_with_mirroring_and_turning(piece, left, below):
    host = of_cells(np.zeros((10, 10), bool))
    x, y = 10 - left - piece.width, 10 - below - piece.height
    assert host.place(piece, at=(left, below)).mirror("x") == host.place(
        piece.mirror("x"), at=(x, below)
    )
    assert host.place(piece, at=(left, below)).rotate(1) == host.place(
        piece.rotate(1), at=(y, left)
    )


@given(pieces(least=5), pieces(most=3), st.integers(0, 2), st.integers(0, 2))
def test_cells_at_any_time_are_the_piece_s_below_it_and_the_host_s_elsewhere(host, piece, x, y):
    placed = host.place(piece, at=(x, y))
    for time in TIMES:
        expected = states_at(host, time)
        expected[y : y + piece.height, x : x + piece.width] = states_at(piece, time)
        assert (states_at(placed, time) == expected).all()


@given(pieces(), st.integers(1, 3))
def test_what_a_border_adds_a_crop_takes_away(piece, cells):
    bordered = piece.border(cells)
    assert bordered.crop(cells, cells, piece.width, piece.height) == piece
    assert bordered.solid.sum() - piece.solid.sum() == bordered.solid.size - piece.solid.size


def test_turning_is_counter_clockwise_for_cells_start_and_heading():
    turned = of_cells([[False, False, True]]).with_start(0.5, 0.5, degrees=0).rotate(1)
    assert turned.solid[:, 0].tolist() == [False, False, True]
    assert (turned.start.x, turned.start.y, turned.start.heading) == (0.5, 0.5, TURN // 4)


def test_a_mirrored_heading_looks_the_other_way():
    piece = of_cells(np.zeros((2, 4), bool)).with_start(1, 1, degrees=30)
    assert (
        piece.mirror("x").start.heading == piece.with_start(1, 1, degrees=150).start.heading
        and piece.mirror("y").start.heading == piece.with_start(1, 1, degrees=-30).start.heading
    )


def test_a_piece_cannot_be_changed():
    cells = np.zeros((2, 2), bool)
    piece = of_cells(cells)
    cells[0, 0] = True
    assert not piece.solid.any()
    with pytest.raises(ValueError, match="read-only"):
        piece.solid[0, 0] = False


def test_a_world_goes_through_a_piece_unchanged():
    for name in ("trap", "fire", "shift"):
        world = generate(name, 3)
        made = of_world(world).layout()
        assert made.robots == world.robots and made.cell_size == world.cell_size
        assert (made.walls == world.walls).all()
        for time in (0.0, 5.0, world.timeline.last_time):
            assert (made.cells_at(time) == world.cells_at(time)).all()
        assert of_world(made) == of_world(world)


def test_start_and_target_are_the_hosts_if_it_has_them():
    host = of_cells(np.zeros((1, 4), bool)).with_target(3.5, 0.5)
    piece = of_cells(np.zeros((1, 2), bool)).with_start(1.5, 0.5).with_target(0.5, 0.5)
    placed = host.place(piece, at=(1, 0))
    assert placed.target == host.target and placed.start.x == 2.5


def test_a_word_says_where_a_piece_goes():
    host, block = of_cells(np.zeros((6, 8), bool)), of_cells([[True, True]])
    assert host.place(block, at="centre") == host.place(block, at=(3, 2))


def test_a_piece_on_the_way_keeps_clear_of_the_border_and_of_start_and_target():
    host = of_family("rooms", 2, size=24)
    block = of_cells(np.ones((5, 5), bool))
    for seed in range(8):
        placed = host.place(block, at="way", seed=seed)
        assert placed.solid[0].all() and placed.layout().start == host.layout().start
        assert placed == host.place(block, at="way", seed=seed)


def test_a_block_on_the_way_makes_the_way_another():
    host = of_cells(np.zeros((20, 20), bool)).border().with_start(2.5, 10.5).with_target(18.5, 10.5)
    for seed in range(8):
        world = host.place(of_cells(np.ones((3, 3), bool)), at="way", seed=seed).world()
        assert world.certificate.length > 1.6


WRONG = {
    "axis": (lambda p: p.mirror("z"), "unknown-name"),
    "quarters": (lambda p: p.rotate(0.5), "not-a-number"),
    "crop": (lambda p: p.crop(2, 2, 4, 1), "outside-grid"),
    "empty-crop": (lambda p: p.crop(0, 0, 0, 1), "not-a-number"),
    "border": (lambda p: p.border(-1), "not-a-number"),
    "huge": (lambda p: p.border(3000), "wrong-shape"),
    "sticks-out": (lambda p: p.place(p, at=(1, 0)), "outside-grid"),
    "word": (lambda p: p.place(p, at="{middle}"), "unknown-name"),
    "half": (lambda p: p.place(p, at=(0.5, 0)), "not-a-number"),
    "braces": (lambda p: p.place(p, at=("{0}", 0)), "not-a-number"),
    "no-seed": (lambda p: p.place(p, at="way"), "needs-seed"),
    "no-room": (lambda p: p.place(p, at="way", seed=1), "no-room"),
    "cell-sizes": (
        lambda p: of_cells(p.solid, cell_size=0.1).place(
            of_cells(p.solid, cell_size=0.2), at=(0, 0)
        ),
        "cell-sizes-differ",
    ),
    "start": (lambda p: p.with_start(4.5, 0), "outside-grid"),
    "radius": (lambda p: p.with_target(1, 1, radius=0), "not-positive"),
    "nan": (lambda p: p.with_start(float("nan"), 0), "not-a-number"),
    "shape": (lambda p: of_cells([True, False]), "wrong-shape"),
    "empty": (lambda p: of_cells(np.zeros((0, 2))), "wrong-shape"),
}


@pytest.mark.parametrize(("act", "code"), WRONG.values(), ids=WRONG)
def test_what_makes_no_sense_is_refused_with_the_way_out(act, code):
    with raises(InvalidParameter, code):
        act(of_cells(np.zeros((3, 4), bool)))


@pytest.mark.parametrize(
    "build",
    [
        pytest.param(lambda: of_cells([["#", "."]]), id="signs"),
        pytest.param(lambda: of_cells([[True], [True, False]]), id="ragged"),
        pytest.param(lambda: of_cells([[0, 0]]).place(of_cells([[1]]), at=(0, 0, 1)), id="three"),
        pytest.param(lambda: of_cells([[0, 0]]).place(of_cells([[1]]), at=5), id="no-pair"),
    ],
)
def test_what_is_no_piece_or_no_place_is_refused_with_a_sentence(build):
    with pytest.raises(InvalidParameter):
        build()


def test_numbers_of_numpy_are_numbers():
    piece = of_cells([[0, 0, 0]])
    assert piece.with_start(np.int64(2), 0) == piece.with_start(2, 0)
    assert piece.with_start(np.float32(0.5), 0) == piece.with_start(0.5, 0)
