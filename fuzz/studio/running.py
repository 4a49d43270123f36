"""Which controllers the page may run: the registered ones, and those named when the studio was started."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from sim.controllers import CONTROLLERS
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter

__all__ = ["may_run"]


def may_run(controller: str, named: Sequence[str]) -> bool:
    """Whether a controller that a file or a campaign names may run.

    Args:
        controller: Its name, without variations.
        named: What was named at the start, with them.
    """
    return controller in CONTROLLERS.names() or controller in _names(tuple(named))


@functools.cache
def _names(labels: tuple[str, ...]) -> frozenset[str]:
    """The controllers' own names in labels."""
    found = set()
    for label in labels:
        for motion in ("swept", "stepped"):  # variations may be of one kind or of the other
            try:
                found.add(Scenario.parse(label, motion=motion).controller)
                break
            except InvalidParameter:
                continue
    return frozenset(found)
