"""Find how much chance matters in a failure, exactly, or else by counting seeds that fail."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from fuzz.evidence_checks.chance import check_chance
from fuzz.failure import regardless_of_walls
from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.noise import is_noisy
from sim.episode import prepare, simulate
from sim.episode.chance import explore, why_not_explored
from sim.options.run import RunOptions
from sim.scenario import Scenario
from sim.verdict import ARRIVALS
from worldgen.support.intervals import interval_95
from worldgen.world import Cut, Value, World

MOST_STATES = 100_000
"""Limit on the states to explore before counting seeds instead; this many take a few seconds."""

# Campaigns find many failures, so they explore less for each.
_MOST_IN_CAMPAIGNS = 20_000

# Ordinary runs that are checked against the explored states, and the steps of each.
_RUNS = 4
_STEPS = 2_000


@dataclass(frozen=True)
class Chance:
    """The outcome of a randomised run, as far as it is known.

    Args:
        chance: ``sure``: the robot arrives with probability one. ``trap``: it never arrives,
            whatever it draws. ``part``: some draws make it impossible to arrive. ``undecided``.
        reason: Why the outcome is undecided; empty otherwise.
        states: Number of states explored, 0 if undecided.
        draws: For ``part``, the shortest sequence of draws after which the target is out of reach.
        lost_after: For ``part``, the number of steps that this takes.
    """

    chance: str
    reason: str = ""
    states: int = 0
    draws: tuple[int, ...] = ()
    lost_after: int = 0

    def as_dict(self) -> dict[str, Any]:
        """Return the result for JSON, without the fields that do not apply to it."""
        own: dict[str, Any] = {"chance": self.chance}
        if self.chance == "undecided":
            return own | {"reason": self.reason}
        lost = (
            {"draws": list(self.draws), "lost_after": self.lost_after}
            if self.chance == "part"
            else {}
        )
        return own | {"states": self.states} | lost


def chance_of(
    world: World, controller: str, options: RunOptions, *, most: int = MOST_STATES
) -> Chance:
    """Return the exact outcome of a randomised run, or the reason why it cannot be computed.

    :mod:`sim.episode.chance` explores the states; independent code then checks its answer.

    Args:
        world: The world of the run.
        controller: Name of the controller.
        options: Options of the run; the seed and the budget do not affect the answer.
        most: Limit on the states to explore.

    Raises:
        WorldgenError: If the controller does not fit the options or the world.
    """
    reason = why_not_explored(CONTROLLERS.get(controller), world, options)
    if reason:
        return Chance("undecided", reason)
    outcomes = explore(world, controller, options, most=most)
    if outcomes is None:
        return Chance(
            "undecided",
            f"there are more than {most} states; use a coarser +lattice=N or a smaller +coin=N",
        )

    # Distrust the exploration: check that the answer follows from its states, and that ordinary
    # runs stay within them.
    chance = outcomes.chance
    runs = [
        simulate(world, controller, replace(options, seed=seed, steps=_STEPS), record=True)
        for seed in range(_RUNS)
    ]
    recorded = [(run.trace, run.verdict) for run in runs if run.trace is not None]
    wrong = check_chance(outcomes, chance, recorded)
    if wrong:
        return Chance(
            "undecided",
            f"internal error, please report it: the check of {chance!r} failed because {wrong}",
        )
    draws, steps = outcomes.way_to_loss() if chance == "part" else ((), 0)
    return Chance(chance, states=len(outcomes.states), draws=draws, lost_after=steps)


def chance_details(world: World, scenario: Scenario) -> dict[str, Value]:
    """Return the entries about chance for a failure's record.

    They are ``chance`` and ``states`` if the exact answer is known, else :func:`seeds_that_fail`.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if (
        isinstance(controller, CompiledController)
        and controller.randomised
        and not world.others
        and not isinstance(world.certificate, Cut)
    ):
        found = chance_of(
            world, scenario.controller, scenario.options(world), most=_MOST_IN_CAMPAIGNS
        )
        if found.states:
            return {"chance": found.chance, "states": found.states}
    return seeds_that_fail(world, scenario)


_WORDS = {
    "sure": "sure: the robot arrives with probability one",
    "trap": "trap: the robot never arrives, whatever it draws",
    "part": "part: the robot may arrive, or may become lost forever",
}


def in_words(found: Chance, seeds: Mapping[str, Value]) -> str:
    """Describe the outcome in one sentence.

    Args:
        found: The outcome.
        seeds: The result of :func:`share_that_fails`, used if the outcome is undecided.
    """
    if found.chance == "undecided":
        failing = seeds.get("failing_seeds")
        if not isinstance(failing, list):
            return f"undecided: {found.reason}"
        share = (
            f", so at least a share of {seeds['failing_share_at_least']} of all seeds fails, with "
            f"95 % confidence"
        )
        return (
            f"undecided: {found.reason}; {failing[0]} of {failing[1]} seeds "
            f"fail{share if failing[0] else ''}"
        )
    lost = ""
    if found.chance == "part":
        drawn = f" with the draws {' '.join(map(str, found.draws))}" if found.draws else ""
        lost = f", at the earliest after {found.lost_after} steps{drawn}"
    return f"{_WORDS[found.chance]}{lost} ({found.states} states explored)"


def seeds_that_fail(world: World, scenario: Scenario, count: int = 40) -> dict[str, Value]:
    """Return the number of ``count`` seeds that fail, for a run with randomness.

    Either the controller draws random numbers, or the simulator does, for slip or sensor noise.

    Returns:
        The result of :func:`share_that_fails`; empty for a run without randomness or a controller
        that is not compiled, which would be too slow.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if not (
        isinstance(controller, CompiledController)
        and (controller.randomised or is_noisy(controller, scenario.run))
    ):
        return {}
    return share_that_fails(world, scenario, count)


def share_that_fails(world: World, scenario: Scenario, count: int) -> dict[str, Value]:
    """Return how many of ``count`` seeds fail to arrive, and the share of all seeds this implies.

    If the target is walled off, arriving is the failure: seeds that get there through walls count.

    Returns:
        ``failing_seeds`` as [k, n], and ``failing_share_at_least``, the lower end of the two-sided
        95 % interval.

    Source: Charles Clopper and Egon Pearson, "The use of confidence or fiducial limits illustrated
        in the case of the binomial", Biometrika 1934.
    """
    controller = CONTROLLERS.get(scenario.controller)
    options = scenario.options(world)
    sealed = isinstance(world.certificate, Cut)
    # In a walled-off world a run should continue past the wall, to see where it ends.
    options = regardless_of_walls(options) if sealed else options
    failing = 0
    for seed in range(count):
        seeded = replace(options, seed=seed)
        if world.others:
            arrives = simulate(world, controller, seeded).verdict in ARRIVALS
        else:
            run = prepare(world, controller, seeded)
            outcome = run.run(options.steps, find_loop=False, record=False, digest=False)
            arrives = outcome.ending in ARRIVALS
        failing += arrives == sealed
    least, _ = interval_95(failing, count)
    return {"failing_seeds": [failing, count], "failing_share_at_least": round(least, 4)}
