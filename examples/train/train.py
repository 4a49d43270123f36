"""Train a small policy with Stable-Baselines3's PPO and keep its weights.

Run ``python train.py [--steps N]``.
"""

import argparse
import time

import gymnasium
import numpy as np
import torch
from policy import SEES
from stable_baselines3 import PPO
from vec_env import Vectorised

WORLDS = {"family": "trap", "params": {"size": 20}}
# Seconds.
EPISODE = 15.0
# Seconds: fewer decisions are easier to learn from; the usual step is the fine one.
COARSE = 0.06
FINE = 0.015


def environments(count, time_step, **more):
    """Return worlds of one family that reward progress along the shortest path.

    A dead end earns nothing.
    """
    envs = gymnasium.make_vec(
        "worldgen.gym:worldgen/Navigate-v0", count, "vector_entry_point", autoreset_mode="SameStep",
        sensors=SEES.sensors, actions=SEES.actions, robot=SEES.robot, time_step=time_step, distance="way",
        max_episode_steps=round(EPISODE / time_step), reward={"reached": 2.0, "contact": -0.02}, **WORLDS, **more,
    )  # fmt: skip
    return Vectorised(envs)


def evaluate(model, episodes=1000):
    """Return the share of episodes in which it arrives, in worlds that it was not trained in."""
    envs = environments(episodes, FINE, pool=200, pool_seed=1_000_000)
    envs.seed(1)
    observations = envs.reset()
    done = np.zeros(episodes, bool)
    reached = 0
    while not done.all():
        observations, _, over, told = envs.step(model.predict(observations, deterministic=True)[0])
        reached += sum(told[k]["is_success"] for k in np.flatnonzero(over & ~done))
        done |= over
    return reached / episodes


def weights(policy):
    """Return the layers of the policy's network, as policy.py takes them."""
    first, _, second, _ = policy.mlp_extractor.policy_net
    layers = {"1": first, "2": second, "3": policy.action_net}
    named = {f"w{k}": layer.weight for k, layer in layers.items()} | {
        f"b{k}": layer.bias for k, layer in layers.items()
    }
    return {name: value.detach().numpy() for name, value in named.items()}


def main():
    """Train, and report how well the policy does before and after."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=3_000_000)
    parser.add_argument("--envs", type=int, default=256)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="policy.npz")
    arguments = parser.parse_args()
    # In such a small network, threads wait for each other.
    torch.set_num_threads(1)
    envs = environments(arguments.envs, COARSE, pool=300)
    envs.seed(arguments.seed)
    model = PPO(
        "MlpPolicy", envs, seed=arguments.seed, device="cpu", n_steps=64, batch_size=4096, n_epochs=6,
        learning_rate=1e-3, gamma=0.99, ent_coef=0.01,
        policy_kwargs={"net_arch": [32, 32], "activation_fn": torch.nn.ReLU},
    )  # fmt: skip
    print(f"before: arrives in {evaluate(model):.1%} of worlds that are not trained in")
    begin = time.perf_counter()
    model.learn(arguments.steps)
    print(f"{model.num_timesteps:,} steps in {time.perf_counter() - begin:.0f} s")
    print(f"after: arrives in {evaluate(model):.1%}")
    np.savez(arguments.out, **weights(model.policy))


if __name__ == "__main__":
    main()
