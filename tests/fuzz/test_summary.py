"""What a campaign's summary says of the time that its controller took."""

import pytest

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.run import Campaign
from fuzz.campaign.summary import controller_share, summary_of, times_in_words
from sim.scenario import Scenario


def campaign_of(controller):
    config = CampaignConfig(Scenario(controller), seed=1, examples=1, families=("native",), shrink=False)
    campaign = Campaign(config, units=1)
    for _ in campaign.run():
        pass
    return config, campaign.state


@pytest.fixture(scope="module")
def of_a_class():
    return campaign_of("sim.examples.python:Example")


@pytest.fixture(scope="module")
def of_a_compiled_one():
    return campaign_of("turn-right")


def test_the_share_of_a_python_class_is_in_the_summary(of_a_class):
    assert 0.0 < summary_of(*of_a_class, "done")["controller_share"] < 1.0


def test_the_share_of_a_python_class_is_in_words(of_a_class):
    assert times_in_words(*of_a_class).endswith(" % of the work was your controller's own code")


def test_a_compiled_controller_has_no_share(of_a_compiled_one):
    assert "controller_share" not in summary_of(*of_a_compiled_one, "done")
    assert times_in_words(*of_a_compiled_one).count("%") == 0


def test_a_sitting_that_did_nothing_has_no_share(of_a_class):
    config, _ = of_a_class
    assert controller_share(config, Campaign(config, units=1).state) is None
