"""Runs that are too long for all of their states to be held in memory.

They are run again in portions whenever their states are needed.

Contents:
    MOST_HELD: Bytes of states that are held at once.
    portions: Yields a run, portion by portion.
    Portion: Some consecutive steps of a run.
"""

from sim.runners.long_runs.in_portions import MOST_HELD, Portion, portions

__all__ = ["MOST_HELD", "Portion", "portions"]
