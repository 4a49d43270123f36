"""Measure steps per second of the Gymnasium environments and of other libraries of environments.

``python -m benchmarks.gymnasium`` prints a table; ``--json`` prints one object. It has each case's
rate and its ratio to each peer, all from one run. Every case and peer runs in its own process, and
they take turns in every round, so that other work on the machine affects all alike; the best of all
rounds counts. A peer runs in the interpreter that its option names, ``--envpool``, ``--minigrid``
or ``--navix``, otherwise in this one; a peer that is not installed is skipped and named.

Rates are steps of one robot per second of the process's CPU time, of all its threads, over calls of
``step`` only: actions are drawn before, or, of a policy, outside the clock. All that ``step`` does
counts: what Python does around the kernel, observations made again, rewards, and episodes that
begin.

- ``random``: discrete actions, equally likely. Robots push along walls in nearly half of their
  steps, which are the expensive ones.
- ``turns away``: ahead, and after a bump on the spot for 5 to 24 steps; walls are touched in one
  step of twenty.

Peers do different things: MiniGrid, NAVIX and FrozenLake move on grids, CartPole is a formula;
envpool's PointMaze moves a ball among walls with MuJoCo.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import click
import gymnasium
import numpy as np

import worldgen.gym
from benchmarks.peer_scripts import add_peer_options, run_peer

# The words of a round that takes seconds; the gate runs it.
TINY = ("--rounds", "1")

# Seconds of a measurement.
SECONDS = 1.5
ROBOTS = 4096
PLAIN = ("target_direction", "target_distance", "bump")
MAZE = {"family": "maze", "params": {"size": 30}, "actions": "discrete", "turn_rate": 12.0}
PEERS = ("envpool", "minigrid", "navix")
Policy = Callable[[Any, int], Any]


def _random(robots: int) -> Policy:
    rng = np.random.default_rng(0)
    actions = [rng.integers(0, 5, robots) for _ in range(8)]
    return lambda _, k: actions[k % 8]


def _turns_away(robots: int) -> Policy:
    rng = np.random.default_rng(0)
    rest = np.zeros(robots, np.int64)

    def act(observation: Any, _: int) -> Any:
        rest[...] = np.where(
            observation[:, 3] > 0.0, rng.integers(5, 25, robots), np.maximum(rest - 1, 0)
        )
        return np.where(rest > 0, 3, 0)

    return act


def _many(
    policy: Callable[[int], Policy], sensors: tuple[str, ...] = PLAIN, **options: Any
) -> float:
    """Return steps per second of the vector environment.

    The kernels have been compiled and the robots are moving by then.
    """
    name = worldgen.gym.ENVIRONMENT
    limit = 1000
    envs = gymnasium.make_vec(
        name, ROBOTS, "vector_entry_point", sensors=sensors, max_episode_steps=limit, **options
    )
    act = policy(ROBOTS)
    observation, _ = envs.reset(seed=1)
    # The first 200 steps warm up and are not timed.
    count = -200
    took = 0.0
    while took < SECONDS:
        actions = act(observation, count)
        begin = time.process_time()
        observation, *_ = envs.step(actions)
        took += time.process_time() - begin if count >= 0 else 0.0
        count += 1
    return count * ROBOTS / took


def _one() -> float:
    """Return steps per second of the single environment, as ``gymnasium.make`` wraps it."""
    env = gymnasium.make(worldgen.gym.ENVIRONMENT, sensors=PLAIN, **MAZE)
    actions = np.random.default_rng(0).integers(0, 5, 512).tolist()
    env.reset(seed=1)
    count = 0
    begin = time.process_time()
    while time.process_time() < begin + SECONDS:
        for _ in range(100):
            if any(env.step(actions[count % 512])[2:4]):
                env.reset()
            count += 1
    return count / (time.process_time() - begin)


def _beams(number: int, reach: float) -> dict[str, Any]:
    return {"sensors": (*PLAIN, "beams"), "robot": {"beams": number, "beam_range": reach}}


CASES: dict[str, Callable[[], float]] = {
    "vector, random": lambda: _many(_random, **MAZE),
    "vector, turns away": lambda: _many(_turns_away, **MAZE),
    "vector, turns away, 16 beams of 2 m": lambda: _many(_turns_away, **MAZE, **_beams(16, 2.0)),
    "vector, turns away, 36 beams of 5 m": lambda: _many(_turns_away, **MAZE, **_beams(36, 5.0)),
    "vector, random, in front of traps": lambda: _many(
        _random, **{**MAZE, "family": "trap", "params": {}}
    ),
    "single, random": _one,
}


def _case(name: str) -> float:
    """Return a case's rate, measured in its own process."""
    code = f"from benchmarks.gymnasium import CASES; print(CASES[{name!r}]())"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return float(done.stdout)


def measure(rounds: int, pythons: dict[str, str]) -> dict[str, Any]:
    """Return the best rates of all rounds, steps per second, and the load meanwhile."""
    ours = dict.fromkeys(CASES, 0.0)
    theirs = {}
    versions = {}
    loads = []
    # Take the best of several rounds, because other load can only slow a round down.
    for _ in range(rounds):
        loads.append(os.getloadavg()[0])
        for name in CASES:
            ours[name] = max(ours[name], _case(name))
        for peer in PEERS:
            found = run_peer("environments.py", peer, pythons[peer])
            if found is not None:
                versions[peer] = found["version"]
                for name, rate in found["rates"].items():
                    label = f"{peer}: {name}"
                    theirs[label] = max(theirs.get(label, 0.0), rate)
    return {
        "cases": {
            name: {
                "steps_per_second": rate,
                "ratios": {peer: rate / theirs[peer] for peer in theirs},
            }
            for name, rate in ours.items()
        },
        "peers": {name: {"steps_per_second": rate} for name, rate in theirs.items()},
        "versions": {**versions, "gymnasium": importlib.metadata.version("gymnasium")},
        "absent_peers": [peer for peer in PEERS if peer not in versions],
        "load": loads,
    }


def main() -> None:
    """Run all and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--rounds", type=int, default=3, help="rounds; the best counts (default 3)")
    add_peer_options(parser, PEERS)
    arguments = parser.parse_args()
    result = measure(arguments.rounds, {peer: getattr(arguments, peer) for peer in PEERS})
    if arguments.json:
        click.echo(json.dumps(result))
        return
    for title, rows in (("worldgen", result["cases"]), ("peers", result["peers"])):
        click.echo(f"{title:44}{'steps/s':>12}")
        for name, row in rows.items():
            click.echo(f"  {name:42}{row['steps_per_second']:12,.0f}")
    click.echo(", ".join(f"{name} {version}" for name, version in result["versions"].items()))
    click.echo(f"load when rounds began: {', '.join(f'{load:.1f}' for load in result['load'])}")
    if result["absent_peers"]:
        click.echo(f"not installed: {', '.join(result['absent_peers'])}")


if __name__ == "__main__":
    main()
