"""The store of a campaign on disk.

No matter how a campaign ends, it loses only the units in progress.

Contents:
    FolderStore: The folder ``OUT/.campaign`` and its lock.
    stored_elites: The archive's entries in a folder.
    CampaignRun, Budget, begin, resume: Open the store for a new campaign, or to continue one.
    stored_seed, with_stored_pace: What the same campaign keeps when it begins again.
    controller_change: Whether its controller's file is still the same.
    Fingerprint, fingerprint_of: A configuration, and the code that determines the units' results.
    errors_recorded, record_error, read_error, forget_error: Why a campaign gave up, as data for
        other programs.
    Summary, Status, Find, Archive, read_summary: The numbers in ``summary.json``.
    MEMORY, MARK: Name of the store's folder in a campaign's folder, and of a studio's mark there.

``docs/reference/campaign-files.md`` describes it for users.
"""

from fuzz.campaign.store.fingerprint import Fingerprint, fingerprint_of
from fuzz.campaign.store.folder import Budget, FolderStore, stored_elites
from fuzz.campaign.store.last_error import (
    MARK,
    errors_recorded,
    forget_error,
    read_error,
    record_error,
)
from fuzz.campaign.store.opening import (
    CampaignRun,
    begin,
    controller_change,
    resume,
    stored_seed,
    with_stored_pace,
)
from fuzz.campaign.store.summary import (
    MEMORY,
    OVERVIEW_FILE,
    SUMMARY,
    Archive,
    Find,
    Status,
    Summary,
    read_summary,
)

__all__ = [
    "MARK",
    "MEMORY",
    "OVERVIEW_FILE",
    "SUMMARY",
    "Archive",
    "Budget",
    "CampaignRun",
    "Find",
    "Fingerprint",
    "FolderStore",
    "Status",
    "Summary",
    "begin",
    "controller_change",
    "errors_recorded",
    "fingerprint_of",
    "forget_error",
    "read_error",
    "read_summary",
    "record_error",
    "resume",
    "stored_elites",
    "stored_seed",
    "with_stored_pace",
]
