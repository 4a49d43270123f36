"""Measure steps per second of a peer's environments.

``PYTHON benchmarks/peers/environments.py LIBRARY`` prints a JSON object. It runs in the peer's own
environment, so it uses only the standard library, NumPy and the peer. Rates are per second of the
process's CPU time, of all its threads, with actions drawn beforehand.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

# Seconds of a measurement.
SECONDS = 1.5
Step = Callable[[int], Any]


def _rate(step: Step, robots: int) -> float:
    """Return steps per second of CPU time, after some calls that compile and fill caches."""
    for k in range(20):
        step(k)
    begin = time.process_time()
    count = 0
    while time.process_time() < begin + SECONDS:
        for _ in range(20):
            step(count)
            count += 1
    return count * robots / (time.process_time() - begin)


def _actions(space: Any, robots: int) -> list[Any]:
    rng = np.random.default_rng(0)
    if hasattr(space, "n"):
        return [rng.integers(0, space.n, robots).astype(np.int32) for _ in range(8)]
    return [
        rng.uniform(space.low, space.high, (robots, *space.shape)).astype(space.dtype)
        for _ in range(8)
    ]


def _envpool() -> Iterator[tuple[str, float]]:
    """Yield several batch sizes, of which the best counts: one worker plus the caller's thread."""
    library: Any = importlib.import_module("envpool")
    for name in ("CartPole-v1", "FrozenLake8x8-v1", "MiniGrid-FourRooms-v0", "PointMaze_Large-v3"):
        best = 0.0
        for robots in (64, 1024):
            envs = library.make(name, env_type="gymnasium", num_envs=robots, num_threads=1)
            actions = _actions(envs.action_space, robots)
            envs.reset()
            best = max(
                best, _rate(lambda k, envs=envs, actions=actions: envs.step(actions[k % 8]), robots)
            )
        yield name, best


def _minigrid() -> Iterator[tuple[str, float]]:
    gymnasium: Any = importlib.import_module("gymnasium")
    importlib.import_module("minigrid")
    for name in ("MiniGrid-FourRooms-v0", "MiniGrid-Empty-16x16-v0"):
        env = gymnasium.make(name)
        actions = np.random.default_rng(0).integers(0, 3, 512).tolist()
        env.reset(seed=0)

        def step(k: int, env: Any = env, actions: Any = actions) -> None:
            if any(env.step(actions[k % 512])[2:4]):
                env.reset()

        yield name, _rate(step, 1)


def _navix() -> Iterator[tuple[str, float]]:
    jax = importlib.import_module("jax")
    navix = importlib.import_module("navix")
    robots = 1024
    rounds = 16
    for name in ("Navix-FourRooms-v0", "Navix-Empty-16x16-v0"):
        env = navix.make(name)
        keys = jax.random.split(jax.random.PRNGKey(0), robots)
        steps = jax.vmap(env.step)

        # One compiled scan over all steps: a Python call per step would measure Python.
        def many(state: Any, actions: Any, steps: Any = steps) -> Any:
            return jax.lax.scan(lambda now, action: (steps(now, action), None), state, actions)[0]

        run = jax.jit(many)
        state = jax.jit(jax.vmap(env.reset))(keys)
        actions = jax.random.randint(jax.random.PRNGKey(1), (rounds, robots), 0, 3)

        def step(_: int, run: Any = run, state: Any = state, actions: Any = actions) -> None:
            # JAX returns before it has computed, so wait for the result.
            jax.block_until_ready(run(state, actions))

        yield name, _rate(step, robots * rounds)


LIBRARIES = {"envpool": _envpool, "minigrid": _minigrid, "navix": _navix}


def main() -> None:
    """Measure the library that the command line names."""
    (name,) = sys.argv[1:]
    rates = dict(LIBRARIES[name]())
    sys.stdout.write(
        json.dumps({"version": importlib.metadata.version(name), "rates": rates}) + "\n"
    )


if __name__ == "__main__":
    main()
