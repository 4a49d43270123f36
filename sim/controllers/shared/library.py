"""Controllers in shared libraries: ``lib:./robot.so:act`` runs inside the simulator.

Whatever the library does runs in another process (:mod:`sim.controllers.shared.guarded`) and in
memory of its own (:mod:`sim.controllers.shared.cage`), so that a crash is a verdict and does not
end the program. Only a system that cannot fork runs it in this process.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sim._core import ffi, lib
from sim.controllers.base import DEFAULT_SENSES, CompiledController, Observation, bits_of
from sim.controllers.controller_error import ControllerError
from sim.controllers.core_act import CoreAct
from sim.controllers.shared import guarded
from sim.controllers.shared.cage import Cage
from sim.controllers.shared.guarded import ControllerDied
from sim.controllers.shared.object_file import declares, info_of
from sim.options.robot import RobotOptions
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter

# What precedes an error of ``reset``, which has no step.
_IN_RESET = "in reset: "

# Numbers in the memory of a controller.
_MOST_MEMORY = 1 << 20


@dataclass(frozen=True)
class SharedAct(CoreAct):
    """The act function of a controller in a shared library.

    Args:
        name: Name of the controller, such as ``lib:./robot.so:act``.
    """

    @property
    def address(self) -> int:
        """Address of the function, a ``WgAct``."""
        return int(ffi.cast("uintptr_t", info_of(self.name).act))

    @property
    def is_guarded(self) -> bool:
        """True if it runs in another process, as on every system that can fork."""
        return guarded.can_fork


@dataclass(frozen=True)
class FailedReset(CoreAct):
    """Acts in place of a controller whose ``reset`` failed: it fails in its first step.

    Args:
        name: Name of the controller.
        fault: What happened in ``reset``.
    """

    fault: ControllerError

    @property
    def address(self) -> int:
        """Address of the function, a ``WgAct``."""
        return int(ffi.cast("uintptr_t", ffi.addressof(lib, "wg_failed_reset_act")))

    def fault_of(self, error: Any) -> ControllerError:
        """Return what happened in ``reset``."""
        return self.fault


def library_controller(name: str) -> CompiledController:
    """Return the controller that a shared library offers.

    Args:
        name: Name of the controller, such as ``lib:./robot.so:act``.

    Raises:
        InvalidParameter: If the library or the controller does not exist, or it was built for
            another version of the interface.
    """
    info = info_of(name)
    senses = _senses(name, int(info.senses))
    beams = _within(name, "beams", int(info.beams), int(lib.WG_MOST_BEAMS))
    if info.beam_range < 0.0 or info.beam_range != info.beam_range:
        raise InvalidParameter(
            "below-minimum",
            "controller {name!r} has beam_range={beam_range:g} m",
            "use 0 or more",
            name=name,
            beam_range=info.beam_range,
        )
    needs: dict[str, Any] = {"beams": beams} if beams else {}
    if info.beam_range:
        needs["beam_range"] = float(info.beam_range)
    if declares(info, "neighbour_range") and info.neighbour_range:
        needs["neighbour_range"] = float(info.neighbour_range)
    if declares(info, "message"):
        needs["message"] = _within(name, "message", int(info.message), int(lib.WG_MOST_MESSAGE))
    act: CoreAct = SharedAct(name)
    size = _within(name, "memory_size", int(info.memory_size), _MOST_MEMORY)
    memory = (0.0,) * size
    try:
        memory = _memory_at_reset(info, size)
    except ControllerError as fault:
        act = FailedReset(name, fault)
    return CompiledController(
        name,
        act,
        memory,
        start_speed=float(info.start_speed),
        randomised="random" in senses,
        senses=senses,
        needs=RobotOptions(**needs),
    )


def _memory_at_reset(info: Any, size: int) -> tuple[float, ...]:
    """Return the memory at reset.

    Raises:
        ControllerError: If the library's function crashes, hangs or misses its memory.
    """
    if info.reset == ffi.NULL:
        return (0.0,) * size
    if not guarded.can_fork:
        memory = ffi.new("double[]", size)
        info.reset(memory)
        return tuple(memory)
    cage = Cage(0, size)
    reset = guarded.SHARED.new("WgReset *")
    reset[0] = info.reset
    work = ffi.addressof(lib, "wg_call_reset")
    function = int(ffi.cast("uintptr_t", info.reset))
    try:
        is_kept = guarded.call(work, (function,), (cage.c, reset), cages=(cage,))
    except ControllerDied as death:
        raise ControllerError(death.verdict, f"{_IN_RESET}{death.error}", death.facts) from None
    if not is_kept:
        error = ffi.string(cage.c.error).decode()
        raise ControllerError(Verdict.CRASH, f"{_IN_RESET}{error}")
    return tuple(ffi.unpack(cage.c.memory, size)) if size else ()


def _within(name: str, field: str, value: int, most: int) -> int:
    if not 0 <= value <= most:
        raise InvalidParameter(
            "out-of-range",
            "controller {name!r} has {field}={value}, outside 0 to {most}",
            "correct it and build the library again",
            name=name,
            field=field,
            value=value,
            most=most,
        )
    return value


def _senses(name: str, bits: int) -> tuple[str, ...]:
    """Return the names of the senses that a library's controller reads."""
    known = int(lib.WG_SENSE_NOTHING_ELSE)
    for sense in Observation._fields:
        known |= bits_of(sense)
    if bits & ~known:
        raise InvalidParameter(
            "unknown-senses",
            "controller {name!r} has senses={bits:#x}, which are not all WG_SENSE_ bits",
            "use only the bits in the header",
            name=name,
            bits=bits,
        )
    if bits == 0:
        return DEFAULT_SENSES
    return tuple(
        sense for sense in Observation._fields if not bits_of(sense) or bits & bits_of(sense)
    )
