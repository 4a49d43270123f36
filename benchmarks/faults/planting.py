"""Plant a fault in a controller: its code runs unchanged, with one deviation around it, in C.

The C is compiled on first use; ``python -m build_tools.cores`` compiles it again after a change.
"""

from __future__ import annotations

import fcntl
import importlib
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct
from sim.verdict import Verdict

_FOLDER = Path(__file__).parent


def _compiled() -> Any:
    """Return the extension module with the faults; of several processes one compiles it."""
    try:
        return importlib.import_module("._core", __package__)
    except ModuleNotFoundError:
        with (_FOLDER / ".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not any(_FOLDER.glob("_core.*")):
                command = [sys.executable, "-m", "build_tools.cores", "benchmarks.faults._core"]
                subprocess.run(command, cwd=_FOLDER.parents[1], check=True, stdout=sys.stderr)
        importlib.invalidate_caches()
        return importlib.import_module("._core", __package__)


_core = _compiled()
_ffi: Any = _core.ffi
_lib: Any = _core.lib


@dataclass(frozen=True)
class FaultAct(CoreAct):
    """The act of a controller with a fault, a function of the C next to this file.

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
