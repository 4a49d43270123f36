"""What a campaign remembers on disk, so that nothing that ends it loses more than the units under way.

Contents:
    CampaignFolder: the folder ``OUT/.campaign``: who writes it, and what is in it.
    Sitting, Goal, begin, resume: opens it for a new campaign, or to go on with the same one.
    Setup, setup_of: a configuration, and the code that decides what its units find.
    errors_recorded, record_error, read_error, forget_error: why a campaign gave up, as data for other programs.
    Ledger: what a campaign needs of it; itself it remembers nothing.

``docs/campaigns.md`` tells what a user sees.
"""

from fuzz.campaign.store.fingerprint import Setup, setup_of
from fuzz.campaign.store.folder import CampaignFolder, Ledger
from fuzz.campaign.store.last_error import errors_recorded, forget_error, read_error, record_error
from fuzz.campaign.store.opening import Goal, Sitting, begin, resume, stored_seed

__all__ = [
    "CampaignFolder",
    "Goal",
    "Ledger",
    "Setup",
    "Sitting",
    "begin",
    "errors_recorded",
    "forget_error",
    "read_error",
    "record_error",
    "resume",
    "setup_of",
    "stored_seed",
]
