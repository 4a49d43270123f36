"""Reports: failures and their campaign as one self-contained HTML page.

Contents:
    write_report: Writes the page from folders, archives and files.
    Summary: The notes that a campaign leaves for reports.
"""

from fuzz.campaign.store import Summary
from fuzz.report.page import write_report

__all__ = ["Summary", "write_report"]
