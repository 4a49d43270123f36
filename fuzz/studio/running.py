"""Decide what the page may run: registered code, and controllers named at the start."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence

from sim.controllers import CONTROLLERS
from sim.controllers.behaviours.catalogue import is_composition_name, listed_names
from sim.motion import MOTIONS
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.plugins.registry import only_code
from worldgen.support.plain_text import shown
from worldgen.world import FailureRecord

__all__ = ["allow_only", "check_named", "check_record", "check_registered", "may_run", "names_of"]


def allow_only(named: Sequence[str]) -> None:
    """Restrict this process and those it starts to registered code and named controllers.

    Args:
        named: Controllers, with their variations.
    """
    only_code(names_of(tuple(named)))


def may_run(controller: str, named: Sequence[str]) -> bool:
    """Return True if a controller that a file or a campaign names may run.

    Args:
        controller: Its name, without variations.
        named: Controllers named at the start, with variations.
    """
    return controller in CONTROLLERS.names() or controller in names_of(tuple(named))


def check_record(record: FailureRecord, named: Sequence[str]) -> None:
    """Refuse to run a failure that needs code from a file, which may come from anywhere.

    None of that code is loaded.

    Raises:
        InvalidParameter: If its controller was not named at the start, or its motion model is not
            registered.
    """
    if not may_run(record.controller, named):
        raise InvalidParameter(
            "not-named",
            "{verdict}; {controller} is not run here: it was not named when the studio started",
            verdict=record.verdict,
            controller=shown(record.controller[:60]),
        )
    if record.motion not in MOTIONS.names():
        raise InvalidParameter(
            "not-registered",
            "{verdict}; it is not run here: its motion model {motion} is from a file",
            "replay it at a terminal",
            verdict=record.verdict,
            motion=shown(record.motion[:60]),
        )


def check_named(label: object, named: Sequence[str]) -> None:
    """Refuse a controller that the page may not run.

    Its own options, ``NAME+option=value``, are allowed.

    Raises:
        InvalidParameter: If it is neither registered nor named at the start.
    """
    if label in named or label in CONTROLLERS.names():
        return
    text = str(label)
    known = (*CONTROLLERS.names(), *named, *names_of(tuple(named)))
    if not any(text.startswith(f"{name}+") for name in known):
        raise InvalidParameter(
            "not-named",
            "controller {controller!r} was not named when the studio was started",
            "name it at the start: worldgen studio --controller",
            at_terminal=True,
            controller=text[:60],
        )


def check_registered(what: str, name: str, offered: Iterable[str]) -> None:
    """Refuse a name that is not registered, because it would be code from a file.

    Raises:
        InvalidParameter: If the name is not registered.
    """
    if name not in offered:
        raise InvalidParameter(
            "not-registered",
            "{kind} {name!r} is not registered",
            "choose one from the list",
            kind=what,
            name=name[:40],
        )


@functools.cache
def names_of(labels: tuple[str, ...]) -> frozenset[str]:
    """Return the controllers' names in labels, without variations.

    Of a composition, the user's own behaviours are among them.
    """
    found = set()
    for label in labels:
        for motion in ("swept", "stepped"):  # variations may be for either kind of robot
            try:
                name = Scenario.parse(label, motion=motion).controller
                own = listed_names(name) if is_composition_name(name) else []
                found.update([name, *(part for part in own if ":" in part)])
                break
            except InvalidParameter:
                continue
    return frozenset(found)
