"""``worldgen run`` with several robots: what it prints and writes, and what it refuses."""

import json

import pytest

from sim.fleet.assignment import controllers_in
from tests.helpers.command_line import worldgen
from tests.helpers.fleets import EAST, fleet_world, hall, passage
from worldgen.files.grid import write_world
from worldgen.world import Pose, Robot, Target

OF_THE_WHOLE_RUN = ("reachable", "proof", "arrival_uncertain")


@pytest.fixture
def grid(tmp_path):
    path = tmp_path / "two.grid"
    write_world(passage(), path)
    return path


def test_json_has_the_same_keys_for_each_robot(grid):
    result = worldgen("run", grid, "--controller", "turn-right", "--json")
    found = json.loads(result.out)
    assert result.code == 1
    assert found["verdict"] == "livelock"
    assert found["evidence"]["waiting"] == [1, 2]
    own = {key for key in found if key not in ("robots", *OF_THE_WHOLE_RUN)}
    assert [set(one) for one in found["robots"]] == [own, own]


def test_a_trace_begins_each_row_with_the_robot(grid, tmp_path):
    out = tmp_path / "o.csv"
    worldgen("run", grid, "--controller", "1=bug2,2=turn-right", "--steps", "50", "--trace", out)
    lines = out.read_text("utf-8").splitlines()
    assert lines[0] == "robot,t,x,y,heading"
    assert [line.partition(",")[0] for line in lines[1:]] == ["1"] * 51 + ["2"] * 51


@pytest.mark.parametrize("suffix", [".png", ".svg", ".html", ".gif"])
def test_all_robots_are_drawn(grid, tmp_path, suffix):
    out = tmp_path / f"trail{suffix}"
    result = worldgen("run", grid, "--controller", "turn-right", "--steps", "60", "--picture", out)
    assert result.code == 1
    assert out.stat().st_size > 1000
    if suffix in (".svg", ".html"):
        assert ">robot 2<" in out.read_text("utf-8")


@pytest.mark.parametrize(
    ("controllers", "code"),
    [
        ("1=bug2", "robot-without-controller"),
        ("1=bug2,vfh", "controller-unnumbered"),
        ("1=bug2,2=vfh,3=bug2", "no-such-robot"),
        ("1=bug2,1=vfh", "robot-named-twice"),
        ("1=bug2,2=nobody", "unknown-name"),
    ],
)
def test_wrong_numbers_are_refused_in_one_sentence(grid, controllers, code):
    result = worldgen("run", grid, "--controller", controllers)
    assert result.code == 2
    assert result.error_code == code
    assert result.err.count("\n") <= 2


def test_a_controller_without_a_number_is_named(grid):
    result = worldgen("run", grid, "--controller", "1=bug2+beams=4,vfh")
    assert result.error.facts["part"] == "'vfh'"


def test_a_comma_may_be_part_of_a_controller():
    controllers = controllers_in("1=./bug,vfh.py:Robot,2=bug2", 2)
    assert controllers == ["./bug,vfh.py:Robot", "bug2"]


@pytest.mark.parametrize(
    ("option", "way_out"),
    [
        ("pushes=0.5:0.1:0:0", "drift and decoys also work with several"),
        ("push_places=1:1:0.1:0:0", "drift and decoys also work with several"),
        ("task=cover", "use a world with one robot"),
    ],
)
def test_what_is_for_one_robot_is_refused_in_one_sentence_with_a_way_out(grid, option, way_out):
    result = worldgen("run", grid, "--controller", f"bug2+{option}")
    assert (result.code, result.error_code) == (2, "option-for-one-robot")
    assert result.err.count("\n") == 1 and "this one has 2" in result.err and way_out in result.err


def test_options_follow_each_controller(grid):
    alike = worldgen("run", grid, "--controller", "vfh+beams=12", "--steps", "40", "--json")
    named = worldgen(
        "run", grid, "--controller", "1=vfh+beams=12,2=vfh+beams=12", "--steps", "40", "--json"
    )
    other = worldgen(
        "run",
        grid,
        "--controller",
        "1=vfh+beams=12,2=vfh+acceleration=0.5",
        "--steps",
        "40",
        "--json",
    )
    assert json.loads(alike.out) == json.loads(named.out) != json.loads(other.out)


def walled_in():
    """Return a hall with a wall all the way across, and robot 2's target on the far side."""
    walls = hall()
    walls[:, 20] = True
    return fleet_world(
        walls,
        Robot(Pose(0.5, 0.5, EAST), Target(1.5, 0.5, 0.05)),
        Robot(Pose(0.5, 1.5, EAST), Target(3.5, 1.5, 0.05)),
    )


@pytest.mark.parametrize(
    ("world", "proof"), [(passage(), "swap"), (walled_in(), "cut")], ids=["swap", "cut"]
)
def test_an_impossible_world_is_not_the_controllers_fault(tmp_path, world, proof):
    path = tmp_path / "impossible.grid"
    write_world(world, path)
    told = worldgen("run", path, "--controller", "turn-right", "--steps", "500")
    found = json.loads(
        worldgen("run", path, "--controller", "turn-right", "--steps", "500", "--json").out
    )
    verified = json.loads(worldgen("verify", path, "--json").out)
    assert told.code == 1
    assert (
        f"cannot all arrive in this world, whatever the controllers do (proved by a {proof})"
        in (told.err)
    )
    assert (found["reachable"], found["proof"]) == (False, proof)
    assert (verified["result"], verified["certificate"]) == ("blocked", proof)


def test_the_doorway_that_the_documentation_shows_is_blocked_from_both_sides(tmp_path):
    path = tmp_path / "blocked.grid"
    worldgen("doorway", "--robots", "2", "--seed", "230", "--out", path)
    found = json.loads(worldgen("run", path, "--controller", "naive", "--json").out)
    assert (found["verdict"], found["reachable"]) == ("deadlock", True)
    assert found["evidence"]["blocked"] == [[1, 2], [2, 1]]
    assert found["evidence"]["moving"] == []
