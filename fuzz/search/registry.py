"""Lanes: where a campaign's scenarios come from.

Each looks for runs that fail and brings them to the one door. Contents:
    lane_of: the lane of a name.
    check_lane: refuses a name, or a lane that does not fit a campaign.
    Task: what a lane gets.
    OWN_LANES: those that are no family's.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable

from fuzz.boundary import is_bounded
from fuzz.screening import can_screen
from fuzz.search import archive, boundary, native
from fuzz.search.names import DATABASE, LAYOUT_LANES, SEALED, can_breach
from fuzz.search.plan import lanes_for
from fuzz.search.task import Task
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES

__all__ = ["OWN_LANES", "Lane", "Task", "check_lane", "lane_of"]

Lane = Callable[[Task], None]
"""Does a unit's work: counts its runs and hands what fails to the task's door."""


# The import of Hypothesis takes a third of a campaign's start, so it waits for the first lane that
# draws with it.


def _search(task: Task) -> None:
    from fuzz.search import drawn

    drawn.search(task)


def _search_again(task: Task) -> None:
    from fuzz.search import drawn

    lanes = [name for name in lanes_for(task.config, task.memory) if name not in _OWN]
    drawn.search_again(task, lanes)


_OWN: dict[str, Lane] = {
    boundary.BOUNDARY: boundary.search,
    native.NATIVE: native.search,
    archive.ARCHIVE: archive.search,
    DATABASE: _search_again,
}


OWN_LANES = (native.NATIVE, archive.ARCHIVE, boundary.BOUNDARY, *LAYOUT_LANES)
"""Lanes that a user may ask for, beside the families."""


def lane_of(name: str) -> Lane:
    """The lane of a name; that of a family, of ``features``, ``sealed`` and ``map`` lets Hypothesis draw."""
    return _OWN.get(name, _search)


def check_lane(name: str, scenario: Scenario) -> None:
    """Refuses what is neither a lane nor a family, and a lane that has nothing to do for a scenario.

    Raises:
        InvalidParameter: If it does not fit.
    """
    if ":" in name or name.endswith(".toml"):
        FAMILIES.get(name)
    elif name not in (known := (*OWN_LANES, *FAMILIES.names())):
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]!r}? " if close else ""
        raise InvalidParameter(
            "unknown-name",
            "no lane and no family is called {name!r}",
            "{hint}lanes: {lanes!l}; families: {families!l}; your own family: "
            "package.module:name, ./file.py:name or ./recipe.toml",
            name=name,
            hint=hint,
            lanes=list(OWN_LANES),
            families=list(FAMILIES.names()),
        )
    if name == SEALED and not can_breach(scenario):
        raise InvalidParameter(
            "lane-needs-keep-going",
            "family {name!r} has walled-off targets, which only a robot reaches that goes on past "
            "a wall",
            "take --motion stepped without +keep_going, or another family",
            at_terminal=True,
            name=name,
        )
    if name in (native.NATIVE, archive.ARCHIVE) and not can_screen(scenario):
        raise InvalidParameter(
            "lane-needs-other-motion",
            "lane {lane!r} runs under swept or endpoint",
            "take another lane for {label} under {motion}",
            lane=name,
            label=scenario.label(),
            motion=scenario.run.motion,
        )
    if name == boundary.BOUNDARY and not is_bounded(scenario):
        raise InvalidParameter(
            "lane-needs-no-chance",
            "lane {lane!r} looks for where failures begin, and with chance they begin anywhere",
            "take another lane for {label}",
            lane=name,
            label=scenario.label(),
        )
