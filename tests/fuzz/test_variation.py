"""Variations of a campaign besides the world: parsed, refused, applied, stored and replayed."""

from dataclasses import replace

import pytest
from hypothesis import given

from fuzz import scenarios
from fuzz.campaign.run import Campaign
from fuzz.campaign.unit import run_unit
from fuzz.layouts.variation import Variation, applied
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import check_certificate, generate
from worldgen.errors import InvalidParameter

SCENARIO = Scenario("turn-right")
NOISE = Variation("sensor_noise", (0.0, 0.2))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("sensor_noise=0,0.05", (0.0, 0.05)),
        ("robot-radius=0.05, 0.07", (0.05, 0.07)),
        ("signal=open,blocked", ("open", "blocked")),
        ("beams=0,8", (0, 8)),
        ("time_step=0.03", (0.03,)),
    ],
)
def test_values_are_read_in_their_own_type(text, values):
    found = Variation.parse(text, SCENARIO).values
    assert found == values and [type(one) for one in found] == [type(one) for one in values]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sensor_noise", {"code": "no-values", "option": "--vary"}),
        ("sensor_noise=0,,1", {"code": "no-values", "option": "--vary"}),
        ("sensor_nose=0", {"code": "unknown-name", "option": "--vary", "name": "sensor_nose"}),
        ("motion=stepped", {"code": "unknown-name", "option": "--vary", "name": "motion"}),
        ("sensor_noise=2", {"code": "out-of-range", "name": "sensor_noise", "high": 1}),
        ("robot_radius=-1", {"code": "out-of-range", "option": "--vary", "name": "robot_radius"}),
        ("robot_speed=fast", {"code": "not-a-number", "option": "--vary", "name": "robot_speed"}),
        ("time_step=99", {"code": "out-of-range", "low": 0.001, "high": 10}),
        (
            "keep_going=true",
            {"code": "unknown-name", "option": "--vary", "name": "keep_going", "motion": "swept"},
        ),
    ],
)
def test_what_cannot_be_varied_is_refused_with_the_way_out(text, expected):
    with raises(InvalidParameter, **expected):
        Variation.parse(text, SCENARIO)


def test_a_quantity_given_twice_is_refused(tmp_path):
    ended = worldgen(
        "fuzz",
        "--controller",
        "turn-right",
        "--vary",
        "slip=0",
        "--vary",
        "slip=0.1",
        "--seed",
        1,
        "--out",
        tmp_path,
    )
    assert ended.code == 2 and ended.error_code == "twice"


def test_another_radius_takes_the_certificate_away_and_the_same_one_does_not():
    world = generate("trap", seed=1)
    other, scenario = applied({"robot_radius": 0.04, "slip": 0.1}, world, SCENARIO)
    assert (
        other.certificate is None and other.robot_radius == 0.04 and scenario.run.robot.slip == 0.1
    )
    assert applied({"robot_radius": world.robot_radius}, world, SCENARIO)[0] is world


def test_a_campaign_that_varies_nothing_draws_what_it_always_drew():
    config = CampaignConfig(SCENARIO, seed=5, examples=30)
    one, two = run_unit(config, 1), run_unit(replace(config, vary=(Variation("slip", (0.0,)),)), 1)
    assert (one.worlds, one.steps, one.verdicts) == (two.worlds, two.steps, two.verdicts)


@pytest.mark.nightly
def test_failures_store_what_was_drawn_and_replay():
    config = CampaignConfig(
        SCENARIO, seed=5, vary=(NOISE, Variation("robot_radius", (0.07, 0.05))), examples=60
    )
    campaign = Campaign(config, units=1)
    for _ in campaign.run():
        pass
    found = list(campaign.state.best.values())
    assert found and all(replay(world).confirmed for world in found)
    assert any("sensor_noise" in failure.record.parameters for failure in found)


@given(
    scenarios(
        "turn-right", family="trap", vary={"robot_radius": [0.07, 0.04], "sensor_noise": [0.0, 0.1]}
    )
)
def test_scenarios_are_reachable_for_the_drawn_robot(drawn):
    world, scenario = drawn
    assert check_certificate(world).valid
    assert world.robot_radius in (0.07, 0.04) and scenario.run.robot.sensor_noise in (0.0, 0.1)


@pytest.mark.nightly
def test_the_command_line_varies_and_its_failures_replay(tmp_path):
    varied = ("--controller", "turn-right", "--vary", "robot_speed=2,0.7", "--vary", "slip=0,0.1")
    found = worldgen(
        "fuzz",
        *varied,
        "--units",
        1,
        "--examples",
        60,
        "--seed",
        4,
        "--workers",
        1,
        "--out",
        tmp_path,
    )
    assert found.code == 1
    assert worldgen("replay", tmp_path).code == 0


def test_a_campaign_in_which_no_world_could_be_run_is_no_success(tmp_path):
    ended = worldgen(
        "fuzz", "--controller", "turn-right", "--vary", "robot_radius=50", "--units", 1, "--strategy", "features",
        "--examples", 5, "--workers", 1, "--seed", 1, "--out", tmp_path,
    )  # fmt: skip
    assert ended.code == 2 and ended.error_code == "no-world-fits"
