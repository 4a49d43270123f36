"""Controllers: observation and memory in, command and memory out; one file each.

Contents:
    CompiledController, PythonController, ProcessController, Observation, Command: the three ways to bring one.
    CONTROLLERS: finds one by name, as ``package.module:name``, ``./file.py:name``, or ``cmd:./program --flag``.
"""

from sim.controllers.base import Command, CompiledController, Controller, Observation, PythonController
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.process import ProcessController

__all__ = [
    "CONTROLLERS",
    "Command",
    "CompiledController",
    "Controller",
    "Observation",
    "ProcessController",
    "PythonController",
]
