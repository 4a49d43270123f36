"""The definition of a campaign."""

from __future__ import annotations

from dataclasses import dataclass

from fuzz.campaign.options import SearchOptions
from fuzz.campaign.variation import Variation
from sim.controllers import CONTROLLERS, CompiledController
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.world import World

# A step in Python takes microseconds.
_SLOWER = 8


@dataclass(frozen=True)
class CampaignConfig(SearchOptions):
    """The definition of a campaign.

    Together with a unit's number and the search state, it determines the unit's result. With a
    database, the result depends on that folder, too. The units of an epoch know the findings of
    earlier epochs, except the one just before. ``examples``, ``oracles`` and the other fields that
    are not listed here are described in :class:`SearchOptions`.

    Args:
        scenario: Controller, motion model and options; each draw has its own seed and time step.
        seed: Seed of the whole campaign.
        families: Families and other strategies to search with; empty for all that fit.
        time_steps: Durations of a step to draw from, s.
        vary: Quantities of the robot and options of the motion model to draw from.
        fixed_map: A map on which only its robots' starts, headings, targets and radii vary.
        shrink: Whether to shrink failures; on a user's own map they are more useful unshrunk.
        robots: Number of robots in each world.
    """

    scenario: Scenario
    seed: int = 0
    families: tuple[str, ...] = ()
    time_steps: tuple[float, ...] = (RunOptions.time_step,)
    vary: tuple[Variation, ...] = ()
    fixed_map: World | None = None
    shrink: bool = True
    robots: int = 1

    @property
    def slower(self) -> int:
        """Factor by which a unit does less work than with a fast compiled controller."""
        controller = CONTROLLERS.get(self.scenario.controller)
        return 1 if isinstance(controller, CompiledController) and not controller.slow else _SLOWER
