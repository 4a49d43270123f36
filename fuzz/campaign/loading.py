"""Load the modules that a campaign's first units need, in each of its processes.

These are the library and the controller.
"""

from __future__ import annotations

from fuzz.campaign.config import CampaignConfig
from fuzz.triage.proofs import certified
from sim.runners.controller_time import Effort
from sim.runners.try_out import EMPTY_ARENA, try_out

__all__ = ["load"]


def load(config: CampaignConfig) -> float:
    """Let the controller take two steps, and prove a world.

    Args:
        config: The campaign's configuration.

    Returns:
        Seconds of this spent in the controller's own code.
    """
    began = Effort.so_far()
    try_out(config.scenario)
    certified(EMPTY_ARENA)
    return began.since().own
