"""``worldgen controllers``: list the controllers, and what each of them senses."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import emit_list, json_option, say

if TYPE_CHECKING:
    from sim.controllers.base import Controller

EXAMPLES = (
    "\b\n  worldgen controllers\n  worldgen controllers ./mine.py:Robot\n"
    "  worldgen controllers topological --json"
)

_WORDS = {
    "touch": ("bump", "bump_bearing"),
    "signal": ("signal", "signal_heading"),
    "target": ("target_heading", "target_distance"),
    "position": ("x", "y"),
    "wheels": ("odometry_x", "odometry_y", "odometry_heading"),
    "compass": ("heading",),
    "other robots": ("neighbours",),
    "clock": ("time",),
    "chance": ("random",),
    "goal heading": ("goal_heading",),
    "slope": ("tilt", "tilt_heading"),
}
"""Senses in words, with the fields of an observation that belong to each."""


@click.command(epilog=EXAMPLES)
@click.argument("name", required=False)
@json_option
def controllers(name: str | None, as_json: bool) -> None:
    """List the controllers, and what each of them senses.

    With NAME, such as bug2 or ./mine.py:Robot, list only that one, and the fields of a class.
    """
    from sim.controllers.catalogue import CONTROLLERS
    from sim.controllers.fields import describe_fields
    from sim.scenario import Scenario

    names = CONTROLLERS.names() if name is None else [name]
    rows = [_facts(one, CONTROLLERS.get(one)) for one in names]
    fields = () if name is None else Scenario(name).fields
    if name is not None:
        rows[0]["fields"] = {one.name: one.default for one in fields}
    columns = {"name": "controller", "in_words": "senses", "about": "what it does"}
    emit_list("controllers", rows, columns, as_json=as_json)
    if fields and not as_json:
        say(f"its name sets its fields: {describe_fields(fields)}")


def _facts(name: str, controller: Controller) -> dict[str, Any]:
    """Return the facts about a controller."""
    from sim.controllers.base import DEFAULT_SENSES, CompiledController, wants_world
    from sim.options.robot import RobotOptions

    senses = tuple(getattr(controller, "senses", DEFAULT_SENSES))
    needs = getattr(controller, "needs", RobotOptions()).changed()
    plans = not isinstance(controller, CompiledController) and wants_world(controller)
    words = ["the map"] if plans else []
    if "senses" not in dir(controller):
        words.append("everything but the clock")
    else:
        words += [word for word, fields in _WORDS.items() if set(fields) & set(senses)]
        if "beams" in senses and "beams" in needs:
            words.append(f"{needs['beams']} beams")
    return {
        "name": name,
        "about": _about(controller),
        "in_words": ", ".join(words),
        "senses": list(senses),
        "needs": needs,
        "knows_map": plans,
    }


def _about(controller: Any) -> str:
    """Return the line that a controller gives about itself, or the first one of its docstring."""
    about = getattr(controller, "about", "")
    arbitration = getattr(controller, "arbitration", None)
    if about:
        return str(about)
    if arbitration is not None:
        return f"Compose behaviours: {', '.join(arbitration.names)}."
    documented = type(controller).__doc__ or ""
    return inspect.cleandoc(documented).partition("\n")[0]
