"""Seeded faults: each has a small world in which it fails, and the faultless controller arrives."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.faults import FAULTS
from benchmarks.finding import Limits, Row, controller_name, look_for, removable_cells, tells
from benchmarks.finding_tables import tables
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.triage.judging import failure_of
from sim import simulate
from sim.controllers import CONTROLLERS
from sim.scenario import Scenario
from tests.helpers.tiers import some

WORLDS = Path(__file__).parents[1] / "data" / "faults"


def test_there_are_at_least_twenty():
    assert len(FAULTS) >= 20


@pytest.mark.nightly
@pytest.mark.parametrize("name", some(FAULTS, 4))
def test_it_fails_as_expected_where_the_controller_without_the_fault_arrives(name):
    fault, failure = FAULTS[name], Failure.read(WORLDS / f"{name}.grid")
    assert simulate(failure.world, fault, failure.options).verdict == fault.expected
    assert tells(fault, failure)


@pytest.mark.parametrize("name", some(FAULTS, 2))
def test_a_command_finds_it_by_its_name(name):
    assert CONTROLLERS.get(Scenario.parse(controller_name(FAULTS[name])).controller) is FAULTS[name]


@pytest.mark.parametrize("name", FAULTS)
def test_it_says_in_one_sentence_what_is_wrong(name):
    fault = FAULTS[name]
    assert (
        fault.sentence.endswith(".")
        and "\n" not in fault.sentence
        and fault.expected
        and fault.base is not None
    )


@pytest.mark.nightly
@pytest.mark.parametrize("searcher", some(["plan", "random", "genetic"]))
def test_searching_finds_a_comparison_of_floats_for_equality(searcher):
    row, failure = look_for(FAULTS["bug2-leaves-by-equality"], searcher, 1, Limits(200_000, 60.0))
    assert row.found and row.solid_cells[1] <= 4 and failure.verdict == "loop"
    assert row.one_minimal and row.removable == 0 and row.shrunk_tells


def test_brute_force_sees_what_shrinking_left():
    failure = Failure.read(WORLDS / "bug2-leaves-by-equality.grid")
    world = failure.world
    block = np.zeros((3, world.width), bool)
    block[1, 1] = True
    larger = failure_of(
        certified(replace(world, walls=np.vstack([world.walls, block]), certificate=None)),
        Scenario(failure.record.controller),
        steps=failure.options.steps,
    )
    assert removable_cells(failure) == 0 and removable_cells(larger) == 1


def test_the_table_compares_what_every_searcher_has_done():
    def row(fault, searcher, found):
        return asdict(
            Row(
                fault,
                searcher,
                1,
                Limits(1, 1.0),
                found,
                worlds=7,
                steps=70,
                seconds=0.1,
                wall_seconds=0.2,
            )
        )

    text = tables([row("a", "random", True), row("b", "random", True), row("a", "plan", False)])
    assert (
        "| `random` | 1 of 1 | 7 (7 to 7) |" in text and "| `plan` | 0 of 1 | - (- to -) |" in text
    )
    assert "| `a` | 7 | not found |" in text and "| `b` | 7 |  |" in text
