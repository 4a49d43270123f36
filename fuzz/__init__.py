"""The fuzzer: find worlds in which a controller fails, prove each failure, shrink it and keep it.

Contents (each name is imported on first use):
    worlds, feature_worlds, family_worlds: Hypothesis strategies for worlds with a witness.
    scenarios: A strategy for worlds together with the run in each of them.
    Campaign, CampaignConfig: A search with a budget.
    Failure: A world and what went wrong in it, as stored in a file.
    failure_of, replay, Replay: Read failures and confirm that they still occur.
    Shrunk: The result of ``fuzz.shrink.shrink``: the smallest world that still fails.

PYTEST_DONT_REWRITE: lets a program that has imported this package call pytest.main() without a
warning about assertion rewriting.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.plugins.own_packages import check_hidden
from worldgen.support.lazy import lazy_names

try:
    import sim.verdict  # noqa: F401 - fails if another package of that name comes first
except ModuleNotFoundError:
    check_hidden()  # raises a clearer error if the user's own package `sim` was imported instead
    raise

if TYPE_CHECKING:
    from fuzz.campaign.run import Campaign
    from fuzz.failure import Failure
    from fuzz.shrink.run import Shrunk
    from fuzz.strategies import family_worlds, feature_worlds, scenarios, worlds
    from fuzz.triage.judging import failure_of
    from fuzz.triage.replaying import Replay, replay
    from fuzz.unit.config import CampaignConfig

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "campaign.run": ("Campaign",),
        "failure": ("Failure",),
        "shrink.run": ("Shrunk",),
        "strategies": ("family_worlds", "feature_worlds", "scenarios", "worlds"),
        "triage.judging": ("failure_of",),
        "triage.replaying": ("Replay", "replay"),
        "unit.config": ("CampaignConfig",),
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
