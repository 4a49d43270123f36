"""Plant a fault in a controller: its code runs unchanged, with one deviation around it, in C."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fuzz import _core
from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct
from sim.verdict import Verdict

_ffi: Any = _core.ffi
_lib: Any = _core.lib


@dataclass(frozen=True)
class FaultAct(CoreAct):
    """The act of a controller with a fault, a function of the search's C core.

    Args:
        name: Name of the fault in ``wg_fault``.
    """

    @property
    def address(self) -> int:
        """Address of the function, a ``WgAct``."""
        return int(_ffi.cast("uintptr_t", _lib.wg_fault(self.name.encode()).act))


@dataclass(frozen=True)
class Fault(CompiledController):
    """A controller with a known fault.

    Args:
        sentence: Description of the fault.
        base: The controller without the fault.
        expected: The verdict that it leads to in worlds where the base arrives.
        variations: Variations of the run, as in a controller's name: ``+motion=endpoint``.
    """

    sentence: str = ""
    base: CompiledController | None = None
    expected: Verdict | None = None
    variations: str = ""


def planted(
    name: str, base: CompiledController, expected: Verdict, sentence: str, *, variations: str = ""
) -> Fault:
    """Return a controller with a fault of the C core.

    Args:
        name: Name of the fault.
        base: The controller without the fault.
        expected: The verdict that it leads to.
        sentence: Description of the fault.
        variations: Variations of the run.
    """
    return Fault(
        name=name,
        act=FaultAct(name),
        memory=base.memory + (0.0,) * int(_lib.wg_fault(name.encode()).room),
        start_speed=base.start_speed,
        randomised=base.randomised,
        senses=base.senses,
        needs=base.needs,
        sentence=sentence,
        base=base,
        expected=expected,
        variations=variations,
    )
