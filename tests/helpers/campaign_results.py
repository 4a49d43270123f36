"""Results of campaigns that nobody ran, and what the terminal shows of them."""

import click
from msgspec import structs

from fuzz.campaign.store import Summary
from fuzz.cause import Cause
from fuzz.overview.building import Overview
from fuzz.overview.natural import NaturalRun, natural_result
from fuzz.overview.result import CampaignResult
from fuzz.overview.terminal import overview_lines

_NUMBERS = Summary(
    controller="mine", motion="swept", seed=1, units=1, worlds=107, steps=1000, seconds=1.0
)


def numbers(**changes):
    """Return a campaign in numbers: controller ``mine`` under swept."""
    return structs.replace(_NUMBERS, **changes)


def natural_worlds(worlds=0, arrived=0, unsensed=0):
    """Return results in natural worlds; where the robot does not arrive, it wanders."""
    runs = [NaturalRun("trap", "reached")] * arrived
    runs += [NaturalRun("trap", "timeout", Cause.WANDERS)] * (worlds - arrived)
    runs += [NaturalRun("fire", "burned", Cause.HARMED_UNSENSED)] * unsensed
    return natural_result(runs)


def terminal(folder, causes=(), natural=None, *, remedy="", in_colour=False, **changes):
    """Return the lines that the terminal shows of a result."""
    result = CampaignResult(causes=[*causes], natural=natural, summary=numbers(**changes))
    lines = overview_lines(Overview(result, {}, {}), folder, remedy=remedy)
    return lines if in_colour else list(map(click.unstyle, lines))
