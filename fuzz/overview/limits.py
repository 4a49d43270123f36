"""Divide the time and the work after a campaign's search: natural worlds, shrinking, explanations."""

from __future__ import annotations

from collections.abc import Callable

from fuzz.campaign.state import CampaignState
from fuzz.overview.natural import NaturalTime
from fuzz.unit.answer import FEWEST
from fuzz.unit.config import CampaignConfig

# Limit on the natural worlds of a campaign without a time limit: a tenth of the worlds that its
# units may try, so that a short campaign stays short, and no more than an interval of +/- 3 %
# needs.
_NATURAL_SHARE = 10
_MOST_NATURAL = 900
_FEWEST_NATURAL = 9

# Fraction of the usual effort that an explanation in a campaign may take.
EFFORT = 0.15

# Limit on the cells that the proofs of one explanation examine: about a second. A map of 200,000
# cells gets ten changes, a shrunk world all of them.
MOST_CELLS = 2_000_000

# Seconds of a slow controller's steps for one explanation without a time limit.
SECONDS_TO_EXPLAIN = 20.0

# Shares of the time after which no more natural worlds are run, and after which failures that only
# they show are no longer shrunk; the rest is for explanations.
_NATURAL_TIME = 0.6
SHRINKING_TIME = 0.75

# Seconds after the end in which explanations may still arrive.
GRACE = 1.0

# Share of a campaign's budget for all of this, once the search is over; and the seconds that a slow
# controller needs for its first natural worlds, unless they are more than another share.
_TO_CONCLUDE = 0.15
_SLOW_TO_CONCLUDE = 6.0
_MOST_TO_CONCLUDE = 0.3


def seconds_to_conclude(config: CampaignConfig, budget: float) -> float:
    """Return the seconds of a campaign's budget that the search leaves."""
    usual = _TO_CONCLUDE * budget
    if not config.pace.is_slow:
        return usual
    return max(usual, min(_SLOW_TO_CONCLUDE, _MOST_TO_CONCLUDE * budget))


def natural_count(config: CampaignConfig, state: CampaignState, seconds: float | None) -> int:
    """Return the largest number of natural worlds, given the seconds for them, if limited."""
    if seconds is not None:
        return _MOST_NATURAL
    count = state.units * config.examples // (_NATURAL_SHARE * config.pace.slower)
    return min(max(count, _FEWEST_NATURAL), _MOST_NATURAL)


def time_for_natural(at: float, seconds: float | None, *, has_failures: bool) -> NaturalTime:
    """Return the time for natural worlds.

    Without failures there is nothing else to do, so the first few get all of the time: an answer
    needs them.
    """
    if seconds is None:
        return NaturalTime()
    return NaturalTime(at + _NATURAL_TIME * seconds, at + seconds, 0 if has_failures else FEWEST)


def has_passed(end: float, clock: Callable[[], float]) -> bool:
    """Return True once a clock shows a time; this can be pickled."""
    return clock() >= end
