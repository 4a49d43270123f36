"""List everything that the page offers as a choice, with its parameters.

These are families, controllers, motion models and formats.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from fuzz.oracles import ORACLES
from fuzz.search.registry import OWN_STRATEGIES
from fuzz.studio.campaigns.fuzz_arguments import options
from fuzz.studio.requests.folder import KNOWN
from fuzz.studio.requests.refusals import refusal
from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.base import Controller
from sim.motion import MOTIONS
from sim.options.robot import RobotOptions
from sim.options.run import DEFAULT_TIME_STEP, RunOptions
from sim.options.thesis import ThesisOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.interop import FORMATS
from worldgen.parameters import Parameter
from worldgen.parameters.bounds import Bounds

# s: a controller that took longer to fail is not tried again, because each new page would have to
# wait.
_SLOW = 3.0
_FAILED: dict[tuple[str, int], dict[str, Any]] = {}

_MAZES = (
    "wilson",
    "aldous-broder",
    "backtracker",
    "hunt-and-kill",
    "kruskal",
    "prim",
    "eller",
    "sidewinder",
    "binary-tree",
    "recursive-division",
)
IDLE: Mapping[str, Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "corridor": {
        "bends": ("shape", ("T", "X", "tunnel")),
        "branches": ("shape", ("bends", "S", "tunnel")),
    },
    "maze": {"newest": ("algorithm", _MAZES), "oldest": ("algorithm", _MAZES)},
    "rooms": {"corridor": ("plan", ("suite",))},
    "trap": {
        "inside": ("faces", ("target",)),
        "parts": ("shape", ("U", "L", "spiral", "V", "pair")),
        "turns": ("shape", ("U", "L", "V", "comb", "nested", "pair")),
    },
}
"""By family and parameter: the parameter that decides, and its values for which this parameter has
no effect.

The families refuse such a parameter with the code ``no-effect``; the page does not show it.
"""


def catalogue(named: Sequence[str], part: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """Return everything that the page offers as a choice.

    Args:
        named: Controllers that were named when the studio was started.
        part: Called with each of them before it is loaded, which may take a long time.
    """
    controllers = []
    for label in dict.fromkeys((*named, *CONTROLLERS.names())):
        if label in named:
            part({"loading": label})
        controllers.append(_tried(label) | {"named": label in named})
    return {
        "families": [_family(name) for name in FAMILIES.names()],
        "controllers": controllers,
        "motions": [_motion(name) for name in MOTIONS.names()],
        "formats": [_format(name) for name in FORMATS.names()],
        "motion": RunOptions().motion,
        "time_step": DEFAULT_TIME_STEP,
        "strategies": list(OWN_STRATEGIES),
        "oracles": ORACLES.names(),
        "cores": os.cpu_count() or 1,
        "known": KNOWN,
        "options": options(),
    }


def _family(name: str) -> dict[str, Any]:
    family = FAMILIES.get(name)
    return {
        "name": name,
        "about": family.description.partition("\n\n")[0],
        "changes": family.changes,
        "parameters": [
            _parameter(parameter) | {"idle": _idle(name, parameter.name)}
            for parameter in family.parameters
        ],
    }


def _idle(family: str, parameter: str) -> dict[str, Any] | None:
    found = IDLE.get(family, {}).get(parameter)
    return None if found is None else {"by": found[0], "values": list(found[1])}


def _parameter(parameter: Parameter) -> dict[str, Any]:
    bounds = parameter.bounds or Bounds()
    return {
        "name": parameter.name,
        "default": parameter.default,
        "kind": type(parameter.default).__name__,
        "choices": list(parameter.choices),
        "low": bounds.low,
        "high": bounds.high,
        "above": bounds.above,
        "chosen": bounds.chosen,
        "bounds": bounds.words,
        "unit": bounds.unit,
        "group": parameter.group,
        "help": parameter.help,
    }


def _tried(label: str) -> dict[str, Any]:
    """Return the entry of a controller after loading it.

    If loading failed slowly before, return that result again until the controller's file changes.
    """
    key = (label, _changed(label))
    if key in _FAILED:
        return _FAILED[key]
    began = time.monotonic()
    entry = _controller(label)
    if entry["fault"] and time.monotonic() - began > _SLOW:
        _FAILED[key] = entry
    return entry


def _changed(label: str) -> int:
    """Return the time of the last change of a controller's file; 0 if it is not in a file."""
    file, ending, _ = label.partition(".py:")
    try:
        return Path(file + ".py").expanduser().stat().st_mtime_ns if ending else 0
    except (OSError, ValueError, RuntimeError):  # ValueError: a NUL; RuntimeError: an unknown user
        return 0


def _controller(label: str) -> dict[str, Any]:
    """Return a controller's label and the motion models it can run under, the usual one first.

    Faults are reported in the entry, not raised.
    """
    entry = {
        "name": label,
        "thesis": False,
        "lattice": True,
        "motion": "swept",
        "also": "",
        "fault": None,
    }
    try:
        scenario = Scenario.parse(label)
        found = CONTROLLERS.get(scenario.controller)
    except InvalidParameter as error:
        with contextlib.suppress(InvalidParameter):  # its options may belong to the thesis's robot
            found = CONTROLLERS.get(Scenario.parse(label, motion="stepped").controller)
            return entry | {"thesis": True, "lattice": False, "motion": "stepped"}
        return entry | {"fault": refusal(error)}
    thesis = isinstance(found, CompiledController) and bool(found.thesis_rule)
    return entry | {"thesis": thesis, "motion": scenario.run.motion, "also": _other_name(label)}


def _other_name(label: str) -> str:
    """Return the registered name of the same controller; empty if there isn't one."""
    same = (
        name
        for name in CONTROLLERS.names()
        if name != label and _registered(name) is _registered(label)
    )
    return next(same, "") if label in CONTROLLERS.names() else ""


def _registered(name: str) -> Controller | None:
    """Return a registered controller; ``None`` if it cannot be loaded."""
    try:
        return CONTROLLERS.get(name)
    except InvalidParameter:
        return None


def _motion(name: str) -> dict[str, Any]:
    motion = MOTIONS.get(name)
    thesis = not motion.on_lattice
    return {
        "name": name,
        "about": motion.summary,
        "thesis": thesis,
        "options": [
            _parameter(option)
            for option in (ThesisOptions if thesis else RobotOptions).declared()
            if not isinstance(option.default, tuple)  # lists can only be set on the command line
        ],
    }


def _format(name: str) -> dict[str, Any]:
    known = FORMATS.get(name)
    return {
        "name": name,
        "about": known.summary,
        "suffixes": list(known.suffixes),
        "reads": known.read is not None,
        "writes": known.write is not None,
        "changes": known.changes,
        "options": [_parameter(parameter) for parameter in known.write_options],
        "read_options": [_parameter(parameter) for parameter in known.read_options],
    }
