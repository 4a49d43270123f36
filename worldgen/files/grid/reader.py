"""Bytes to world, strictly: every fault is one :class:`FormatError` with its line."""

from __future__ import annotations

import difflib
from typing import NamedTuple

import numpy as np

from worldgen.domain import CELL_SIZES, LATEST, number_fault
from worldgen.errors import FormatError, InvalidWorld, Message, NotAGrid
from worldgen.files.grid.header import Header
from worldgen.files.grid.records import (
    check_keys,
    read_certificate,
    read_failure,
    read_number,
    read_provenance,
    read_triple,
)
from worldgen.files.grid.schema import (
    CERTIFICATE_KINDS,
    CUT,
    END,
    MAGIC,
    MAX_HEADER_BYTES,
    SECTIONS,
    START,
    TARGET,
    TIMELINE,
    WITNESS,
)
from worldgen.files.grid.sections import Block, CellBlock, LetterMark, read_cells, read_columns
from worldgen.lattice import UNIT, lattice_to_metres
from worldgen.timeline import Timeline
from worldgen.world import DEFAULT_ROBOT_SPEED, Certificate, Cut, Pose, Target, Witness, World

__all__ = ["loads"]

_CARRIAGE_RETURN = Message(
    "carriage-return",
    "a carriage return (CR); lines end with LF alone",
    "convert the file, e.g. with dos2unix",
)


def loads(data: bytes, source: str | None = None) -> World:
    """Return the world that a ``.grid`` text describes.

    Time and memory stay within a small multiple of the text's size, whatever it says.

    Args:
        data: The whole text, not compressed.
        source: The file's name for messages.

    Raises:
        FormatError: If anything is wrong, with the line, what came, the rule and the way out.
    """
    file = _File(data, source)
    header_end = _header_end(file)
    header = Header(_decode(file, file.first_line_end, header_end), 2, source)
    blocks = _split(file, header_end)
    check_keys(header)
    cell_size = read_number(header, "cell_size")
    fault = number_fault("cell_size", cell_size, CELL_SIZES, "m")
    if fault is not None:
        raise header.fault(fault, "cell_size")
    robot_radius = read_number(header, "robot_radius")
    robot_speed = read_number(header, "robot_speed", default=DEFAULT_ROBOT_SPEED)
    provenance = read_provenance(header)
    failure = read_failure(header)
    cells = read_cells(blocks["cells"])
    start, target = _ends(header, cells, cell_size)
    timeline = _timeline(blocks, cells.walls.shape)
    certificate = _certificate(header, blocks)
    try:
        return World(
            cells.walls, start, target, cell_size, robot_radius, robot_speed,
            timeline, certificate, provenance, failure,
        )  # fmt: skip
    except InvalidWorld as error:  # a number that no world has, or start or target outside the grid
        key = str(error.facts["name"]).removesuffix(" radius")
        mark = {"start": cells.start, "target": cells.target}.get(key)
        line = header.line_of(key) if mark is None else mark.line
        raise FormatError.of(error.message, line=line, source=source) from error


class _File(NamedTuple):
    """The whole text and its name."""

    data: bytes
    source: str | None

    @property
    def first_line_end(self) -> int:
        return len(MAGIC) + 1

    def fault(self, message: Message, at: int) -> FormatError:
        """Return an error in the line that holds byte ``at``."""
        return FormatError.of(message, line=self.data.count(b"\n", 0, at) + 1, source=self.source)


def _header_end(file: _File) -> int:
    """Check the first line and the line ends; give the offset of the first section's line."""
    data = file.data
    magic = MAGIC.encode("ascii")
    if data[: len(magic) + 1] != magic + b"\n":
        raise _first_line_fault(file)
    carriage = data.find(b"\r")
    if carriage >= 0:
        raise file.fault(_CARRIAGE_RETURN, carriage)
    newline = data.find(b"\n%", len(magic), len(magic) + 1 + MAX_HEADER_BYTES)
    if newline >= 0:
        return newline + 1
    if len(data) > MAX_HEADER_BYTES:
        raise file.fault(
            Message(
                "cut-short",
                "no %cells within {most} bytes of header",
                "shorten it, or add the line %cells",
                most=MAX_HEADER_BYTES,
            ),
            MAX_HEADER_BYTES,
        )
    raise file.fault(
        Message(
            "cut-short", "the file ends before %cells; it was cut off, or its cells are missing"
        ),
        len(data) - 1,
    )


def _first_line_fault(file: _File) -> FormatError:
    first = file.data[:200].split(b"\n")[0]
    text = first.decode("utf-8", "replace")
    way_out = "the first line is `{magic}`"
    magic = MAGIC.encode("ascii")
    if not file.data:
        message = Message("empty", "the file is empty", way_out, magic=MAGIC)
    elif first.startswith(b"\xef\xbb\xbf"):
        way_out = f"save it as UTF-8 without one, so that {way_out}"
        message = Message(
            "byte-order-mark", "the file begins with a byte order mark", way_out, magic=MAGIC
        )
    elif first.startswith(b"\x1f\x8b"):
        way_out = f"give the file a name that ends in .gz; unpacked, {way_out}"
        message = Message("packed-file", "this is gzip data", way_out, magic=MAGIC)
    elif first == magic + b"\r":
        message = _CARRIAGE_RETURN
    elif first == magic:
        message = Message(
            "cut-short", "the file ends after its first line; the header and %cells follow it"
        )
    elif first.startswith(magic.split()[0]):
        problem = f"{{came!q}}: this program reads version 1: {way_out}"
        message = Message("other-version", problem, came=text, magic=MAGIC)
    else:
        message = Message(
            "not-a-grid", "no .grid file: it begins with {came!q}", way_out, came=text, magic=MAGIC
        )
        return NotAGrid.of(message, line=1, source=file.source)
    return FormatError.of(message, line=1, source=file.source)


def _decode(file: _File, begin: int, end: int) -> str:
    try:
        return file.data[begin:end].decode("utf-8")
    except UnicodeDecodeError as error:
        at = begin + error.start
        raise file.fault(
            Message(
                "not-utf8",
                "byte 0x{byte:02x} is not UTF-8",
                "save the file as UTF-8",
                byte=file.data[at],
            ),
            at,
        ) from error


def _split(file: _File, at: int) -> dict[str, Block]:
    """Return the sections by name, in order, up to ``%end`` and nothing after it."""
    data, source = file
    blocks: dict[str, Block] = {}
    line = data.count(b"\n", 0, at) + 1
    while True:
        stop = data.find(b"\n", at)
        name = _section_name(file, at, stop, line, blocks)
        if name == END:
            if stop + 1 < len(data):
                extra = len(data) - stop - 1
                raise FormatError(
                    "after-end",
                    "{extra} bytes after %end; nothing follows it",
                    "delete them",
                    extra=extra,
                    line=line + 1,
                    source=source,
                )
            return blocks
        end = data.find(b"\n%", stop) + 1
        if end == 0:
            raise file.fault(
                Message(
                    "cut-short",
                    "the file ends before %end; it was cut off, or the line %end is missing",
                ),
                len(data) - 1,
            )
        blocks[name] = Block(data, stop + 1, end, line + 1, source)
        line += 1 + data.count(b"\n", stop + 1, end)
        at = end


def _section_name(file: _File, at: int, stop: int, line: int, blocks: dict[str, Block]) -> str:
    text = file.data[at : at + 200 if stop < 0 else min(stop, at + 200)].decode("utf-8", "replace")
    name = text[1:]
    if name not in SECTIONS:
        near = "".join(difflib.get_close_matches(name[:40], SECTIONS, n=1))
        message = Message(
            "unknown-name",
            "{name!q} is no section",
            ("did you mean %{near}, alone on its line? " if near else "")
            + "known, in this order: {known!l}",
            name=text,
            near=near,
            known=[f"%{section}" for section in SECTIONS],
        )
    elif stop < 0:
        message = Message(
            "cut-short",
            "the file ends within the line {section}; every line ends with LF, the last too",
            "add it",
            section=text,
        )
    elif name in blocks:
        message = Message(
            "twice", "a second {section}; each section comes once", "join them", section=text
        )
    elif not blocks and name != "cells":
        message = Message(
            "wrong-order", "{section} before %cells; the cells come first", section=text
        )
    elif blocks and SECTIONS.index(name) < SECTIONS.index(next(reversed(blocks))):
        message = Message(
            "wrong-order",
            "{section} after %{previous}; the order is {known!l}",
            "move it up",
            section=text,
            previous=next(reversed(blocks)),
            known=list(SECTIONS),
        )
    else:
        return name
    raise FormatError.of(message, line=line, source=file.source)


def _ends(header: Header, cells: CellBlock, cell_size: float) -> tuple[Pose, Target]:
    """Start and target, each from the header or from its mark, never both."""
    for key, letter, mark in (("start", START, cells.start), ("target", TARGET, cells.target)):
        if mark is None and key not in header.data:
            raise header.missing(
                Message(
                    "missing-key",
                    "the header has no {key} and no cell is marked {letter}",
                    "add one of the two",
                    key=key,
                    letter=letter,
                )
            )
        if mark is not None and key in header.data:
            message = Message(
                "conflict",
                "a cell is marked {letter}, and the header has {key}",
                "remove one of the two",
                letter=letter,
                key=key,
            )
            raise FormatError.of(message, line=mark.line, source=header.source)
    numbers = (
        read_triple(header, "start") if cells.start is None else _centre(cells.start, cell_size)
    )
    start = Pose(*numbers)
    if cells.target is None:
        return start, Target(*read_triple(header, "target"))
    radius = lattice_to_metres(UNIT // 2, cell_size)
    return start, Target(*_centre(cells.target, cell_size), radius)


def _centre(mark: LetterMark, cell_size: float) -> tuple[float, float]:
    """Return the centre of a cell, m, correctly rounded."""
    return (
        lattice_to_metres(mark.ix * UNIT + UNIT // 2, cell_size),
        lattice_to_metres(mark.iy * UNIT + UNIT // 2, cell_size),
    )


def _timeline(blocks: dict[str, Block], shape: tuple[int, ...]) -> Timeline:
    block = blocks.get("timeline")
    if block is None:
        return Timeline()
    times, ix, iy, states = read_columns(block, TIMELINE)
    for name, index, side in (("ix", ix, shape[1]), ("iy", iy, shape[0])):
        outside = index >= side
        if outside.any():
            row = int(np.argmax(outside))
            raise block.fault(
                Message(
                    "out-of-range",
                    "%timeline: {name} is {index}",
                    "the grid has {name} from 0 to {last}",
                    name=name,
                    index=index[row],
                    last=side - 1,
                ),
                row,
            )
    falling = times[1:] < times[:-1]
    if falling.any():
        row = int(np.argmax(falling)) + 1
        message = Message(
            "not-sorted",
            "%timeline: time {time} comes after {previous}",
            "sort the lines by time",
            time=times[row],
            previous=times[row - 1],
        )
        raise block.fault(message, row)
    late = times > LATEST
    if late.any():
        row = int(np.argmax(late))
        message = Message(
            "out-of-range",
            "%timeline: {name} is {time}",
            "a change comes at {latest:g} s at the latest",
            name="time",
            time=times[row],
            latest=LATEST,
        )
        raise block.fault(message, row)
    return Timeline(times, ix, iy, states)


def _certificate(header: Header, blocks: dict[str, Block]) -> Certificate | None:
    """Return the certificate; its section is there if and only if the header says so."""
    record = read_certificate(header)
    for kind in CERTIFICATE_KINDS:
        if kind in blocks and (record is None or record[0] != kind):
            said = "no [certificate]" if record is None else f'kind = "{record[0]}"'
            raise blocks[kind].fault(
                Message(
                    "conflict",
                    "%{kind}, but the header has {said}",
                    "remove one or correct the other",
                    kind=kind,
                    said=said,
                ),
                -1,
            )
    if record is None:
        return None
    kind, clearance = record
    if kind not in blocks:
        message = Message(
            "missing-section",
            'kind = "{kind}", but there is no section %{kind}',
            "add it, or remove [certificate]",
            kind=kind,
        )
        raise header.fault(message, "certificate", "kind")
    if kind == "cut":
        return Cut(np.column_stack(read_columns(blocks[kind], CUT)), clearance)
    times, x, y = read_columns(blocks[kind], WITNESS)
    return Witness(times, x, y, clearance)
