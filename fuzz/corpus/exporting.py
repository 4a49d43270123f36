"""Export a corpus: one archive with a table and pictures, or the table alone."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from fuzz.corpus.entry import HIDDEN, CorpusEntry, Facts, name_of
from fuzz.corpus.merging import distinct
from fuzz.corpus.pictures import draw_failure
from fuzz.failure import Failure
from worldgen.errors import InvalidParameter, OutputError
from worldgen.files.archives import ZipWriter
from worldgen.files.whole import check_output, write_bytes
from worldgen.plugins.installation import pip_install

TABLE = "corpus.csv"  # name of the table in an archive
# The table's columns stay as they are, because scripts read them; the files say the rest.
_FACTS = [field.name for field in fields(Facts) if field.name not in (*HIDDEN, "shrinking")]
_COLUMNS = ("file", *("cause" if name == "group" else name for name in _FACTS))


def export(entries: Iterable[CorpusEntry], out: Path, *, force: bool = False) -> int:
    """Write failures to one file, ordered by controller, motion model, cause and size.

    Args:
        entries: Entries of any number of corpora; identical failures are written once.
        out: The output file. Its suffix decides the format: an archive with a file, a picture and a
            table row for each failure; a ``.csv`` table; or a ``.parquet`` table with pictures,
            which requires pyarrow.
        force: Overwrite an existing file.

    Returns:
        The number of failures written.

    Raises:
        InvalidParameter: If the suffix is unknown.
        OutputError: If the file exists or cannot be written, or pyarrow is missing.
        FormatError: If a file can no longer be read.
    """
    # Refuse before the slow part, which draws the pictures.
    ending = out.suffix.lower()
    make = {".zip": _archive, ".csv": _bare_table, ".parquet": _parquet}.get(ending)
    if make is None:
        raise InvalidParameter(
            "unknown-format",
            "{name!r}: unknown file type",
            "choose a name that ends in .zip, .csv or .parquet",
            name=out.name,
        )
    check_output(out, force)
    if ending == ".parquet":
        _pyarrow()
    ordered = distinct(entries)
    write_bytes(out, make(ordered, out), force=force)
    return len(ordered)


def _archive(entries: Sequence[CorpusEntry], out: Path) -> bytes:
    """Return an archive. Equal failures give equal bytes: it contains no file names or times."""
    stream = io.BytesIO()
    archive = ZipWriter(stream)
    rows = []
    # A file, a picture and a table row for each failure.
    for name, entry in _named(entries):
        failure = Failure.read(entry.path)
        picture = f"pictures/{name}.png"
        archive.add(f"{name}.grid", failure.dumps())
        archive.add(picture, draw_failure(entry, failure))
        row = entry.as_dict() | {"file": f"{name}.grid", "picture": picture}
        rows.append(row)
    archive.add(TABLE, _table(rows, (*_COLUMNS, "picture")))
    archive.close()
    return stream.getvalue()


def _named(entries: Sequence[CorpusEntry]) -> Iterator[tuple[str, CorpusEntry]]:
    met: Counter[tuple[str, str, str]] = Counter()
    names = {name_of(entry.facts) for entry in entries}
    for entry in entries:
        met[entry.facts.key] += 1
        yield name_of(entry.facts, met[entry.facts.key], names), entry


def _bare_table(entries: Sequence[CorpusEntry], _out: Path) -> bytes:
    return _table([entry.as_dict() for entry in entries], (*_COLUMNS, "first_seen"))


def _table(rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> bytes:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode(errors="backslashreplace")


def _parquet(entries: Sequence[CorpusEntry], _out: Path) -> bytes:
    """Return the table with the text and the picture of each failure as bytes."""
    arrow, parquet = _pyarrow()
    rows = []
    for entry in entries:
        failure = Failure.read(entry.path)
        rows.append(
            entry.as_dict() | {"grid": failure.dumps(), "picture": draw_failure(entry, failure)}
        )
    # State the types, because an empty table would not show them.
    kinds = {
        "width": arrow.int64(),
        "height": arrow.int64(),
        "solid": arrow.int64(),
        "events": arrow.int64(),
    }
    kinds |= {"grid": arrow.binary(), "picture": arrow.binary()}
    columns = (*_COLUMNS, "first_seen", "grid", "picture")
    schema = arrow.schema([(name, kinds.get(name, arrow.string())) for name in columns])
    stream = io.BytesIO()
    parquet.write_table(arrow.Table.from_pylist(rows, schema=schema), stream)
    return stream.getvalue()


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow  # noqa: PLC0415 - an extra
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise OutputError(
            "package-missing",
            "a .parquet table needs pyarrow",
            "{install}, or write .csv",
            at_terminal=True,
            install=pip_install("parquet"),
        ) from error
    return pyarrow, pyarrow.parquet
