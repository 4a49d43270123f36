"""Share a campaign's budget among search strategies in proportion to their yield.

The yield of a strategy is the value of its findings divided by its cost. Cost is counted in worlds
and steps rather than seconds, so a plan is the same on every machine. A strategy starts with an
optimistic estimate, and its share never falls below a floor, because yields change during a
campaign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzz.boundary import is_bounded, subject_of
from fuzz.search.archive import ARCHIVE
from fuzz.search.boundary import BOUNDARY
from fuzz.search.native import NATIVE
from fuzz.search.native import fits as fits_native
from fuzz.search.small import SMALL
from fuzz.search.small import fits as fits_small
from fuzz.unit.config import CampaignConfig
from fuzz.unit.names import SEALED, can_breach
from fuzz.unit.result import SearchState, StrategyYield

_DRAWN = (
    "features",
    "trap",
    "maze",
    "corridor",
    "fire",
    "rooms",
    "forest",
    "cave",
    "rubble",
    "shift",
)
# Strategies with several robots: any layout, and the families that are made for them.
_FLEETS = ("features", "doorway", "alley", "junction", "crossing", "warehouse")
_PRIOR = {SMALL: 1000.0, NATIVE: 24.0, ARCHIVE: 8.0, "features": 8.0, BOUNDARY: 3.0}
"""First estimate of the new signatures that a strategy finds per unit of cost; 1 if not listed."""

_FLOOR = 0.3  # share of the budget that is split evenly
_COSTLY_FLOOR = 0.1  # the same where each step is expensive
_FAILURE = 0.01  # weight of a failure, relative to a new signature
_WORLD_COST = {
    NATIVE: 0.02,
    ARCHIVE: 0.03,
    SMALL: 3.0,
    "features": 1.0,
    SEALED: 1.0,
    BOUNDARY: 0.5,
}  # ms per world, in addition to its steps
_FAMILY_COST = 4.0  # ms per world of a family, in addition to its steps
_NO_WORLDS = 1e-3  # the first estimate of a strategy whose units ran no world; leaves it the floor
_AT_FIRST = 1000.0  # the first estimate has the weight of this many ms of work

# The golden ratio times 2**64. Its multiples, modulo 2**64, are spread as evenly as possible over
# any run of consecutive units.
_GOLDEN = 0x9E3779B97F4A7C15


@dataclass(frozen=True)
class Prices:
    """Cost of a campaign's work in milliseconds, which depends on the controller's pace.

    Args:
        step: One step of a run.
        proof: One failure: certify, run again, record, judge and classify it.
        run: Beginning a run.
    """

    step: float = 1e-4
    proof: float = 7.0
    run: float = 0.0


# A proof runs a quick class about four times, each for as many steps as it gets to close its loop.
_PROOF_RUNS = 4
_PROOF_STEPS = 60_000
# Steps of a proof where each is expensive: the witness's budget twice, or a loop several times.
_COSTLY_PROOF = 1_500
# Milliseconds of a proof, in addition to its steps.
_PROOF_COST = 8.0
# Fraction of a step's time that the search adds to it.
_ADDED = 0.25


def prices_of(config: CampaignConfig) -> Prices:
    """Return the prices of a campaign's work."""
    if config.pace.slower == 1:
        return Prices()
    pace = config.pace
    steps = _COSTLY_PROOF if pace.is_slow else _PROOF_RUNS * (_PROOF_STEPS // pace.slower)
    return Prices(
        step=1e3 * (1.0 + _ADDED) * pace.step,
        proof=_PROOF_COST + 1e3 * steps * pace.step,
        run=1e3 * pace.reset,
    )


def strategies_for(config: CampaignConfig, memory: SearchState) -> tuple[str, ...]:
    """Return the strategies that fit a campaign, in the order in which they are first tried."""
    if config.families:
        return config.families
    if config.robots > 1:
        return ("map",) if config.fixed_map is not None else _FLEETS
    # Where a step is expensive, the worlds that need fewest come first, and mostly.
    small = (SMALL,) if config.pace.is_slow and fits_small(config) else ()
    if config.fixed_map is not None:
        has_subject = any(map(subject_of, memory.failures.values()))
        return (*small, "map", *((BOUNDARY,) if has_subject else ()))
    bounded = (BOUNDARY,) if is_bounded(config.scenario) else ()
    native = (NATIVE, ARCHIVE) if fits_native(config) else ()
    # The small strategy draws from the families that suit it, and ends runs that promise nothing. In
    # fire and behind moving walls a robot mostly waits; natural worlds have some of these.
    drawn = ("features",) if small else _DRAWN
    return (*small, *native, *drawn, *bounded, *((SEALED,) if can_breach(config.scenario) else ()))


def planned_strategy(config: CampaignConfig, unit: int, memory: SearchState) -> str:
    """Return the strategy of a unit.

    Among consecutive units with the same search state, each strategy gets its share to within one
    or two units.
    """
    names = strategies_for(config, memory)
    # Walk along the shares, laid end to end from 0 to 1, to the unit's point.
    point = unit * _GOLDEN % 2**64 / 2**64
    floor = _COSTLY_FLOOR if config.pace.is_slow else _FLOOR
    shares = strategy_shares(names, memory, prices_of(config), floor)
    for name, share in zip(names, shares, strict=True):
        point -= share
        if point < 0.0:
            return name
    return names[-1]


def strategy_shares(
    names: Sequence[str], memory: SearchState, prices: Prices, floor: float = _FLOOR
) -> list[float]:
    """Return each strategy's share of the budget; the shares add up to 1.

    Args:
        names: Names of the strategies.
        memory: State of the search, with each strategy's finds so far.
        prices: Cost of the campaign's work.
        floor: Share of the budget that is split evenly.
    """
    yields = [
        _worth(name, memory.strategies.get(name, StrategyYield(name)), prices) for name in names
    ]
    total = sum(yields)
    return [floor / len(names) + (1.0 - floor) * one / total for one in yields]


def _worth(name: str, brought: StrategyYield, prices: Prices) -> float:
    """Return new signatures and failures per unit of cost, starting from the first estimate."""
    found = brought.variants + _FAILURE * brought.failures
    worlds = brought.worlds * (_WORLD_COST.get(name, _FAMILY_COST) + prices.run)
    cost = worlds + brought.steps * prices.step + brought.failures * prices.proof
    prior = _NO_WORLDS if brought.units and not brought.worlds else _PRIOR.get(name, 1.0)
    return (prior + found) / (_AT_FIRST + cost)
