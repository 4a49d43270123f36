"""Damaged files are passed to the cores.

Every file that can be read is decided and run, without any memory error. The gate and the nightly
tier run this with the cores compiled under sanitizers, too.
"""

import contextlib
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import corpora
from sim import simulate, simulate_many
from sim.scenario import Scenario
from tests.helpers.damages import damages
from worldgen.errors import WorldgenError
from worldgen.files.grid import read_world
from worldgen.reach import decide, decide_in_time

FILES = sorted(Path(corpora.__file__).parent.rglob("*.grid"))[::7]
SCENARIOS = (
    "turn-right",
    "bug2+motion=endpoint",
    "turn-left+motion=stepped",
    "vfh",
    "mapper+odometry_noise=0.1",
)
STEPS = 200
MOST_CELLS = 40_000


def read_and_use(file, scenario):
    """Do with a file what commands do; a refusal must be one of our own errors."""
    try:
        world = read_world(file)
    except WorldgenError:
        return False
    if world.walls.size > MOST_CELLS:
        return False
    bare = replace(world, certificate=None, failure=None)
    for use in (decide, decide_in_time):
        with contextlib.suppress(WorldgenError):
            use(bare)
    try:
        parsed = Scenario.parse(scenario)
        options = parsed.options(bare, STEPS)
        simulate(bare, parsed.controller, options)
        simulate_many(bare, parsed.controller, seeds=2, steps=STEPS, motion=parsed.run.motion)
    except WorldgenError:
        return False
    return True


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("damaged")


def test_worlds_that_are_not_damaged_are_used(folder):
    assert all(read_and_use(file, SCENARIOS[0]) for file in FILES[:3])


@given(
    st.sampled_from(FILES), st.lists(damages(), min_size=1, max_size=3), st.sampled_from(SCENARIOS)
)
def test_a_damaged_world_is_refused_or_used(folder, file, ways, scenario):
    data = file.read_bytes()
    for way in ways:
        data = way(data)
    damaged = folder / "w.grid"
    damaged.write_bytes(data)
    read_and_use(damaged, scenario)
