"""A small campaign folder.

Three failures of the thesis's robots, one of them as found, and a summary.
"""

import json
from dataclasses import replace
from pathlib import Path

from worldgen.files.grid import read_world, world_digest, write_world

CORPUS = Path(__file__).parents[2] / "corpora" / "thesis-faults"
LOOP, TUNNEL, STALLED = "thesis-1-loop-104.grid", "thesis-2-slide.grid", "thesis-1-confined.grid"
SUMMARY = {
    "version": 3, "controller": "turn-right", "motion": "stepped", "seed": 2**64 - 1, "units": 4, "worlds": 900,
    "steps": 120_000, "seconds": 3.5, "verdicts": {"reached": 700, "loop": 12}, "met": {"returns-to-a-wall": 17},
    "strategies": [
        {"strategy": "native", "units": 3, "worlds": 800, "steps": 100_000, "failures": 9, "variants": 1},
        {"strategy": "archive", "units": 1, "worlds": 100, "steps": 20_000, "failures": 2, "variants": 1},
    ],
    "found": [
        {"unit": 0, "strategy": "native", "cause": "returns-to-a-wall", "solid_cells": 40, "worlds": 12,
         "steps": 900, "seconds": 0.2, "file": "a"},
        {"unit": 1, "strategy": "archive", "cause": "goes-through-a-wall", "solid_cells": 9, "worlds": 300,
         "steps": 40_000, "seconds": 1.2, "file": "b"},
        {"unit": 2, "strategy": "native", "cause": "returns-to-a-wall", "solid_cells": 4, "worlds": 500,
         "steps": 70_000, "seconds": 2.5, "file": "c"},
    ],
    "archive": {
        "axes": [{"name": "detour", "edges": [1.5, 2.0]}, {"name": "density", "edges": [0.1]}],
        "cells": [[0, 0, 1.5, "reached"], [2, 1, 4.0, "loop"]],
    },
}  # fmt: skip


def campaign_folder(folder, **summary):
    """Makes the folder; ``summary`` replaces parts of its summary."""
    memory = folder / ".campaign"
    (memory / "failures").mkdir(parents=True)
    for name, signature, cause in (
        (TUNNEL, "tunnel-a", "goes-through-a-wall"),
        (STALLED, "stalled-a", "wanders"),
    ):
        write_world(
            with_details(read_world(CORPUS / name), **{"class": signature}, cause=cause),
            folder / name,
        )
    loop = with_details(read_world(CORPUS / LOOP), **{"class": "loop-a"}, cause="returns-to-a-wall")
    original = replace(loop, provenance=None)
    name = world_digest(original)[:16]
    write_world(original, memory / "failures" / f"{name}.grid")
    details = {"original": name, "found_by": "native", "failing_seeds": [39, 40]}
    write_world(with_details(loop, **details), folder / LOOP)
    (memory / "summary.json").write_text(json.dumps(SUMMARY | summary))
    return folder


def explain_the_loop(folder, changes):
    """Write an overview into the folder, with the loop as the example of its only cause."""
    cause = {
        "cause": "returns-to-a-wall", "sentence": "It bounces.", "advice": "Add memory.",
        "severity": "never-arrives", "state": "new", "met": 17, "verdicts": {"loop": 17},
        "natural": None, "groups": ["returns-to-a-wall"], "files": [LOOP], "file": LOOP, "smallest": LOOP,
        "why": "arrives if some cell is free", "changes": changes,
    }  # fmt: skip
    (folder / ".campaign/overview.json").write_text(json.dumps({"version": 2, "causes": [cause]}))


def with_details(world, **details):
    """Return the failure with other details in its record."""
    details = {**world.failure.details, **details}
    return replace(world, failure=replace(world.failure, details=details))
