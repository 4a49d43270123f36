"""``worldgen behaviours``: list the behaviours that a controller can be composed of."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import (
    PATH,
    check_out,
    emit_json,
    force_option,
    json_option,
    say,
    write_out,
)
from worldgen.support.plain_text import stacked

if TYPE_CHECKING:
    from sim.controllers.behaviours.arbitration import Arbitration

EXAMPLES = (
    "\b\n  worldgen behaviours\n"
    "  worldgen behaviours behaviours:avoid+angle=2,follow,wander --chart out.svg\n"
    "  worldgen behaviours thesis-1 --json"
)


@click.command(epilog=EXAMPLES)
@click.argument("controller", required=False)
@click.option(
    "--chart",
    type=PATH,
    metavar="OUT",
    help="Draw how the controller arbitrates, as a flow chart (.svg).",
)
@json_option
@force_option
def behaviours(controller: str | None, chart: Path | None, as_json: bool, force: bool) -> None:
    """List behaviours, or show how a controller chooses among its own.

    Compose your own: --controller behaviours:avoid,follow,wander starts with the highest
    priority.
    """
    from sim.controllers.behaviours.arbitration import sentences
    from sim.controllers.behaviours.chart import chart_svg
    from sim.scenario import Scenario

    # Without a controller, list the library.
    if controller is None:
        if chart is not None:
            raise click.UsageError("--chart draws a controller, so choose one")
        _list_library(as_json)
        return
    # Check the chart's file before the work.
    check_out("--chart", chart, ".svg", force=force)
    arbitration = Scenario.parse(controller).arbitration
    if arbitration is None:
        raise click.UsageError(
            f"{controller} does not arbitrate among behaviours; compose some: "
            "behaviours:avoid,follow,wander"
        )
    # Print, then draw.
    if as_json:
        emit_json(_facts(arbitration))
    else:
        say(stacked((f"by {arbitration.arbiter}", *sentences(arbitration))))
    if chart is not None:
        write_out(chart, chart_svg(arbitration, controller).encode(), force=force)


def _list_library(as_json: bool) -> None:
    from sim.controllers.behaviours.arbitration import ALWAYS
    from sim.controllers.behaviours.catalogue import BEHAVIOURS, options_of

    rows = []
    for name in BEHAVIOURS:
        one = BEHAVIOURS.get(name)
        own = [option for option in options_of(one) if option.name not in _OF_EVERY_PART]
        defaults = {option.name: option.default for option in own}
        rows.append({"name": name, "when": one.applies, "does": one.does, "options": defaults})
    if as_json:
        emit_json({"behaviours": rows})
        return
    for row in rows:
        when = row["when"] if row["when"] == ALWAYS else f"when {row['when']}"
        say(f"{row['name']}: {when}")
        say(f"  {row['does']}")
        options = row["options"]
        if isinstance(options, dict) and options:
            words = " ".join(f"+{key}={value}" for key, value in options.items())
            say(f"  options: {words}")
    say("each part also has +priority=N, +duration=STEPS and +interruptible")


_OF_EVERY_PART = ("priority", "duration", "interruptible")


def _facts(arbitration: Arbitration) -> dict[str, object]:
    return {
        "arbiter": arbitration.arbiter,
        "parts": [
            {
                "name": name,
                "priority": part.priority,
                "when": part.trigger,
                "does": part.action,
                "duration": part.duration if part.duration != float("inf") else None,
                "interruptible": part.interruptible,
            }
            for name, part in zip(arbitration.names, arbitration.parts, strict=True)
        ],
    }
