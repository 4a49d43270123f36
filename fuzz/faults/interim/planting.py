"""Plants a fault in a controller: the controller's own code, with one deviation round it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numba
import numpy as np
import numpy.typing as npt

from sim.controllers.base import Act, CompiledController
from sim.kernels import layout
from sim.kernels._jit import kernel

__all__ = ["Deviation", "Fault", "Floats", "seeded", "unwrap_turn"]

Floats: TypeAlias = npt.NDArray[np.float64]
Deviation: TypeAlias = Callable[[Floats, Floats, Floats, Act], None]


@dataclass(frozen=True)
class Fault(CompiledController):
    """A controller with a known fault.

    Args:
        sentence: What is wrong.
        base: The controller without it.
        expected: The verdict to which it leads where the base arrives.
        variations: Of the run, as behind a controller's name: ``+motion=endpoint``.
        plain: ``act`` as Python, for who wants it interpreted.
    """

    sentence: str = ""
    base: CompiledController | None = None
    expected: str = ""
    variations: str = ""
    plain: Act | None = None


@kernel
def unwrap_turn(observation: Floats, command: Floats) -> None:
    """Makes the commanded turn the difference of two headings in [-pi, pi), as if nobody had wrapped it."""
    turn = command[layout.CMD_TURN_RATE] * observation[layout.OBS_TIME_STEP]
    if observation[layout.OBS_HEADING] + turn > math.pi:
        command[layout.CMD_TURN_RATE] = (turn - 2.0 * math.pi) / observation[layout.OBS_TIME_STEP]


def seeded(
    base: CompiledController, expected: str, *, room: int = 0,
    variations: str = "",
) -> Callable[[Deviation], Fault]:  # fmt: skip
    """Makes a :class:`Fault` of a function ``(observation, memory, command, base)``, which calls ``base`` in its way.

    Its docstring is the sentence that says what is wrong.

    Args:
        base: The controller without the fault.
        expected: Verdict.
        room: Numbers of memory behind the base's, 0 at reset.
        variations: Of the run.
    """
    jit: Any = numba.njit(nogil=True, boundscheck=True)
    base_act = jit(base.act)

    def plant(deviation: Deviation) -> Fault:
        deviate = jit(deviation)

        def act(observation: Floats, memory: Floats, command: Floats) -> None:
            deviate(observation, memory, command, base_act)

        def plain(observation: Floats, memory: Floats, command: Floats) -> None:
            deviation(observation, memory, command, getattr(base.act, "py_func", base.act))

        return Fault(
            name=getattr(deviation, "__name__", "fault").replace("_", "-"),
            act=act,
            memory=base.memory + (0.0,) * room,
            start_speed=base.start_speed,
            randomised=base.randomised,
            senses=base.senses,
            needs=base.needs,
            sentence=str(deviation.__doc__),
            base=base,
            expected=expected,
            variations=variations,
            plain=plain,
        )

    return plant
