"""Decide what the page may run, by the same rule as every command (``worldgen.plugins.trust``)."""

from __future__ import annotations

import contextlib
import functools
import re
import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fuzz.studio.requests.folder import Opened
from fuzz.studio.requests.protocol import RunRequest
from sim.controllers import CONTROLLERS
from sim.controllers.behaviours.arbitration import Arbitration, sentences
from sim.controllers.behaviours.catalogue import BEHAVIOURS, is_composition_name, listed_names
from sim.controllers.behaviours.chart import chart_of
from sim.controllers.catalogue import own_words
from sim.controllers.learning import LEARNED
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.plugins import trust
from worldgen.support.plain_text import shown
from worldgen.world import FailureRecord

# The option of a controller that names a file.
_LEARNED_FILE = re.compile(rf"(\+{LEARNED}=)([^+,]*)")


def allow_only(named: Sequence[str]) -> None:
    """Apply the rule of commands to this process and those it starts.

    Args:
        named: Controllers that were named at the start, with their variations.
    """
    trust.restrict(named)


def may_run(controller: str, named: Sequence[str], *, learned: bool = False) -> bool:
    """Return True if a controller that a file or a campaign names may run.

    Args:
        controller: Its name, without variations of the run.
        named: Controllers named at the start, with variations.
        learned: Whether it may read what it learned from a file, whose place has been checked.
    """
    allowed = names_of(tuple(named))
    with contextlib.suppress(InvalidParameter):
        base, words = own_words(controller)
        # Its fields change nothing about whose code it is.
        if words and LEARNED not in words:
            return controller in allowed or may_run(base, named)
        if words and learned:
            return base in CONTROLLERS.names() or base in allowed or controller in allowed
    parts = listed_names(controller) if is_composition_name(controller) else [controller]
    registered = BEHAVIOURS if is_composition_name(controller) else CONTROLLERS
    return all(
        part in registered.names() or part in allowed or (":" in part and trust.may_run(part))
        for part in parts
    )


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
            "{verdict}; {controller} does not run here: it was not named when the studio started",
            verdict=record.verdict,
            controller=shown(record.controller[:60]),
        )
    if record.motion not in MOTIONS.names():
        raise InvalidParameter(
            "not-registered",
            "{verdict}; it does not run here: its motion model {motion} comes from a file",
            "replay it at a terminal",
            verdict=record.verdict,
            motion=shown(record.motion[:60]),
        )


def check_named(label: str, named: Sequence[str]) -> None:
    """Refuse a controller that the page may not run.

    Its own options, ``NAME+option=value``, are allowed.

    Raises:
        InvalidParameter: If it is neither registered nor named at the start.
    """
    if label in named or label in CONTROLLERS.names():
        return
    # Each part's options follow its name, and those of the run follow the word before the colon.
    if is_composition_name(label) and may_run(label, named):
        return
    known = (*CONTROLLERS.names(), *named, *names_of(tuple(named)))
    if not any(label.startswith(f"{name}+") for name in known):
        raise InvalidParameter(
            "not-named",
            "controller {controller!r} was not named when the studio was started",
            "name it at the start: worldgen studio --controller",
            at_terminal=True,
            controller=label[:60],
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


def from_anywhere(line: str, code: str, registered: list[str]) -> str:
    """Return a command that also works in another folder.

    Code in a file may be named relative to the folder in which the studio was started.

    Args:
        line: The command, quoted for a shell.
        code: The controller that it needs, possibly with variations; empty if there is none.
        registered: Names that mean the same everywhere.
    """
    if code in ("", *registered) or any(code.startswith(f"{name}+") for name in registered):
        return line
    return f"cd {shlex.quote(str(Path.cwd()))} && {line}"


@functools.cache
def names_of(labels: tuple[str, ...]) -> frozenset[str]:
    """Return the controllers' names in labels, without variations.

    For a composition, these include the user's own behaviours.
    """
    found = set()
    for label in labels:
        for motion in ("swept", "stepped"):  # the variations may suit either kind of robot
            try:
                name = Scenario.parse(label, motion=motion).controller
                own = listed_names(name) if is_composition_name(name) else []
                found.update([name, *(part for part in own if ":" in part)])
                break
            except InvalidParameter:
                continue
    return frozenset(found)


def label_in(opened: Opened, label: str) -> str:
    """Return a controller's label, in which files that it reads have their full paths.

    The user's own labels, named at the start, are returned unchanged.

    Raises:
        InvalidParameter: If the page may not run it, or it names a file outside the folder.
    """
    check_named(label, opened.named)
    if label in opened.named:
        return label
    return _LEARNED_FILE.sub(lambda found: found[1] + opened.folder.file_in_option(found[2]), label)


def scenario_of(label: str, request: RunRequest, opened: Opened) -> Scenario:
    """Return the scenario of a controller that the page may run, with the requested options.

    Args:
        label: The controller, with its own options after ``+``.
        request: The request.
        opened: The opened folder, and the controllers named at the start.

    Raises:
        InvalidParameter: If the page may not run it, or an option does not fit.
    """
    text = label_in(opened, label)
    motion = request.motion
    check_registered("motion", motion, MOTIONS.names())
    scenario = Scenario.parse(text, motion=motion, time_step=request.time_step, seed=request.seed)
    if not may_run(scenario.controller, opened.named, learned=True):
        raise InvalidParameter(
            "not-named",
            "controller {controller!r} was not named when the studio was started",
            controller=scenario.controller[:60],
        )
    run = scenario.run
    check_registered("motion", run.motion, MOTIONS.names())
    # The controller's own variations take precedence over the options for all robots.
    options = {
        "time_step": run.time_step,
        **(request.options if run.motion == motion else {}),
        **run.changed(),
    }
    return Scenario(scenario.controller, RunOptions.of(run.motion, request.seed, options))


def chart_message(arbitration: Arbitration | None) -> dict[str, Any] | None:
    """Return how a robot arbitrates among its behaviours, as a flow chart and in words."""
    if arbitration is None:
        return None
    chart = chart_of(arbitration)
    return {
        "arbiter": arbitration.arbiter,
        "words": sentences(arbitration),
        "width": chart.width,
        "height": chart.height,
        "shapes": chart.shapes,
    }
