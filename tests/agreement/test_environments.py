"""An environment's episode is the simulator's run of the same actions, bit for bit."""

from dataclasses import dataclass

import numpy as np
import pytest

from sim import Command, simulate
from tests.agreement.test_drivers import BOX, driven_by
from tests.agreement.test_episodes_against_reference import with_waypoints
from tests.sim.test_batch import burning
from worldgen import generate
from worldgen.robot import Drive
from worldgen_plugins.for_gymnasium import NavigateEnv

STEPS = 300
WORLDS = {
    "trap": generate("trap", seed=3),
    "maze": generate("maze", seed=4, size=16),
    "fire": burning(),
    "body": driven_by(generate("trap", seed=3), footprint=BOX),
    "car": driven_by(burning(), footprint=BOX, drive=Drive(0.1, True, 3.0)),
    "tour": with_waypoints(generate("trap", seed=3)),
    "car's tour": with_waypoints(driven_by(generate("trap", seed=3), drive=Drive(0.1, True, 3.0))),
}
ROBOTS = {
    "plain": {},
    "slow": {
        "acceleration": 3.0,
        "friction": 2.0,
        "turn_limit": 4.0,
        "slip": 0.3,
        "wall_friction": 0.2,
    },
}


@dataclass(frozen=True)
class Plays:
    """A controller with a fixed list of commands."""

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
    world, actions = (
        WORLDS[name],
        np.random.default_rng(5).uniform(-1, 1, (STEPS, 2)).astype(np.float32),
    )
    actions[:, 1] = np.abs(actions[:, 1]) ** 0.25
    env = NavigateEnv(
        world=world, robot=ROBOTS[robot], sensors=("bump", "target_distance"), turn_rate=20.0
    )
    _, told = env.reset(seed=1)
    plays = Plays(tuple(map(tuple, actions.astype(float).tolist())), world.robot_speed, 20.0)
    run = simulate(world, plays, steps=STEPS, seed=told["run_seed"], record=True, **ROBOTS[robot])
    states = run.trace.states.view(np.int64)
    # The place is that after the next move; so is a car's heading. Speed and random numbers used are
    # those that the controller has set.
    moved = 3 if world.robots[0].drive.is_car else 2
    pose, own = slice(0, moved), slice(moved, 5)
    for k in range(1, len(states) - 1):
        seen, _, over, *_ = env.step(actions[k - 1])
        state = env._lockstep.crew.state[0]
        assert state[pose].tolist() == states[k + 1, pose].tolist()
        assert (
            state[own].tolist() == states[k, own].tolist()
            and bool(seen[0]) == run.trace.bump[k + 1]
        )
    assert not world.robots[0].waypoints or env._lockstep.crew.passed[0] == run.trace.passed[-1] > 0
    assert over == (run.verdict in ("reached", "burned"))
