"""The sections: cells as one block of bytes, events and points as lines of few words.

Valid sections are read in bulk; only if something is wrong does a slow second pass find the line.
"""

from __future__ import annotations

import difflib
import functools
import re
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.domain import MAX_SIDE
from worldgen.errors import FormatError, Message
from worldgen.files.grid.schema import FREE, SOLID, START, STATES, TARGET, Field, LineSection
from worldgen.support.arrays import Bools
from worldgen.support.frozen import freeze
from worldgen.support.rows import flip_rows

# Bytes of lines split into words at a time; words take 20 times their text in memory.
_CHUNK = 1 << 20
_CELL_BYTES = (SOLID + FREE + START + TARGET).encode("ascii")


class Block(NamedTuple):
    """The place of a section's lines: ``data[begin:end]``, whole lines from line ``line``."""

    data: bytes
    begin: int
    end: int
    line: int
    source: str | None

    def at(self, row: int) -> dict[str, Any]:
        """Return the place of a line of the block, from 0, as :class:`FormatError` takes it."""
        return {"line": self.line + row, "source": self.source}


class LetterMark(NamedTuple):
    """A cell marked by a letter: column, row from the bottom, and the line of the file."""

    ix: int
    iy: int
    line: int


class CellBlock(NamedTuple):
    """The contents of ``%cells``: walls, lowest row first, and the marks of start and target."""

    walls: Bools
    start: LetterMark | None
    target: LetterMark | None


def read_cells(block: Block) -> CellBlock:
    """Parse the cells from their rows.

    Raises:
        FormatError: If there are no rows, too many, too long ones, ones of different length, an
            invalid character, or a second start or target.
    """
    # Check the sizes first, because they bound everything else.
    data = block.data
    begin = block.begin
    end = block.end
    if begin == end:
        raise FormatError(
            "empty",
            "%cells has no rows",
            "write one line of {solid} and {free} for each row, the top one first",
            solid=SOLID,
            free=FREE,
            **block.at(-1),
        )
    width = data.index(b"\n", begin) - begin
    height, rest = divmod(end - begin, width + 1)
    if rest or not 0 < width <= MAX_SIDE or height > MAX_SIDE:
        _check_rows(block, width)
    # Read all cells together; look for marks only if there are other letters.
    text = np.frombuffer(data, np.uint8, end - begin, begin).reshape(height, width + 1)
    cells = flip_rows(text[:, :-1])
    solid = cells == ord(SOLID)
    start = target = None
    if not ((text[:, -1] == ord("\n")).all() and (solid | (cells == ord(FREE))).all()):
        _check_rows(block, width)
        start = _mark(block, START, width)
        target = _mark(block, TARGET, width)
    return CellBlock(freeze(solid), start, target)


def _mark(block: Block, letter: str, width: int) -> LetterMark | None:
    """Return the only cell with a letter, in a block with valid rows."""
    # Find the letter, and refuse a second one.
    code = letter.encode("ascii")
    first = block.data.find(code, block.begin, block.end)
    if first < 0:
        return None
    second = block.data.find(code, first + 1, block.end)
    if second >= 0:
        row = (second - block.begin) // (width + 1)
        raise FormatError(
            "twice",
            "a second {letter}; only one cell may be marked {letter}: make the other one {free}",
            letter=letter,
            free=FREE,
            **block.at(row),
        )
    height = (block.end - block.begin) // (width + 1)
    row, ix = divmod(first - block.begin, width + 1)
    return LetterMark(ix, height - 1 - row, block.line + row)


def _check_rows(block: Block, width: int) -> None:
    """Raise for the first row that breaks a rule.

    The rows before it are at most a world's size.
    """
    at = block.begin
    row = 0
    # Check one row after another, the most common faults first.
    while at < block.end:
        stop = block.data.index(b"\n", at)
        length = stop - at
        if row == MAX_SIDE:
            raise FormatError(
                "too-large",
                "more than {most} rows; a side has at most {most} cells",
                "split the world",
                most=MAX_SIDE,
                **block.at(row),
            )
        if length == 0:
            raise FormatError(
                "empty",
                "an empty line in %cells; a row has at least one cell",
                "delete the line",
                **block.at(row),
            )
        strange = block.data[at : min(stop, at + MAX_SIDE)].translate(None, _CELL_BYTES)
        if strange:
            raise _strange_cell(block, at, stop, row)
        if length > MAX_SIDE:
            raise FormatError(
                "too-large",
                "a row of {cells} cells; a side has at most {most} cells",
                "split the world",
                cells=length,
                most=MAX_SIDE,
                **block.at(row),
            )
        if length != width:
            raise FormatError(
                "ragged-rows",
                "a row of {cells} cells, but the first row has {width}",
                "make all rows equally long",
                cells=length,
                width=width,
                **block.at(row),
            )
        at = stop + 1
        row = row + 1


def _strange_cell(block: Block, at: int, stop: int, row: int) -> FormatError:
    column = next(k for k, code in enumerate(block.data[at:stop]) if code not in _CELL_BYTES)
    character = block.data[at + column : min(at + column + 4, stop)].decode("utf-8", "replace")[0]
    return FormatError(
        "unknown-sign",
        "{sign!r} at column {column} is not a cell",
        "write {solid} for solid, {free} for free, {start} and {target} for start and target",
        sign=character,
        column=column + 1,
        solid=SOLID,
        free=FREE,
        start=START,
        target=TARGET,
        **block.at(row),
    )


def read_columns(block: Block, section: LineSection) -> list[npt.NDArray[Any]]:
    """Parse the words of a section into one array per field.

    Raises:
        FormatError: If a line does not have the section's form, or a number exceeds 64 bits.
    """
    line_pattern = _line_pattern(section)
    at = block.begin
    row = 0
    parts: list[list[npt.NDArray[Any]]] = [[np.zeros(0, field.dtype)] for field in section.fields]
    # Read as many whole lines at a time as fit into a chunk.
    while at < block.end:
        stop = _chunk_end(block, at)
        match = line_pattern.match(block.data, at, stop)
        if match is None or match.end() < stop:
            good_until = at if match is None else match.end()
            raise _strange_line(
                block, section, good_until, row + block.data.count(b"\n", at, good_until)
            )
        # Convert each column.
        words = block.data[at:stop].split()
        count = len(section.fields)
        for k, field in enumerate(section.fields):
            parts[k].append(_column(block, section, field, words[k::count], row))
        at = stop
        row = row + len(words) // count
    return [np.concatenate(columns) for columns in parts]


def _chunk_end(block: Block, at: int) -> int:
    """Return the end of the whole lines within a chunk, or of the one line that is longer."""
    if block.end - at <= _CHUNK:
        return block.end
    last = block.data.rfind(b"\n", at, at + _CHUNK)
    return (last if last >= 0 else block.data.index(b"\n", at)) + 1


@functools.cache
def _line_pattern(section: LineSection) -> re.Pattern[bytes]:
    return re.compile(b"(?:" + b" ".join(field.pattern for field in section.fields) + b"\n)*+")


def _column(
    block: Block, section: LineSection, field: Field, words: list[bytes], row: int
) -> npt.NDArray[Any]:
    values = list(map(field.read, words))
    try:
        column = np.array(values, field.dtype)
        if np.isfinite(column).all():
            return column
        wrong = int(np.argmin(np.isfinite(column)))
    except OverflowError:
        wrong = next(k for k, value in enumerate(values) if not -(2**63) <= value < 2**63)
    raise FormatError.of(
        _word_message(section, field, words[wrong].decode("ascii")), **block.at(row + wrong)
    )


def _word_message(section: LineSection, field: Field, word: str) -> Message:
    near = "".join(
        difflib.get_close_matches(word[:20], list(STATES), n=1) if field.name == "state" else []
    )
    return Message(
        "wrong-form",
        "%{section}: {field} {word!q} is not {rule}" + ("; did you mean {near!r}?" if near else ""),
        "write `{form}`, for example `{example}`",
        section=section.name,
        field=field.name,
        word=word,
        rule=field.rule,
        near=near,
        form=section.form,
        example=section.example,
    )


def _strange_line(block: Block, section: LineSection, at: int, row: int) -> FormatError:
    stop = block.data.index(b"\n", at)
    line = block.data[at : min(stop, at + 1000)].decode("utf-8", "replace")
    words = line.split(" ")
    if len(words) == len(section.fields):
        for field, word in zip(section.fields, words, strict=True):
            if not re.fullmatch(field.pattern, word.encode("utf-8", "replace")):
                return FormatError.of(_word_message(section, field, word), **block.at(row))
    return FormatError(
        "wrong-form",
        "%{section}: {came!q} is not `{form}`, words with one space between them",
        "write it as in `{example}`",
        section=section.name,
        came=line,
        form=section.form,
        example=section.example,
        **block.at(row),
    )
