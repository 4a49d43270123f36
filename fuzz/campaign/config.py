"""What a campaign looks for."""

from __future__ import annotations

from dataclasses import dataclass

from fuzz.campaign.options import SearchOptions
from fuzz.campaign.variation import Variation
from sim.controllers import CONTROLLERS, CompiledController
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.world import World

__all__ = ["CampaignConfig"]

_SLOWER = 8  # a step in Python takes microseconds


@dataclass(frozen=True)
class CampaignConfig(SearchOptions):
    """What a campaign looks for.

    Together with a unit's number and memory, all that the unit depends on. With a database, what a
    campaign finds depends on that folder, too. What the units of an epoch found, the units of the
    epoch after the next one know.

    Args:
        scenario: Controller, motion model and switches; each draw has its own seed and time step.
        seed: Of the whole campaign.
        families: Families and other strategies to look for failures with; empty for all that fit.
        time_steps: Durations of a step to draw from, s.
        vary: Quantities of the robot and options of the motion model to draw from.
        fixed_map: A foreign map on which only start, heading, target and radius vary.
        shrink: Whether failures are shrunk; on a user's own map they are more useful where they
            are.
    """

    scenario: Scenario
    seed: int = 0
    families: tuple[str, ...] = ()
    time_steps: tuple[float, ...] = (RunOptions.time_step,)
    vary: tuple[Variation, ...] = ()
    fixed_map: World | None = None
    shrink: bool = True

    @property
    def slower(self) -> int:
        """How much less a unit does than for a compiled controller, whose steps take nanoseconds."""
        controller = CONTROLLERS.get(self.scenario.controller)
        return 1 if isinstance(controller, CompiledController) and not controller.slow else _SLOWER
