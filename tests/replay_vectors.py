"""Replays recorded runs of the thesis's program: ``python -m tests.replay_vectors FILE.jsonl``.

Print a line for each difference and end with ``matched N of M``; exit code 0 if all match, 1 if one
does not, 2 if a file or a line can't be read, or there is none.
"""

from __future__ import annotations

import sys
import zlib
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim.thesis.core_calls import (
    CELL,
    WALL,
    ThesisEpisode,
    ThesisSetup,
    add_noise,
    new_rows,
    signal_map,
)
from tests.helpers.java_random import java_doubles
from tests.helpers.recordings import NotARecordingError, parse, read_lines

Vector = dict[str, Any]

FLOATS = ("x", "y", "heading", "target_heading", "speed")
"""The numbers of a state in a recording."""


def mismatches(vector: Vector) -> list[str]:
    """Return the differences between a replay and its recording, in words; empty if they match."""
    cells, light = signal_cells(vector)
    found = []
    crc = zlib.crc32(np.ascontiguousarray(cells.T).astype(">i4").tobytes())
    if f"{crc:08x}" != vector.get("cellCrc32", f"{crc:08x}"):
        found.append(f"cellCrc32 {crc:08x}, recorded {vector['cellCrc32']}")
    draws = random_numbers(vector)
    rows = simulate(vector, cells, light, draws, vector["maxTicks"])[1]
    outcome = judge(vector, rows)
    run, rows = simulate(vector, cells, light, draws, outcome["ticks"])
    outcome["simTime"] = float(outcome["ticks"] * vector["timeSize"])
    outcome["hash"] = f"{run.digest:016x}"
    outcome["collideActivations"] = run.activations
    outcome["firstCentreInWall"] = run.in_wall.step
    outcome["firstPen1"] = run.overlap.step
    outcome["firstCross"] = first_crossing(vector, rows)
    for key, value in outcome.items():
        if value != vector.get(key, value):
            found.append(f"{key} {value}, recorded {vector[key]}")
    deepest = run.deepest
    if (
        abs(deepest - vector.get("maxPen", deepest)) > 1e-9
    ):  # px; measured at tick ends, not part of the listing
        found.append(f"maxPen {deepest}, recorded {vector['maxPen']}")
    used = draws[: run.state.draws_used].tolist()
    return found + draw_mismatches(vector, used) + checkpoint_mismatches(vector, rows)


def random_numbers(vector: Vector) -> Any:
    """Return the draws that a run may use, at most one per tick.

    The recorded ones come first, then its seed's.
    """
    if vector["rule"] != 3:
        return np.zeros(0)
    recorded = vector.get("draws", [])
    seeded = java_doubles(vector["seed"], vector["maxTicks"]) if "seed" in vector else []
    return np.array(recorded + seeded[len(recorded) :], np.float64)


def draw_mismatches(vector: Vector, used: list[float]) -> list[str]:
    """Return whether the run used exactly the recorded draws, and whether the seed gives them."""
    found = []
    recorded = vector.get("draws", used)
    if len(recorded) != len(used):
        found.append(f"draws: {len(used)} used, recorded {len(recorded)}")
    if "seed" in vector and java_doubles(vector["seed"], len(recorded)) != recorded:
        found.append("the seed does not give the recorded draws")
    return found


def signal_cells(vector: Vector) -> tuple[Any, Any]:
    """The recording's signal map, with walls and noise, and without."""
    rows, n = vector["rows"], vector["n"]
    target_y = next(y for y, row in enumerate(rows) if "T" in row)
    light = signal_map(n, n, rows[target_y].index("T"), target_y)
    solid = np.array([[rows[y][x] == "#" for y in range(n)] for x in range(n)])
    cells = np.where(solid, np.int32(WALL), light)
    if vector["noise"]:
        add_noise(cells, light)
    return cells, light


def setup_of(vector: Vector) -> ThesisSetup:
    """Return a recording's robot."""
    return ThesisSetup(
        rule=vector["rule"],
        time_step=float(vector["timeSize"]),
        sense=int((vector["sensorRange"] - 36) / 10) + 1,
        collide_ticks=vector["collTicks"],
        drive_ticks=vector["driveTicks"],
    )


def simulate(vector: Vector, cells: Any, light: Any, draws: Any, ticks: int) -> tuple[Any, Any]:
    """Runs a recording's scenario and returns the report and the rows of the ticks."""
    start = (float(vector["start"][0]), float(vector["start"][1]), float(vector["start"][2]))
    setup = setup_of(vector)._replace(steps=ticks)
    episode = ThesisEpisode(cells, light, np.zeros((0, 4), np.int64), start, setup)
    rows = new_rows(ticks + 1)
    episode.go(ticks, draws, rows)
    return episode.run, rows[: episode.run.steps + 1]


def judge(vector: Vector, rows: Any) -> Vector:
    """Determine verdict, ticks and loop from the states:

    the target entered, the first repetition, or neither.
    """
    loop = None if vector["rule"] == 3 else first_repetition(rows)
    ticks = len(rows) - 1
    cell = (int(rows[-1]["x"] // CELL), int(rows[-1]["y"] // CELL))
    reached = vector["rows"][cell[1]][cell[0]] == "T"
    if loop is not None:
        return {"verdict": "loop", "ticks": sum(loop), "loopStart": loop[0], "period": loop[1]}
    return {"verdict": "reached" if reached else "limit", "ticks": ticks}


def first_repetition(rows: Any) -> tuple[int, int] | None:
    """Start and period of the first state that recurs, by its recorded words."""
    words = state_words(rows)
    seen: dict[bytes, int] = {}
    for tick, row in enumerate(words):
        before = seen.setdefault(row.tobytes(), tick)
        if before != tick:
            return before, tick - before
    return None


def state_words(rows: Any) -> Any:
    """(n, 7) uint64: the recording's seven words of each state."""
    words = np.zeros((len(rows), 7), np.uint64)
    for k, name in enumerate(FLOATS):
        words[:, k] = rows[name].copy().view(np.uint64)
    behaviour = rows["behaviour"].astype(np.int64)
    words[:, 5] = rows["collision"].astype(np.int64) + np.where(
        behaviour >= 0, 2 + 4 * (behaviour + 1), 0
    )
    words[:, 6] = rows["ticks_left"].copy().view(np.uint64)
    return words


def first_crossing(vector: Vector, rows: Any) -> int:
    """First tick that ends in a free cell outside the start's 4-connected component.

    -1 if none.
    """
    component = flood(vector["rows"], *(int(value // CELL) for value in vector["start"][:2]))
    for tick in range(1, len(rows)):
        x = int(rows[tick]["x"] // CELL)
        y = int(rows[tick]["y"] // CELL)
        if vector["rows"][y][x] != "#" and (x, y) not in component:
            return tick
    return -1


def flood(rows: list[str], x: int, y: int) -> set[tuple[int, int]]:
    """Free cells joined to (x, y) across edges."""
    reached, queue = {(x, y)}, deque([(x, y)])
    while queue:
        x, y = queue.popleft()
        for near in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if near not in reached and rows[near[1]][near[0]] != "#":
                reached.add(near)
                queue.append(near)
    return reached


def checkpoint_mismatches(vector: Vector, rows: Any) -> list[str]:
    """Checkpoints whose numbers, raw bits, flags or counters differ."""
    found = []
    for tick, *recorded in vector.get("cp", []):
        if not 0 < tick < len(rows):
            found.append(f"checkpoint {tick}: the replay has ticks 1 to {len(rows) - 1}")
            continue
        row = rows[tick]
        floats = [float(row[name]) for name in FLOATS]
        busy = int(row["behaviour"] >= 0)
        bits = " ".join(f"{np.float64(value).view(np.uint64):016x}" for value in floats[:4])
        ours = [
            *floats,
            int(row["collision"]),
            busy,
            int(row["active"]),
            int(row["ticks_left"]),
            bits,
        ]
        if ours != recorded:
            found.append(f"checkpoint {tick}: {ours}, recorded {recorded}")
    return found


def read_vectors(path: Path) -> Iterator[tuple[int, Vector]]:
    """Line numbers and recordings of a file.

    Raises:
        ValueError: If a line is not a recording.
    """
    for number, line in read_lines(path):
        yield number, parse(line)


def replay(name: str) -> tuple[int, int, int]:
    """Replay a file line by line, report differences, and count: matched, all, unreadable."""
    matched = total = unreadable = 0
    try:
        for number, line in read_lines(Path(name)):
            total += 1
            try:
                vector = parse(line)
            except NotARecordingError as error:
                unreadable += 1
                sys.stderr.write(f"{name}:{number}: cannot be replayed: {error}\n")
                continue
            wrong = mismatches(vector)
            matched += not wrong
            for difference in wrong:
                sys.stdout.write(f"{name}:{number}: {vector.get('id', '?')}: {difference}\n")
    except (OSError, ValueError) as error:
        sys.stderr.write(f"{name}: cannot be read: {error}\n")
        return matched, total, unreadable + 1
    if total == 0:
        sys.stderr.write(f"{name}: holds no recording; use a file with one JSON object a line\n")
    return matched, total, unreadable + (total == 0)


def main(arguments: list[str]) -> int:
    """Replays the files named on the command line."""
    if not arguments:
        sys.stderr.write("usage: python -m tests.replay_vectors FILE.jsonl [...]\n")
        return 2
    counts = [replay(name) for name in arguments]
    matched, total, unreadable = (sum(column) for column in zip(*counts, strict=True))
    sys.stdout.write(f"matched {matched} of {total}\n")
    if unreadable:
        return 2
    return 0 if matched == total else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
