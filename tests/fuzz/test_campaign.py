"""Campaigns: pure units, proved failures, and no failure is lost."""

import importlib
from dataclasses import replace

import pytest

from fuzz.campaign.run import Campaign
from fuzz.campaign.state import Discovery
from fuzz.campaign.unit import run_unit
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from worldgen import check_certificate

CONFIG = CampaignConfig(Scenario("turn-right"), seed=5, examples=40)


def corpus(campaign):
    for _ in campaign.run():
        pass
    return {kind: found.dumps() for kind, found in campaign.state.best.items()}


FEWER = replace(CONFIG, examples=12, families=("features", "trap"))


@pytest.fixture(scope="module")
def found():
    campaign = Campaign(FEWER, units=3)
    return campaign, corpus(campaign)


def test_a_unit_is_a_pure_function_of_its_number():
    one, two = run_unit(CONFIG, 2), run_unit(CONFIG, 2)
    assert (one.worlds, one.steps, one.verdicts, one.met) == (
        two.worlds,
        two.steps,
        two.verdicts,
        two.met,
    )
    assert {k: found.dumps() for k, found in one.failures.items()} == {
        k: found.dumps() for k, found in two.failures.items()
    }


def test_a_unit_does_not_depend_on_what_else_is_loaded(tmp_path, monkeypatch):
    config = replace(CONFIG, families=("maze",))
    before = run_unit(config, 0)
    (tmp_path / "strange_numbers.py").write_text("A = [7, 13, 29, 4242, 65521, 1234567]\n" * 20)
    monkeypatch.syspath_prepend(tmp_path)
    importlib.import_module("strange_numbers")
    run_unit(replace(CONFIG, families=("trap",)), 1)
    after = run_unit(config, 0)
    assert (before.steps, before.verdicts) == (after.steps, after.verdicts)


@pytest.mark.gate
def test_other_units_and_other_seeds_draw_other_worlds():
    steps = {run_unit(replace(CONFIG, seed=seed), unit).steps for seed in (5, 6) for unit in (0, 1)}
    assert len(steps) == 4


@pytest.mark.gate
def test_the_thesis_robot_is_found_to_loop(found):
    campaign, files = found
    verdicts = {one.verdict for one in campaign.state.best.values()}
    assert files and verdicts <= {"loop", "stalled", "timeout"}
    assert campaign.state.worlds >= 30 and campaign.state.verdicts["loop"] > 0


@pytest.mark.gate
def test_every_failure_replays_and_carries_a_valid_witness(found):
    for world in found[0].state.best.values():
        assert replay(world).confirmed and check_certificate(world.world).valid


@pytest.mark.gate
def test_every_failure_says_that_it_is_one_minimal(found):
    assert all(failure.record.details["one_minimal"] for failure in found[0].state.best.values())


def test_what_is_not_shrunk_yet_is_kept_when_a_campaign_stops():
    campaign = Campaign(CONFIG, units=3)
    for event in campaign.run():
        if isinstance(event, Discovery):
            break
        assert campaign.pending() or not campaign.state.met
    assert campaign.state.best or campaign.pending()


def test_a_budget_of_no_time_does_no_work():
    campaign = Campaign(CONFIG, seconds=0.0)
    assert corpus(campaign) == {} and campaign.state.units == 0
