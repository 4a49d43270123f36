"""Seeded faults as Python classes.

They run like their compiled functions, and campaigns find them just as quickly.
"""

import pytest

from benchmarks.faults import FAULTS
from benchmarks.faults_as_classes import look_for
from sim import simulate
from sim.controllers import CONTROLLERS
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate


@pytest.mark.gate
@pytest.mark.parametrize(
    "fault", ["bug1_keeps_the_last_place", "vfh_turn_sign", "q_learning_last_turn_lost"]
)
def test_a_fault_runs_the_same_compiled_and_interpreted(fault):
    world = generate("forest", 3)
    compiled = CONTROLLERS.get(f"benchmarks.as_classes:{fault}")
    plain = CONTROLLERS.get(f"tests.reference.fuzz.as_classes:{fault}")
    assert (
        simulate(world, compiled, steps=300).trace_digest
        == simulate(world, plain, steps=300).trace_digest
    )


def test_a_class_without_its_attribute_is_none_of_them():
    with raises(InvalidParameter, "unknown-name", attribute="no_such_fault"):
        CONTROLLERS.get("benchmarks.as_classes:no_such_fault")


@pytest.mark.nightly
@pytest.mark.parametrize("fault", FAULTS)
def test_a_campaign_finds_a_fault_brought_as_a_class_within_a_minute(fault):
    assert look_for(fault, "class", seconds=60.0).found
