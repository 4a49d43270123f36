"""Parse bytes strictly into a world: each fault raises one :class:`FormatError` with its line."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from worldgen.domain import CELL_SIZES, LATEST, number_fault
from worldgen.errors import FormatError, InvalidWorld, Message, NotAGrid
from worldgen.files.grid.header import Header
from worldgen.files.grid.records import (
    Table,
    read_certificate,
    read_failure,
    read_provenance,
    read_robots,
    read_top,
)
from worldgen.files.grid.schema import (
    BODY_CUT,
    CERTIFICATE_KINDS,
    CUT,
    END,
    HEADING_WITNESS,
    MAGIC,
    MAX_HEADER_BYTES,
    ROBOTS_WITNESS,
    SECTIONS,
    START,
    TABLES_MAGIC,
    TARGET,
    TIMELINE,
    WITNESS,
)
from worldgen.files.grid.sections import Block, CellBlock, LetterMark, read_cells, read_columns
from worldgen.lattice import cell_middle
from worldgen.timeline import Timeline
from worldgen.world import Certificate, Cut, JointWitness, Pose, Robot, Target, Witness, World

_CARRIAGE_RETURN = Message(
    "carriage-return",
    "a carriage return (CR); lines end with LF only",
    "convert the file, e.g. with dos2unix",
)


def loads(data: bytes, source: str | None = None) -> World:
    """Parse the world in a ``.grid`` text.

    Time and memory stay within a small multiple of the text's size, whatever it contains.

    Args:
        data: The complete text, not compressed.
        source: The file's name for messages.

    Raises:
        FormatError: If anything is wrong, with the line, the value, the rule and the remedy.
    """
    # Check the form of the file, then the header.
    file = _File(data, source)
    header_end = _header_end(file)
    header = Header(_decode(file, file.first_line_end, header_end), 2, source)
    blocks = _split(file, header_end)
    top = read_top(header, tables=file.has_tables)
    cell_size = top.read("cell_size")
    fault = number_fault("cell_size", cell_size, CELL_SIZES, "m")
    if fault is not None:
        raise FormatError.of(fault, **header.at("cell_size"))
    # Read the robots, whose places the cells may mark.
    radius = speed = 0.0
    if file.has_tables:
        robots = read_robots(header)
    else:
        radius = top.read("robot_radius")
        speed = top.read("robot_speed")
    provenance = read_provenance(header)
    failure = read_failure(header)
    cells = read_cells(blocks["cells"])
    if file.has_tables:
        _refuse_marks(header, cells)
    else:
        start, target = _ends(top, cells, cell_size)
        robots = [Robot(start, target, radius, speed)]
    # Read the rest, and let the world check itself.
    timeline = _timeline(blocks, cells.walls.shape)
    certificate = _certificate(header, blocks, robots, tables=file.has_tables)
    try:
        return World(
            cells.walls, cell_size=cell_size, timeline=timeline, certificate=certificate,
            provenance=provenance, failure=failure, robots=robots,
        )  # fmt: skip
    # An impossible number, or robots that overlap.
    except InvalidWorld as error:
        line = _line_of_fault(header, cells, error.facts, tables=file.has_tables)
        raise FormatError.of(error.message, line=line, source=source) from error


def _line_of_fault(
    header: Header, cells: CellBlock, facts: Mapping[str, Any], *, tables: bool
) -> int:
    """Return the line of the fault in a rejected world."""
    name = str(facts.get("name", "")).removesuffix(" radius")
    if not tables:
        mark = {"start": cells.start, "target": cells.target}.get(name)
        return header.line_of(name) if mark is None else mark.line
    if "second" in facts:
        return header.line_in_item("robot", facts["second"] - 1)
    # Such as "robot 2 radius" or "robot 2 target radius".
    words = str(facts.get("name", "")).removeprefix("robot_").split(" ")
    row = 0
    if words[0] == "robot" and len(words) > 2:
        row = int(words[1]) - 1
        words = words[2:]
    key = "waypoints" if words[0] == "waypoint" else words[0]
    return header.line_in_item("robot", row, key)


class _File(NamedTuple):
    """The complete text and its name."""

    data: bytes
    source: str | None

    @property
    def first_line_end(self) -> int:
        # Both versions have first lines of the same length.
        return len(MAGIC) + 1

    @property
    def has_tables(self) -> bool:
        """True for version 2, with [[robot]] tables."""
        return self.data.startswith(TABLES_MAGIC.encode("ascii"))

    def at(self, byte: int) -> dict[str, Any]:
        """Return the place of the line that contains a byte, as :class:`FormatError` takes it."""
        return {"line": self.data.count(b"\n", 0, byte) + 1, "source": self.source}


def _header_end(file: _File) -> int:
    """Check the first line and the line ends; return the offset of the first section's line."""
    # Check the first line and the line ends.
    data = file.data
    magic = MAGIC.encode("ascii")
    known = (MAGIC, TABLES_MAGIC)
    if data[: len(magic) + 1] not in [f"{line}\n".encode("ascii") for line in known]:
        raise _first_line_fault(file)
    carriage = data.find(b"\r")
    if carriage >= 0:
        raise FormatError.of(_CARRIAGE_RETURN, **file.at(carriage))
    # The header ends before the first section.
    newline = data.find(b"\n%", len(magic), len(magic) + 1 + MAX_HEADER_BYTES)
    if newline >= 0:
        return newline + 1
    if len(data) > MAX_HEADER_BYTES:
        raise FormatError(
            "cut-short",
            "no %cells within {most} bytes of header",
            "shorten it, or add the line %cells",
            most=MAX_HEADER_BYTES,
            **file.at(MAX_HEADER_BYTES),
        )
    raise FormatError(
        "cut-short",
        "the file ends before %cells; it is truncated, or its cells are missing",
        **file.at(len(data) - 1),
    )


def _first_line_fault(file: _File) -> FormatError:
    # Distinguish the most common mistakes, so that the remedy fits.
    first = file.data[:200].split(b"\n")[0]
    text = first.decode("utf-8", "replace")
    way_out = "the first line is `{magic}`"
    magics = [line.encode("ascii") for line in (MAGIC, TABLES_MAGIC)]
    # The remedy depends on what the file seems to be.
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
    elif first.endswith(b"\r") and first[:-1] in magics:
        message = _CARRIAGE_RETURN
    elif first in magics:
        message = Message(
            "cut-short", "the file ends after its first line; the header and %cells follow it"
        )
    elif first.startswith(magics[0].split()[0]):
        problem = f"{{came!q}}: this program reads versions 1 and 2: {way_out}, or `{{tables}}`"
        message = Message("other-version", problem, came=text, magic=MAGIC, tables=TABLES_MAGIC)
    else:
        message = Message(
            "not-a-grid",
            "not a .grid file: it begins with {came!q}",
            way_out,
            came=text,
            magic=MAGIC,
        )
        return NotAGrid.of(message, line=1, source=file.source)
    return FormatError.of(message, line=1, source=file.source)


def _decode(file: _File, begin: int, end: int) -> str:
    try:
        return file.data[begin:end].decode("utf-8")
    except UnicodeDecodeError as error:
        at = begin + error.start
        raise FormatError(
            "not-utf8",
            "byte 0x{byte:02x} is not UTF-8",
            "save the file as UTF-8",
            byte=file.data[at],
            **file.at(at),
        ) from error


def _split(file: _File, at: int) -> dict[str, Block]:
    """Return the sections by name, in order, up to ``%end`` and nothing after it."""
    data, source = file
    blocks: dict[str, Block] = {}
    line = data.count(b"\n", 0, at) + 1
    # Sections follow each other until %end.
    while True:
        stop = data.find(b"\n", at)
        name = _section_name(file, at, stop, line, blocks)
        if name == END:
            if stop + 1 < len(data):
                extra = len(data) - stop - 1
                raise FormatError(
                    "after-end",
                    "{extra} bytes after %end; nothing may follow it",
                    "delete them",
                    extra=extra,
                    line=line + 1,
                    source=source,
                )
            return blocks
        end = data.find(b"\n%", stop) + 1
        if end == 0:
            raise FormatError(
                "cut-short",
                "the file ends before %end; it is truncated, or the line %end is missing",
                **file.at(len(data) - 1),
            )
        blocks[name] = Block(data, stop + 1, end, line + 1, source)
        line += 1 + data.count(b"\n", stop + 1, end)
        at = end


def _section_name(file: _File, at: int, stop: int, line: int, blocks: dict[str, Block]) -> str:
    # Name the most common mistake, so that the remedy fits.
    text = file.data[at : at + 200 if stop < 0 else min(stop, at + 200)].decode("utf-8", "replace")
    name = text[1:]
    if name not in SECTIONS:
        near = "".join(difflib.get_close_matches(name[:40], SECTIONS, n=1))
        message = Message(
            "unknown-name",
            "{name!q} is not a section",
            ("did you mean %{near}, alone on its line? " if near else "")
            + "known, in this order: {known!l}",
            name=text,
            near=near,
            known=[f"%{section}" for section in SECTIONS],
        )
    elif stop < 0:
        message = Message(
            "cut-short",
            "the file ends within the line {section}; every line ends with LF, including the last",
            "add it",
            section=text,
        )
    elif name in blocks:
        message = Message(
            "twice",
            "a second {section}; each section may occur only once",
            "join them",
            section=text,
        )
    elif not blocks and name != "cells":
        message = Message(
            "wrong-order", "{section} before %cells; %cells must come first", section=text
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


def _ends(top: Table, cells: CellBlock, cell_size: float) -> tuple[Pose, Target]:
    """Return start and target, each from the header or from its mark, never from both."""
    # Each place comes from the header or from its mark, never from both.
    for key, letter, mark in (("start", START, cells.start), ("target", TARGET, cells.target)):
        if mark is None and key not in top.values:
            raise FormatError(
                "missing-key",
                "the header has no {key}, and no cell is marked {letter}",
                "add one of the two",
                key=key,
                letter=letter,
                **top.at(),
            )
        if mark is not None and key in top.values:
            raise FormatError(
                "conflict",
                "a cell is marked {letter}, but the header has {key}",
                "remove one of the two",
                letter=letter,
                key=key,
                line=mark.line,
                source=top.header.source,
            )
    # A marked start has its cell's centre, a marked target the cell's inscribed disc.
    start = Pose(*(top.read("start") if cells.start is None else _centre(cells.start, cell_size)))
    if cells.target is None:
        return start, Target(*top.read("target"))
    radius = cell_middle(0, cell_size)
    return start, Target(*_centre(cells.target, cell_size), radius)


def _refuse_marks(header: Header, cells: CellBlock) -> None:
    """Reject the marks of version 1 in version 2, whose tables have starts and targets."""
    for letter, mark in ((START, cells.start), (TARGET, cells.target)):
        if mark is not None:
            raise FormatError(
                "conflict",
                "a cell is marked {letter}, and in version 2 each [[robot]] table has its own "
                "start and target",
                "make it a free cell",
                letter=letter,
                line=mark.line,
                source=header.source,
            )


def _centre(mark: LetterMark, cell_size: float) -> tuple[float, float]:
    return cell_middle(mark.ix, cell_size), cell_middle(mark.iy, cell_size)


def _timeline(blocks: dict[str, Block], shape: tuple[int, ...]) -> Timeline:
    block = blocks.get("timeline")
    if block is None:
        return Timeline()
    times, ix, iy, states = read_columns(block, TIMELINE)
    # Events must be in the grid, in order of time, and not absurdly late.
    for name, index, side in (("ix", ix, shape[1]), ("iy", iy, shape[0])):
        outside = index >= side
        if outside.any():
            row = int(np.argmax(outside))
            raise FormatError(
                "out-of-range",
                "%timeline: {name} is {index}",
                "the grid has {name} 0 to {last}",
                name=name,
                index=index[row],
                last=side - 1,
                **block.at(row),
            )
    falling = times[1:] < times[:-1]
    if falling.any():
        row = int(np.argmax(falling)) + 1
        raise FormatError(
            "not-sorted",
            "%timeline: time {time} comes after {previous}",
            "sort the lines by time",
            time=times[row],
            previous=times[row - 1],
            **block.at(row),
        )
    late = times > LATEST
    if late.any():
        row = int(np.argmax(late))
        raise FormatError(
            "out-of-range",
            "%timeline: {name} is {time}",
            "no change can happen later than {latest:g} s",
            name="time",
            time=times[row],
            latest=LATEST,
            **block.at(row),
        )
    return Timeline(times, ix, iy, states)


def _certificate(
    header: Header, blocks: dict[str, Block], robots: list[Robot], *, tables: bool
) -> Certificate | None:
    """Return the certificate; its section must exist if and only if the header declares it."""
    # A section needs its table.
    record = read_certificate(header, robots, tables=tables)
    for kind in CERTIFICATE_KINDS:
        if kind in blocks and (record is None or record.kind != kind):
            said = "no [certificate]" if record is None else f'kind = "{record.kind}"'
            raise FormatError(
                "conflict",
                "%{kind}, but the header has {said}",
                "remove one or correct the other",
                kind=kind,
                said=said,
                **blocks[kind].at(-1),
            )
    if record is None:
        return None
    kind = record.kind
    clearance = record.clearances[0]
    # The table needs its section.
    if kind not in blocks:
        raise FormatError(
            "missing-section",
            'kind = "{kind}", but there is no section %{kind}',
            "add it, or remove [certificate]",
            kind=kind,
            **header.at("certificate", "kind"),
        )
    block = blocks[kind]
    if kind == "cut":
        if tables and _words_of_first_line(block) == len(BODY_CUT.fields):
            boxes = np.column_stack(read_columns(block, BODY_CUT))
            cells = np.empty((0, 2), np.int64)
            return Cut(cells, clearance, record.robot, boxes, record.waypoint)
        cells = np.column_stack(read_columns(block, CUT))
        return Cut(cells, clearance, record.robot, waypoint=record.waypoint)
    if tables:
        paths = _paths(block, record.clearances)
        return paths[0] if len(robots) == 1 else JointWitness(paths)
    times, x, y = read_columns(block, WITNESS)
    return Witness(times, x, y, clearance)


def _words_of_first_line(block: Block) -> int:
    end = block.data.find(b"\n", block.begin, block.end)
    return len(block.data[block.begin : end].split()) if end >= 0 else 0


def _paths(block: Block, clearances: tuple[float, ...]) -> tuple[Witness, ...]:
    """Return the paths of all robots; the lines are ordered by robot."""
    with_headings = _words_of_first_line(block) == len(HEADING_WITNESS.fields)
    section = HEADING_WITNESS if with_headings else ROBOTS_WITNESS
    numbers, *columns = read_columns(block, section)
    robots = len(clearances)

    # Each line is about the same robot as the one before, or the next one.
    before = np.concatenate([[1], numbers[:-1]])
    wrong = (numbers < before) | (numbers > before + 1) | (numbers > robots)
    wrong[:1] |= numbers[:1] != 1
    if wrong.any():
        row = int(np.argmax(wrong))
        raise FormatError(
            "not-sorted",
            "%witness: this line of robot {robot} is out of order",
            "write the lines of robots 1 to {last} in order, one robot at a time",
            robot=numbers[row],
            last=robots,
            **block.at(row),
        )
    counts = np.bincount(numbers, minlength=robots + 1)[1:]
    if not counts.all():
        raise FormatError(
            "missing-section",
            "%witness has no line for robot {robot}",
            "each robot needs a path of at least one line",
            robot=int(np.argmin(counts)) + 1,
            **block.at(len(numbers) - 1),
        )

    ends = np.cumsum(counts)[:-1]
    # Times, x and y come before the clearance, headings after it.
    parts = [np.split(values, ends) for values in columns]
    return tuple(Witness(*own) for own in zip(*parts[:3], clearances, *parts[3:], strict=True))
