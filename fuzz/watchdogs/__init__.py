"""Watchdogs under test: which loops a watchdog misses, and which arrivals it interrupts.

Contents:
    Watchdog: What a watchdog is: ``reset`` and ``step``.
    WATCHDOGS: The registered ones, and a user's own by ``./file.py:Class``.
    watchdog_named: Makes one from its name with options.
    Drive: A run whose outcome is proved.
    drives_of: The runs of failures, and of the same controllers in natural worlds.
    judge: Runs watchdogs next to the robots of such runs.
    WatchdogResult: How one of them did.
"""

from fuzz.watchdogs.drives import Drive, drives_of
from fuzz.watchdogs.judging import WatchdogResult, judge
from fuzz.watchdogs.watchdog import WATCHDOGS, Watchdog, watchdog_named

__all__ = [
    "WATCHDOGS",
    "Drive",
    "Watchdog",
    "WatchdogResult",
    "drives_of",
    "judge",
    "watchdog_named",
]


def __dir__() -> list[str]:
    return __all__
