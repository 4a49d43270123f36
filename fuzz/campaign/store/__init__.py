"""What a campaign remembers on disk, so that nothing that ends it loses more than the units under way.

Contents:
    FolderStore: the folder ``OUT/.campaign``: who writes it, and what is in it.
    CampaignRun, Budget, begin, resume: opens it for a new campaign, or to go on with the same one.
    Fingerprint, fingerprint_of: a configuration, and the code that decides what its units find.
    errors_recorded, record_error, read_error, forget_error: why a campaign gave up, as data for other programs.
    CampaignStore: what a campaign needs of a store; this one remembers nothing.

``docs/campaigns.md`` tells what a user sees.
"""

from fuzz.campaign.store.fingerprint import Fingerprint, fingerprint_of
from fuzz.campaign.store.folder import CampaignStore, FolderStore
from fuzz.campaign.store.last_error import errors_recorded, forget_error, read_error, record_error
from fuzz.campaign.store.opening import Budget, CampaignRun, begin, resume, stored_seed

__all__ = [
    "Budget",
    "CampaignRun",
    "CampaignStore",
    "Fingerprint",
    "FolderStore",
    "begin",
    "errors_recorded",
    "fingerprint_of",
    "forget_error",
    "read_error",
    "record_error",
    "resume",
    "stored_seed",
]
