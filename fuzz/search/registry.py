"""Search strategies: where a campaign's scenarios come from.

Each looks for runs that fail and passes them to triage.

Contents:
    strategy_of: Looks up a strategy by name.
    check_strategy: Refuses an unknown name, or a strategy that does not fit a scenario.
    Task: The work of one unit, the argument of a strategy.
    OWN_STRATEGIES: Names of the strategies that are not families.
"""

from __future__ import annotations

from collections.abc import Callable

from fuzz.boundary import is_bounded
from fuzz.screening import can_screen
from fuzz.search import archive, boundary, native, small
from fuzz.search.task import SearchTask
from fuzz.unit.names import LAYOUT_STRATEGIES, SEALED, can_breach
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.parameters.known_names import unknown_name

Strategy = Callable[[SearchTask], None]
"""Does the work of one unit: counts its runs and passes those that fail to the task's triage."""


# Importing Hypothesis takes a third of the time that a campaign needs to start, so it waits for the
# first strategy that draws with it.


def _search(task: SearchTask) -> None:
    from fuzz.search import drawn

    drawn.search(task)


_OWN: dict[str, Strategy] = {
    boundary.BOUNDARY: boundary.search,
    native.NATIVE: native.search,
    archive.ARCHIVE: archive.search,
    small.SMALL: small.search,
}


OWN_STRATEGIES = (
    native.NATIVE,
    archive.ARCHIVE,
    small.SMALL,
    boundary.BOUNDARY,
    *LAYOUT_STRATEGIES,
)
"""Strategies that a user may ask for, in addition to families."""


def strategy_of(name: str) -> Strategy:
    """Return the strategy with a name.

    Families, ``features``, ``sealed`` and ``map`` share one, in which Hypothesis draws.
    """
    return _OWN.get(name, _search)


def check_strategy(name: str, scenario: Scenario, robots: int = 1) -> None:
    """Check that a name is a strategy or a family, and that it can find failures of a scenario.

    Args:
        name: Name of the strategy or family.
        scenario: Scenario of the campaign.
        robots: Number of robots in its worlds.

    Raises:
        InvalidParameter: If the name is unknown or the strategy does not fit.
    """
    if ":" in name:
        FAMILIES.get(name)
    elif name not in (known := (*OWN_STRATEGIES, *FAMILIES.names())):
        raise InvalidParameter.of(
            unknown_name(
                "no strategy and no family is called {name!r}",
                name,
                known,
                "strategies: {strategies!l}; families: {families!l}; your own family: "
                "package.module:name or ./file.py:name",
                strategies=list(OWN_STRATEGIES),
                families=list(FAMILIES.names()),
            )
        )
    alone = (native.NATIVE, archive.ARCHIVE, small.SMALL, boundary.BOUNDARY, SEALED)
    if robots > 1 and name in alone:
        raise InvalidParameter(
            "strategy-for-one-robot",
            "strategy {strategy!r} runs one robot, but the campaign has {robots}",
            "use features or a family",
            strategy=name,
            robots=robots,
        )
    if name == SEALED and not can_breach(scenario):
        raise InvalidParameter(
            "strategy-needs-keep-going",
            "family {name!r} has walled-off targets, which only a robot that continues past "
            "a wall can reach",
            "use --motion stepped without +keep_going, or another family",
            at_terminal=True,
            name=name,
        )
    if name in (native.NATIVE, archive.ARCHIVE, small.SMALL) and not can_screen(scenario):
        raise InvalidParameter(
            "strategy-needs-other-motion",
            "strategy {strategy!r} only runs under swept or endpoint",
            "use another strategy for {label} under {motion}",
            strategy=name,
            label=scenario.label(),
            motion=scenario.run.motion,
        )
    if name == boundary.BOUNDARY and not is_bounded(scenario):
        raise InvalidParameter(
            "strategy-needs-no-chance",
            "strategy {strategy!r} looks for the point where failures begin, which does not exist "
            "if failures depend on chance",
            "use another strategy for {label}",
            strategy=name,
            label=scenario.label(),
        )
