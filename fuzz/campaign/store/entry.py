"""Convert a unit's result to an entry of the store, and back.

An entry is a table in JSON's types with a digest of all of it.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import msgspec

from fuzz.campaign.store.fingerprint import digest_of
from fuzz.failure import ID_DIGITS, Failure
from fuzz.unit.result import Elite, FirstMet, UnitResult
from worldgen.files.json_file import plain

_FailureId = Annotated[str, msgspec.Meta(pattern=rf"^[0-9a-f]{{{ID_DIGITS}}}\Z")]
_Hex = Annotated[str, msgspec.Meta(pattern=r"^([0-9a-f]{2})*\Z")]

StoredElite: TypeAlias = tuple[list[int], _Hex, float, str]
"""Cell of the archive, layout, quality and verdict."""


class UnitEntry(msgspec.Struct, frozen=True, kw_only=True):
    """An entry without its digest.

    Args:
        unit: Number of the unit.
        strategy: See :class:`UnitResult`, also for the other fields.
        seconds: Seconds of the campaign, over all runs, when the unit was merged.
        failures: Names of the failures' files.
        first_met: Of each of them in turn, when the unit first met one of its key.
    """

    unit: int
    strategy: str
    worlds: int
    steps: int
    seconds: float
    verdicts: dict[str, int]
    judged: int
    met: list[tuple[str, str, int]]
    failures: list[_FailureId]
    first_met: list[FirstMet]
    elites: list[StoredElite]


class _Sealed(UnitEntry, frozen=True, kw_only=True):
    digest: str


@dataclass(frozen=True)
class Done:
    """A finished unit.

    Args:
        result: Its result, with only those failures and elites that are worth keeping.
        seconds: Seconds of the campaign, over all runs, when the unit was merged.
    """

    result: UnitResult
    seconds: float


def write_entry(unit: int, done: Done, fingerprint: str, failures: Sequence[str]) -> bytes:
    """Return the text of an entry.

    Args:
        unit: Number of the unit.
        done: Its result.
        fingerprint: Digest of the campaign's fingerprint, without which an entry is meaningless.
        failures: Names of the failures' files.
    """
    result = done.result
    entry = UnitEntry(
        unit=unit,
        strategy=result.strategy,
        worlds=result.worlds,
        steps=result.steps,
        seconds=round(done.seconds, 3),
        verdicts=dict(result.verdicts),
        judged=result.judged,
        met=[(*kind, count) for kind, count in result.met.items()],
        failures=list(failures),
        first_met=[result.first_met[key] for key in result.failures],
        elites=[
            (list(cell), elite.layout.hex(), elite.quality, elite.verdict)
            for cell, elite in result.elites.items()
        ],
    )
    table = plain(entry)
    return (json.dumps({**table, "digest": digest_of([fingerprint, table])}) + "\n").encode()


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
        entry = msgspec.json.decode(text, type=_Sealed)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error
    table = plain(entry)
    if table.pop("digest") != digest_of([fingerprint, table]) or entry.unit != unit:
        raise ValueError("it belongs to another campaign or unit, or was changed")
    failures = list(map(failure, entry.failures))
    if len(entry.first_met) != len(failures):
        raise ValueError("it does not tell when each failure was met")
    result = UnitResult(
        strategy=entry.strategy,
        worlds=entry.worlds,
        steps=entry.steps,
        verdicts=Counter(entry.verdicts),
        judged=entry.judged,
        met=Counter({(group, verdict): count for group, verdict, count in entry.met}),
        failures={one.key: one for one in failures},
        first_met={one.key: at for one, at in zip(failures, entry.first_met, strict=True)},
        elites={
            tuple(cell): Elite(bytes.fromhex(layout), quality, verdict)
            for cell, layout, quality, verdict in entry.elites
        },
    )
    return Done(result, entry.seconds)
