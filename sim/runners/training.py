"""Train a learning controller in worlds, and store what it learned.

Each episode is a run in one of the worlds with some random decisions: many at first, none at the
end. After every tenth of the episodes the controller is tried without drawing, in each world. The
memory with the best test result is kept: most worlds reached, then fewest steps. The same worlds,
episodes and seed give the same numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.controllers.base import Controller
from sim.controllers.learning import Episodes, Learned, Learning
from sim.controllers.taught import learning_of, memory_at_reset, with_exploration, with_numbers
from sim.options.run import RunOptions
from sim.runners.lattice import LatticeRun
from sim.scenario import Scenario
from sim.verdict import ARRIVALS
from worldgen.errors import InvalidParameter
from worldgen.parameters.bounds import check_between
from worldgen.plugins.registry import user_code
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Floats
from worldgen.world import World

Progress = Callable[[int], None]

# Number of trials during training, in addition to the one before it.
_TESTS = 10


@dataclass(frozen=True)
class TrainingOptions:
    """How a controller is trained.

    Args:
        episodes: Runs to learn from.
        steps: Budget of each episode, steps; a test has the usual budget of a run in the world.
        explore: Thousandths of the decisions that are random at first; they fall to zero.
        seed: Seed of the worlds' order and of the random decisions.

    Raises:
        InvalidParameter: If a value is out of range.
    """

    episodes: int = 200
    steps: int = 2000
    explore: int = 300
    seed: int = 0

    def __post_init__(self) -> None:
        check_between("episodes", self.episodes, 1, 10_000_000)
        check_between("steps", self.steps, 1, 10_000_000)
        check_between("explore", self.explore, 0, 1000)


def train(
    worlds: Sequence[World],
    scenario: Scenario,
    controller: Controller,
    options: TrainingOptions,
    progress: Progress | None = None,
) -> Learned:
    """Train a controller in some worlds.

    Args:
        worlds: The worlds, at least one.
        scenario: Its name and the options of its runs.
        controller: The controller that it names.
        options: How it is trained.
        progress: Called after each episode with the number of finished episodes.

    Returns:
        What it learned, and its learning curve, which begins before the training.

    Raises:
        InvalidParameter: If the controller does not learn, fails, or learns something that is not
            a number, or there is no world.
    """
    learning = learning_of(controller, scenario.controller)
    if not worlds:
        raise InvalidParameter("no-worlds", "there is no world to train in", "name at least one")
    # Separate streams, so that the worlds' order does not depend on how many seeds are drawn.
    order = RandomStream(options.seed).child("order of worlds")
    seeds = RandomStream(options.seed).child("episodes")
    learned = np.array(memory_at_reset(controller, scenario.controller))[learning.places]
    best = learned
    curve = [_tested(worlds, scenario, controller, learned, 0)]
    best_point = curve[0]
    due = _tests_after(options.episodes)
    # Explore less and less. Keep the best of what was tested, because learning can also unlearn.
    for episode in range(options.episodes):
        left = options.episodes - 1 - episode
        explore = options.explore * left // max(options.episodes - 1, 1)
        begun = _with(controller, scenario, learned)
        tried = with_exploration(begun, explore, scenario.controller)
        world = order.choice(worlds)
        learned = _episode(world, scenario, tried, learning, options, seeds.next64() >> 1)
        if progress is not None:
            progress(episode + 1)
        if episode + 1 in due:
            point = _tested(worlds, scenario, controller, learned, episode + 1)
            curve.append(point)
            if _is_better(point, best_point):
                best_point = point
                best = learned
    return Learned(scenario.controller, tuple(best.tolist()), tuple(curve))


def _tests_after(episodes: int) -> set[int]:
    """Return the numbers of episodes after which the controller is tried."""
    return {max(1, episodes * k // _TESTS) for k in range(1, _TESTS + 1)}


def _is_better(point: Episodes, other: Episodes) -> bool:
    return (-point.reached, point.steps) < (-other.reached, other.steps)


def _with(controller: Controller, scenario: Scenario, learned: Floats) -> Controller:
    """Return the controller that starts with some numbers."""
    return with_numbers(controller, tuple(learned.tolist()), scenario.controller)


def _episode(
    world: World,
    scenario: Scenario,
    controller: Controller,
    learning: Learning,
    options: TrainingOptions,
    seed: int,
) -> Floats:
    """Return what a controller has learned after one episode."""
    run = LatticeRun(world, controller, replace(scenario.run, seed=seed))
    # End an episode that draws nothing as soon as it loops, because it would teach nothing new.
    outcome, memory = run.run_and_recall(options.steps, find_loop=True)
    if outcome.ending in ARRIVALS and learning.arrives is not None:
        with user_code(f"controller {scenario.controller!r}: learning.arrives"):
            learning.arrives(memory)
    learned = memory[learning.places].copy()
    if not np.isfinite(learned).all():
        raise InvalidParameter(
            "not-finite",
            "controller {controller!r} learned a value that is not a finite number",
            "set bounds on the numbers that it learns",
            controller=scenario.controller,
        )
    return learned


def _tested(
    worlds: Sequence[World],
    scenario: Scenario,
    controller: Controller,
    learned: Floats,
    episodes: int,
) -> Episodes:
    """Return how a controller does in all worlds without drawing."""
    reached = 0
    steps = 0
    tried = _with(controller, scenario, learned)
    for world in worlds:
        budget: RunOptions = scenario.options(world)
        outcome, _ = LatticeRun(world, tried, budget).run_and_recall(budget.steps, find_loop=True)
        arrived = outcome.ending in ARRIVALS
        reached += arrived
        # One that does not arrive counts with its whole budget, however early its loop is noticed.
        steps += outcome.steps if arrived else budget.steps
    return Episodes(episodes, reached, len(worlds), steps)
