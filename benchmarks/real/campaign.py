"""Run ``worldgen fuzz`` on a robot as a user would, and measure what it costs and shows."""

from __future__ import annotations

import itertools
import json
import os
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.real.planting import PURPOSES, Robot, write
from fuzz.facts.hazards import is_hazard
from fuzz.failure import Failure
from sim import simulate
from sim.verdict import BY_THE_CONTROLLER, Verdict
from worldgen.files.grid import read_world

# Seconds between two looks at the folder.
_EVERY = 0.1
# Failures, the first ones, that are replayed until one shows the fault.
_MOST_REPLAYED = 6
# Lines that fit a terminal.
_SCREEN = 50
_TICKS = os.sysconf("SC_CLK_TCK")


@dataclass
class Row:
    """One campaign.

    Args:
        first: CPU seconds until a failure was stored that ``replay`` confirms and that the correct
            controller does not have; None if there was none.
        stored: CPU seconds until any failure was stored that is not a hazard.
        seconds: CPU seconds in all, those of its processes included.
        worlds: Worlds that it counted.
        calls: Calls of ``act`` by purpose.
        counted: Share of all calls that were not made for worlds that did not count. Calls for a
            proof count even if the proof was cut.
        names: How the first cause on the screen names the fault: ``line`` if it quotes the planted
            line, ``motion`` if it has one of the fault's words, else empty.
        exit_code: The command's exit code.
        answer: The campaign's answer.
        screen: What it printed.
    """

    first: float | None = None
    stored: float | None = None
    seconds: float = 0.0
    worlds: int = 0
    calls: dict[str, int] = field(default_factory=dict)
    counted: float | None = None
    names: str = ""
    exit_code: int = 0
    answer: str = ""
    screen: str = ""


def campaign(
    robot: Robot, folder: Path, *, faulty: bool, pace: float, budget: float, workers: int, seed: int
) -> Row:
    """Run one campaign in an empty folder."""
    calls = folder / "calls"
    out = folder / "failures"
    controller = write(robot, folder, faulty=faulty, pace=pace, calls=calls)
    command = [
        *(sys.executable, "-m", "worldgen", "fuzz", "--controller", controller),
        *(
            "--budget",
            f"{budget:g}s",
            "--workers",
            str(workers),
            "--seed",
            str(seed),
            "--out",
            str(out),
        ),
    ]
    row = Row()
    before = _cpu_of_children()
    with (folder / "screen").open("w") as screen, (folder / "progress").open("w") as progress:
        running = subprocess.Popen(command, stdout=screen, stderr=progress, start_new_session=True)
        stored: dict[Path, float] = {}
        while running.poll() is None:
            _keep_new(out, folder / "kept", stored, running.pid)
            time.sleep(_EVERY)
    row.seconds = round(_cpu_of_children() - before, 2)
    row.exit_code = running.returncode
    _keep_new(out, folder / "kept", stored, None, row.seconds)

    # What it printed, and how much of the work counted.
    row.screen = (folder / "screen").read_text()
    row.names = names(robot, row.screen) if faulty else ""
    summary_file = out / ".campaign" / "summary.json"
    if summary_file.exists():
        summary = json.loads(summary_file.read_text())
        row.worlds = summary["worlds"]
        row.answer = summary.get("answer", "")
        letters = Counter(calls.read_text()) if calls.exists() else Counter()
        row.calls = {name: letters[letter] for letter, name in PURPOSES.items() if letters[letter]}
        lost = max(0, row.calls.get("screening", 0) - summary["steps"])
        row.counted = round(1 - lost / letters.total(), 3) if letters else None

    # The padding changes no run, so failures are replayed without it.
    write(robot, folder, faulty=faulty)
    base = write(robot, folder / "correct", faulty=False)
    failures = {
        file: Failure.of(read_world(file)) for file in sorted(stored, key=stored.__getitem__)
    }
    # A fire that the robot cannot sense says nothing about it, and fuzz does not count it either.
    files = [file for file, failure in failures.items() if not is_hazard(failure)]
    row.stored = stored[files[0]] if files else None
    # Failures that the correct controller has, too, say nothing about the fault.
    own = (file for file in files if not faulty or _arrives(failures[file], base))
    for file in itertools.islice(own, _MOST_REPLAYED):
        if _is_confirmed(file):
            row.first = stored[file]
            break
    return row


def names(robot: Robot, screen: str) -> str:
    """Return how the first cause on a screen names a robot's fault."""
    lines = screen.splitlines()[:_SCREEN]
    ends = [k for k, line in enumerate(lines) if line.startswith("2. ")]
    first = "\n".join(lines[: ends[0]] if ends else lines)
    if robot.planted.split("  #")[0] in first:
        return "line"
    # A cause's name has dashes: turns-on-the-spot.
    plain = first.lower().replace("-", " ")
    return "motion" if any(word in plain for word in robot.words) else ""


def _keep_new(
    out: Path, kept: Path, stored: dict[Path, float], group: int | None, seconds: float = 0.0
) -> None:
    """Copy failures that are new in a campaign's folder, with the CPU seconds spent so far."""
    kept.mkdir(exist_ok=True)
    for file in out.rglob("*.grid"):
        copy = kept / file.name
        if copy not in stored:
            try:
                shutil.copy(file, copy)
            except FileNotFoundError:
                continue
            stored[copy] = round(_cpu_of_group(group) if group else seconds, 2)


def _cpu_of_children() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def _cpu_of_group(group: int) -> float:
    """Return the CPU seconds of the processes of a group, and of those that have ended."""
    ticks = 0
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = file.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group:
            ticks += sum(int(value) for value in fields[11:15])
    return ticks / _TICKS


def _is_confirmed(file: Path) -> bool:
    command = [sys.executable, "-m", "worldgen", "replay", "--json", "--trust", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode == 0 and json.loads(done.stdout)["confirmed"] == 1


def _arrives(failure: Failure, controller: str) -> bool:
    """Return True if the correct controller arrives, or at least makes no error there."""
    verdict = simulate(failure.world, controller, failure.options).verdict
    is_error = failure.verdict in BY_THE_CONTROLLER and verdict not in BY_THE_CONTROLLER
    return verdict == Verdict.REACHED or is_error
