"""Campaigns for a body, a drive or a goal: it is the same in every world that is searched or kept."""

import dataclasses

import pytest

from fuzz.campaign.configure import configure
from fuzz.campaign.store import fingerprint_of
from fuzz.campaign.store.fingerprint import config_of
from fuzz.campaign.unit import run_unit
from fuzz.layouts.features import arena_for
from fuzz.layouts.small_worlds import small_world
from fuzz.layouts.variation import OVERRIDES, quantities_of
from fuzz.overview.natural import natural_runs
from fuzz.shrink import removable, shrink
from fuzz.shrink.predicate import StillFails
from fuzz.triage.replaying import replay
from fuzz.unit.options import CampaignOptions
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import check_certificate, generate
from worldgen.errors import InvalidParameter
from worldgen.files.grid import read_world, write_world
from worldgen.random_streams import RandomStream
from worldgen.robot_overrides import RobotOverrides

LONG = {"footprint": "1.2x0.4"}
CAR = {"footprint": "0.62x0.9", "drive": "car", "turning_radius": 0.5, "reverse": True}
GOAL = {
    "arrival": "stop:0.05",
    "target_radius": 0.13,
    "target_heading": "1.5708:0.1",
    "contact": "fail",
}


def config(controller="turn-right", **options):
    return configure(CampaignOptions(controller=controller, examples=8, **options), seed=1)


def unit(campaign, strategy):
    """Return what a unit of a strategy finds."""
    campaign = dataclasses.replace(campaign, families=(strategy,))
    return run_unit(campaign, 0)


@pytest.mark.parametrize("robot", [LONG, CAR, GOAL], ids=["long", "car", "goal"])
def test_the_robot_is_part_of_the_configuration_and_of_what_is_stored(robot):
    campaign = config(**robot)
    stored = fingerprint_of(campaign)
    assert config_of(stored.configuration) == campaign
    assert stored.digest != fingerprint_of(config()).digest
    assert {one.name for one in campaign.vary} == quantities_of(RobotOverrides(**robot)).keys()


@pytest.mark.parametrize("strategy", ["native", "archive", "features", "trap"])
@pytest.mark.parametrize("robot", [LONG, GOAL], ids=["long", "goal"])
def test_every_strategy_runs_this_robot_alone(strategy, robot):
    overrides = RobotOverrides(**robot)
    result = unit(config(**robot), strategy)
    assert result.worlds > 0
    for failure in result.failures.values():
        one = failure.world.robots[0]
        assert overrides.applied_to_robot(one) == one
        assert check_certificate(failure.world).valid
        assert failure.record.details["fixed"].keys() == quantities_of(overrides).keys()
        assert replay(failure).confirmed


def test_a_failure_and_its_shrunk_world_have_the_radius_of_the_target_that_was_given():
    result = unit(config(target_radius=0.13), "native")
    failures = list(result.failures.values())
    worlds = [*(one.world for one in failures), shrink(failures[0]).failure.world]
    assert {world.target.radius for world in worlds} == {0.13}


def test_boundaries_of_a_footprint_leave_its_size_alone():
    campaign = dataclasses.replace(config(**LONG), examples=64)
    result = unit(campaign, "boundary")
    assert result.worlds > 0
    for failure in result.failures.values():
        axes = [one["axis"] for one in failure.record.details.get("boundaries", [])]
        assert "radius" not in axes


@pytest.mark.parametrize("robot", [LONG, CAR], ids=["long", "car"])
def test_small_worlds_are_made_for_the_body(robot):
    values = quantities_of(RobotOverrides(**robot))
    worlds = [small_world(RandomStream(n), n, values, 0.015) for n in range(14)]
    made = [world for world in worlds if world is not None]
    assert len(made) >= 10
    for world in made:
        assert world.robots[0].footprint == RobotOverrides(**robot)._body()
        assert check_certificate(world).valid


def test_natural_worlds_are_made_for_the_body():
    campaign = config("bug2", **LONG)
    result, examples = natural_runs(campaign.scenario, ["trap", "forest"], 6, 1, vary=campaign.vary)
    assert result.worlds == 6
    for case in examples.values():
        assert case.world.robots[0].footprint == RobotOverrides(**LONG)._body()


def test_a_map_is_searched_with_the_body(tmp_path):
    world = generate("rooms", 1, size=24, **LONG)
    plain = dataclasses.replace(world.robots[0], footprint=(), radius=0.2)
    write_world(dataclasses.replace(world.bare, robots=(plain,)), tmp_path / "m.grid")
    campaign = config(world=tmp_path / "m.grid", **LONG)
    assert campaign.fixed_map.robots[0].footprint == RobotOverrides(**LONG)._body()
    result = run_unit(dataclasses.replace(campaign, examples=40), 1)
    assert result.worlds > 0
    for failure in result.failures.values():
        assert failure.world.robots[0].footprint == campaign.fixed_map.robots[0].footprint


def test_a_shrunk_failure_keeps_its_body_and_is_one_minimal_for_it():
    result = unit(config(**LONG), "trap")
    failure = next(iter(result.failures.values()))
    done = shrink(failure)
    assert done.failure.world.robots[0].footprint == failure.world.robots[0].footprint
    assert done.failure.world.solid_cells < failure.world.solid_cells
    assert check_certificate(done.failure.world).valid
    assert done.failure.record.details["one_minimal"]
    assert removable(done.failure.world, StillFails.of(done.failure)) == []


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"robots": 2, **LONG}, "not-for-fleets"),
        ({"reverse": True}, "option-missing"),
        ({"drive": "car"}, "option-missing"),
        ({"vary": ("robot_footprint=1x1,0.5x0.5",), **LONG}, "twice"),
        ({"vary": ("robot_radius=0.1,0.2",), **LONG}, "no-effect"),
        ({"vary": ("robot_footprint=1,2",)}, "wrong-form"),
        ({"footprint": "0x1"}, "not-positive"),
    ],
)
def test_what_no_campaign_can_have_is_refused_before_any_work(options, code):
    with raises(InvalidParameter, code):
        config(**options)


def test_bodies_may_vary():
    campaign = config(vary=("robot_footprint=0.62x0.9,1.2x0.4", "robot_arrival=touch,step"))
    found = unit(campaign, "features")
    assert found.worlds > 0


def test_an_arena_suits_the_body():
    plain = arena_for({})
    for robot in (LONG, CAR, {"footprint": "40x20"}):
        world = arena_for(quantities_of(RobotOverrides(**robot)))
        assert world.walls.shape == plain.walls.shape
        # It can turn at its start.
        assert world.robot_radius <= 1.5 * world.cell_size


def test_a_campaign_with_another_body_is_another_campaign(tmp_path):
    words = ["--controller", "turn-right", "--strategy", "trap", "--units", 1, "--examples", 4]
    words += ["--seed", 1, "--workers", 1, "--out", tmp_path / "out"]
    first = worldgen("fuzz", *words, "--footprint", "1.2x0.4")
    assert first.code in (0, 1, 4), first.err
    again = worldgen("fuzz", *words, "--footprint", "1.1x0.4")
    assert again.code == 2
    resumed = worldgen("fuzz", "--resume", tmp_path / "out", "--footprint", "1.1x0.4")
    assert "--footprint cannot change in a resumed campaign" in resumed.err
    for file in (tmp_path / "out").glob("*.grid"):
        assert read_world(file).robots[0].footprint == RobotOverrides(**LONG)._body()


def test_every_quantity_of_the_robot_has_an_option():
    flags = {option.flag for option in CampaignOptions.declared()}
    assert {option.flag for option in OVERRIDES.values()} <= flags
