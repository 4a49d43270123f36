"""The mapping controller.

It arrives if its memory is large enough, and shows the effect of too little memory.
"""

from dataclasses import replace

import pytest

from sim import simulate
from sim.controllers.library.mapper import mapper, mapper_small, mapping
from tests.helpers.command_line import worldgen
from tests.helpers.drawn_worlds import drawn
from tests.helpers.interpreted import Interpreted
from tests.helpers.raising import raises
from worldgen import InvalidParameter, Target, generate


@pytest.mark.gate
@pytest.mark.parametrize("family", ["maze", "trap", "corridor"])
@pytest.mark.parametrize("time_step", [0.015, 0.15])
def test_it_reaches_every_target(family, time_step):
    for seed in range(8):
        world = generate(family, seed, size=20)
        assert simulate(world, mapper, time_step=time_step, steps=60_000).verdict == "reached", seed


def test_it_drives_the_shortest_way_where_nothing_is_in_the_way():
    world = drawn("......\n......\n.S....\n......\n....G.\n......", target_radius=0.005)
    assert simulate(world, mapper).path_length == pytest.approx(0.1 * (1 + 2 * 2**0.5), abs=0.03)


def test_a_target_off_its_grid_is_reached():
    world = drawn("........\n........\n.S......\n........\n....#...\n......G.\n........")
    assert simulate(replace(world, target=Target(0.637, 0.163, 0.001)), mapper).verdict == "reached"


@pytest.mark.nightly
def test_it_drives_round_a_target_that_is_walled_off_and_does_not_crash():
    world = drawn("S......\n.......\n..####.\n..#..#.\n..#.G#.\n..####.\n.......", radius=0.03)
    assert simulate(world, mapper, steps=20_000).verdict in ("loop", "stalled")


def test_who_keeps_too_far_from_walls_gets_through_in_the_end():
    timid = mapping("timid", 128, no_room=1.5)
    world = drawn("......\n.S....\n......\n###.##\n......\n....G.\n......", radius=0.045)
    assert simulate(world, timid, steps=50_000).verdict == "reached"


def test_it_need_not_try_what_a_touch_has_shown():
    blind = mapping("blind", 128, no_room=0.0)
    worlds = [generate("trap", seed, size=20) for seed in range(6)]
    feeling, trying = (
        sum(simulate(world, one).collisions for world in worlds) for one in (mapper, blind)
    )
    assert feeling < 0.7 * trying


def test_with_too_little_memory_it_goes_round_for_ever_where_more_is_enough():
    failing = [
        seed
        for seed in range(12)
        if simulate(generate("trap", seed, size=28), mapper_small).verdict == "loop"
    ]
    assert failing
    assert all(
        simulate(generate("trap", seed, size=28), mapper).verdict == "reached" for seed in failing
    )


@pytest.mark.parametrize("controller", [mapper, mapper_small], ids=lambda c: c.name)
def test_a_run_is_the_same_compiled_and_interpreted(controller):
    world = generate("trap", 3, size=16)
    runs = [simulate(world, one, steps=60) for one in (controller, Interpreted(controller))]
    assert runs[0].trace_digest == runs[1].trace_digest


def test_a_map_of_a_size_of_one_s_own_takes_a_number_for_each_dozen_of_nodes():
    assert (
        len(mapping("larger", 48).memory) - len(mapping("smaller", 24).memory)
        == (48 * 48 - 24 * 24) / 12
    )


@pytest.mark.parametrize(
    "size",
    [{"side": 4}, {"side": 5000}, {"side": 20, "pitch": 0.0}, {"side": 20, "no_room": -1.0}],
    ids=str,
)
def test_a_map_that_cannot_be_is_refused(size):
    with raises(InvalidParameter, "out-of-range"):
        mapping("bad", **size)


@pytest.mark.nightly
@pytest.mark.parametrize("time_step", [0.015, 0.06])
def test_a_campaign_finds_nothing_against_it(time_step, tmp_path):
    done = worldgen(
        "fuzz", "--controller", "sim.controllers.library.mapper:mapper", "--units", 4, "--seed", 1,
        "--family", "features", "--family", "maze", "--family", "trap", "--family", "corridor", "--examples", 200,
        "--time-step", time_step, "--workers", 1, "--no-shrink", "--out", tmp_path / "found",
    )  # fmt: skip
    assert done.code == 0, done.out
