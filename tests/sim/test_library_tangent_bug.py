"""TangentBug sees ahead, is quicker than bugs that do not, and fails where a disc does not fit."""

import pytest

from sim import simulate
from sim.controllers.library.bug2 import bug2
from sim.controllers.library.tangent_bug import BEAMS, tangent_bug
from tests.helpers.drawn_worlds import drawn
from tests.helpers.interpreted import Interpreted
from worldgen import generate

ISLAND = """
...........
.........G.
...........
...........
....###....
....###....
....###....
...........
.S.........
...........
"""


@pytest.mark.gate
def test_it_turns_aside_before_it_gets_to_an_island():
    seeing, touching = (simulate(drawn(ISLAND), one) for one in (tangent_bug, bug2))
    assert seeing.verdict == touching.verdict == "reached"
    assert (
        seeing.path_length < 0.9 * touching.path_length and seeing.collisions < touching.collisions
    )


def test_it_gets_out_of_traps():
    worlds = [generate("trap", seed, size=24) for seed in range(20)]
    assert [simulate(world, tangent_bug).verdict for world in worlds].count("reached") >= 19


@pytest.mark.gate
def test_it_reaches_the_end_of_nearly_every_corridor():
    verdicts = [
        simulate(generate("corridor", seed, size=20), tangent_bug).verdict for seed in range(20)
    ]
    assert verdicts.count("reached") >= 17


def test_it_takes_for_free_only_what_the_whole_of_it_can_drive():
    """A wall that is just out of sight stops a disc before the end of its range."""
    worlds = [generate("trap", seed, robot_radius=0.14) for seed in range(100, 108)]
    assert [simulate(world, tangent_bug).verdict for world in worlds] == ["reached"] * 8


def test_it_is_run_with_the_beams_that_it_needs():
    with_more = simulate(generate("trap", 1, size=24), tangent_bug, beams=2 * BEAMS)
    assert (
        with_more.trace_digest != simulate(generate("trap", 1, size=24), tangent_bug).trace_digest
    )


@pytest.mark.gate
@pytest.mark.parametrize("seed", [2, 3])
def test_a_run_is_the_same_compiled_and_interpreted(seed):
    world = generate("trap", seed, size=20)
    runs = [simulate(world, one, steps=40) for one in (tangent_bug, Interpreted(tangent_bug))]
    assert runs[0].trace_digest == runs[1].trace_digest
