"""The native strategy: a unit is a function of its number, and reports proved, small failures."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from fuzz.campaign.unit import run_unit
from fuzz.layouts.variation import Variation
from fuzz.screening import evaluate
from fuzz.search.native import Few, fits, scenes
from fuzz.search.plan import planned_strategy, strategies_for
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import SearchState
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.random_streams import RandomStream

CONFIG = CampaignConfig(Scenario("turn-right"), seed=4, examples=25, families=("native",))


def varied(*texts):
    scenario = Scenario("turn-right")
    return CampaignConfig(
        scenario,
        1,
        examples=12,
        families=("native",),
        vary=tuple(Variation.parse(text, scenario) for text in texts),
    )


@pytest.mark.gate
def test_a_unit_is_a_function_of_its_number():
    one, two, other = run_unit(CONFIG, 3), run_unit(CONFIG, 3), run_unit(CONFIG, 4)
    assert [found.dumps() for found in one.failures.values()] == [
        found.dumps() for found in two.failures.values()
    ]
    assert (one.worlds, one.steps, one.verdicts) == (two.worlds, two.steps, two.verdicts)
    assert one.steps != other.steps


@pytest.mark.gate
def test_what_a_unit_reports_replays():
    result = run_unit(CONFIG, 0)
    assert result.worlds == result.verdicts.total() > 500 and len(result.failures) > 5
    assert all(replay(failure).confirmed for failure in result.failures.values())


def test_the_smallest_of_each_key_come_first():
    layouts = scenes(RandomStream(1), 300)
    looks = evaluate(layouts, Scenario("turn-right"), np.zeros(len(layouts), np.uint64), 0.015)
    few = Few()
    few.add(looks)
    chosen = [n for _, n in few.in_order()]
    keys = looks.key[chosen].tolist()
    found = set(looks.key[looks.verdict == "loop"].tolist())
    loops = [key for key, n in zip(keys, chosen, strict=True) if looks.verdict[n] == "loop"]
    assert len(chosen) == len(set(chosen)) <= 32 and set(loops[: len(found)]) == found
    for n in chosen[: len(found)]:
        assert looks.solid[n] == looks.solid[looks.key == looks.key[n]].min()


def test_of_runs_that_only_spent_their_budget_few_are_proved():
    layouts = scenes(RandomStream(1), 400)
    few = Few()
    few.add(
        evaluate(layouts, Scenario("turn-right"), np.zeros(len(layouts), np.uint64), 0.015, 900)
    )
    verdicts = Counter(str(looks.verdict[n]) for looks, n in few.in_order())
    assert verdicts["undecided"] == 4 and verdicts["loop"] > 1


def test_a_campaign_for_a_compiled_controller_is_mainly_native():
    strategies = Counter(
        planned_strategy(CampaignConfig(Scenario("vfh")), unit, SearchState())
        for unit in range(100)
    )
    assert strategies["native"] > 35 and strategies["features"] > 5


def test_native_search_is_chosen_for_a_robot_of_one_radius_wider_than_a_cell():
    config = replace(varied("robot_radius=0.12"), families=())
    assert {"native", "archive"} <= set(strategies_for(config, SearchState()))
    found = run_unit(varied("robot_radius=0.12"), 0)
    assert found.worlds > 100 and found.failures
    assert {failure.world.robot_radius for failure in found.failures.values()} == {0.12}


@pytest.mark.parametrize(
    ("config", "expected"),
    [
        (CampaignConfig(Scenario("bug1", RunOptions("endpoint"))), True),
        (CampaignConfig(Scenario("turn-left", RunOptions("stepped"))), False),
        (CampaignConfig(Scenario("tests.sim.test_vector_controllers:TurnsAway")), True),
        (varied("robot_radius=0.05,0.12"), True),
        (varied("robot_radius=0.15"), True),
        (varied("robot_radius=0.05,0.16"), False),
        (varied("slip=0,0.1"), True),
    ],
    ids=["compiled", "stepped", "vector", "radii", "widest", "too-wide", "slip"],
)
def test_the_strategy_works_where_its_kernel_runs(config, expected):
    assert fits(config) is expected


@pytest.mark.gate
def test_what_a_campaign_varies_is_one_thing_for_a_unit():
    config = varied("wall_friction=0.1,0.3", "time_step=0.02,0.04", "robot_speed=1,2")
    seen: set[tuple[object, ...]] = set()
    for unit in (0, 4):
        made = {
            (
                failure.record.parameters["wall_friction"],
                failure.record.parameters["time_step"],
                failure.world.robot_speed,
            )
            for failure in run_unit(config, unit).failures.values()
        }
        assert len(made) <= 1
        seen |= made
    assert len(seen) > 1


@pytest.mark.gate
@pytest.mark.parametrize("controller", ["turn-random", "random-walk"])
def test_a_robot_that_wanders_until_after_its_budget_has_failed(controller):
    result = run_unit(
        CampaignConfig(Scenario(controller), seed=1, examples=25, families=("native",)), 0
    )
    assert result.failures and all(
        one.verdict in ("timeout", "stalled") for one in result.failures.values()
    )
    assert all(replay(failure).confirmed for failure in result.failures.values())


@pytest.mark.gate
def test_a_unit_does_less_for_a_controller_that_says_it_is_slow():
    quick, slow = (CampaignConfig(Scenario(name)) for name in ("turn-right", "dynamic-window"))
    assert (quick.pace.slower, slow.pace.slower) == (1, 8)
    steps = run_unit(CONFIG, 0).steps
    assert 0 < run_unit(replace(CONFIG, measured=slow.pace), 0).steps < steps / 4
