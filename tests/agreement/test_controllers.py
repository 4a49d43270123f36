"""The core's controllers and their plain Python give the same bits, on any observations."""

import math

import numpy as np
import pytest

from benchmarks.faults import FAULTS
from sim.controllers import CONTROLLERS
from sim.controllers.controller_error import ControllerError
from sim.controllers.core_act import CoreAct
from sim.controllers.library.dynamic_window import DynamicWindow, dynamic_window_robot
from sim.controllers.library.potential_field import PotentialField, potential_field_robot
from sim.controllers.library.three_layer import ThreeLayer, three_layer_robot
from sim.controllers.library.vfh import VfhPlus, vfh_robot
from sim.controllers.taught import with_exploration
from tests.reference.fuzz import as_classes
from tests.reference.sim.controllers import dynamic_window, potential_field, three_layer, vfh
from tests.reference.sim.library import ACTS

STEPS = 150
SLOW = {
    "mapper": 15,
    "signal-mapper": 15,
    "tangent-bug": 40,
}  # steps for controllers that are slow in plain Python
LIBRARY = (
    "bug1", "bug2", "dynamic-window", "gestalt", "mapper", "mapper-small", "odometry-bug", "potential-field",
    "q-learner", "q-learning", "random-walk", "signal-mapper", "signal-three-layer",
    "tangent-bug", "three-layer", "topological", "turn-left", "turn-random", "turn-right", "vfh",
    "wall-left", "wall-right",
)  # fmt: skip
RAISED = (IndexError, ZeroDivisionError)


def observations(beams, seed, steps):
    """Yields observations in an order that no simulator would produce.

    Half of the time nearly the same place, half of the time another one.
    """
    rng = np.random.default_rng(seed)
    seen = np.zeros(17 + beams)
    for step in range(steps):
        if step == 0 or rng.random() < 0.5:
            seen[1:5] = rng.uniform(-math.pi, math.pi, 4)
            seen[5:7] = rng.uniform(0.0, 3.0, 2)
            seen[7] = rng.uniform(-math.pi, math.pi)
            seen[8] = rng.uniform(0.05, 4.0)
            seen[17:] = np.minimum(2.0, rng.exponential(0.3, beams) + 0.05)
        if step % 50 == 0:
            seen[10:13] = (
                rng.choice([0.02, 0.1]),
                rng.choice([0.5, 2.0]),
                rng.choice([0.03, 0.07, 0.2]),
            )
        seen[0] = rng.random() < 0.4
        seen[2] = 0.0 if rng.random() < 0.2 else rng.uniform(0.001, 1.0)
        seen[5:7] += rng.normal(0.0, 0.02, 2)
        seen[9] = rng.random()
        seen[14:17] = rng.normal(0.0, 0.03, 3)
        seen[14:16] += seen[5:7]
        seen[16] += seen[4]
        yield seen.copy()


def drive(act, memory, seen):
    """Return memory and command after a step, as bits; the exception if it raised one."""
    kept = np.array(memory)
    command = np.zeros(3)
    try:
        act(seen, kept, command)
    except ControllerError as error:
        return error.error
    except RAISED as error:
        return type(error).__name__
    command[np.isnan(command)] = math.nan  # whose sign is meaningless
    return kept, command.tobytes()


def check_alike(controller, plain, seed):
    memory = np.array(controller.memory)
    for seen in observations(controller.needs.beams, seed, SLOW.get(controller.name, STEPS)):
        one = drive(controller.act, memory, seen.copy())
        other = drive(plain, memory, seen.copy())
        if isinstance(one, str) or isinstance(other, str):
            assert one.startswith(other)
            continue
        assert one[0].tobytes() == other[0].tobytes() and one[1] == other[1]
        memory = one[0]


@pytest.mark.parametrize("name", LIBRARY)
def test_a_controller_of_the_library_is_its_plain_python(name):
    controller = CONTROLLERS.get(name)
    check_alike(controller, ACTS[controller.act.name], seed=7)


COMPOSITIONS = (
    "behaviours:drive,seek,collide+turn=random",
    "behaviours:avoid,escape+patience=5,approach",
    "behaviours:follow+interruptible,swerve,wander",
    "behaviours:collide+interruptible+duration=3,seek+interruptible,home",
    "behaviours+by=vote:avoid+priority=3,swerve+priority=2,approach,wander",
    "behaviours+by=vote:drive,seek,collide,follow,escape+patience=3",
    "behaviours+by=learning:avoid,follow+duration=9,approach,escape+patience=7,home",
)  # fmt: skip


@pytest.mark.parametrize("name", COMPOSITIONS)
def test_a_composition_is_its_plain_python(name):
    controller = CONTROLLERS.get(name)
    assert controller.act == CoreAct("composition")
    for seed in range(4):
        check_alike(controller, ACTS["composition"], seed=seed)


def test_a_learner_that_explores_is_its_plain_python():
    controller = with_exploration(CONTROLLERS.get("q-learner"), 400, "q-learner")
    check_alike(controller, ACTS["q-learner"], seed=5)


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_its_plain_python(name):
    check_alike(FAULTS[name], as_classes.ACTS[name], seed=8)


TUNED = {
    "potential-field": (
        potential_field_robot,
        potential_field,
        PotentialField(push=1e-4),
        lambda _: (),
    ),
    "vfh": (vfh_robot, vfh, VfhPlus(turning_radius=0.2, wide=4), lambda _: (np.zeros(72),)),
    "dynamic-window": (
        dynamic_window_robot,
        dynamic_window,
        DynamicWindow(speeds=3, turns=7),
        lambda seen: (np.zeros((len(seen) - 17, 2)),),
    ),
    "three-layer": (
        three_layer_robot,
        three_layer,
        ThreeLayer(patience=7, look=0.1),
        lambda _: (np.zeros(48, np.int64), np.zeros(48, np.int64)),
    ),
}


@pytest.mark.gate
@pytest.mark.parametrize("name", TUNED)
def test_a_controller_with_numbers_of_one_s_own_is_its_plain_python(name):
    made, module, tuned, room = TUNED[name]

    def plain(seen, memory, command):
        module.drive(seen, memory, command, *room(seen), tuned)

    controller = made(tuned)
    assert controller.act == CoreAct(f"{name}-tuned")
    check_alike(controller, plain, seed=9)
