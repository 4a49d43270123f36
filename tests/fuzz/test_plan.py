"""Lanes share the budget by what they yield."""

from collections import Counter

import pytest

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.result import LaneYield, SearchState
from fuzz.search.plan import Prices, lane_shares, lanes_for, planned_lane
from fuzz.search.registry import check_lane
from sim.scenario import Scenario
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter

CONFIG = CampaignConfig(Scenario("turn-right"), seed=1)
TWO = ("trap", "maze")


def shares(first, second):
    return lane_shares(TWO, SearchState({"trap": first, "maze": second}), Prices())


def test_lanes_of_which_nothing_is_known_share_alike():
    assert lane_shares(TWO, SearchState(), Prices()) == [0.5, 0.5]


def test_a_lane_that_finds_more_for_the_same_cost_gets_more():
    poor, rich = (
        LaneYield(units=5, worlds=2000),
        LaneYield(units=5, worlds=2000, failures=40, classes=6),
    )
    low, high = shares(poor, rich)
    assert high > 2 * low


def test_a_lane_that_finds_the_same_for_less_gets_more():
    dear, cheap = LaneYield(worlds=4000, failures=40), LaneYield(worlds=400, failures=40)
    low, high = shares(dear, cheap)
    assert high > 2 * low


def test_no_lane_starves():
    nothing, much = LaneYield(worlds=10**9), LaneYield(worlds=1, failures=10**6, classes=100)
    assert shares(nothing, much)[0] == pytest.approx(0.15)


def test_shares_add_up_to_the_budget():
    names = lanes_for(CONFIG, SearchState())
    assert sum(lane_shares(names, SearchState(), Prices(step=1e-2))) == pytest.approx(1.0)


def test_units_are_dealt_out_as_the_shares_say():
    memory = SearchState(
        {"trap": LaneYield(worlds=4000), "maze": LaneYield(worlds=400, failures=400, classes=9)}
    )
    config = CampaignConfig(Scenario("turn-right"), families=TWO)
    units = Counter(planned_lane(config, unit, memory) for unit in range(1000, 1100))
    assert units["trap"] == pytest.approx(100 * lane_shares(TWO, memory, Prices())[0], abs=2)


def test_named_families_are_all_that_is_drawn_from():
    config = CampaignConfig(Scenario("turn-right"), families=TWO)
    assert {planned_lane(config, unit, SearchState()) for unit in range(20)} == set(TWO)


@pytest.mark.parametrize(
    ("lane", "controller", "expected"),
    [
        ("boundary", "turn-random", {"code": "lane-needs-no-chance"}),
        ("sealed", "turn-right", {"code": "lane-needs-keep-going", "name": "sealed"}),
        ("bondary", "turn-right", {"code": "unknown-name", "name": "bondary"}),
    ],
)
def test_a_lane_that_does_not_fit_is_refused(lane, controller, expected):
    with raises(InvalidParameter, **expected):
        check_lane(lane, Scenario(controller))


def test_a_misspelt_lane_is_told_the_lanes():
    with raises(InvalidParameter, "unknown-name", name="natve"):
        check_lane("natve", Scenario("turn-right"))
