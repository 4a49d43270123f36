"""Loads what the first units of a campaign need: kernels come from their cache, or are compiled into it.

On a new installation that takes a minute, which no budget is to be spent on.
"""

from __future__ import annotations

from dataclasses import replace

from fuzz.config import CampaignConfig
from fuzz.failure import certified
from fuzz.lanes.plan import lanes_for
from fuzz.result import Memory
from fuzz.shrink import shrink
from fuzz.unit import run_unit
from sim.effort import Effort
from sim.try_out import EMPTY_ARENA, try_out
from worldgen.errors import WorldgenError
from worldgen.world import World

__all__ = ["load"]

_LANES = ("native", "features")  # whose kernels all the others need, too


def load(config: CampaignConfig) -> float:
    """Load what the first units need.

    Args:
        config: The campaign's. A quick controller does a little work for its lanes; of a slow one nobody knows how
            long that would take, so it only takes two steps.

    Returns:
        Seconds that the controller's own code took of this.
    """
    began = Effort.so_far()
    _load(config)
    return began.since().own


def _load(config: CampaignConfig) -> None:
    try_out(config.scenario)
    certified(EMPTY_ARENA)
    if config.slower > 1 or config.fixed_map is not None:
        return
    for lane in _LANES:
        if lane in lanes_for(config, Memory()):
            found = run_unit(replace(config, families=(lane,), examples=1, database="", oracles=()), 0).failures
            _load_shrinking(found[min(found)] if found and config.shrink else None)


def _load_shrinking(failure: World | None) -> None:
    if failure is not None:
        try:
            shrink(failure, seconds=0.1)
        except WorldgenError:
            return
