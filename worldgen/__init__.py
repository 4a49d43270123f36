"""Worlds for mobile robots: generated, proved reachable, written as one text file.

Contents, each imported when it is first used:
    World, Pose, Target, Witness, Cut, Provenance, FailureRecord: what a world is made of.
    Timeline, Event, CellState: what changes in it.
    generate: a world of a family, with its proof.
    stream: such worlds one after another, made when they are asked for.
    read_world, write_world, world_digest: the ``.grid`` file.
    decide, check_certificate: reachability, proved and checked apart from each other.
    WorldgenError and its kinds: what went wrong, as a sentence.

PYTEST_DONT_REWRITE: a program that has imported this may call pytest.main() without a warning.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

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
    from worldgen.world import Cut, FailureRecord, Pose, Provenance, Target, Witness, World

_HOME = {
    "errors": (
        "FormatError",
        "GenerationFailed",
        "InvalidParameter",
        "InvalidWorld",
        "OutputError",
        "WorldgenError",
    ),
    "generation": ("generate", "stream"),
    "files.grid": ("read_world", "world_digest", "write_world"),
    "reach": ("check_certificate", "decide"),
    "timeline": ("CellState", "Event", "Timeline"),
    "world": ("Cut", "FailureRecord", "Pose", "Provenance", "Target", "Witness", "World"),
}
_MODULE = {name: f"worldgen.{module}" for module, names in _HOME.items() for name in names}

__all__ = [
    "CellState", "Cut", "Event", "FailureRecord", "FormatError", "GenerationFailed", "InvalidParameter",
    "InvalidWorld", "OutputError", "Pose", "Provenance", "Target", "Timeline", "Witness", "World",
    "WorldgenError", "check_certificate", "decide", "generate", "read_world", "stream", "world_digest", "write_world",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _MODULE:
        raise AttributeError(f"module 'worldgen' has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULE[name]), name)
