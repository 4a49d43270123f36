"""Runs too long for all of their states to be held.

Gone through in portions, as often as somebody looks. Contents:
    MOST_HELD: bytes of states that are held at once.
    portions: a run, portion by portion (``in_portions``).
"""

from sim.runners.long_runs.in_portions import MOST_HELD, Portion, portions

__all__ = ["MOST_HELD", "Portion", "portions"]
