"""A campaign's options are declared once, for both the command and the configuration."""

import pytest

from fuzz.campaign.configure import configure
from fuzz.commands.fuzz import fuzz
from fuzz.unit.options import CampaignOptions
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter


def test_each_option_of_a_campaign_has_help():
    assert [option.name for option in CampaignOptions.declared() if not option.help] == []


def test_the_command_takes_each_option_of_a_campaign():
    taken = {param.opts[0]: param.name for param in fuzz.params}
    assert {
        option.flag: option.name for option in CampaignOptions.declared()
    }.items() <= taken.items()


def test_options_that_are_kept_reach_the_configuration():
    options = CampaignOptions(
        controller="turn-right", examples=7, epoch=3, oracles=("detour=5", "turn")
    )
    config = configure(options, seed=1)
    assert (config.examples, config.epoch) == (7, 3)
    assert config.oracles == ("detour=5", "turn")


@pytest.mark.parametrize(
    ("settings", "code"),
    [
        ({"examples": 0}, "out-of-range"),
        ({"epoch": 1.5}, "wrong-type"),
        ({"oracles": (3,)}, "wrong-type"),
    ],
)
def test_a_wrong_option_of_a_campaign_is_refused(settings, code):
    with raises(InvalidParameter, code):
        CampaignOptions(controller="turn-right", **settings)
