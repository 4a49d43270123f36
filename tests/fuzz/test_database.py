"""A campaign's Hypothesis database keeps failing examples and tries them first, under our key."""

from dataclasses import replace

import pytest

from fuzz.campaign.unit import run_unit
from fuzz.search.database import remembered
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen.generation import generate


@pytest.fixture
def config(tmp_path):
    return CampaignConfig(
        Scenario("turn-right"), seed=5, examples=30, database=str(tmp_path / "examples")
    )


def test_what_a_unit_found_the_next_campaign_tries_first(config):
    found = run_unit(config, 1)
    again = run_unit(replace(config, seed=99), 0)
    assert again.strategy == "database" and found.failures
    assert set(found.failures) <= set(again.failures)


def test_trying_again_deletes_nothing(config):
    run_unit(config, 1)
    first, second = run_unit(config, 0), run_unit(config, 0)
    assert first.worlds == second.worlds > 0
    assert {k: found.dumps() for k, found in first.failures.items()} == {
        k: found.dumps() for k, found in second.failures.items()
    }


def test_a_database_changes_nothing_in_what_a_unit_draws(config):
    with_one, without = run_unit(config, 3), run_unit(replace(config, database=""), 3)
    assert (with_one.strategy, with_one.steps, with_one.verdicts) == (
        without.strategy,
        without.steps,
        without.verdicts,
    )


def test_an_empty_database_has_nothing_to_try(config):
    assert run_unit(config, 0).worlds == 0


def test_another_controller_does_not_read_choices_that_are_not_its_own(config):
    run_unit(config, 1)
    assert run_unit(replace(config, scenario=Scenario("turn-left")), 0).worlds == 0


def test_another_map_does_not_read_places_of_the_first(config):
    here, there = (generate("trap", seed=seed) for seed in (1, 2))
    run_unit(replace(config, fixed_map=here), 1)
    assert (
        run_unit(replace(config, fixed_map=here), 0).worlds
        > run_unit(replace(config, fixed_map=there), 0).worlds
    )


def test_a_strategy_has_its_own_failures(config):
    run_unit(replace(config, families=("trap",), examples=120), 1)
    assert list(remembered(config, "trap").fetch(b".secondary")) and not list(
        remembered(config, "maze").fetch(b".secondary")
    )


def test_a_database_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    line = (
        "fuzz",
        "--controller",
        "turn-right",
        "--database",
        tmp_path / "file",
        "--out",
        tmp_path / "out",
    )
    ended = worldgen(*line)
    assert ended.code == 2 and "is a file" in ended.err
