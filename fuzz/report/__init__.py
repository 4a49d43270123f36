"""Reports: failures and their campaign as one HTML page that needs nothing else.

Contents:
    write_report: from folders, archives and files to the page.
    Summary: what a campaign notes of itself for reports.
"""

from fuzz.report.page import write_report
from fuzz.report.summary import Summary

__all__ = ["Summary", "write_report"]
