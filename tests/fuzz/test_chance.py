"""Seeds with which a run that draws random numbers fails."""

import math

import numpy as np
import pytest

from fuzz.chance import seeds_that_fail
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.shrink import shrink
from fuzz.triage.judging import failure_of
from sim.controllers.base import CompiledController
from sim.scenario import Scenario
from tests.reference.sim import layout
from worldgen import Pose, Target, World
from worldgen.files.grid import dumps, loads

SENSES = ("bump", "heading", "random", "time_step", "top_speed")
HERE = "tests.fuzz.test_chance"


def _choose(observation, memory, command):
    """Chooses east or west once and for all."""
    if memory[0] == 0.0:
        memory[0], command[layout.CMD_DRAW] = 1.0, 1.0
        if observation[layout.OBS_RANDOM] >= 0.5:
            command[layout.CMD_TURN_RATE] = math.pi / observation[layout.OBS_TIME_STEP]
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED]


choose = CompiledController("choose", _choose, (0.0,), randomised=True, senses=SENSES)


def hall(target=(1.05, 0.25)):
    """Twelve cells by five; the start is in the middle of the left half."""
    return World(np.zeros((5, 12), bool), Pose(0.35, 0.25, 0.0), Target(*target, 0.05))


@pytest.mark.gate
@pytest.mark.parametrize(("target", "share"), [((1.05, 0.25), [27, 40]), ((1.05, 0.45), [40, 40])])
def test_seeds_that_choose_the_wrong_end_are_counted(target, share):
    counted = seeds_that_fail(hall(target), Scenario(f"{HERE}:choose"))
    assert counted["failing_seeds"] == share
    assert 0.0 < counted["failing_share_at_least"] < share[0] / 40


def test_a_shrunk_failure_has_no_answer_of_the_world_that_it_came_from():
    failure = failure_of(
        certified(hall((1.05, 0.45))), Scenario(f"{HERE}:choose"), chance="sure", states=7
    )
    details = shrink(failure).failure.record.details
    assert not {"chance", "states"} & details.keys() and "failing_seeds" in details


def test_an_exact_answer_in_an_older_record_is_read():
    failure = failure_of(
        certified(hall((1.05, 0.45))), Scenario(f"{HERE}:choose"), chance="trap", states=7
    )
    again = Failure.found_in(loads(dumps(failure.stored)))
    assert again is not None
    assert (again.record.details["chance"], again.record.details["states"]) == ("trap", 7)
