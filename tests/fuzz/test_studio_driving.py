"""Server answers for a robot driven by hand: exact, repeatable, and refused if necessary."""

import math

import numpy as np
import pytest

from fuzz.studio.driving import MOST_DRIVEN, HandDriven
from sim import simulate
from tests.helpers.raising import raises
from tests.helpers.studio import Answers, message_of, page_of, studio_of
from worldgen import Pose, Target, World, generate
from worldgen.errors import InvalidParameter

SETUP = {"motion": "swept", "time_step": 0.015, "seed": 0, "options": {}, "steps": None}
CORRIDOR = World(np.zeros((3, 9), bool), Pose(0.15, 0.15, 0.0), Target(0.75, 0.15, 0.05))


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    with studio_of(tmp_path_factory.mktemp("drive")) as gate:
        yield gate


def drive(page, commands, world=CORRIDOR, **changes):
    message = {**SETUP, "world": message_of(world), "commands": commands}
    return page.ask("drive", **(message | changes))


@pytest.mark.gate
def test_a_drive_goes_where_it_is_steered_and_ends_at_the_target(gate):
    with page_of(gate) as page:
        short = drive(page, [[4, 1.0, 0.0]])["answer"]
        assert (short["name"], short["steps"], short["ended"]) == ("you", 4, False)
        assert short["path"] == pytest.approx(3 * 2.0 * 0.015, abs=1e-3)
        whole = drive(page, [[4, 1.0, 0.0], [100, 0.5, 0.0]])["answer"]
        assert (short["verdict"], short["why"]) == ("still driving", "")
        assert whole["ended"] and whole["verdict"] == "reached"
        # The robot continues from where it was, so a drive can be repeated bit for bit.
        assert drive(page, [[4, 1.0, 0.0], [100, 0.5, 0.0]])["answer"]["digest"] == whole["digest"]


@pytest.mark.parametrize("motion", ["swept", "endpoint", "stepped"])
def test_every_motion_model_can_be_driven(gate, motion):
    with page_of(gate) as page:
        said = drive(page, [[3, 1.0, 0.0], [5, 0.5, 3.0]], motion=motion)["answer"]
        # The thesis's model has only the thesis's robots.
        assert said["steps"] == 8
        assert said["motion"] == ("swept" if motion == "stepped" else motion)


def test_it_turns_left_by_a_positive_rate():
    robot = HandDriven.of([[10, 0.0, 2.0]])
    world = generate("rooms", 3)
    episode = simulate(world, robot, time_step=0.05, steps=10, record=True)
    turned = episode.trace.heading[-1] - episode.trace.heading[0]
    assert math.remainder(turned - 1.0, 2 * math.pi) == pytest.approx(0.0, abs=1e-2)


@pytest.mark.parametrize(
    ("commands", "code"),
    [
        ([], "wrong-message"),
        ([[MOST_DRIVEN, 1.0, 0.0], [1, 0.0, 0.0]], "out-of-range"),
        ([[0, 1.0, 0.0]], "wrong-message"),
        ([[1, 2.0, 0.0]], "wrong-message"),
        ([[1, 1.0, 21.0]], "wrong-message"),
        ([[1, 1.0, math.nan]], "not-json"),
        ([[1, True, 0.0]], "wrong-message"),
        ([[1.5, 1.0, 0.0]], "wrong-message"),
        ([[1, 1.0]], "wrong-message"),
        (["forward"], "wrong-message"),
    ],
)
def test_commands_of_another_form_are_refused(tmp_path, commands, code):
    with raises(InvalidParameter, code):
        Answers(tmp_path).ask("drive", **SETUP, world=message_of(CORRIDOR), commands=commands)


def test_a_world_of_several_robots_is_refused(gate):
    with page_of(gate) as page:
        several = message_of(generate("doorway", 1, robots=2))
        said = page.ask("drive", **SETUP, world=several, commands=[[1, 1.0, 0.0]])
        assert said["error"]["code"] == "world-of-several-robots"
        said = drive(page, [[1, 1.0, 0.0]], motion="./mine.py:Motion")
        assert said["error"]["code"] == "not-registered"
