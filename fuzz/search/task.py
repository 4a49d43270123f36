"""The work of one unit: the argument of a search strategy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from fuzz.triage.triage import Triage
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import ScreenedRun, SearchState
from sim.controllers import CONTROLLERS, Controller
from sim.scenario import Scenario
from worldgen.random_streams import RandomStream


@dataclass(frozen=True)
class SearchTask:
    """The work of one unit.

    Args:
        strategy: Name of the strategy that does it.
        config: Configuration of the campaign.
        unit: Number of the unit.
        memory: State of the search after earlier units.
        triage: Counts runs and collects failures.
        screened: Runs that the unit made before it was cut short, by the numbers of their worlds.
    """

    strategy: str
    config: CampaignConfig
    unit: int
    memory: SearchState
    triage: Triage
    screened: Mapping[int, ScreenedRun] = field(default_factory=dict)

    @cached_property
    def controller(self) -> Controller:
        """The campaign's controller, looked up once."""
        return CONTROLLERS.get(self.config.scenario.controller)

    @property
    def stream(self) -> RandomStream:
        """A new random stream of the unit, at its beginning."""
        return RandomStream(self.config.seed).child("unit", self.unit)

    def scenario(self, seed: int, time_step: float) -> Scenario:
        """Return the campaign's scenario with the seed and time step of a draw."""
        return self.config.scenario.with_run(time_step=time_step, seed=seed)
