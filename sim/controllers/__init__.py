"""Controllers: observation and memory in, command and memory out; one file each.

Contents:
    CompiledController, PythonController, Observation, Command: the two ways to bring one.
    CONTROLLERS: finds one by name, as ``package.module:name``, or as ``./file.py:name``.
"""

from sim.controllers.base import (
    CONTROLLERS,
    Command,
    CompiledController,
    Controller,
    Observation,
    PythonController,
)

__all__ = ["CONTROLLERS", "Command", "CompiledController", "Controller", "Observation", "PythonController"]
