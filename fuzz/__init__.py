"""The fuzzer: searches for worlds in which a controller fails, proves it, shrinks it, keeps it.

Contents, each imported when it is first used:
    worlds, feature_worlds, family_worlds: Hypothesis strategies for worlds with a witness.
    scenarios: a strategy for worlds together with what runs in them.
    Campaign, CampaignConfig: a budgeted search.
    Failure: a world and what went wrong in it, as a file holds it.
    failure_of, replay, Replay: failures and their confirmation.
    Shrunk: what ``fuzz.shrink.shrink`` returns, the smallest world that still fails.

PYTEST_DONT_REWRITE: a program that has imported this may call pytest.main() without a warning.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.plugins.own_packages import check_hidden
from worldgen.support.lazy import lazy_names

try:
    from sim.containment import contain
except ModuleNotFoundError:
    check_hidden()  # the user's own sim came instead; say so
    raise

if TYPE_CHECKING:
    from fuzz.campaign.config import CampaignConfig
    from fuzz.campaign.run import Campaign
    from fuzz.failure import Failure
    from fuzz.shrink.run import Shrunk
    from fuzz.strategies import family_worlds, feature_worlds, scenarios, worlds
    from fuzz.triage.judging import Replay, failure_of, replay

contain()  # whatever a campaign, a replay or a shrinking runs may crash

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "campaign.config": ("CampaignConfig",),
        "campaign.run": ("Campaign",),
        "failure": ("Failure",),
        "shrink.run": ("Shrunk",),
        "strategies": ("family_worlds", "feature_worlds", "scenarios", "worlds"),
        "triage.judging": ("Replay", "failure_of", "replay"),
    },
)

__all__ = [
    "Campaign",
    "CampaignConfig",
    "Failure",
    "Replay",
    "Shrunk",
    "failure_of",
    "family_worlds",
    "feature_worlds",
    "replay",
    "scenarios",
    "worlds",
]
