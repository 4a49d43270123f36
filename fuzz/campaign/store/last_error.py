"""Record why a campaign gave up or did not begin: ``.campaign/error.json``, for programs."""

from __future__ import annotations

import contextlib
import json
import os
import re
import string
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fuzz.campaign.store.summary import CAMPAIGN_FILE, MEMORY
from worldgen.errors import FormatError, Message, OutputError, WorldgenError
from worldgen.files.locks import holder
from worldgen.files.whole import read_text, write_bytes

MARK = "studio.begins."
"""Name of the mark, in the store, of a campaign that a studio is beginning.

The number of the waiting process follows, since two studios may begin a campaign in one folder.
"""

_VERSION = 1
# Limit on the characters of a template.
_LONGEST = 4_000
_FIELD = re.compile(r"[a-z][a-z0-9_]*")
# Widths are not allowed, because they could request gigabytes.
_SPEC = re.compile(r"[#,]?(?:\.\d)?[a-zA-Z%]?|[a-z ]{0,40}")


def _file(out: Path) -> Path:
    return out / MEMORY / "error.json"


def record_error(out: Path, error: WorldgenError) -> None:
    """Write the reason why a campaign gave up into its folder.

    Nothing is written if it has no store there, or another process is writing it.

    Args:
        out: The campaign's folder.
        error: The reason.
    """
    memory = out / MEMORY
    if not memory.is_dir() or holder(memory / "lock") not in (None, os.getpid()):
        return
    problem, remedy = error.message.templates
    record = {
        "version": _VERSION,
        "code": error.code,
        "problem": error.message.problem,
        "remedy": error.message.remedy,
        "facts": error.facts,
        "line": getattr(error, "line", None),
        "source": getattr(error, "source", None),
        "at_terminal": error.message.at_terminal,
        "templates": {"problem": problem, "remedy": remedy},
    }
    # The disk may be full; a number of 5,000 digits raises ValueError.
    with contextlib.suppress(OutputError, ValueError):
        write_bytes(
            _file(out), (json.dumps(record, indent=1, default=str) + "\n").encode(), force=True
        )


@contextlib.contextmanager
def errors_recorded(out: Path | None, *, begins: bool = False) -> Iterator[None]:
    """Record an error raised in the block in a campaign's folder, and let it propagate.

    Args:
        out: The campaign's folder.
        begins: Whether the block begins a campaign. A campaign that the folder already holds has
            nothing to do with its errors, so they are recorded there only for a studio that waits
            for them and removes them.
    """
    holds_one = begins and out is not None and (out / MEMORY / CAMPAIGN_FILE).is_file()
    try:
        yield
    except WorldgenError as error:
        if out is not None and (not holds_one or any((out / MEMORY).glob(f"{MARK}*"))):
            record_error(out, error)
        raise


def forget_error(out: Path) -> None:
    """Remove the record of an earlier run of the campaign."""
    with contextlib.suppress(OSError):
        _file(out).unlink(missing_ok=True)


def read_error(out: Path) -> WorldgenError | None:
    """Return the reason why a campaign gave up.

    It is ``None`` if nothing is recorded, or the file isn't such a record.
    """
    file = _file(out)
    if not file.is_file() or file.is_symlink():
        return None
    try:
        record = json.loads(read_text(file))
        if record["version"] != _VERSION:
            return None
        return _error(record)
    except (
        AttributeError,
        IndexError,
        KeyError,
        RecursionError,
        TypeError,
        ValueError,
        WorldgenError,
    ):
        return None


def _error(record: dict[str, Any]) -> WorldgenError:
    """Return the error of a record, which may come from an untrusted file.

    Its message is built here, so that a bad template fails now.
    """
    templates = [str(record["templates"][name]) for name in ("problem", "remedy")]
    for template in templates:
        _check_template(template)
    line = record["line"]
    source = record["source"]
    message = Message(
        str(record["code"]),
        *templates,
        at_terminal=record["at_terminal"] is True,
        **dict(record["facts"]),
    )
    str(message)
    if source is None and line is None:
        return WorldgenError.of(message)
    return FormatError.of(
        message,
        line=None if line is None else int(line),
        source=None if source is None else str(source),
    )


def _check_template(template: str) -> None:
    if len(template) > _LONGEST:
        raise ValueError("template is too long")
    for _, name, spec, conversion in string.Formatter().parse(template):
        if name is None:
            continue
        if (
            not _FIELD.fullmatch(name)
            or not _SPEC.fullmatch(spec or "")
            or conversion not in (None, "r", "s", "q", "l")
        ):
            raise ValueError(f"{template!r} is not a template of a message")
