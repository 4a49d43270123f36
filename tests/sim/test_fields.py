"""The fields of a controller's class are options in its name."""

import json
from dataclasses import dataclass
from typing import Annotated, Literal

import pytest

from sim import Command, Scenario, simulate
from sim.controllers import CONTROLLERS
from sim.controllers.catalogue.renewal import as_loaded
from sim.controllers.fields import fields_of
from sim.scenario.unused import ineffective
from tests.helpers.command_line import worldgen
from tests.helpers.halls import hall
from tests.helpers.raising import raises
from worldgen import write_world
from worldgen.errors import InvalidParameter
from worldgen.parameters.bounds import Bounds

HERE = "tests.sim.test_fields"


class Still:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(), memory


@dataclass(frozen=True)
class Robot(Still):
    """Stand still.

    Args:
        lookahead: How far it looks, m.
    """

    lookahead: float = 1
    share: Annotated[float, Bounds(0, 1)] = 0.5
    turns: int = 3
    clockwise: bool = True
    mode: Literal["seek", "flee"] = "seek"
    beams: int = 9
    robot_target_radius: float = 0.1
    plan: tuple = ()
    _hidden: float = 0.0
    senses = ("bump",)
    name = "Robby"


class Sets(Still):
    gain = 0.5
    other = 0.5

    def reset(self):
        self.gain = 0.5
        return ()


@dataclass(frozen=True)
class Needs(Still):
    gain: float


@dataclass(frozen=True)
class Labelled(Still):
    label: str = "a"


@dataclass(frozen=True, slots=True)
class Slotted(Still):
    gain: float = 1.0


class Plain(Still):
    limit = 2.0

    def __init__(self, bias=0.5, *, wide: bool = False):
        self.bias = bias
        self.half = self.limit / 2
        self.wide = wide


class Stubborn(Still):
    limit = 2.0

    def __init__(self):
        self.limit = 3.0


class Picky(Still):
    def __init__(self, gain=1.0):
        if gain < 0:
            raise ValueError("gain is negative")


ROBOT = Robot()


def controller(name):
    return CONTROLLERS.get(f"{HERE}:{name}")


def test_fields_are_public_numbers_switches_and_words_outside_the_contract():
    assert {one.name: one.default for one in fields_of(Robot)} == {
        "lookahead": 1.0,
        "share": 0.5,
        "turns": 3,
        "clockwise": True,
        "mode": "seek",
    }
    assert fields_of(Robot)[0].help == "How far it looks, m."
    assert [one.name for one in fields_of(Plain)] == ["bias", "wide", "limit"]


def test_a_name_sets_fields():
    robot = controller("Robot+lookahead=0.25+clockwise=off+mode=flee")
    assert robot == Robot(lookahead=0.25, clockwise=False, mode="flee")
    assert controller("Robot") == Robot()
    assert controller("Slotted+gain=0.5").gain == 0.5


def test_an_attribute_of_the_class_is_set_before_its_init_reads_it():
    plain = controller("Plain+limit=5+wide")
    assert (plain.limit, plain.half, plain.wide) == (5.0, 2.5, True)
    assert Plain.limit == 2.0 and controller("Plain").half == 1.0


def test_a_controller_with_fields_is_the_same_object_until_its_file_is_loaded_again():
    assert controller("Robot+turns=4") is controller("Robot+turns=4")
    assert as_loaded(f"{HERE}:Robot+turns=4") is controller("Robot+turns=4")


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ("Robot+lookahead=far", "not-a-number"),
        ("Robot+turns=2.5", "not-a-number"),
        ("Robot+lookahead", "missing-value"),
        ("Robot+clockwise=maybe", "not-a-truth-value"),
        ("Robot+mode=sleep", "unknown-name"),
        ("Robot+share=2", "out-of-range"),
        ("Robot+senses=3", "option-reserved"),
        ("Robot+plan=3", "option-reserved"),
        ("Robot+act=3", "unknown-name"),
        ("Needs+gain=3", "code-failed"),
        ("Robot+robot_target_radius=3", "option-reserved"),
        ("ROBOT+lookahead=2", "unknown-name"),
        ("Stubborn+limit=5", "field-overwritten"),
        ("Picky+gain=-1", "code-failed"),
    ],
)
def test_a_wrong_field_is_refused(options, code):
    with pytest.raises(InvalidParameter) as refused:
        simulate(hall(), Scenario.parse(f"{HERE}:{options}").controller)
    assert refused.value.code == code
    assert "\n" not in str(refused.value)


def test_a_word_can_be_empty_and_a_parameter_without_a_default_is_named():
    scenario = Scenario.parse(f"{HERE}:Labelled+label=")
    assert CONTROLLERS.get(scenario.controller).label == ""
    assert [scenario.value_of(one) for one in scenario.fields] == [""]
    with pytest.raises(InvalidParameter, match=r"needs gain.*give each a default"):
        CONTROLLERS.get(f"{HERE}:Needs")


def test_a_misspelt_field_is_answered_with_all_fields_and_the_right_command(tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    refused = worldgen("run", tmp_path / "w.grid", "--controller", f"{HERE}:Robot+lookahed=0.2")
    assert refused.error_code == "unknown-name" and refused.code == 2
    assert "lookahead: float = 1.0, share: float = 0.5, turns: int = 3" in refused.err
    assert refused.err.splitlines()[-1].endswith(f"{HERE}:Robot+lookahead=0.2")


@pytest.mark.parametrize("name", ["lib:./mine.so:mine+lookahead=2", "cmd+lookahead=2:./mine"])
def test_only_a_class_has_fields(name, tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    refused = worldgen("run", tmp_path / "w.grid", "--controller", name)
    assert refused.error_code == "unknown-name" and len(refused.err.splitlines()) == 1


def test_an_option_of_the_run_wins_and_the_clash_is_named():
    scenario = Scenario.parse(f"{HERE}:Robot+beams=4+lookahead=2")
    assert scenario.run.robot.beams == 4 and scenario.controller == f"{HERE}:Robot+lookahead=2"
    (clash,) = [one for one in ineffective([scenario]) if "rename the field" in one]
    assert "the field beams" in clash and "keeps 9" in clash
    assert not [one for one in ineffective([Scenario(f"{HERE}:Robot")]) if "rename" in one]


def test_a_field_that_reset_sets_again_is_named():
    (sentence,) = ineffective([Scenario.parse(f"{HERE}:Sets+gain=2+other=2")])
    assert sentence.startswith("+gain has no effect: reset()") and "to 0.5" in sentence


def test_a_scenario_reads_and_changes_fields():
    scenario = Scenario.parse(f"{HERE}:Robot+lookahead=0.25+slip=0.1")
    changed = scenario.with_option("lookahead", 0.5).with_option("slip", 0.2)
    assert changed.controller == f"{HERE}:Robot+lookahead=0.5" and changed.run.robot.slip == 0.2
    assert [changed.value_of(one) for one in changed.fields] == [0.5, 0.5, 3, True, "seek"]
    assert Scenario.parse(changed.label()) == changed
    with raises(InvalidParameter, "unknown-name", name="nothing"):
        scenario.with_option("nothing", 1)


def test_the_list_of_controllers_names_the_fields_of_a_class():
    shown = worldgen("controllers", f"{HERE}:Plain").out
    assert shown.endswith("fields: bias: float = 0.5, wide: bool = False, limit: float = 2.0\n")
    (row,) = json.loads(worldgen("controllers", f"{HERE}:Plain", "--json").out)["controllers"]
    assert row["fields"] == {"bias": 0.5, "wide": False, "limit": 2.0}
    (row,) = json.loads(worldgen("controllers", "bug2", "--json").out)["controllers"]
    assert row["fields"] == {}
