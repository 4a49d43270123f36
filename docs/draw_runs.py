"""Draws the pictures of runs in README.md and in the pages: ``python -m docs.draw_runs``.

Writes them to ``docs/pictures``, or to the folder that is named. Each picture is made by the
commands below, so a test can compare what it says with what the program says today.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.thesis_faults import draw_worlds
from worldgen.files.grid import write_world

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"

# The worlds, by the name of their file. A hall is the last of so many, of a kind.
WORLDS = {
    "trap": "trap --size 24 --seed 3",
    "maze": "maze --size 24 --seed 3",
    "large-maze": "maze --seed 1",
    "rooms": "rooms --seed 101",
    "small-rooms": "rooms --size 20 --seed 2",
    "doorway": "doorway --robots 2 --seed 230",
    "footprint": "maze --size 30 --seed 3 --footprint 1.2x0.4",
    "car": "maze --size 24 --seed 3 --footprint 0.62x0.9 --drive car --turning-radius 0.6 --reverse",
}
HALLS = {"scattered": ("scattered", 1), "one-u": ("one U", 2)}
HALL_SEED = 9
# A room whose opening is narrower than the robot, to import.
WALLED = ROOT / "docs" / "playground" / "walled.txt"
SMALLEST = ROOT / "corpora" / "failures" / "turn-right" / "swept" / "returns-to-a-wall.grid"

# The picture's name, and the command that draws it, without its --picture.
RUNS = {
    "reach-witness": "show trap.grid --no-signal",
    "reach-cut": "show walled.grid --no-signal",
    "search-found": "run maze.grid --controller turn-right",
    "search-shrunk": "run shrunk.grid --controller turn-right",
    "loop": "run trap.grid --controller turn-right",
    "pushed": "run trap.grid --controller turn-right+pushes=1:0.4:0:1.57:3:0:-0.5:0",
    "not-covered": "run small-rooms.grid --task cover --controller turn-random",
    "blocked": "run doorway.grid --controller naive",
    "audit-irsim": f"audit {ROOT}/examples/audits/wall.grid "
    f"{ROOT}/examples/audits/recorded/irsim-fast.csv",
    "footprint": "run footprint.grid --controller bug2",
    "controller-wall-left": "run trap.grid --controller wall-left",
    "controller-bug1": "run trap.grid --controller bug1",
    "controller-bug2": "run maze.grid --controller bug2",
    "controller-tangent-bug": "run maze.grid --controller tangent-bug",
    "controller-mapper": "run maze.grid --controller mapper",
    "controller-topological": "run rooms.grid --controller topological",
    "controller-gestalt": "run trap.grid --controller gestalt",
    "controller-random-walk": "run trap.grid --controller random-walk --seed 9",
    "controller-potential-field": "run one-u.grid --controller potential-field",
    "controller-vfh": "run scattered.grid --controller vfh",
    "controller-dynamic-window": "run scattered.grid --controller dynamic-window",
    "controller-three-layer": "run large-maze.grid --controller three-layer",
    "controller-q-learning": "run scattered.grid --controller q-learning",
    "controller-hybrid-car": "run car.grid --controller hybrid-car",
}


def worldgen(arguments: str) -> None:
    """Run a command of worldgen; an exit code of 1 is a run that failed, as some should.

    Raises:
        RuntimeError: If the command could not do its work.
    """
    command = [sys.executable, "-m", "worldgen", *shlex.split(arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode > 1:
        raise RuntimeError(f"worldgen {arguments}: {done.stderr}")


def draw(folder: Path) -> list[Path]:
    """Draw all pictures into a folder, and return their files."""
    drawn = [folder.absolute() / f"{name}.png" for name in RUNS]
    with tempfile.TemporaryDirectory() as scratch, contextlib.chdir(scratch):
        for name, family in WORLDS.items():
            worldgen(f"{family} --out {name}.grid")
        worldgen(f"import {shlex.quote(os.fspath(WALLED))} --out walled.grid")
        shutil.copy(SMALLEST, "shrunk.grid")
        for name, (kind, count) in HALLS.items():
            *_, hall = draw_worlds(kind, count, HALL_SEED)
            write_world(hall, Path(f"{name}.grid"))
        for picture, run in zip(drawn, RUNS.values(), strict=True):
            worldgen(f"{run} --force --picture {shlex.quote(os.fspath(picture))}")
    return drawn


if __name__ == "__main__":
    for picture in draw(Path(*sys.argv[1:2]) if sys.argv[1:] else PICTURES):
        sys.stdout.write(f"{picture}\n")
