"""Which lane a unit works for."""

from __future__ import annotations

from fuzz.config import CampaignConfig
from fuzz.lanes.drawn import combined
from fuzz.result import Memory

__all__ = ["planned_lane"]


def planned_lane(config: CampaignConfig, unit: int, memory: Memory) -> str:
    """The lane of a unit: of those that fit the campaign, in turn."""
    names = ("map",) if config.fixed_map is not None else (config.families or combined(config.scenario))
    return names[unit % len(names)]
