"""What there is to choose from: families, controllers, motion models and formats, with their parameters."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from sim.controllers import CONTROLLERS, CompiledController
from sim.motion import MOTIONS
from sim.motion.base import THESIS
from sim.robot_options import RobotOptions
from sim.run_options import DEFAULT_TIME_STEP
from sim.scenario import Scenario
from sim.switches import Switches
from sim.thesis_options import ThesisOptions
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.interop import FORMATS
from worldgen.parameters import Parameter, argument_notes

__all__ = ["catalogue"]


def catalogue(named: Sequence[str]) -> dict[str, Any]:
    """Everything that the page offers.

    Args:
        named: Controllers that were named when the studio was started.
    """
    return {
        "families": [_family(name) for name in FAMILIES.names()],
        "controllers": [_controller(name) for name in dict.fromkeys((*named, *CONTROLLERS.names()))],
        "motions": [_motion(name) for name in MOTIONS.names()],
        "formats": [_format(name) for name in FORMATS.names()],
        "time_step": DEFAULT_TIME_STEP,
    }


def _family(name: str) -> dict[str, Any]:
    family = FAMILIES.get(name)
    return {
        "name": name,
        "about": family.description,
        "changes": family.changes,
        "parameters": [_parameter(parameter) for parameter in family.parameters],
    }


def _parameter(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "default": parameter.default,
        "kind": type(parameter.default).__name__,
        "choices": list(parameter.choices),
        "help": parameter.help,
    }


def _controller(label: str) -> dict[str, Any]:
    """A controller's label, and under which kind of motion model it drives; a fault in it is told, not raised."""
    entry = {"name": label, "thesis": False, "lattice": True, "fault": ""}
    try:
        found = CONTROLLERS.get(Scenario.parse(label).controller)
    except InvalidParameter as error:
        with contextlib.suppress(InvalidParameter):  # with options of the other motion models
            found = CONTROLLERS.get(Scenario.parse(label, motion="stepped").controller)
            return entry | {"thesis": True, "lattice": False}
        return entry | {"fault": str(error)}
    return entry | {"thesis": isinstance(found, CompiledController) and bool(found.thesis_rule)}


def _motion(name: str) -> dict[str, Any]:
    motion = MOTIONS.get(name)
    thesis = motion.kernel == THESIS
    return {
        "name": name,
        "about": motion.summary,
        "thesis": thesis,
        "options": _options(ThesisOptions if thesis else RobotOptions),
    }


def _options(kind: type[Switches]) -> list[dict[str, Any]]:
    notes = argument_notes(kind.__doc__ or "")
    listed = []
    for one in fields(kind):
        low, high, unit = kind.RANGES.get(one.name, (-math.inf, math.inf, ""))
        if isinstance(one.default, tuple):
            continue  # lists are the command line's
        listed.append(
            {
                "name": one.name,
                "default": one.default,
                "kind": type(one.default).__name__,
                "choices": list(kind.CHOICES.get(one.name, ())),
                "low": low if math.isfinite(low) else None,
                "high": high if math.isfinite(high) else None,
                "unit": unit.strip(),
                "help": notes.get(one.name, ""),
            }
        )
    return listed


def _format(name: str) -> dict[str, Any]:
    known = FORMATS.get(name)
    return {
        "name": name,
        "about": known.summary,
        "suffixes": list(known.suffixes),
        "reads": known.read is not None,
        "writes": known.write is not None,
    }
