"""The simulator: robots, motion models, controllers, runs and their traces.

Contents, each imported when it is first used:
    simulate: Run one controller in one world. Returns an Episode, with a Trace if one is recorded.
    FleetEpisode: What simulate returns for a world of several robots.
    simulate_many: Run many controllers, worlds and seeds. Returns Runs, with results in arrays.
    RunOptions: How a run is done: motion model, time step, budget and robot.
    RobotOptions: Dynamics and sensors of the robot, under the motion models on the lattice.
    ThesisOptions: Options of the thesis's simulator.
    Scenario: Everything about a run except the world.
    CompiledController, PythonController, VectorController, ProcessController: Bring your own
        controller as one of these.
    Observation, Command: A controller's input and output, for one robot.
    Observations, Commands: The same for many robots, in arrays.
    MemoryField, MemoryMap: How pages and pictures show a controller's memory.
    CONTROLLERS, MOTIONS: The registered controllers and the motion models, by name.

PYTEST_DONT_REWRITE: lets a program that has imported this call pytest.main() without a warning.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
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
    from sim.episode.batch import Runs, simulate_many
    from sim.motion import MOTIONS
    from sim.options.robot import RobotOptions
    from sim.options.run import RunOptions
    from sim.options.thesis import ThesisOptions
    from sim.outcome import FleetEpisode
    from sim.scenario import Scenario
    from sim.trace import Trace

__getattr__, __dir__ = lazy_names(
    __name__,
    {
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
        "episode.batch": ("Runs", "simulate_many"),
        "motion": ("MOTIONS",),
        "options.robot": ("RobotOptions",),
        "options.run": ("RunOptions",),
        "options.thesis": ("ThesisOptions",),
        "outcome": ("FleetEpisode",),
        "scenario": ("Scenario",),
        "trace": ("Trace",),
    },
)

__all__ = [
    "CONTROLLERS",
    "MOTIONS",
    "Command",
    "Commands",
    "CompiledController",
    "Episode",
    "FleetEpisode",
    "MemoryField",
    "MemoryMap",
    "Observation",
    "Observations",
    "ProcessController",
    "PythonController",
    "RobotOptions",
    "RunOptions",
    "Runs",
    "Scenario",
    "ThesisOptions",
    "Trace",
    "VectorController",
    "simulate",
    "simulate_many",
]
