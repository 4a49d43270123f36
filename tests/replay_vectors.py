"""Replays recorded runs of the thesis's program: ``python -m tests.replay_vectors FILE.jsonl``.

Ends with ``matched N of M``; exit code 0 if all match, 1 if not, 2 if the file cannot be read.
"""

from __future__ import annotations

import gzip
import json
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

Vector = dict[str, Any]


def mismatches(vector: Vector) -> list[str]:
    """Everything in which a replay differs from its recording, in words; empty if it matches."""
    cells, light = signal_cells(vector)
    found = []
    crc = zlib.crc32(np.ascontiguousarray(cells.T).astype(">i4").tobytes())
    if f"{crc:08x}" != vector["cellCrc32"]:
        found.append(f"cellCrc32 {crc:08x}, recorded {vector['cellCrc32']}")
    draws = np.array(vector.get("draws", []), np.float64)
    if vector["rule"] == 3 and java_doubles(vector["seed"], len(draws)) != draws.tolist():
        found.append("the seed does not give the recorded draws")
    rows = simulate(vector, cells, light, draws, vector["maxTicks"])[1]
    outcome = judge(vector, rows)
    progress, rows = simulate(vector, cells, light, draws, outcome["ticks"])
    outcome["hash"] = f"{int(progress.counts[at.OUT_DIGEST]) & (2**64 - 1):016x}"
    outcome["collideActivations"] = int(progress.counts[at.OUT_ACTIVATIONS])
    outcome["firstCentreInWall"] = int(progress.counts[at.OUT_IN_WALL_STEP])
    outcome["firstPen1"] = int(progress.counts[at.OUT_OVERLAP_STEP])
    outcome["firstCross"] = first_crossing(vector, rows)
    for key, value in outcome.items():
        if value != vector.get(key):
            found.append(f"{key} {value}, recorded {vector.get(key)}")
    deepest = float(progress.sums[at.SUM_OVERLAP])
    if abs(deepest - vector["maxPen"]) > 1e-9:
        found.append(f"maxPen {deepest}, recorded {vector['maxPen']}")
    return found + checkpoint_mismatches(vector, rows)


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
    """Checkpoints whose raw bits, flags or counters differ."""
    found = []
    for tick, *_, collision, busy, active, ticks_left, bits in vector["cp"]:
        if tick >= len(rows):
            found.append(f"checkpoint {tick}: the replay ends before")
            continue
        row, mode = rows[tick], rows[tick, at.ROW_MODE :].astype(int)
        ours = " ".join(f"{int(float_bits(row[k])) & (2**64 - 1):016x}" for k in range(4))
        state = [mode[at.COLLISION], int(mode[at.BEHAVIOUR] >= 0), mode[at.ACTIVE], mode[at.TICKS_LEFT]]
        if ours != bits or state != [collision, busy, active, ticks_left]:
            found.append(f"checkpoint {tick}: {ours} {state}, recorded {bits} {[collision, busy, active, ticks_left]}")
    return found


def read_vectors(path: Path) -> Iterator[tuple[int, Vector]]:
    """Line numbers and recordings of a file.

    Raises:
        ValueError: If a line is no recording.
    """
    text = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    for number, line in enumerate(text.decode().splitlines(), start=1):
        if line.strip():
            vector = json.loads(line)
            missing = {"n", "rows", "rule", "start", "maxTicks", "hash"} - set(vector)
            if missing:
                raise ValueError(f"line {number}: a recording needs {', '.join(sorted(missing))}")
            yield number, vector


def main(arguments: list[str]) -> int:
    """Replays the files named on the command line."""
    if not arguments:
        sys.stderr.write("usage: python -m tests.replay_vectors FILE.jsonl [...]\n")
        return 2
    matched = total = 0
    for name in arguments:
        try:
            for number, vector in read_vectors(Path(name)):
                wrong = mismatches(vector)
                total += 1
                matched += not wrong
                for line in wrong:
                    sys.stdout.write(f"{name}:{number}: {vector.get('id', '?')}: {line}\n")
        except (OSError, ValueError, KeyError, StopIteration) as error:
            sys.stderr.write(f"{name}: cannot be replayed: {error!r}\n")
            return 2
    sys.stdout.write(f"matched {matched} of {total}\n")
    return 0 if matched == total else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
