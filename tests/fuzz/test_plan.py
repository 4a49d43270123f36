"""Strategies share the budget according to their yield."""

from collections import Counter

import pytest

from fuzz.search.plan import Prices, planned_strategy, strategies_for, strategy_shares
from fuzz.search.registry import check_strategy
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import SearchState, StrategyYield
from sim.scenario import Scenario
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter

CONFIG = CampaignConfig(Scenario("turn-right"), seed=1)
TWO = ("trap", "maze")


def shares(first, second):
    return strategy_shares(TWO, SearchState({"trap": first, "maze": second}), Prices())


def test_strategies_of_which_nothing_is_known_share_alike():
    assert strategy_shares(TWO, SearchState(), Prices()) == [0.5, 0.5]


def test_a_strategy_that_finds_more_for_the_same_cost_gets_more():
    poor, rich = (
        StrategyYield("trap", units=5, worlds=2000),
        StrategyYield("trap", units=5, worlds=2000, failures=40, variants=6),
    )
    low, high = shares(poor, rich)
    assert high > 2 * low


def test_a_strategy_that_finds_the_same_for_less_gets_more():
    dear, cheap = (
        StrategyYield("trap", worlds=4000, failures=40),
        StrategyYield("trap", worlds=400, failures=40),
    )
    low, high = shares(dear, cheap)
    assert high > 2 * low


def test_no_strategy_starves():
    nothing, much = (
        StrategyYield("trap", worlds=10**9),
        StrategyYield("trap", worlds=1, failures=10**6, variants=100),
    )
    assert shares(nothing, much)[0] == pytest.approx(0.15)


def test_a_strategy_that_runs_no_world_loses_its_first_estimate():
    memory = SearchState({"small": StrategyYield("small", units=3)})
    before, after = (
        strategy_shares(("small", "map"), known, Prices())[0] for known in (SearchState(), memory)
    )
    assert before > 0.8 and after == pytest.approx(0.15, abs=0.01)


def test_shares_add_up_to_the_budget():
    names = strategies_for(CONFIG, SearchState())
    assert sum(strategy_shares(names, SearchState(), Prices(step=1e-2))) == pytest.approx(1.0)


def test_units_are_dealt_out_as_the_shares_say():
    memory = SearchState(
        {
            "trap": StrategyYield("trap", worlds=4000),
            "maze": StrategyYield("maze", worlds=400, failures=400, variants=9),
        }
    )
    config = CampaignConfig(Scenario("turn-right"), families=TWO)
    units = Counter(planned_strategy(config, unit, memory) for unit in range(1000, 1100))
    assert units["trap"] == pytest.approx(100 * strategy_shares(TWO, memory, Prices())[0], abs=2)


def test_named_families_are_all_that_is_drawn_from():
    config = CampaignConfig(Scenario("turn-right"), families=TWO)
    assert {planned_strategy(config, unit, SearchState()) for unit in range(20)} == set(TWO)


@pytest.mark.parametrize(
    ("strategy", "controller", "expected"),
    [
        ("boundary", "turn-random", {"code": "strategy-needs-no-chance"}),
        ("sealed", "turn-right", {"code": "strategy-needs-keep-going", "name": "sealed"}),
        ("bondary", "turn-right", {"code": "unknown-name", "name": "bondary"}),
    ],
)
def test_a_strategy_that_does_not_fit_is_refused(strategy, controller, expected):
    with raises(InvalidParameter, **expected):
        check_strategy(strategy, Scenario(controller))


def test_a_misspelt_strategy_is_told_the_strategies():
    with raises(InvalidParameter, "unknown-name", name="natve"):
        check_strategy("natve", Scenario("turn-right"))
