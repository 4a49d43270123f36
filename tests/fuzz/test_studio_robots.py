"""The server's answers for robots with their own options, next to others."""

from pathlib import Path

import pytest

from sim import simulate
from sim.scenario import Scenario
from tests.helpers.raising import raises
from tests.helpers.studio import Answers, message_of, page_of, studio_of
from worldgen.errors import InvalidParameter
from worldgen.files.grid import loads, read_world

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots")
    (folder / "config-05.grid").write_bytes(CONFIG_5.read_bytes())
    (folder / "evil.py").write_text(f"open({str(folder / 'ran')!r}, 'w')\n")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder, file="config-05.grid") as gate:
        yield gate


def run(page, controllers, **changes):
    message = {
        "world": message_of(read_world(CONFIG_5)),
        "motion": "stepped",
        "time_step": 0.015,
        "seed": 0,
    }
    message |= {"controllers": controllers, "steps": 500, "options": {}}
    return page.ask("run", **(message | changes))["parts"][1:]


def digest(label):
    world, scenario = read_world(CONFIG_5), Scenario.parse(label, motion="stepped", time_step=0.015)
    return simulate(world, scenario.controller, scenario.options(world, 500)).trace_digest


def test_a_robot_gets_a_body_and_goals_by_the_options_of_the_command_line(tmp_path):
    world = read_world(CONFIG_5)
    server = Answers(tmp_path)

    def goal(sent, **texts):
        empty = dict.fromkeys(("footprint", "heading", "arrival", "waypoints"), "")
        return server.ask("goal", world=sent, **(empty | texts))

    given = goal(message_of(world), footprint="0.2x0.1", heading="1.5:0.1", waypoints="1.0,1.0")
    (robot,) = loads(given["source"].encode()).robots
    assert (len(robot.footprint), robot.target.heading, len(robot.waypoints)) == (4, 1.5, 1)
    back = loads(goal(given)["source"].encode())
    assert back.robots == world.robots
    with raises(InvalidParameter, "no-places"):
        goal(message_of(world), waypoints="2")


@pytest.mark.gate
def test_robots_with_and_without_options_of_their_own_drive_at_once(gate):
    labels = ["thesis-1", "thesis-1+repaired", "thesis-1+slip=0.2"]
    with page_of(gate) as page:
        found = [part["digest"] for part in run(page, labels)]
    assert found == [digest(label) for label in labels] and len(set(found)) > 1


@pytest.mark.gate
def test_a_robot_with_behaviours_comes_with_its_flow_chart_and_another_one_without(gate):
    with page_of(gate) as page:
        (part,) = run(page, ["thesis-1+collide_ticks=9"])
        (bug,) = run(page, ["bug1"], motion="swept")
    chart = part["arbitration"]
    assert bug["arbitration"] is None and chart["arbiter"] == "priority"
    assert "9 steps" in chart["words"][-1]
    boxes = [
        attributes["data-part"] for _, attributes, _ in chart["shapes"] if "data-part" in attributes
    ]
    assert boxes == ["drive", "seek", "collide"] and set(boxes) == set(part["run"]["behaviours"])


@pytest.mark.gate
def test_a_robot_s_own_option_counts_more_than_that_of_all(gate):
    with page_of(gate) as page:
        parts = run(page, ["thesis-1", "thesis-1+slip=0.3"], options={"slip": 0.2})
    assert [part["digest"] for part in parts] == [
        digest("thesis-1+slip=0.2"),
        digest("thesis-1+slip=0.3"),
    ]


@pytest.mark.gate
def test_what_is_wrong_with_one_robot_s_options_is_told_and_the_others_drive(gate):
    with page_of(gate) as page:
        wrong, right = run(page, ["thesis-1+slop=0.3", "thesis-1"])
    assert (wrong["error"]["code"], wrong["error"]["facts"]["name"]) == ("unknown-name", "slop")
    assert right["digest"] == digest("thesis-1")


@pytest.mark.parametrize(
    "name", ["{}:Robot+noise", "turn-left+motion={}:Motion", "turn-left+motion={}:Motion+slip=0.1"]
)
def test_options_bring_no_code_of_a_file_along(gate, folder, name):
    with page_of(gate) as page:
        (part,) = run(page, [name.format(folder / "evil.py")])
    assert "error" in part and "run" not in part and not (folder / "ran").exists()


@pytest.mark.gate
@pytest.mark.parametrize(
    "wrong", ["nope", "thesis-1+foo=3", "./evil.py:X", "thesis-1+motion=./evil.py:X"]
)
def test_what_is_no_robot_is_refused_when_it_is_added(gate, wrong):
    ask = {"motion": "stepped", "time_step": 0.015, "seed": 0, "options": {}}
    with page_of(gate) as page:
        assert "error" in page.ask("check", controller=wrong, **ask)
        assert "answer" in page.ask("check", controller="thesis-1+repaired", **ask)
        swept = ask | {"motion": "swept"}
        assert "answer" in page.ask("check", controller="turn-right+slip=0.1", **swept)
