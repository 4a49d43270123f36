"""Worlds for mobile robots: generated, proved reachable, written as one text file.

Each of these is imported when it is first used: World, Robot, Pose, Target, Witness, JointWitness,
    Cut, Provenance, FailureRecord: a world and its parts. Timeline, Event, CellState: its changes over time.
    generate: a world of a family, with its proof. stream: a sequence of such worlds, made on
    demand. read_world, write_world, world_digest: the ``.grid`` file. decide, check_certificate:
    prove reachability, and check the proof independently. WorldgenError, with FormatError,
    GenerationFailed, InvalidParameter, InvalidWorld, OutputError: errors as data and as a sentence.
    Submodules: families (``worldgen.families.maze(seed=7)``), compose, interop (import and
    export), render (pictures), testing (for your own families).

PYTEST_DONT_REWRITE: lets a program that has imported this call pytest.main() without a warning.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from worldgen.errors import (
        FormatError,
        GenerationFailed,
        InvalidParameter,
        InvalidWorld,
        OutputError,
        WorldgenError,
    )
    from worldgen.files.grid import read_world, world_digest, write_world
    from worldgen.generation import generate, stream
    from worldgen.reach import check_certificate, decide
    from worldgen.timeline import CellState, Event, Timeline
    from worldgen.world import (
        Cut,
        FailureRecord,
        JointWitness,
        Pose,
        Provenance,
        Robot,
        Target,
        Witness,
        World,
    )

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "errors": (
            "FormatError",
            "GenerationFailed",
            "InvalidParameter",
            "InvalidWorld",
            "OutputError",
            "WorldgenError",
        ),
        "files.grid": ("read_world", "world_digest", "write_world"),
        "generation": ("generate", "stream"),
        "reach": ("check_certificate", "decide"),
        "timeline": ("CellState", "Event", "Timeline"),
        "world": (
            "Cut",
            "FailureRecord",
            "JointWitness",
            "Pose",
            "Provenance",
            "Robot",
            "Target",
            "Witness",
            "World",
        ),
    },
    modules=("compose", "families", "interop", "render", "testing"),
)

__all__ = [
    "CellState", "Cut", "Event", "FailureRecord", "FormatError", "GenerationFailed",
    "InvalidParameter", "InvalidWorld", "JointWitness", "OutputError", "Pose", "Provenance",
    "Robot", "Target", "Timeline", "Witness", "World", "WorldgenError", "check_certificate",
    "decide", "generate", "read_world", "stream", "world_digest", "write_world",
]  # fmt: skip
