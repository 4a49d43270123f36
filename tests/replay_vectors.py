"""Replays recorded runs of the thesis's program: ``python -m tests.replay_vectors FILE.jsonl``.

Prints a line for everything that differs and ends with ``matched N of M``; exit code 0 if all match, 1 if one
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

from sim.kernels import thesis_layout as at
from sim.kernels.fdlibm import float_bits
from sim.kernels.thesis_episode import thesis_episode
from sim.kernels.thesis_signal import add_noise, signal_map
from tests.helpers.java_random import java_doubles
from tests.helpers.recordings import NotARecordingError, parse, read_lines

Vector = dict[str, Any]


def mismatches(vector: Vector) -> list[str]:
    """Everything recorded in which a replay differs, in words; empty if it matches."""
    cells, light = signal_cells(vector)
    found = []
    crc = zlib.crc32(np.ascontiguousarray(cells.T).astype(">i4").tobytes())
    if f"{crc:08x}" != vector.get("cellCrc32", f"{crc:08x}"):
        found.append(f"cellCrc32 {crc:08x}, recorded {vector['cellCrc32']}")
    draws = random_numbers(vector)
    rows = simulate(vector, cells, light, draws, vector["maxTicks"])[1]
    outcome = judge(vector, rows)
    progress, rows = simulate(vector, cells, light, draws, outcome["ticks"])
    outcome["simTime"] = float(outcome["ticks"] * vector["timeSize"])
    outcome["hash"] = f"{int(progress.counts[at.OUT_DIGEST]) & (2**64 - 1):016x}"
    outcome["collideActivations"] = int(progress.counts[at.OUT_ACTIVATIONS])
    outcome["firstCentreInWall"] = int(progress.counts[at.OUT_IN_WALL_STEP])
    outcome["firstPen1"] = int(progress.counts[at.OUT_OVERLAP_STEP])
    outcome["firstCross"] = first_crossing(vector, rows)
    for key, value in outcome.items():
        if value != vector.get(key, value):
            found.append(f"{key} {value}, recorded {vector[key]}")
    deepest = float(progress.sums[at.SUM_OVERLAP])
    if abs(deepest - vector.get("maxPen", deepest)) > 1e-9:  # px; measured at tick ends, not part of the listing
        found.append(f"maxPen {deepest}, recorded {vector['maxPen']}")
    used = draws[: progress.mode[at.DRAWS_USED]].tolist()
    return found + draw_mismatches(vector, used) + checkpoint_mismatches(vector, rows)


def random_numbers(vector: Vector) -> Any:
    """The draws that a run may use, one a tick at most: the recorded ones first, then its seed's."""
    if vector["rule"] != 3:
        return np.zeros(0)
    recorded = vector.get("draws", [])
    seeded = java_doubles(vector["seed"], vector["maxTicks"]) if "seed" in vector else []
    return np.array(recorded + seeded[len(recorded) :], np.float64)


def draw_mismatches(vector: Vector, used: list[float]) -> list[str]:
    """Whether the run used exactly the recorded draws, and whether the seed gives them."""
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
    cells = np.where(solid, np.int32(at.WALL), light)
    if vector["noise"]:
        add_noise(cells, light)
    return cells, light


def simulate(vector: Vector, cells: Any, light: Any, draws: Any, ticks: int) -> tuple[at.Progress, Any]:
    """Runs a recording's scenario and returns the reports and the rows of the ticks."""
    setup = at.Setup(
        rule=vector["rule"],
        time_step=float(vector["timeSize"]),
        sense=at.sensor_cells(vector["sensorRange"]),
        collide_ticks=vector["collTicks"],
        drive_ticks=vector["driveTicks"],
        steps=ticks,
    )
    progress = at.new_progress(*map(float, vector["start"]))
    rows = np.zeros((ticks + 1, at.ROW_SIZE))
    thesis_episode(at.new_arena(cells, light), setup, progress, draws, rows)
    return progress, rows[: progress.counts[at.OUT_STEPS] + 1]


def judge(vector: Vector, rows: Any) -> Vector:
    """Verdict, ticks and loop from the states: the target entered, the first repetition, or neither."""
    loop = None if vector["rule"] == 3 else first_repetition(rows)
    ticks = len(rows) - 1
    cell = tuple((rows[-1, [at.X, at.Y]] // at.CELL).astype(int))
    reached = vector["rows"][cell[1]][cell[0]] == "T"
    if loop is not None:
        return {"verdict": "loop", "ticks": sum(loop), "loopStart": loop[0], "period": loop[1]}
    return {"verdict": "reached" if reached else "limit", "ticks": ticks}


def first_repetition(rows: Any) -> tuple[int, int] | None:
    """Start and period of the first state that comes back, by the recorded words of a state."""
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
    words[:, :5] = np.ascontiguousarray(rows[:, : at.SPEED + 1]).view(np.uint64)
    mode = rows[:, at.ROW_MODE :].astype(np.int64)
    busy = mode[:, at.BEHAVIOUR] >= 0
    words[:, 5] = mode[:, at.COLLISION] + np.where(busy, 2 + 4 * (mode[:, at.BEHAVIOUR] + 1), 0)
    words[:, 6] = mode[:, at.TICKS_LEFT].astype(np.float64).view(np.uint64)
    return words


def first_crossing(vector: Vector, rows: Any) -> int:
    """First tick that ends in a free cell of another 4-connected component than the start's; -1 if none."""
    component = flood(vector["rows"], *(int(value // at.CELL) for value in vector["start"][:2]))
    for tick in range(1, len(rows)):
        x, y = int(rows[tick, at.X] // at.CELL), int(rows[tick, at.Y] // at.CELL)
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
        row, mode = rows[tick, : at.SPEED + 1].tolist(), rows[tick, at.ROW_MODE :].astype(int).tolist()
        busy = int(mode[at.BEHAVIOUR] >= 0)
        bits = " ".join(f"{int(float_bits(value)) & (2**64 - 1):016x}" for value in row[: at.TARGET_HEADING + 1])
        ours = [*row, mode[at.COLLISION], busy, mode[at.ACTIVE], mode[at.TICKS_LEFT], bits]
        if ours != recorded:
            found.append(f"checkpoint {tick}: {ours}, recorded {recorded}")
    return found


def read_vectors(path: Path) -> Iterator[tuple[int, Vector]]:
    """Line numbers and recordings of a file.

    Raises:
        ValueError: If a line is no recording.
    """
    for number, line in read_lines(path):
        yield number, parse(line)


def replay(name: str) -> tuple[int, int, int]:
    """Replays a file line by line, says what differs, and counts: matched, all, unreadable."""
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
        sys.stderr.write(f"{name}: holds no recording; give a file with one JSON object a line\n")
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
