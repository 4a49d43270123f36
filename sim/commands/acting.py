"""Report which behaviour of a composition acted when, for the command line."""

from __future__ import annotations

from sim.controllers.behaviours.arbitration import Arbitration, acting, shares
from sim.episode import Episode
from sim.options.run import MAX_RECORDED
from sim.scenario import Scenario
from worldgen.world import World

__all__ = ["acting_shares", "counts_behaviours", "who_acted"]


def counts_behaviours(scenarios: list[Scenario], world: World, steps: int | None) -> bool:
    """Return True if a run has behaviours to count, and is short enough to be recorded for this.

    Args:
        scenarios: One for each robot; behaviours are counted only for a single robot.
        world: Its witness determines how long the run may take.
        steps: Budget to use instead.
    """
    short = scenarios[0].options(world, steps).steps <= MAX_RECORDED
    return _arbitration(scenarios) is not None and short


def who_acted(scenarios: list[Scenario], episode: Episode) -> list[str]:
    """Return the behaviour that acted in each step; empty without behaviours or a recording."""
    arbitration = _arbitration(scenarios)
    trace = episode.trace
    if arbitration is None or trace is None:
        return []
    return acting(arbitration, trace)


def acting_shares(scenarios: list[Scenario], episode: Episode) -> dict[str, dict[str, float]]:
    """Return the share of steps in which each behaviour acted, under the key ``behaviours``."""
    arbitration = _arbitration(scenarios)
    acted = who_acted(scenarios, episode)
    if arbitration is None or not acted:
        return {}
    return {"behaviours": shares(arbitration, acted)}


def _arbitration(scenarios: list[Scenario]) -> Arbitration | None:
    """Return how the robot arbitrates, if it is alone and arbitrates."""
    return scenarios[0].arbitration if len(scenarios) == 1 else None
