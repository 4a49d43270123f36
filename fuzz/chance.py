"""What chance has to do with a failure.

The exact answer where there is one, else how many seeds fail.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from fuzz.evidence_checks.chance import check_chance
from fuzz.failure import regardless_of_walls
from sim.chance import explore, why_not_explored
from sim.controllers import CONTROLLERS, CompiledController
from sim.episode import prepare, simulate
from sim.options.run import RunOptions
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.support.intervals import interval_95
from worldgen.world import Cut, Value, World

__all__ = [
    "MOST_STATES",
    "Chance",
    "chance_details",
    "chance_of",
    "in_words",
    "seeds_that_fail",
    "share_that_fails",
]

MOST_STATES = 100_000
"""States that are looked at before only seeds are counted; a few seconds."""

_MOST_IN_CAMPAIGNS = 20_000
# ordinary runs that are held against the states
_RUNS = 4
_STEPS = 2_000


@dataclass(frozen=True)
class Chance:
    """What is known about a run with chance.

    Args:
        chance: ``sure``: with probability one the robot arrives. ``trap``: it never does, whatever
            is drawn. ``part``: some draws are its end. ``undecided``.
        reason: Why it is undecided; else empty.
        states: That were looked at, 0 if undecided.
        draws: For ``part``, values from 0 that, drawn one after the other, lose all in the fewest
            steps.
        lost_after: For ``part``, those steps.
    """

    chance: str
    reason: str = ""
    states: int = 0
    draws: tuple[int, ...] = ()
    lost_after: int = 0

    def as_dict(self) -> dict[str, Any]:
        """For JSON; without what does not belong to the answer."""
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
    """The exact answer for a run with chance, or why there is none.

    The states are explored by :mod:`sim.chance`; the answer is checked apart from that.

    Args:
        world: Where.
        controller: Its name.
        options: How; the seed and the budget have no part in the answer.
        most: States to look at.

    Raises:
        WorldgenError: If controller, options and world do not go together.
    """
    reason = why_not_explored(CONTROLLERS.get(controller), world, options)
    if reason:
        return Chance("undecided", reason)
    outcomes = explore(world, controller, options, most=most)
    if outcomes is None:
        return Chance(
            "undecided",
            f"there are more than {most} states; take a coarser +lattice=N or a smaller +coin=N",
        )
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
            f"a fault of ours, please report it: the check of {chance!r} says that {wrong}",
        )
    draws, steps = outcomes.way_to_loss() if chance == "part" else ((), 0)
    return Chance(chance, states=len(outcomes.states), draws=draws, lost_after=steps)


def chance_details(world: World, scenario: Scenario) -> dict[str, Value]:
    """What a failure's record says about chance.

    ``chance`` and ``states``, or :func:`seeds_that_fail`.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if (
        isinstance(controller, CompiledController)
        and controller.randomised
        and not isinstance(world.certificate, Cut)
    ):
        found = chance_of(
            world, scenario.controller, scenario.options(world), most=_MOST_IN_CAMPAIGNS
        )
        if found.states:
            return {"chance": found.chance, "states": found.states}
    return seeds_that_fail(world, scenario)


_WORDS = {
    "sure": "sure: with probability one the robot arrives",
    "trap": "trap: the robot never arrives, whatever it draws",
    "part": "part: the robot may arrive, and may be lost for ever",
}


def in_words(found: Chance, seeds: Mapping[str, Value]) -> str:
    """The answer in one sentence.

    Args:
        found: The answer.
        seeds: Of :func:`share_that_fails`, where it is undecided.
    """
    if found.chance == "undecided":
        failing = seeds.get("failing_seeds")
        if not isinstance(failing, list):
            return f"undecided: {found.reason}"
        share = (
            f", so that the share of all is {seeds['failing_share_at_least']} at least, with "
            f"95 % confidence"
        )
        return (
            f"undecided: {found.reason}; {failing[0]} of {failing[1]} seeds "
            f"fail{share if failing[0] else ''}"
        )
    lost = ""
    if found.chance == "part":
        drawn = f" with the draws {' '.join(map(str, found.draws))}" if found.draws else ""
        lost = f", the soonest after {found.lost_after} steps{drawn}"
    return f"{_WORDS[found.chance]}{lost} ({found.states} states looked at)"


def seeds_that_fail(world: World, scenario: Scenario, count: int = 40) -> dict[str, Value]:
    """For a run with randomness: how many of ``count`` seeds do not arrive, and what that shows.

    The controller may draw random numbers, or the simulator, for slip or a noisy sensor.

    Returns:
        Of :func:`share_that_fails`; empty for a run without randomness, and for what is not
        compiled.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if not (
        isinstance(controller, CompiledController) and (controller.randomised or scenario.random)
    ):
        return {}
    return share_that_fails(world, scenario, count)


def share_that_fails(world: World, scenario: Scenario, count: int) -> dict[str, Value]:
    """How many of ``count`` seeds do not arrive, and what that shows.

    Where the target is walled off, it is the seeds with which the robot does arrive, regardless of
    walls.

    Returns:
        ``failing_seeds`` as [k, n] and ``failing_share_at_least``, the lower end of the two-sided
        95 % interval.

    Source: Charles Clopper and Egon Pearson, "The use of confidence or fiducial limits illustrated
        in the
    case of the binomial", Biometrika 1934.
    """
    controller = CONTROLLERS.get(scenario.controller)
    options = scenario.options(world)
    sealed = isinstance(world.certificate, Cut)
    options = regardless_of_walls(options) if sealed else options
    failing = 0
    for seed in range(count):
        run = prepare(world, controller, replace(options, seed=seed))
        arrives = (
            run.run(options.steps, find_loop=False, record=False, digest=False).ending
            == Verdict.REACHED
        )
        failing += arrives == sealed
    least, _ = interval_95(failing, count)
    return {"failing_seeds": [failing, count], "failing_share_at_least": round(least, 4)}
