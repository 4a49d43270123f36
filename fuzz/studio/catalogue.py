"""List everything that the page offers as a choice, with its parameters.

These are families, controllers, motion models and formats.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from fuzz.oracles import ORACLES
from fuzz.search.registry import OWN_STRATEGIES
from fuzz.studio.campaigns.fuzz_arguments import options
from fuzz.studio.requests.folder import KNOWN, Opened, answer
from fuzz.studio.requests.protocol import (
    FamilyMessage,
    FormatMessage,
    Hello,
    Idle,
    MotionMessage,
    Offered,
    OfferedController,
    ParameterMessage,
    SendPart,
)
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
_FAILED: dict[tuple[str, int], OfferedController] = {}

_MAZES = [
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
]
IDLE: Mapping[str, Mapping[str, Idle]] = {
    "corridor": {
        "bends": Idle("shape", ["T", "X", "tunnel"]),
        "branches": Idle("shape", ["bends", "S", "tunnel"]),
    },
    "maze": {"newest": Idle("algorithm", _MAZES), "oldest": Idle("algorithm", _MAZES)},
    "rooms": {"corridor": Idle("plan", ["suite"])},
    "trap": {
        "inside": Idle("faces", ["target"]),
        "parts": Idle("shape", ["U", "L", "spiral", "V", "pair"]),
        "turns": Idle("shape", ["U", "L", "V", "comb", "nested", "pair"]),
    },
}
"""By family and parameter: the parameter that decides, and its values for which this parameter has
no effect.

The families refuse such a parameter with the code ``no-effect``; the page does not show it.
"""


@answer.register
def _hello(request: Hello, opened: Opened, part: SendPart[str]) -> Offered:
    return catalogue(opened.named, part)


def catalogue(named: Sequence[str], part: SendPart[str]) -> Offered:
    """Return everything that the page offers as a choice.

    Args:
        named: Controllers that were named when the studio was started.
        part: Called with each of them before it is loaded, which may take a long time.
    """
    controllers = []
    for label in dict.fromkeys((*named, *CONTROLLERS.names())):
        if label in named:
            part(label)
        controllers.append(_tried(label, label in named))
    return Offered(
        families=[*map(_family, FAMILIES.names())],
        controllers=controllers,
        motions=[*map(_motion, MOTIONS.names())],
        formats=[*map(_format, FORMATS.names())],
        motion=RunOptions().motion,
        time_step=DEFAULT_TIME_STEP,
        strategies=list(OWN_STRATEGIES),
        oracles=ORACLES.names(),
        cores=os.cpu_count() or 1,
        known=KNOWN,
        options=options(),
    )


def _family(name: str) -> FamilyMessage:
    family = FAMILIES.get(name)
    about = family.description.partition("\n\n")[0]
    idle = IDLE.get(name, {})
    parameters = [_parameter(one, idle.get(one.name)) for one in family.parameters]
    return FamilyMessage(name, about, family.changes, parameters)


def _parameter(parameter: Parameter, idle: Idle | None = None) -> ParameterMessage:
    bounds = parameter.bounds or Bounds()
    return ParameterMessage(
        name=parameter.name,
        default=parameter.default,
        kind=type(parameter.default).__name__,
        choices=list(parameter.choices),
        low=bounds.low,
        high=bounds.high,
        above=bounds.above,
        chosen=bounds.chosen,
        bounds=bounds.words,
        unit=bounds.unit,
        group=parameter.group,
        help=parameter.help,
        idle=idle,
    )


def _tried(label: str, named: bool) -> OfferedController:
    """Return the entry of a controller after loading it.

    If loading failed slowly before, return that result again until the controller's file changes.
    """
    key = (label, _changed(label))
    if key in _FAILED:
        return _FAILED[key]
    began = time.monotonic()
    entry = _controller(label, named)
    if entry.fault and time.monotonic() - began > _SLOW:
        _FAILED[key] = entry
    return entry


def _changed(label: str) -> int:
    """Return the time of the last change of a controller's file; 0 if it is not in a file."""
    file, ending, _ = label.partition(".py:")
    try:
        return Path(file + ".py").expanduser().stat().st_mtime_ns if ending else 0
    except (OSError, ValueError, RuntimeError):  # ValueError: a NUL; RuntimeError: an unknown user
        return 0


def _controller(label: str, named: bool) -> OfferedController:
    """Return a controller's label and the motion models it can run under, the usual one first.

    Faults are reported in the entry, not raised.
    """
    try:
        scenario = Scenario.parse(label)
        found = CONTROLLERS.get(scenario.controller)
    except InvalidParameter as error:
        with contextlib.suppress(InvalidParameter):  # its options may belong to the thesis's robot
            CONTROLLERS.get(Scenario.parse(label, motion="stepped").controller)
            return OfferedController(
                name=label, named=named, thesis=True, lattice=False, motion="stepped"
            )
        return OfferedController(name=label, named=named, fault=refusal(error))
    return OfferedController(
        name=label,
        named=named,
        thesis=isinstance(found, CompiledController) and bool(found.thesis_rule),
        motion=scenario.run.motion,
        also=_other_name(label),
    )


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


def _motion(name: str) -> MotionMessage:
    motion = MOTIONS.get(name)
    thesis = not motion.on_lattice
    options = [
        _parameter(option)
        for option in (ThesisOptions if thesis else RobotOptions).declared()
        if not isinstance(option.default, tuple)  # lists can only be set on the command line
    ]
    return MotionMessage(name, motion.summary, thesis, options)


def _format(name: str) -> FormatMessage:
    known = FORMATS.get(name)
    return FormatMessage(
        name,
        known.summary,
        list(known.suffixes),
        reads=known.read is not None,
        writes=known.write is not None,
        changes=known.changes,
        options=[*map(_parameter, known.write_options)],
        read_options=[*map(_parameter, known.read_options)],
    )
