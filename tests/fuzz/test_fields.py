"""Fields of a controller's class are varied in boundaries, counterfactuals and campaigns."""

import json
import math
from dataclasses import dataclass

import pytest

from fuzz.boundary import Subject, axis_of_field
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.layouts.variation import Variation, applied
from fuzz.overview import counterfactual
from fuzz.overview.counterfactual import Change, counterfactuals, describe_changes
from fuzz.shrink.run import shrink
from fuzz.simplicity import Case
from fuzz.triage.judging import failure_of
from fuzz.unit.constraint import _OF_A_ROBOT, Constraint
from sim import Command, Scenario
from sim.controllers.fields import OF_A_WORLD
from tests.helpers.command_line import worldgen
from tests.helpers.halls import hall
from tests.helpers.raising import raises
from worldgen import write_world
from worldgen.errors import InvalidParameter

HERE = "tests.fuzz.test_fields"


@dataclass(frozen=True)
class Robot:
    """Drives away from the target unless ``bias`` and ``eager`` are right; the rest is idle."""

    bias: float = 3.0
    away: float = -0.5
    offset: float = 0.0
    tries: int = 3
    eager: bool = False
    mode: str = "seek"
    robot_target_radius: float = 0.1
    speed: float = 2.0
    senses = ("heading", "target_heading")

    def reset(self):
        return ()

    def act(self, observation, memory):
        is_right = self.bias <= 2.0 or self.eager or self.tries >= 6 or self.offset >= 0.05
        turn = observation.target_heading - observation.heading
        turn += 0.0 if is_right or self.away > -0.3 else math.pi
        return Command(2.0, math.remainder(turn, math.tau) / 0.015), memory


@pytest.fixture(scope="module")
def failure():
    found = failure_of(proved_hall(), Scenario(f"{HERE}:Robot"))
    assert found is not None
    return found


def proved_hall():
    return certified(hall())


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("bias", (2.99, 3.0, 3.01)),
        ("away", (-0.501, -0.5, -0.499)),
        ("offset", (-0.01, 0.0, 0.01)),
        ("tries", (2, 3, 4)),
    ],
)
def test_an_axis_goes_through_the_values_around_a_fields_own(name, values):
    scenario = Scenario(f"{HERE}:Robot")
    axis = axis_of_field(scenario, name)
    subject = Subject(hall(), scenario)
    own = axis.index(subject)
    assert tuple(axis.value(own + step) for step in (-1, 0, 1)) == values
    changed = axis.at(subject, values[2]).scenario
    field = next(one for one in changed.fields if one.name == name)
    assert changed.value_of(field) == values[2]


def test_only_a_field_that_is_a_number_is_an_axis():
    with raises(InvalidParameter, "unknown-name", name="mode"):
        axis_of_field(Scenario(f"{HERE}:Robot"), "mode")


def test_a_field_named_like_an_axis_or_a_quantity_of_the_world_is_not_varied_under_that_name():
    assert _OF_A_ROBOT.keys() == OF_A_WORLD
    with pytest.raises(InvalidParameter) as refused:
        axis_of_field(Scenario(f"{HERE}:Robot"), "spede")
    assert str(refused.value).partition("it has ")[2].count("speed") == 1
    varied = Variation.parse("robot_target_radius=0.1,0.2", Scenario(f"{HERE}:Robot"))
    world, scenario = applied({varied.name: 0.2}, hall(), Scenario(f"{HERE}:Robot"))
    assert (world.target.radius, scenario) == (0.2, Scenario(f"{HERE}:Robot"))


def test_counterfactuals_name_the_nearest_value_of_each_field_that_helps(failure):
    found = counterfactuals(failure)
    fields = {one.value[0]: one.value[1] for one in found.changes if one.what == "field"}
    assert fields == {"bias": 2.0, "away": -0.299, "offset": 0.05, "tries": 6, "eager": True}
    assert "with bias 2 instead of 3" in found.describe()
    assert describe_changes([Change("field", ["eager", True], False)]) == (
        "arrives with eager True instead of False"
    )


def test_fields_do_not_use_up_the_steps_of_the_other_changes(failure, monkeypatch):
    monkeypatch.setattr(counterfactual, "_SHARE_OF_FIELDS", 0.0)
    found = counterfactuals(failure)
    assert not found.is_complete and found.runs > 20
    assert not [one for one in found.changes if one.what == "field"]


def test_boundary_varies_a_field(tmp_path):
    write_world(proved_hall(), tmp_path / "w.grid")
    command = ("boundary", tmp_path / "w.grid", "--controller", f"{HERE}:Robot")
    result = worldgen(*command, "--axis", "bias", "--json")
    stretches = json.loads(result.out)["stretches"]
    assert (stretches[0]["outcome"], stretches[0]["last"]) == ("arrives", 2.0)
    assert stretches[1]["outcome"] == "fails" and stretches[1]["first"] == 2.01
    result = worldgen(*command, "--axis", "tries", "--json")
    ends = [
        (one["outcome"], one["first"], one["last"]) for one in json.loads(result.out)["stretches"]
    ]
    assert ends == [("fails", 0.0, 5.0), ("arrives", 6.0, 35.0)]
    refused = worldgen(*command, "--axis", "bia")
    assert refused.error_code == "unknown-name"
    assert refused.err.splitlines()[-1].endswith("--axis bias")


def test_varied_fields_have_the_type_of_the_field_and_are_kept():
    scenario = Scenario(f"{HERE}:Robot")
    assert Variation.parse("tries=3,6", scenario).values == (3, 6)
    constraint = Constraint.of({"tries": (3, 6)})
    world = hall()
    assert constraint.allows(Case(world, scenario.with_option("tries", 6)))
    assert constraint.violated_by(Case(world, scenario.with_option("tries", 4))) == ("tries",)
    with raises(InvalidParameter, "not-a-number"):
        Variation.parse("tries=3.5", scenario)


@pytest.mark.gate
def test_a_campaign_varies_a_field_and_its_failures_replay(tmp_path):
    name = f"{HERE}:Robot"
    fuzz = ("fuzz", "--controller", name, "--vary", "tries=3,4", "--units", 2, "--seed", 1)
    worldgen(*fuzz, "--examples", 40, "--workers", 1, "--out", tmp_path / "out")
    files = sorted((tmp_path / "out").glob("*.grid"))
    failures = [Failure.read(file) for file in files]
    assert {one.record.controller for one in failures} <= {f"{name}+tries=3", f"{name}+tries=4"}
    assert files and worldgen("replay", *files).code == 0


def test_shrinking_keeps_the_fields(failure):
    named = failure_of(proved_hall(), Scenario(f"{HERE}:Robot+bias=2.5"))
    assert shrink(named).failure.record.controller == f"{HERE}:Robot+bias=2.5"
