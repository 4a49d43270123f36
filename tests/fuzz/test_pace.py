"""The pace of a controller: measured with a budget, usual without, and what it makes of a unit."""

import contextlib
import math
import sys
import time
from dataclasses import replace

import pytest

from fuzz.campaign.configure import configure, unstated_pace
from fuzz.campaign.store import Budget, begin, resume, with_stored_pace
from fuzz.campaign.store.fingerprint import config_of, fingerprint_of
from fuzz.failure import ShrinkState
from fuzz.overview.counterfactual import counterfactuals
from fuzz.overview.limits import seconds_to_conclude
from fuzz.search.native import unit_size_of
from fuzz.search.plan import Prices, prices_of
from fuzz.shrink.queue import shrunk_or_same
from fuzz.triage.judging import failure_of
from fuzz.unit.config import CampaignConfig
from fuzz.unit.options import CampaignOptions
from fuzz.unit.pace import Pace, usual_pace
from sim.controllers import CONTROLLERS, ProcessController
from sim.controllers.examples.python import Example
from sim.episode.try_out import step_times
from sim.scenario import Scenario
from tests.helpers.raising import raises
from worldgen import generate
from worldgen.errors import InvalidParameter

PYTHON = "sim.controllers.examples.python:Example"
HERE = "tests.fuzz.test_pace"


class Padded(Example):
    """Computes for two milliseconds in each step."""

    def act(self, observation, memory):
        end = time.process_time() + 0.002
        while time.process_time() < end:
            pass
        return super().act(observation, memory)


def sized(pace, controller=PYTHON):
    return unit_size_of(CampaignConfig(Scenario(controller), measured=pace))


def test_a_slow_step_is_measured():
    step, _ = step_times(Scenario(f"{HERE}:Padded"), at_most=10.0)
    assert step > 0.001


def test_with_a_budget_a_slow_controller_is_recorded_with_its_pace():
    options = CampaignOptions(controller=f"{HERE}:Padded")
    pace = configure(options, seed=1, seconds=30.0).measured
    assert pace is not None and pace.is_slow and len(f"{pace.step:g}") <= 6


@pytest.mark.parametrize("controller", ["bug2", "dynamic-window", PYTHON])
def test_a_controller_of_about_the_usual_pace_is_not_recorded(controller, monkeypatch):
    # What a clock says here depends on the machine.
    usual = usual_pace(CONTROLLERS.get(controller)).step
    measured = {}
    monkeypatch.setattr("fuzz.campaign.configure.step_times", lambda *_, **__: measured["times"])
    for times, is_recorded in ((3.9, False), (4.1, True)):
        measured["times"] = (times * usual + 1e-5, 1e-3)
        found = configure(CampaignOptions(controller=controller), seed=1, seconds=600.0).measured
        assert (found is not None) == is_recorded


def test_without_a_budget_no_clock_decides():
    assert configure(CampaignOptions(controller=f"{HERE}:Padded"), seed=1).measured is None


@pytest.mark.parametrize(
    ("controller", "pace", "is_mentioned"),
    [
        (f"{HERE}:Padded", None, True),
        (f"{HERE}:Padded", 2.0, False),
        (PYTHON, None, False),
        ("bug2", None, False),
    ],
)
def test_a_pace_is_mentioned_if_a_slow_class_has_none(controller, pace, is_mentioned):
    found = unstated_pace(configure(CampaignOptions(controller=controller, pace=pace), seed=1))
    assert (found is not None) == is_mentioned


def test_a_given_pace_is_not_measured():
    options = CampaignOptions(controller="bug2", pace=4.0)
    assert [configure(options, 1, seconds).measured for seconds in (None, 30.0)] == [
        Pace(0.004),
        Pace(0.004),
    ]


def test_a_stored_pace_is_read_back():
    config = CampaignConfig(Scenario(PYTHON), measured=Pace(0.004, 0.05))
    stored = fingerprint_of(config).configuration
    assert config_of(stored) == config
    assert fingerprint_of(config_of(stored)).configuration == stored


@pytest.mark.parametrize(
    "wrong", [{"step": -1.0, "reset": 0.0}, {"step": 1.0}, [1.0], {"step": "x", "reset": 0.0}]
)
def test_a_stored_pace_that_is_none_is_refused(wrong):
    stored = {**fingerprint_of(CampaignConfig(Scenario(PYTHON))).configuration, "measured": wrong}
    with pytest.raises((TypeError, ValueError, KeyError)):
        config_of(stored)


def test_units_of_the_usual_kinds_keep_their_size():
    quick, slow, python, vector, program = (
        sized(None, name)
        for name in (
            "bug2",
            "dynamic-window",
            PYTHON,
            "sim.controllers.examples.vector:Example",
            "cmd:true",
        )
    )
    assert (quick.one_in, quick.step, quick.beam) == (1, 1, 1)
    assert (slow.one_in, slow.step, slow.beam) == (8, 8, 8)
    assert (python.at_once, python.scene, python.step, python.proved) == (100, 16, 24, 8)
    assert (vector.at_once, vector.scene, vector.step, vector.proved) == (16_000, 1, 4, 8)
    assert (program.at_once, program.scene, program.step, program.proved) == (100, 160, 400, 4)
    assert prices_of(CampaignConfig(Scenario("bug2"))) == Prices()
    assert prices_of(CampaignConfig(Scenario(PYTHON))).proof == pytest.approx(80.0)


@pytest.mark.parametrize("pace", [Pace(0.001), Pace(0.01), Pace(1e-6, reset=0.08)])
def test_a_batch_of_a_slow_controller_takes_a_second_or_two(pace):
    assert sized(pace).at_once == 1 or sized(pace).at_once * pace.run <= 2.0


@pytest.mark.parametrize("pace", [-1.0, 0.0, "fast"])
def test_a_pace_that_is_no_time_is_refused(pace):
    with raises(InvalidParameter, "wrong-type" if pace == "fast" else "out-of-range"):
        CampaignOptions(controller="bug2", pace=pace)


def test_only_a_slow_controller_has_a_limit_on_what_shrinking_and_explaining_may_take():
    assert Pace(1e-6).steps_in(30.0) == math.inf
    assert Pace(0.01).steps_in(30.0) == 3000.0


def test_what_shrinking_a_programs_failure_may_take_includes_starting_its_runs():
    program = usual_pace(ProcessController([sys.executable]))
    assert not program.is_slow
    assert 30.0 / program.step > program.steps_in(30.0) > 100_000


def test_a_slow_controller_gets_seconds_for_natural_worlds_from_a_short_budget():
    quick, slow = (
        CampaignConfig(Scenario("turn-right"), measured=pace) for pace in (None, Pace(1e-3))
    )
    seconds = [
        [seconds_to_conclude(one, budget) for budget in (10, 20, 60)] for one in (quick, slow)
    ]
    assert seconds == [[1.5, 3.0, 9.0], [3.0, 6.0, 9.0]]


@pytest.mark.gate
def test_shrinking_that_ends_at_its_limit_of_steps_is_final_and_the_same_again():
    failure = failure_of(generate("trap", 7), Scenario("turn-right"))
    one, two = (shrunk_or_same(failure, most_steps=1.0) for _ in range(2))
    assert one.complete and one.failure.shrinking == ShrinkState.CUT_SHORT
    assert one.failure.world.solid_cells < failure.world.solid_cells
    assert one.failure.dumps() == two.failure.dumps()


def test_an_explanation_reports_how_far_it_is_and_ends_at_its_limit_of_steps():
    failure = failure_of(generate("trap", 7), Scenario("turn-right"))
    seen = []
    found = counterfactuals(
        failure, most_steps=20_000, progress=lambda done, of: seen.append((done, of))
    )
    assert not found.is_complete
    assert [done for done, _ in seen] == [*range(1, found.runs + 1)]
    assert all(of >= done for done, of in seen)


def test_the_same_campaign_again_keeps_the_pace_with_which_it_began(tmp_path):
    first = CampaignConfig(Scenario(PYTHON), seed=1, measured=Pace(0.004))
    with contextlib.closing(begin(first, tmp_path, Budget(seconds=9.0)).store):
        pass
    now = replace(first, measured=Pace(0.005, 0.01))
    assert with_stored_pace(now, tmp_path) == first
    assert with_stored_pace(replace(now, measured=None), tmp_path) == first
    other = replace(now, seed=2)
    assert with_stored_pace(other, tmp_path) == other
    assert with_stored_pace(now, tmp_path / "empty") == now
    again = resume(tmp_path)
    again.store.close()
    assert again.config.measured == Pace(0.004)


class SlowToBegin(Example):
    """Plans for twenty milliseconds before each run, and acts at once."""

    def reset(self):
        end = time.process_time() + 0.02
        while time.process_time() < end:
            pass
        return super().reset()


def test_no_pace_is_mentioned_of_a_class_that_only_begins_slowly():
    config = configure(CampaignOptions(controller=f"{HERE}:SlowToBegin"), seed=1)
    assert unstated_pace(config) is None
