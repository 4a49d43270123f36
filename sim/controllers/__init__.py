"""Controllers: observation and memory in, command and memory out.

Contents, each imported when it is first used:
    CompiledController, PythonController, VectorController, ProcessController: Bring your own
        controller as one of these.
    Observation, Command: A controller's input and output, for one robot.
    Observations, Commands: The same for many robots, in arrays.
    MemoryField, MemoryMap: How a controller's memory is shown to users.
    CONTROLLERS: Finds a controller by name, as ``package.module:name``, ``./file.py:name``, or
        ``cmd:./program --flag``.
    controller_of: Finds a controller by name, or checks the one that it is given.
    names_in: Splits a comma-separated list of controllers.
    in_plain_place: Normalises the path in a controller's name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from sim.controllers.base import (
        Command,
        Commands,
        CompiledController,
        Controller,
        Observation,
        Observations,
        PythonController,
        VectorController,
    )
    from sim.controllers.catalogue import CONTROLLERS, controller_of, in_plain_place, names_in
    from sim.controllers.memory_view import MemoryField, MemoryMap
    from sim.controllers.programs.process import ProcessController

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "base": (
            "Command",
            "Commands",
            "CompiledController",
            "Controller",
            "Observation",
            "Observations",
            "PythonController",
            "VectorController",
        ),
        "catalogue": ("CONTROLLERS", "controller_of", "in_plain_place", "names_in"),
        "memory_view": ("MemoryField", "MemoryMap"),
        "programs.process": ("ProcessController",),
    },
)

__all__ = [
    "CONTROLLERS",
    "Command",
    "Commands",
    "CompiledController",
    "Controller",
    "MemoryField",
    "MemoryMap",
    "Observation",
    "Observations",
    "ProcessController",
    "PythonController",
    "VectorController",
    "controller_of",
    "in_plain_place",
    "names_in",
]
