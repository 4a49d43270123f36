"""What short campaigns find for each of the thesis's robots, and how small it becomes."""

import functools

import pytest

from fuzz.campaign.run import Campaign
from fuzz.shrink import removable
from fuzz.shrink.predicate import StillFails
from fuzz.unit.config import CampaignConfig
from sim.options.run import RunOptions
from sim.scenario import Scenario


@functools.cache
def campaign(controller, motion):
    config = CampaignConfig(Scenario(controller, RunOptions(motion)), seed=1, examples=120)
    made = Campaign(config, units=4)
    for _ in made.run():
        pass
    return made.state


@pytest.mark.nightly
@pytest.mark.parametrize("controller", ["turn-left", "turn-right"])
@pytest.mark.parametrize("motion", ["swept", "stepped"])
def test_a_deterministic_robot_is_caught_in_a_proved_loop_of_few_cells(controller, motion):
    loops = [
        failure
        for failure in campaign(controller, motion).best.values()
        if failure.record.verdict == "loop"
    ]
    assert loops and min(failure.world.solid_cells for failure in loops) <= 4


@pytest.mark.nightly
@pytest.mark.parametrize("controller", ["turn-left", "turn-right", "turn-random"])
def test_the_thesis_model_is_caught_going_through_walls(controller):
    verdicts = {failure.verdict for failure in campaign(controller, "stepped").best.values()}
    assert verdicts & {"tunnel", "overlap"}


@pytest.mark.gate
def test_fast_robots_tunnel_under_endpoint():
    scenario = Scenario("turn-right", RunOptions("endpoint"))
    config = CampaignConfig(scenario, seed=1, examples=30, time_steps=(0.15,), shrink=False)
    made = Campaign(config, units=2)
    for _ in made.run():
        pass
    assert "tunnel" in {failure.verdict for failure in made.state.best.values()}


@pytest.mark.nightly
@pytest.mark.parametrize("controller", ["turn-left", "turn-right", "turn-random"])
def test_nothing_tunnels_or_overlaps_under_swept(controller):
    state = campaign(controller, "swept")
    assert state.verdicts["tunnel"] == state.verdicts["overlap"] == 0 and state.worlds >= 300


@pytest.mark.nightly
def test_every_finding_is_one_minimal_by_its_file_alone():
    for failure in campaign("turn-right", "stepped").best.values():
        assert removable(failure.world, StillFails.of(failure)) == []
