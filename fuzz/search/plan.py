"""Which lane a unit works for: lanes share the budget by what they yield.

A lane's yield is what it brought, divided by what it cost; cost is counted in worlds and steps, not
by the clock, so that a plan is the same on every machine. A lane of which nothing is known is taken
to be worth a try, and none falls below a floor, for what a lane brings changes as a campaign goes
on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fuzz.boundary import is_bounded, subject_of
from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.result import LaneYield, SearchState
from fuzz.search.archive import ARCHIVE
from fuzz.search.boundary import BOUNDARY
from fuzz.search.names import DATABASE, SEALED, can_breach
from fuzz.search.native import NATIVE
from fuzz.search.native import fits as fits_native
from sim.controllers import CONTROLLERS, CompiledController, ProcessController

__all__ = ["Prices", "lane_shares", "lanes_for", "planned_lane", "prices_of"]

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
_PRIOR = {NATIVE: 24.0, ARCHIVE: 8.0, "features": 8.0, BOUNDARY: 3.0}
"""New classes that a lane is taken to bring at first, for each unit of cost; 1 for the others."""

_FLOOR = 0.3  # share of the budget that is dealt out evenly
_FAILURE = 0.01  # what a failure counts beside a class that is new
_WORLD_COST = {
    NATIVE: 0.02,
    ARCHIVE: 0.03,
    "features": 1.0,
    SEALED: 1.0,
    BOUNDARY: 0.5,
}  # ms, beside its steps
_FAMILY_COST = 4.0  # ms, likewise, of a family's world
_AT_FIRST = 1000.0  # ms: what a lane's expected yield weighs against what it brought

# Of 2**64: multiples of it lie as evenly as can be, wherever one begins or ends.
_GOLDEN = 0x9E3779B97F4A7C15


@dataclass(frozen=True)
class Prices:
    """What a campaign's work costs, by the kind of its controller; milliseconds.

    Args:
        step: Of a run.
        proof: Of each failure: certified, run again, recorded, judged, classified.
    """

    step: float = 1e-4
    proof: float = 7.0


_SLOW = Prices(step=1e-2)
_PYTHON = Prices(
    step=3e-3, proof=80.0
)  # a proof runs the class four times or so, each up to 7,500 steps
_PROCESS = Prices(step=5e-2, proof=400.0)  # and starts the program each time


def prices_of(config: CampaignConfig) -> Prices:
    """Return the prices of a campaign's work."""
    controller = CONTROLLERS.get(config.scenario.controller)
    if isinstance(controller, CompiledController):
        return _SLOW if controller.slow else Prices()
    return _PROCESS if isinstance(controller, ProcessController) else _PYTHON


def lanes_for(config: CampaignConfig, memory: SearchState) -> tuple[str, ...]:
    """The lanes that fit a campaign, those that are tried first first."""
    if config.families:
        return config.families
    if config.fixed_map is not None:
        return ("map", BOUNDARY) if any(map(subject_of, memory.failures.values())) else ("map",)
    bounded = (BOUNDARY,) if is_bounded(config.scenario) else ()
    native = (NATIVE, ARCHIVE) if fits_native(config) else ()
    return (*native, *_DRAWN, *bounded, *((SEALED,) if can_breach(config.scenario) else ()))


def planned_lane(config: CampaignConfig, unit: int, memory: SearchState) -> str:
    """The lane of a unit. Of any run of units that know the same, each lane has its share, to within a unit or two.

    What failed before comes first of all.
    """
    if config.database and unit == 0:
        return DATABASE
    names = lanes_for(config, memory)
    point = unit * _GOLDEN % 2**64 / 2**64
    for name, share in zip(names, lane_shares(names, memory, prices_of(config)), strict=True):
        point -= share
        if point < 0.0:
            return name
    return names[-1]


def lane_shares(names: Sequence[str], memory: SearchState, prices: Prices) -> list[float]:
    """The share of the budget of each lane, by what it yields.

    Args:
        names: Of the lanes.
        memory: What they brought.
        prices: Of the campaign's work.
    """
    yields = [_worth(name, memory.lanes.get(name, LaneYield()), prices) for name in names]
    total = sum(yields)
    return [_FLOOR / len(names) + (1.0 - _FLOOR) * one / total for one in yields]


def _worth(name: str, brought: LaneYield, prices: Prices) -> float:
    """New classes and failures for each second of work, beginning with what is expected of the lane."""
    found = brought.classes + _FAILURE * brought.failures
    worlds = brought.worlds * _WORLD_COST.get(name, _FAMILY_COST)
    cost = worlds + brought.steps * prices.step + brought.failures * prices.proof
    return (_PRIOR.get(name, 1.0) + found) / (_AT_FIRST + cost)
