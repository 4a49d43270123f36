"""Seeded faults: each has a small world in which it fails as expected and the controller without it arrives."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.fault_finding import controller_name, look_for, tells
from fuzz.faults import FAULTS
from sim import simulate
from sim.controllers import CONTROLLERS
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.grid_file import read_world

WORLDS = Path(__file__).parents[1] / "data" / "faults"


def test_there_are_at_least_twenty():
    assert len(FAULTS) >= 20


@pytest.mark.parametrize("name", FAULTS)
def test_it_fails_as_expected_where_the_controller_without_the_fault_arrives(name):
    fault, world = FAULTS[name], read_world(WORLDS / f"{name}.grid")
    options = RunOptions.of(world.failure.motion, world.failure.seed, world.failure.parameters)
    assert simulate(replace(world, failure=None), fault, options).verdict == fault.expected
    assert tells(fault, world)


@pytest.mark.parametrize("name", FAULTS)
def test_a_command_finds_it_by_its_name(name):
    assert CONTROLLERS.get(Scenario.parse(controller_name(FAULTS[name])).controller) is FAULTS[name]


@pytest.mark.parametrize("name", FAULTS)
def test_it_says_in_one_sentence_what_is_wrong(name):
    fault = FAULTS[name]
    assert fault.sentence.endswith(".") and "\n" not in fault.sentence and fault.expected and fault.base is not None


def test_a_campaign_finds_a_comparison_of_floats_for_equality():
    row, world = look_for(FAULTS["bug2-leaves-by-equality"], units=2, examples=60)
    assert row.found and row.solid_cells <= 4 and world.failure.verdict == "loop"
