"""Plants a fault in a controller.

The controller's own code, with one deviation around it, in the C core.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fuzz import _core
from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct
from sim.verdict import Verdict

__all__ = ["Fault", "FaultAct", "planted"]

_ffi: Any = _core.ffi
_lib: Any = _core.lib


@dataclass(frozen=True)
class FaultAct(CoreAct):
    """The act of a controller with a fault, a function of the search's C core.

    Args:
        name: As ``wg_fault`` has it.
    """

    @property
    def address(self) -> int:
        """Where the function is: a ``WgAct``."""
        return int(_ffi.cast("uintptr_t", _lib.wg_fault(self.name.encode()).act))


@dataclass(frozen=True)
class Fault(CompiledController):
    """A controller with a known fault.

    Args:
        sentence: What is wrong.
        base: The controller without it.
        expected: The verdict to which it leads where the base arrives.
        variations: Of the run, as they follow a controller's name: ``+motion=endpoint``.
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
        name: Of the fault.
        base: The controller without it.
        expected: Verdict.
        sentence: What is wrong.
        variations: Of the run.
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
