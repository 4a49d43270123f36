"""Behaviours compose: by priority, by vote, by learning; in C, in Python, and as the thesis's
robots.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import Command, CompiledController, simulate
from sim.controllers import CONTROLLERS, names_in
from sim.controllers.behaviours import BEHAVIOURS, Behaviour, Layer, composed
from sim.controllers.behaviours.arbitration import acted_at, acting, sentences, shares
from sim.controllers.behaviours.base import UNTIL_DONE
from sim.controllers.behaviours.chart import chart_svg
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter
from worldgen.families import maze, trap
from worldgen.files.grid import read_world

WORLD = trap(3, size=24)
ROBOTS = {
    "turn-right": "behaviours:drive,seek,collide",
    "turn-left": "behaviours:drive,seek,collide+turn=left",
    "turn-random": "behaviours:drive,seek,collide+turn=random",
}
FAILURES = Path(__file__).parents[2] / "corpora" / "failures"
SHIPPED = [path for robot in ROBOTS for path in sorted((FAILURES / robot).glob("*/*.grid"))]
MINE = """
from sim import Command

class Back:
    duration = 4
    senses = ("bump", "top_speed")
    memory = (0.0,)
    def trigger(self, observation, memory):
        return observation.bump
    def action(self, observation, memory):
        return Command(-observation.top_speed, 0.4), ((memory[0] + 1.0) % 5.0,)

class Raises(Back):
    def action(self, observation, memory):
        return 1 / 0

class Forgets(Back):
    def action(self, observation, memory):
        return Command(), ()

class Words(Back):
    def action(self, observation, memory):
        return ("fast", 0.4), memory

class WordsInMemory(Back):
    def action(self, observation, memory):
        return Command(), ("far",)

class Hides(Back):
    def action(self, observation, memory):
        self.count = getattr(self, "count", 0) + 1
        return super().action(observation, memory)

class Tires(Back):
    count = 0
    def action(self, observation, memory):
        self.count = min(self.count + 1, 30)
        return Command(-observation.top_speed, 0.4 * (self.count < 30)), memory
"""


def path_of(world, controller, options):
    """Return a run's poses, contacts and acting behaviours, without the memory."""
    episode = simulate(world, controller, options, record=True)
    trace = episode.trace
    poses = np.column_stack((trace.x, trace.y, trace.heading, trace.bump))
    acted = acting(CONTROLLERS.get(controller).arbitration, trace) if trace.active is None else []
    return episode.verdict, episode.steps, poses.tobytes(), acted


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_thesis_robot_is_the_composition_of_its_three_behaviours(robot):
    for seed in range(3):
        world = maze(seed, size=20)
        options = replace(Scenario(robot).options(world, 3000), seed=seed)
        assert path_of(world, robot, options) == path_of(world, ROBOTS[robot], options)


@pytest.mark.gate
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_shipped_failure_of_a_thesis_robot_is_one_of_the_composition(path):
    world = read_world(path)
    failure = world.failure
    options = Scenario(failure.controller).run.of(
        failure.motion, failure.seed, dict(failure.parameters)
    )
    ours = path_of(world, ROBOTS[failure.controller], options)
    assert ours == path_of(world, failure.controller, options)
    assert ours[0] == failure.verdict


@pytest.mark.parametrize("robot", ROBOTS)
def test_under_stepped_the_thesis_s_own_program_runs_for_the_composition(robot):
    options = Scenario.parse(robot, motion="stepped").options(WORLD, 2000)
    ours = simulate(WORLD, ROBOTS[robot], options)
    assert ours.trace_digest == simulate(WORLD, robot, options).trace_digest
    assert CONTROLLERS.get(ROBOTS[robot]).thesis_rule == CONTROLLERS.get(robot).thesis_rule


def test_a_composition_that_differs_from_the_thesis_s_has_no_rule_of_it():
    for name in (
        "behaviours:seek,drive,collide",
        "behaviours:drive+duration=3,seek,collide",
        "behaviours:drive,seek,collide+interruptible",
        "behaviours+by=vote:drive,seek,collide",
    ):
        assert CONTROLLERS.get(name).thesis_rule == 0


def test_the_part_with_the_highest_priority_acts_whatever_the_order():
    one = simulate(WORLD, "behaviours:avoid,approach", steps=500)
    other = simulate(WORLD, "behaviours:approach+priority=1,avoid+priority=2", steps=500)
    assert (one.steps, one.path_length) == (other.steps, other.path_length)
    assert simulate(WORLD, "behaviours:approach,avoid", steps=500).path_length != one.path_length


def test_a_part_that_keeps_control_is_not_interrupted_and_one_that_does_not_is():
    def acted(text):
        controller = CONTROLLERS.get(text)
        episode = simulate(WORLD, text, steps=400, record=True)
        return acting(controller.arbitration, episode.trace)

    interrupted = acted("behaviours:avoid,approach+duration=1000000")
    assert interrupted.count("avoid") > 0
    kept = Layer(BEHAVIOURS.get("approach"), duration=1e6, interruptible=False)
    controller = composed((BEHAVIOURS.get("avoid"), kept))
    episode = simulate(WORLD, controller, steps=400, record=True)
    assert set(acting(controller.arbitration, episode.trace)) == {"approach"}


def test_nothing_applies_and_the_robot_stands_still():
    episode = simulate(WORLD, "behaviours:avoid", steps=50, record=True)
    assert episode.path_length == 0.0
    arbitration = CONTROLLERS.get("behaviours:avoid").arbitration
    assert shares(arbitration, acting(arbitration, episode.trace)) == {"avoid": 0.0, "none": 1.0}


def test_an_arbiter_that_learns_reaches_what_the_same_parts_by_priority_never_do():
    parts = "avoid,follow,approach,escape"
    assert simulate(WORLD, f"behaviours+by=learning:{parts}", steps=4000).verdict == "reached"
    assert simulate(WORLD, f"behaviours:{parts}", steps=4000).verdict == "loop"


def test_a_behaviour_in_python_takes_part_and_its_loop_is_proved(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    for by in ("", "+by=vote", "+by=learning"):
        name = f"behaviours{by}:{tmp_path}/mine.py:Back,approach"
        episode = simulate(WORLD, name, steps=60_000)
        assert episode.verdict in {"loop", "reached"}


def test_the_arbiter_treats_a_behaviour_in_python_as_one_in_c():
    def towards(observation, memory):
        turn = observation.signal_heading - observation.heading
        turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
        return Command(observation.top_speed, turn / observation.time_step), memory

    own = Behaviour("mine", lambda seen, _: seen.signal > 0.0, towards)
    avoid = BEHAVIOURS.get("avoid")
    in_c = composed((avoid, BEHAVIOURS.get("approach")))
    mixed = composed((avoid, own))
    assert isinstance(in_c, CompiledController) and not isinstance(mixed, CompiledController)
    one = simulate(WORLD, in_c, steps=800, record=True)
    other = simulate(WORLD, mixed, steps=800, record=True)
    steps = min(one.steps, other.steps)
    assert steps > 100
    assert acting(in_c.arbitration, one.trace)[:100] == [
        name.replace("mine", "approach") for name in acting(mixed.arbitration, other.trace)[:100]
    ]


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("Raises", "crash"),
        ("Forgets", "invalid-command"),
        ("Words", "invalid-command"),
        ("WordsInMemory", "invalid-command"),
    ],
)
def test_a_behaviour_in_python_that_fails_ends_the_run_as_a_controller_would(
    tmp_path, capfd, name, verdict
):
    (tmp_path / "mine.py").write_text(MINE)
    episode = simulate(WORLD, f"behaviours:{tmp_path}/mine.py:{name},approach", steps=500)
    assert episode.verdict == verdict
    assert capfd.readouterr().err == ""  # cffi would print a traceback there, and go on


def test_a_behaviour_with_hidden_state_is_not_proved_to_loop(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    episode = simulate(WORLD, f"behaviours:{tmp_path}/mine.py:Hides,approach", steps=4000)
    assert episode.verdict in {"stalled", "timeout"}


def test_a_behaviour_keeps_nothing_from_one_run_to_the_next(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    name = f"behaviours:{tmp_path}/mine.py:Tires,approach"
    runs = [simulate(WORLD, name, steps=1000) for _ in range(3)]
    assert len({(run.verdict, run.trace_digest) for run in runs}) == 1
    assert runs[0].verdict != "loop"


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("behaviours:avid", "unknown-name"),
        ("behaviours:avoid+angl=1", "unknown-name"),
        ("behaviours:avoid+angle=9", "out-of-range"),
        ("behaviours:avoid,,home", "empty-name"),
        ("behaviours:", "empty-name"),
        ("behaviours+by=force:avoid", "unknown-name"),
        ("behaviours:" + ",".join(["avoid"] * 17), "out-of-range"),
    ],
)
def test_a_wrong_composition_is_an_error_with_a_code(name, code):
    with pytest.raises(InvalidParameter) as caught:
        CONTROLLERS.get(name)
    assert caught.value.code == code


def test_a_behaviour_without_an_action_is_refused(tmp_path):
    (tmp_path / "mine.py").write_text("class Idle:\n    def trigger(self, seen, memory): ...\n")
    with raises(InvalidParameter, "not-a-behaviour"):
        CONTROLLERS.get(f"behaviours:{tmp_path}/mine.py:Idle")
    with raises(InvalidParameter, "out-of-range"):
        Behaviour("mine", lambda *_: 1, lambda *_: 1, duration=-1)


def test_options_of_the_run_stand_before_the_colon_and_come_back_in_the_label():
    text = "behaviours+by=vote+sensor_noise=0.1:avoid+angle=1.5,approach"
    scenario = Scenario.parse(text)
    assert scenario.run.robot.sensor_noise == 0.1
    assert scenario.controller == "behaviours+by=vote:avoid+angle=1.5,approach"
    assert Scenario.parse(scenario.label()) == scenario


def test_a_list_of_controllers_may_hold_a_composition():
    assert names_in("bug2,behaviours:avoid,follow+hand=right,vfh") == [
        "bug2",
        "behaviours:avoid,follow+hand=right",
        "vfh",
    ]


def test_the_trace_and_the_json_say_which_behaviour_acted(tmp_path):
    path = tmp_path / "w.grid"
    worldgen("trap", "--size", "24", "--seed", "3", "--out", path)
    name = "behaviours:follow,approach"
    out = worldgen("run", path, "--controller", name, "--json", "--trace", tmp_path / "t.csv").out
    found = json.loads(out)["behaviours"]
    assert set(found) == {"follow", "approach"} and sum(found.values()) == pytest.approx(1.0)
    header, first, *rows = (tmp_path / "t.csv").read_text().splitlines()
    assert header == "t,x,y,heading,behaviour" and first.endswith(",")
    acted = [row.rpartition(",")[2] for row in rows]
    assert acted.count("follow") / len(acted) == pytest.approx(found["follow"], abs=1e-6)


def test_a_chart_names_each_part_once_and_is_well_formed():
    from xml.etree import ElementTree

    for name in (*ROBOTS.values(), "behaviours+by=vote:avoid,approach", "subsumption"):
        arbitration = CONTROLLERS.get(name).arbitration
        root = ElementTree.fromstring(chart_svg(arbitration, name))
        words = [one.text for one in root.iter("{http://www.w3.org/2000/svg}text")]
        assert all(words.count(part) == 1 for part in arbitration.names)
        boxes = [box.get("data-part") for box in root.iter() if box.get("data-part")]
        assert sorted(boxes) == sorted(arbitration.names)
        described = root.findtext("{http://www.w3.org/2000/svg}desc")
        assert all(one in described for one in sentences(arbitration))


@pytest.mark.parametrize("robot", ["turn-random", "behaviours:avoid,escape,approach"])
def test_who_acted_is_known_at_some_steps_as_it_is_at_all(robot):
    episode = simulate(maze(3, size=20), robot, steps=9000, record=True)
    arbitration = CONTROLLERS.get(robot).arbitration
    every = acting(arbitration, episode.trace)
    some = np.array([0, 1, 2, 50, *range(150, episode.steps, 700), episode.steps])
    found = acted_at(arbitration, episode.trace, some).tolist()
    names = (*arbitration.names, "none")
    assert [names[part] for part in found] == ["none", *(every[step - 1] for step in some[1:])]
    assert len(set(every)) > 1


def test_the_chart_of_the_thesis_s_own_program_has_its_options():
    label = "thesis-2+motion=stepped+collide_ticks=9+turn_angle=0.5"
    words = "\n".join(sentences(Scenario.parse(label).arbitration))
    assert "turn left by 28.65 degrees, and drive on for 9 steps" in words
    assert "turn to a random heading" in sentences(Scenario.parse("thesis-3").arbitration)[-1]


def test_every_registered_behaviour_says_when_it_applies_and_what_it_does():
    for name in BEHAVIOURS:
        one = BEHAVIOURS.get(name)
        assert one.name == name and one.applies and one.does
        assert one.duration == UNTIL_DONE or one.duration >= 0
