"""Controllers: observation and memory in, command and memory out; one file each.

Contents:
    CompiledController, PythonController, VectorController, ProcessController: the ways to bring
        one.
    Observation, Command, Observations, Commands: what it sees and says, for one robot and for many.
    MemoryField, MemoryMap: how its memory is shown to people.
    CONTROLLERS: finds one by name, as ``package.module:name``, ``./file.py:name``, or
        ``cmd:./program --flag``.
    controller_of: the same, or the thing itself, checked.
    names_in: the controllers of a list with commas.
    in_plain_place: one name for all ways to write a controller's file.
"""

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
