"""A unit's result as an entry of the store, and back.

A table in JSON's types with a digest over all of it.
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
    """A unit that is done.

    Args:
        result: What it found; of the failures and elites only what was worth keeping.
        seconds: Of the campaign, over all runs, when the unit was merged.
    """

    result: UnitResult
    seconds: float


def write_entry(unit: int, done: Done, fingerprint: str, failures: Mapping[str, str]) -> bytes:
    """Return the text of an entry.

    Args:
        unit: Its number.
        done: Its result.
        fingerprint: Digest of what the campaign is, without which an entry means nothing.
        failures: By class, the name of the failure's file.
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
    """Return the unit that an entry tells of.

    Args:
        text: The entry's file.
        unit: Whose entry it is to be.
        fingerprint: Digest of what the campaign is.
        failure: Reads the failure of a name.

    Raises:
        ValueError: If it is cut off, changed, or another unit's or campaign's; or if a failure of
            it cannot be read.
    """
    try:
        entry = json.loads(text)
        if entry.pop("digest") != digest_of([fingerprint, entry]) or entry["unit"] != unit:
            raise ValueError("it is of another campaign or unit, or was changed")
        result = UnitResult(
            strategy=str(entry["strategy"]),
            worlds=int(entry["worlds"]),
            steps=int(entry["steps"]),
            verdicts=Counter({str(name): int(count) for name, count in entry["verdicts"].items()}),
            met=Counter({str(name): int(count) for name, count in entry["met"].items()}),
            failures={
                str(kind): failure(_checked(name)) for kind, name in entry["failures"].items()
            },
            elites=dict(_elite(*one) for one in entry["elites"]),
        )
        return Done(result, float(entry["seconds"]))
    except (AttributeError, KeyError, OverflowError, RecursionError, TypeError) as error:
        raise ValueError(f"it is not an entry of a campaign store: {error}") from error


def _checked(name: Any) -> str:
    if not _FAILURE_ID.fullmatch(name):
        raise ValueError(f"{name!r} is no failure's name")
    return str(name)


def _elite(
    cell: list[int], layout: str, quality: float, verdict: str
) -> tuple[tuple[int, ...], Elite]:
    return tuple(map(int, cell)), Elite(bytes.fromhex(layout), float(quality), str(verdict))
