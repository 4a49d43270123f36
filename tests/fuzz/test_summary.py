"""How a campaign's summary reports the time that its controller took."""

import pytest

from fuzz.campaign.executors import InlineExecutor
from fuzz.campaign.run import Campaign
from fuzz.campaign.state import CampaignState, UnitDone
from fuzz.campaign.store import Budget, Status, begin, read_summary, resume
from fuzz.campaign.summary import controller_share, describe_share, describe_time, summary_of
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from tests.helpers.campaign_results import numbers
from worldgen.files.json_file import plain


def campaign_of(controller):
    config = CampaignConfig(
        Scenario(controller), seed=1, examples=1, families=("native",), shrink=False
    )
    campaign = Campaign(config, units=1)
    for _ in campaign.run():
        pass
    return config, campaign.state


@pytest.fixture(scope="module")
def of_a_class():
    return campaign_of("sim.controllers.examples.python:Example")


@pytest.fixture(scope="module")
def of_a_compiled_one():
    return campaign_of("turn-right")


def test_the_share_of_a_python_class_is_in_the_summary(of_a_class):
    assert 0.0 < summary_of(*of_a_class, Status.DONE).controller_share <= 1.0


def test_the_share_of_a_python_class_is_in_words(of_a_class):
    config, _ = of_a_class
    share = describe_share(summary_of(*of_a_class, Status.DONE), config.scenario.controller)
    assert share.endswith(" % of the work was your controller's own code")


def test_a_compiled_controller_has_no_share(of_a_compiled_one):
    summary = summary_of(*of_a_compiled_one, Status.DONE)
    assert "controller_share" not in plain(summary)
    assert describe_share(summary, "turn-right") is None


def test_a_sitting_that_did_nothing_has_no_share(of_a_class):
    config, _ = of_a_class
    assert controller_share(config, Campaign(config, units=1).state) is None


def test_the_time_of_a_run_is_told_by_its_parts():
    times = {"start-up": 2.0, "search": 1.3, "shrinking": 26.7}
    assert (
        describe_time(numbers(seconds=28.0, times=times))
        == "30.0 s: start-up 2.0 s, search 1.3 s, shrinking 26.7 s"
    )


def test_a_run_that_had_nothing_to_do_reports_the_time_of_the_runs_before_it():
    nothing = dict.fromkeys(("start-up", "search", "shrinking"), 0.0)
    assert describe_time(numbers(seconds=28.0, times=nothing)) == "28.0 s"


def test_time_goes_on_until_ctrl_c_and_not_only_until_the_last_unit(monkeypatch):
    config = CampaignConfig(
        Scenario("turn-right"), seed=1, examples=1, families=("features",), shrink=False
    )
    campaign = Campaign(config, units=2)
    events = campaign.run()
    assert isinstance(next(events), UnitDone)
    monkeypatch.setattr("fuzz.campaign.schedule.Schedule.elapsed", lambda _: 30.0)
    with pytest.raises(KeyboardInterrupt):
        events.throw(KeyboardInterrupt)
    assert campaign.state.seconds == 30.0 == campaign.state.times["search"]


def test_a_resumed_run_counts_what_earlier_runs_spent_after_their_last_unit(tmp_path):
    config = CampaignConfig(
        Scenario("turn-right"), seed=1, examples=1, families=("features",), shrink=False
    )
    campaign_run = begin(config, tmp_path, Budget(units=1))
    list(Campaign(config, units=1, executor=InlineExecutor(), store=campaign_run.store).run())
    written = summary_of(config, CampaignState(seconds=1_000.0), Status.STOPPED)
    campaign_run.store.save_summary(written)
    campaign_run.store.close()

    again = resume(tmp_path)
    campaign = Campaign(config, units=1, executor=InlineExecutor(), store=again.store)
    list(campaign.run())
    again.store.close()
    assert campaign.state.seconds == 1_000.0


def test_a_summary_is_read_as_it_was_written(of_a_class, tmp_path):
    campaign_run = begin(of_a_class[0], tmp_path, Budget(units=1))
    written = summary_of(*of_a_class, Status.DONE)
    campaign_run.store.save_summary(written)
    campaign_run.store.close()
    assert read_summary(tmp_path) == written


def test_a_find_has_the_time_at_which_it_was_found_also_after_a_restart(tmp_path):
    config = CampaignConfig(
        Scenario("turn-right"), seed=1, examples=20, families=("features",), shrink=False
    )
    campaign_run = begin(config, tmp_path, Budget(units=1))
    first, again = (Campaign(config, units=2, store=campaign_run.store) for _ in range(2))
    for campaign in (first, again):
        for _ in campaign.run():
            pass
    campaign_run.store.close()
    finds = [find for find, _ in first.state.finds]
    assert finds == [find for find, _ in again.state.finds]
    # Each unit has twenty worlds.
    assert {find.unit for find in finds} == {0, 1}
    assert [find.worlds for find in finds] == sorted(find.worlds for find in finds)
    assert 0 < finds[0].worlds < 20 and 0 < finds[0].steps < first.state.steps
    assert 0.0 < finds[0].seconds < finds[-1].seconds <= first.state.seconds
