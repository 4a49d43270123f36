"""Read files of recorded runs, and report what is wrong with invalid lines."""

import gzip
import json
import math
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.reference.sim.fdlibm import REDUCTION_LIMIT

Recording = dict[str, Any]

# Integers that determine a run: least and greatest value. The upper ends only keep a run finite.
_WHOLE = {
    "n": (3, 2000),
    "rule": (1, 3),
    "timeSize": (1, 1000),
    "sensorRange": (0, 100_000),
    "collTicks": (-1_000_000, 1_000_000),
    "driveTicks": (-1_000_000, 1_000_000),
    "maxTicks": (1, 1_000_000),
}
_CHECKPOINT_FIELDS = 11
_OUTCOME = {"verdict": str, "ticks": int, "hash": str}  # without these a replay would check nothing


class NotARecordingError(ValueError):
    """A line that is not a recording: its contents and the rule."""


def read_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Return the numbers and texts of the lines that are not blank, even in a gzipped file.

    Raises:
        OSError: If the file can't be read.
        ValueError: If it is not text.
    """
    try:
        data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    except (EOFError, zlib.error) as error:
        raise ValueError(f"not a whole gzip file: {error}") from error
    for number, line in enumerate(data.decode("utf-8").split("\n"), start=1):
        if line.strip():
            yield number, line


def parse(line: str) -> Recording:
    """Return the recording in a line.

    Raises:
        NotARecordingError: What is wrong with it.
    """
    try:
        found = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise NotARecordingError(f"not JSON: {error}") from error
    if not isinstance(found, dict):
        raise NotARecordingError(f"a recording is a JSON object, not {_kind(found)}")
    for key, (least, most) in _WHOLE.items():
        if not (_is_whole(found.get(key)) and least <= found[key] <= most):
            raise NotARecordingError(
                f"{key} is {_shown(found, key)}; it must be a whole number from {least} to {most}"
            )
    if not isinstance(found.get("noise"), bool):
        raise NotARecordingError(f"noise is {_shown(found, 'noise')}; it must be true or false")
    _check_rows(found)
    _check_start(found)
    _check_draws(found)
    _check_outcome(found)
    return found


def _check_rows(found: Recording) -> None:
    n, rows = found["n"], found.get("rows")
    if (
        not isinstance(rows, list)
        or len(rows) != n
        or not all(isinstance(r, str) and len(r) == n for r in rows)
    ):
        raise NotARecordingError(f"rows must be {n} strings of {n} characters, as n says")
    text = "".join(rows)
    if strange := set(text) - set("#.T"):
        raise NotARecordingError(f"rows hold {min(strange)!r}; only '#', '.' and 'T' are cells")
    if text.count("T") != 1:
        raise NotARecordingError(f"rows hold {text.count('T')} targets 'T'; there must be one")
    if set(rows[0] + rows[-1] + "".join(r[0] + r[-1] for r in rows)) != {"#"}:
        raise NotARecordingError("rows are open at the border; every cell there must be '#'")


def _check_start(found: Recording) -> None:
    start, side = found.get("start"), 10 * found["n"]
    if (
        not isinstance(start, list)
        or len(start) != 3
        or not all(_is_finite(value) for value in start)
    ):
        raise NotARecordingError(
            f"start is {_shown(found, 'start')}; it must be [x, y, heading], finite numbers"
        )
    if not (0 <= start[0] < side and 0 <= start[1] < side):
        raise NotARecordingError(
            f"start is {_shown(found, 'start')}; x and y must be in [0, {side}) px"
        )
    if abs(start[2]) > REDUCTION_LIMIT:
        raise NotARecordingError(
            f"start's heading is {start[2]:g}; it must be within {REDUCTION_LIMIT:g} rad of 0"
        )


def _check_draws(found: Recording) -> None:
    if found["rule"] != 3:
        return
    if "seed" not in found and "draws" not in found:
        raise NotARecordingError("rule 3 draws random numbers; give seed, draws or both")
    if "seed" in found and not _is_whole(found["seed"]):
        raise NotARecordingError(f"seed is {_shown(found, 'seed')}; it must be a whole number")
    draws = found.get("draws", [])
    if not isinstance(draws, list) or not all(
        _is_finite(value) and 0 <= value < 1 for value in draws
    ):
        raise NotARecordingError("draws must be a list of numbers in [0, 1)")


def _check_outcome(found: Recording) -> None:
    for key, kind in _OUTCOME.items():
        if not isinstance(found.get(key), kind):
            raise NotARecordingError(
                f"{key} is {_shown(found, key)}; a recording says how the run went"
            )
    if "maxPen" in found and not _is_finite(found["maxPen"]):
        raise NotARecordingError(f"maxPen is {_shown(found, 'maxPen')}; it must be a number")
    points = found.get("cp", [])
    if not isinstance(points, list) or not all(
        isinstance(p, list)
        and len(p) == _CHECKPOINT_FIELDS
        and _is_whole(p[0])
        and all(map(_is_finite, p[1:-1]))
        for p in points
    ):
        raise NotARecordingError(
            f"cp must be a list of checkpoints, {_CHECKPOINT_FIELDS} values each, the last one text"
        )


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_finite(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e300 and math.isfinite(value)


def _kind(value: object) -> str:
    return {list: "a list", str: "a string", type(None): "null"}.get(
        type(value), "a number or a truth value"
    )


def _shown(found: Recording, key: str) -> str:
    return repr(found[key])[:60] if key in found else "missing"
