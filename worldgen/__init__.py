"""Worlds for mobile robots: generated, proved reachable, written as one text file.

Contents, each imported when it is first used:
    World, Robot, Pose, Target, Drive, Provenance, FailureRecord: A world and its parts.
    Witness, JointWitness, Cut: The proofs that a target can, or cannot, be reached.
    Timeline, Event, CellState: How a world changes over time.
    generate: A world of a family, with its proof.
    stream: A sequence of such worlds, made on demand.
    read_world, write_world, world_digest: The ``.grid`` file.
    decide, check_certificate: Prove reachability, and check the proof independently.
    WorldgenError: The base of FormatError, GenerationFailed, InvalidParameter, InvalidWorld and
        OutputError: an error as data and as a sentence.
    families, compose, interop, render, testing: Submodules: ``worldgen.families.maze(seed=7)``,
        worlds from parts, import and export, pictures, and checks for your own families.
    __version__: The installed version.

PYTEST_DONT_REWRITE: lets a program that has imported this package call pytest.main() without a
warning about assertion rewriting.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from worldgen.support.lazy import lazy_names
from worldgen.support.world_methods import world_methods

if TYPE_CHECKING:
    __version__: str

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
        Drive,
        FailureRecord,
        JointWitness,
        Pose,
        Provenance,
        Robot,
        Target,
        Witness,
        World,
    )

_lazy, __dir__ = lazy_names(
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
            "Drive",
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


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("worldgen")
    return _lazy(name)


def _digest(world: World) -> str:
    from worldgen.files.grid import world_digest

    return world_digest(world)


def _picture(world: World) -> bytes:
    from worldgen.render import draw_png

    return draw_png(world)


world_methods.update(digest=_digest, picture=_picture)

__all__ = [
    "CellState", "Cut", "Drive", "Event", "FailureRecord", "FormatError", "GenerationFailed",
    "InvalidParameter", "InvalidWorld", "JointWitness", "OutputError", "Pose", "Provenance",
    "Robot", "Target", "Timeline", "Witness", "World", "WorldgenError", "check_certificate",
    "decide", "generate", "read_world", "stream", "world_digest", "write_world",
]  # fmt: skip
