"""The shared simulator: robots, motion models, controllers, runs and their traces.

Contents, each imported when it is first used:
    simulate: one run and its verdict. Episode, Trace: what comes back. RunOptions: how it is done.
    simulate_many, Runs: many runs at once, results in arrays.
    Scenario: everything about a run except the world. RobotOptions, ThesisOptions: dynamics and
        sensors under
    the motion models on the lattice; switches of the thesis's simulator.
    CompiledController, PythonController, VectorController, ProcessController: bring your own
        controller.
    Observation, Command, Observations, Commands: what it sees and says, for one robot and for many.
    MemoryField, MemoryMap: how its memory is shown to people.
    CONTROLLERS, MOTIONS: what is registered.

PYTEST_DONT_REWRITE: a program that has imported this may call pytest.main() without a warning.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from sim.batch import Runs, simulate_many
    from sim.controllers import (
        CONTROLLERS,
        Command,
        Commands,
        CompiledController,
        MemoryField,
        MemoryMap,
        Observation,
        Observations,
        ProcessController,
        PythonController,
        VectorController,
    )
    from sim.episode import Episode, simulate
    from sim.motion import MOTIONS
    from sim.options.robot import RobotOptions
    from sim.options.run import RunOptions
    from sim.scenario import Scenario
    from sim.thesis.options import ThesisOptions
    from sim.trace import Trace

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "batch": ("Runs", "simulate_many"),
        "controllers": (
            "CONTROLLERS",
            "Command",
            "Commands",
            "CompiledController",
            "MemoryField",
            "MemoryMap",
            "Observation",
            "Observations",
            "ProcessController",
            "PythonController",
            "VectorController",
        ),
        "episode": ("Episode", "simulate"),
        "motion": ("MOTIONS",),
        "options.robot": ("RobotOptions",),
        "options.run": ("RunOptions",),
        "scenario": ("Scenario",),
        "thesis.options": ("ThesisOptions",),
        "trace": ("Trace",),
    },
)

__all__ = [
    "CONTROLLERS", "MOTIONS", "Command", "Commands", "CompiledController", "Episode", "MemoryField", "MemoryMap",
    "Observation", "Observations", "ProcessController", "PythonController", "RobotOptions", "RunOptions", "Runs",
    "Scenario", "ThesisOptions", "Trace",
    "VectorController", "simulate", "simulate_many",
]  # fmt: skip
