"""An environment's episode is the simulator's run of the same actions, and its kernel its Python twin, to the bit."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from sim import Command, simulate
from sim.kernels import layout
from tests.helpers.twins import twin
from tests.sim.test_batch import burning
from worldgen import generate
from worldgen_plugins.for_gymnasium import NavigateEnv
from worldgen_plugins.for_gymnasium.interface import SENSORS
from worldgen_plugins.for_gymnasium.kernels import navigate
from worldgen_plugins.for_gymnasium.lockstep import Lockstep
from worldgen_plugins.for_gymnasium.options import resolve

STEPS = 300
WORLDS = {"trap": generate("trap", seed=3), "maze": generate("maze", seed=4, size=16), "fire": burning()}
ROBOTS = {
    "plain": {},
    "slow": {"acceleration": 3.0, "friction": 2.0, "turn_limit": 4.0, "slip": 0.3, "wall_friction": 0.2},
}


@dataclass(frozen=True)
class Plays:
    """A controller that knows its commands beforehand."""

    actions: tuple
    top_speed: float
    turn_rate: float

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        turn, speed = self.actions[int(memory[0])]
        return Command(speed * self.top_speed, turn * self.turn_rate), (memory[0] + 1.0,)


@pytest.mark.gate
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("name", WORLDS)
def test_an_episode_is_the_simulators_run_of_its_actions(name, robot):
    world, actions = WORLDS[name], np.random.default_rng(5).uniform(-1, 1, (STEPS, 2)).astype(np.float32)
    actions[:, 1] = np.abs(actions[:, 1]) ** 0.25
    env = NavigateEnv(world=world, robot=ROBOTS[robot], sensors=("bump", "target_distance"), turn_rate=20.0)
    _, told = env.reset(seed=1)
    plays = Plays(tuple(map(tuple, actions.astype(float).tolist())), world.robot_speed, 20.0)
    run = simulate(world, plays, steps=STEPS, seed=told["run_seed"], record=True, **ROBOTS[robot])
    states = run.trace.states.view(np.int64)
    own = slice(layout.STATE_HEADING, layout.STATE_MEMORY)
    for k in range(1, len(states) - 1):
        seen, _, over, *_ = env.step(actions[k - 1])
        state = env._lockstep.crew.state[0]
        assert state[: layout.STATE_HEADING].tolist() == states[k + 1, : layout.STATE_HEADING].tolist()
        assert state[own].tolist() == states[k, own].tolist() and bool(seen[0]) == run.trace.bump[k + 1]
    assert over == (run.verdict in ("reached", "burned"))


def told_by(begin_many, step, options, worlds, moves):
    """What kernels say of four robots, step by step, and how they leave them."""
    fleet = Lockstep(resolve(options)[0], 4, 12)
    fleet.load(worlds)
    fleet.crew.seed[:] = np.arange(4) + 7
    told = [fleet._told() for _ in range(len(moves) + 1)]
    with np.errstate(over="ignore"):  # random numbers are made by it
        begin_many(fleet._worlds(), fleet.crew, np.ones(4, bool), told[0])
        for move, one in zip(moves, told[1:], strict=True):
            step(fleet._worlds(), fleet.crew, np.zeros(0, np.int64), move, one)
    return [part.tobytes() for one in (*told[1:], fleet.crew._replace(search=fleet.crew.state)) for part in one]


@pytest.mark.gate
@pytest.mark.parametrize("distance", ["straight", "way"])
def test_the_kernel_is_its_python_twin(distance):
    worlds = [replace(WORLDS["trap"], robot_speed=9.0), WORLDS["maze"], *([WORLDS["fire"]] * (distance == "straight"))]
    options = {"sensors": tuple(SENSORS), "robot": {"beams": 3, "sensor_noise": 0.1}, "distance": distance}
    moves = np.random.default_rng(0).uniform(-1, 1, (40, 4, 2)).astype(np.float32)
    kernels = (navigate.begin_many, navigate.step)
    assert told_by(*kernels, options, worlds, moves) == told_by(*map(twin, kernels), options, worlds, moves)
