"""Native search with controllers that are not compiled.

Its screening runs are the same as the simulator's.
"""

import math
import sys
from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.as_classes import AsClass
from fuzz.campaign.unit import run_unit
from fuzz.screening import evaluate
from fuzz.screening.one_by_one import OneByOne
from fuzz.search.native import scenes as drawn
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from sim import Command, Commands
from sim.controllers import CONTROLLERS
from sim.controllers.programs.batch import Offer
from sim.episode import prepare
from sim.scenario import Scenario
from worldgen.lattice import UNIT
from worldgen.random_streams import RandomStream
from worldgen.world import World

HERE = "tests.fuzz.test_native_kinds"


@dataclass(frozen=True)
class Homing:
    """Drives to the target, and away from walls for a while; draws a random number at each bump."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        (left,) = memory
        if observation.bump:
            return Command(observation.top_speed, 40.0 * (observation.random - 0.5), True), (15.0,)
        if left > 0.0:
            return Command(observation.top_speed), (left - 1.0,)
        turn = math.remainder(observation.target_heading - observation.heading, 2 * math.pi)
        return Command(observation.top_speed, turn / observation.time_step), (0.0,)


@dataclass(frozen=True)
class Planner(Homing):
    """Plans with the world, and drives more slowly in larger ones.

    The length of its memory is the world's height.
    """

    def reset(self, world):
        assert isinstance(world, World)
        assert world.certificate is None
        return (0.0, *([float(world.width)] * world.height))

    def act(self, observation, memory):
        command, (left,) = super().act(observation, memory[:1])
        return command._replace(speed=command.speed * 10.0 / memory[1]), (left, *memory[1:])


class Attributes(Homing):
    """Keeps its memory in attributes that ``reset`` sets, as many classes do."""

    def reset(self):
        self.left = 0.0
        return ()

    def act(self, observation, memory):
        command, (self.left,) = super().act(observation, (self.left,))
        return command, memory


class Fragile(Homing):
    """Raises when it touches a wall in the right half of a large world."""

    def act(self, observation, memory):
        if observation.bump and observation.x > 1.0:
            raise ValueError(observation.x)
        return super().act(observation, memory)


class TwiceFragile(Homing):
    """Raises when it touches a wall, at another place if that is in the right half of a large
    world.
    """

    def act(self, observation, memory):
        if observation.bump and observation.x > 1.0:
            raise KeyError("seldom")
        if observation.bump:
            raise ValueError("often")
        return super().act(observation, memory)


class Mistaken(Homing):
    """Commands nan when it touches a wall in the right half of a large world."""

    def act(self, observation, memory):
        command, memory = super().act(observation, memory)
        return command._replace(
            speed=math.nan if observation.bump and observation.x > 1.0 else command.speed
        ), memory


class Unready(Homing):
    """Has no initial memory."""

    def reset(self):
        return None


WallLeft = AsClass("wall-left")

CLASSES = (
    "Homing",
    "Homing+motion=endpoint",
    "Planner",
    "Attributes",
    "Fragile",
    "Mistaken",
    "Unready",
)

PROGRAM = """
import json, sys
left = 0
for line in sys.stdin:
    seen = json.loads(line)
    if "reset" in seen:
        left = 0
        continue
    left = 20 if seen["bump"] else max(left - 1, 0)
    turn = 1.0 if seen["bump"] else 0.0 if left else seen["target_heading"] - seen["heading"]
    print(json.dumps({"speed": 2.0, "turn_rate": turn / seen["time_step"]}), flush=True)
"""


PROGRAM_OF_MANY = """
import json, sys
left = {}

def turn_of(place, bump, target, heading, time_step):
    left[place] = 20 if bump else max(left.get(place, 0) - 1, 0)
    return (1.0 if bump else 0.0 if left[place] else target - heading) / time_step

for line in sys.stdin:
    seen = json.loads(line)
    if "worldgen" in seen:
        left.clear()
        first = "reset" in seen
        continue
    if "robots" in seen:
        for place in seen["reset"]:
            left[place] = 0
        columns = zip(seen["robots"], seen["bump"], seen["target_heading"], seen["heading"], seen["time_step"])
        turns = [turn_of(*one) for one in columns]
        answer = {"speed": [2.0] * len(turns), "turn_rate": turns}
    else:
        turn = turn_of(0, seen["bump"], seen["target_heading"], seen["heading"], seen["time_step"])
        answer = {"speed": 2.0, "turn_rate": turn}
        if first and OFFER:
            answer["batch"] = {"robots": 8, "senses": ["bump", "target_heading", "heading", "time_step"]}
    first = False
    print(json.dumps(answer), flush=True)
"""


class Many:
    """Homing for many robots at once, without random numbers."""

    def reset(self):
        return (0.0,)

    def act_many(self, observation, memory):
        bump, left = observation.bump, memory[:, 0]
        ahead = np.arctan2(
            np.sin(observation.target_heading - observation.heading),
            np.cos(observation.target_heading - observation.heading),
        )
        turn = np.where(bump, 1.3, np.where(left > 0.0, 0.0, ahead))
        left = np.where(bump, 15.0, np.maximum(left - 1.0, 0.0))
        return Commands(observation.top_speed, turn / observation.time_step), left[:, np.newaxis]


class ManyFragile(Many):
    """Raises when any robot touches a wall in the right half of a large world."""

    def act_many(self, observation, memory):
        if (observation.bump & (observation.x > 1.5)).any():
            raise ValueError("a wall")
        return super().act_many(observation, memory)


class ManyCounting(Many):
    """Counts its calls, and drives more slowly with each."""

    calls = 0

    def act_many(self, observation, memory):
        ManyCounting.calls += 1
        commands, memory = super().act_many(observation, memory)
        return commands._replace(speed=observation.top_speed / (1 + ManyCounting.calls)), memory


def named(name):
    return Scenario.parse(f"{HERE}:{name}")


def program(text, deadline=5):
    return Scenario(f"cmd+deadline={deadline}+start={deadline}:{sys.executable} -I -S -c '{text}'")


def look(scenario, count, budget=None, seed=5):
    layouts = drawn(RandomStream(seed), count)
    seeds = np.arange(count, dtype=np.uint64)
    return evaluate(layouts, scenario, seeds, np.resize([0.03, 0.06, 0.15], count), budget)


def assert_looks_are_runs(looks):
    for n in np.flatnonzero(looks.ran):
        scenario = looks.scenario_of(n)
        world = looks.world(n)
        budget = int(looks.budget[n])
        run = prepare(world, scenario.controller, scenario.options(world, budget)).run(
            budget, find_loop=True, record=False
        )
        assert looks.verdict[n] in (run.ending, "undecided", "overlap")
        assert (looks.steps[n], looks.collisions[n]) == (run.steps, run.collisions)
        assert looks.period[n] == run.period or run.ending != "loop"
        assert looks.path[n] * world.cell_size / UNIT == pytest.approx(run.path_length, rel=1e-12)
        assert looks.raw["last_new_cell"][n] == run.last_new_cell


@pytest.mark.gate
@pytest.mark.parametrize("name", CLASSES)
def test_a_look_at_a_class_is_its_run_in_the_decoded_world(name):
    assert_looks_are_runs(look(named(name), 60, budget=300))


@pytest.mark.gate
def test_a_look_at_a_program_is_its_run_in_the_decoded_world():
    assert_looks_are_runs(look(program(PROGRAM), 12, budget=60))


@pytest.mark.gate
@pytest.mark.parametrize("name", ["Many", "Many+motion=endpoint", "ManyFragile"])
def test_a_look_at_a_vector_class_is_its_run_alone_in_the_decoded_world(name, monkeypatch):
    monkeypatch.setattr("fuzz.screening.in_lockstep.PLACES", 16)
    looks = look(named(name), 100, budget=300)
    assert_looks_are_runs(looks)
    assert {"crash" if name == "ManyFragile" else "undecided", "reached"} <= set(looks.verdict)


@pytest.mark.gate
def test_a_vector_class_looks_the_same_for_any_number_of_places(monkeypatch):
    few = look(named("Many"), 200)
    monkeypatch.setattr("fuzz.screening.in_lockstep.PLACES", 3)
    assert (look(named("Many"), 200).raw == few.raw).all()


def test_a_vector_class_that_remembers_outside_its_memory_is_run_alone(monkeypatch):
    alone = []
    run = OneByOne.run
    monkeypatch.setattr(
        OneByOne, "run", lambda self, worlds: alone.append(worlds) or run(self, worlds)
    )
    look(named("ManyCounting"), 12, budget=30)
    look(named("Many"), 12, budget=30)
    assert alone == [12]


@pytest.mark.gate
def test_a_program_that_offers_it_drives_many_robots_at_once():
    offering = program(PROGRAM_OF_MANY.replace("OFFER", "True"))
    one = look(program(PROGRAM_OF_MANY.replace("OFFER", "False")), 40, 60)
    many = look(offering, 40, 60)
    assert CONTROLLERS.get(offering.controller).offer == Offer(
        8, ("bump", "target_heading", "heading", "time_step")
    )
    assert (one.raw == many.raw).all()
    assert {"reached", "undecided"} <= set(many.verdict)


def test_a_program_that_fails_among_others_is_run_alone():
    text = PROGRAM_OF_MANY.replace("OFFER", "True").replace(
        'answer = {"speed": [2.0]', 'answer = {"sped": [2.0]'
    )
    alone = look(program(PROGRAM_OF_MANY.replace("OFFER", "False")), 12, 30)
    assert (look(program(text), 12, 30).raw == alone.raw).all()


@pytest.mark.parametrize(
    ("name", "verdict"), [("Fragile", "crash"), ("Mistaken", "invalid-command")]
)
def test_a_class_that_fails_ends_only_its_own_run(name, verdict):
    assert {verdict, "reached"} <= set(look(named(name), 60, budget=300).verdict.tolist())


def test_crashes_in_two_places_have_two_keys():
    looks = look(named("TwiceFragile"), 200, budget=300)
    assert len(set(looks.key[looks.verdict == "crash"].tolist())) == 2


def test_after_two_hangs_of_a_program_the_rest_is_not_run():
    looks = look(program("import time; time.sleep(60)", deadline=0.2), 30)
    assert looks.ran.sum() == 2
    assert set(looks.verdict[looks.ran]) == {"hang"}


def test_looks_at_a_class_are_those_at_the_compiled_controller_that_it_is():
    compiled = look(Scenario("wall-left"), 80, 600)
    twin = look(named("WallLeft"), 80, 600)
    decided = compiled.verdict != "undecided"
    assert (compiled.raw[decided] == twin.raw[decided]).all()
    assert (compiled.verdict == twin.verdict).all()
    assert {"reached", "loop"} <= set(compiled.verdict)


@pytest.mark.nightly
def test_a_unit_of_a_class_is_a_function_of_its_number_and_replays():
    config = CampaignConfig(named("WallLeft"), seed=2, examples=60, families=("native",))
    one = run_unit(config, 1)
    two = run_unit(config, 1)
    assert [found.dumps() for found in one.failures.values()] == [
        found.dumps() for found in two.failures.values()
    ]
    assert (one.worlds, one.steps, one.verdicts) == (two.worlds, two.steps, two.verdicts)
    assert one.failures
    assert all(replay(failure).confirmed for failure in one.failures.values())
