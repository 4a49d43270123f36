"""Convert a unit's result to an entry of the store, and back.

An entry is a table in JSON's types with a digest of all of it.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fuzz.campaign.result import Elite, UnitResult
from fuzz.campaign.store.fingerprint import digest_of
from fuzz.failure import ID_DIGITS, Failure

__all__ = ["Done", "read_entry", "write_entry"]

_FAILURE_ID = re.compile(rf"[0-9a-f]{{{ID_DIGITS}}}")


@dataclass(frozen=True)
class Done:
    """A finished unit.

    Args:
        result: Its result; with only those failures and elites that are worth keeping.
        seconds: Seconds of the campaign, over all runs, when the unit was merged.
    """

    result: UnitResult
    seconds: float


def write_entry(unit: int, done: Done, fingerprint: str, failures: Mapping[str, str]) -> bytes:
    """Return the text of an entry.

    Args:
        unit: Number of the unit.
        done: Its result.
        fingerprint: Digest of the campaign's fingerprint, without which an entry is meaningless.
        failures: Name of the failure's file, by class.
    """
    result = done.result
    entry = {
        "unit": unit,
        "strategy": result.strategy,
        "worlds": result.worlds,
        "steps": result.steps,
        "seconds": round(done.seconds, 3),
        "verdicts": dict(result.verdicts),
        "met": dict(result.met),
        "failures": dict(failures),
        "elites": [
            [list(cell), elite.layout.hex(), elite.quality, elite.verdict]
            for cell, elite in result.elites.items()
        ],
    }
    return (json.dumps({**entry, "digest": digest_of([fingerprint, entry])}) + "\n").encode()


def read_entry(text: str, unit: int, fingerprint: str, failure: Callable[[str], Failure]) -> Done:
    """Parse the unit in an entry.

    Args:
        text: The entry's file.
        unit: Number of the expected unit.
        fingerprint: Digest of the campaign's fingerprint.
        failure: Reads the failure of a name.

    Raises:
        ValueError: If the entry is truncated, changed, or another unit's or campaign's, or one of
            its failures cannot be read.
    """
    try:
        entry = json.loads(text)
        if entry.pop("digest") != digest_of([fingerprint, entry]) or entry["unit"] != unit:
            raise ValueError("it belongs to another campaign or unit, or was changed")
        result = UnitResult(
            strategy=str(entry["strategy"]),
            worlds=int(entry["worlds"]),
            steps=int(entry["steps"]),
            verdicts=Counter({str(name): int(count) for name, count in entry["verdicts"].items()}),
            met=Counter({str(name): int(count) for name, count in entry["met"].items()}),
            failures={
                str(bucket): failure(_checked(name)) for bucket, name in entry["failures"].items()
            },
            elites=dict(_elite(*one) for one in entry["elites"]),
        )
        return Done(result, float(entry["seconds"]))
    except (AttributeError, KeyError, OverflowError, RecursionError, TypeError) as error:
        raise ValueError(f"it is not an entry of a campaign store: {error}") from error


def _checked(name: Any) -> str:
    if not _FAILURE_ID.fullmatch(name):
        raise ValueError(f"{name!r} is not a failure's name")
    return str(name)


def _elite(
    cell: list[int], layout: str, quality: float, verdict: str
) -> tuple[tuple[int, ...], Elite]:
    return tuple(map(int, cell)), Elite(bytes.fromhex(layout), float(quality), str(verdict))
