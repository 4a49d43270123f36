"""What a campaign remembers on disk.

So that nothing that ends it loses more than the units under way. Contents:
    FolderStore: the folder ``OUT/.campaign``: who writes it, and what is in it.
    CampaignRun, Budget, begin, resume: opens it for a new campaign, or to go on with the same one.
    Fingerprint, fingerprint_of: a configuration, and the code that decides what its units find.
    errors_recorded, record_error, read_error, forget_error: why a campaign gave up, as data for
        other programs.
    Summary, StrategyTotals, BucketTotals, Archive, read_summary: a campaign in numbers, as
        ``summary.json`` has it.
    MEMORY: name of the folder in a campaign's folder.
    CampaignStore: what a campaign needs of a store; this one remembers nothing.

``docs/howto/campaigns.md`` tells what a user sees.
"""

from fuzz.campaign.store.fingerprint import Fingerprint, fingerprint_of
from fuzz.campaign.store.folder import CampaignStore, FolderStore
from fuzz.campaign.store.last_error import errors_recorded, forget_error, read_error, record_error
from fuzz.campaign.store.opening import Budget, CampaignRun, begin, resume, stored_seed
from fuzz.campaign.store.summary import (
    MEMORY,
    Archive,
    BucketTotals,
    StrategyTotals,
    Summary,
    read_summary,
)

__all__ = [
    "MEMORY",
    "Archive",
    "BucketTotals",
    "Budget",
    "CampaignRun",
    "CampaignStore",
    "Fingerprint",
    "FolderStore",
    "StrategyTotals",
    "Summary",
    "begin",
    "errors_recorded",
    "fingerprint_of",
    "forget_error",
    "read_error",
    "read_summary",
    "record_error",
    "resume",
    "stored_seed",
]
