"""The work of one unit, as its lane gets it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.result import SearchState
from fuzz.triage.triage import Triage
from sim.controllers import CONTROLLERS, Controller
from sim.scenario import Scenario
from worldgen.random_streams import RandomStream

__all__ = ["Task"]


@dataclass(frozen=True)
class Task:
    """The work of one unit.

    Args:
        lane: The lane that does it.
        config: The campaign's.
        unit: Its number.
        memory: What it knows of earlier units.
        door: Counts runs and takes failures.
    """

    lane: str
    config: CampaignConfig
    unit: int
    memory: SearchState
    door: Triage

    @cached_property
    def controller(self) -> Controller:
        """The campaign's controller, looked up once."""
        return CONTROLLERS.get(self.config.scenario.controller)

    @property
    def stream(self) -> RandomStream:
        """The unit's random numbers, from the beginning."""
        return RandomStream(self.config.seed).child("unit", self.unit)

    def scenario(self, seed: int, time_step: float) -> Scenario:
        """What runs, with a draw's seed and time step."""
        return self.config.scenario.with_run(time_step=time_step, seed=seed)
