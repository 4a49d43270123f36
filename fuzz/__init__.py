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

import importlib
from typing import TYPE_CHECKING, Any

from sim.containment import contain

if TYPE_CHECKING:
    from fuzz.campaign.config import CampaignConfig
    from fuzz.campaign.run import Campaign
    from fuzz.failure import Failure
    from fuzz.shrink.run import Shrunk
    from fuzz.strategies import family_worlds, feature_worlds, scenarios, worlds
    from fuzz.triage.judging import Replay, failure_of, replay

contain()  # whatever a campaign, a replay or a shrinking runs may crash

_HOME = {
    "campaign.run": ("Campaign",),
    "campaign.config": ("CampaignConfig",),
    "failure": ("Failure",),
    "judging": ("Replay", "failure_of", "replay"),
    "strategies": ("family_worlds", "feature_worlds", "scenarios", "worlds"),
}
_MODULE = {name: f"fuzz.{module}" for module, names in _HOME.items() for name in names}
_MODULE |= {"Shrunk": "fuzz.shrink.run"}

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


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f"module 'fuzz' has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULE[name]), name)
