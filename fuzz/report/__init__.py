"""Reports: failures and their campaign as one HTML page that needs nothing else.

Contents:
    write_report: from folders, archives and files to the page.
    Summary: what a campaign notes of itself for reports.
"""

from fuzz.campaign.store import Summary
from fuzz.report.page import write_report

__all__ = ["Summary", "write_report"]
