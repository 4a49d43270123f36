"""Units of a campaign: pure functions of (configuration, unit number, memory), so any worker may do any of them."""

from __future__ import annotations

from fuzz.config import CampaignConfig
from fuzz.door import Door
from fuzz.lanes import lane_of
from fuzz.lanes.plan import planned_lane
from fuzz.lanes.task import Task
from fuzz.result import Memory, UnitResult

__all__ = ["run_unit"]


def run_unit(config: CampaignConfig, unit: int, memory: Memory | None = None) -> UnitResult:
    """Does one unit: draws, runs, proves, classifies. No clock, no shared state.

    Args:
        config: What to look for.
        unit: Its number.
        memory: What the units up to the epoch before the last one found; nothing where left out.
    """
    known = Memory() if memory is None else memory
    name = planned_lane(config, unit, known)
    result = UnitResult(lane=name)
    lane_of(name)(Task(name, config, unit, known, Door(config, result)))
    return result
