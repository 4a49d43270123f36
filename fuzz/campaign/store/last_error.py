"""Why a campaign gave up, or was not begun: ``.campaign/error.json``, which other programs read."""

from __future__ import annotations

import contextlib
import json
import os
import re
import string
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fuzz.campaign.store.summary import MEMORY
from worldgen.errors import FormatError, Message, OutputError, WorldgenError
from worldgen.files.locks import holder
from worldgen.files.whole import read_text, write_bytes

__all__ = ["errors_recorded", "forget_error", "read_error", "record_error"]

_VERSION = 1
_LONGEST = 4_000  # characters of a template
_FIELD = re.compile(r"[a-z][a-z0-9_]*")
_SPEC = re.compile(
    r"[#,]?(?:\.\d)?[a-zA-Z%]?|[a-z ]{0,40}"
)  # no width, which could ask for gigabytes


def _file(out: Path) -> Path:
    return out / MEMORY / "error.json"


def record_error(out: Path, error: WorldgenError) -> None:
    """Write why a campaign gave up into its folder.

    Nothing if it has no memory there, or another process writes it.

    Args:
        out: The campaign's folder.
        error: Why.
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
    with contextlib.suppress(
        OutputError, ValueError
    ):  # a full disk may be why; ValueError: a number of 5,000 digits
        write_bytes(
            _file(out), (json.dumps(record, indent=1, default=str) + "\n").encode(), force=True
        )


@contextlib.contextmanager
def errors_recorded(out: Path | None) -> Iterator[None]:
    """Write an error that comes out of the block into a campaign's folder, and let it go on."""
    try:
        yield
    except WorldgenError as error:
        if out is not None:
            record_error(out, error)
        raise


def forget_error(out: Path) -> None:
    """Remove what an earlier run of the campaign left."""
    with contextlib.suppress(OSError):
        _file(out).unlink(missing_ok=True)


def read_error(out: Path) -> WorldgenError | None:
    """Return why a campaign gave up.

    ``None`` if nothing is recorded, or what is there is no such record.
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
    """Return the error of a record, which may come from anywhere.

    It is worded here, so that a bad one shows now.
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
