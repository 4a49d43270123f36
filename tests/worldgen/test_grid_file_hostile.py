"""Files that are wrong: each gets one message, at its line, saying what came and what to do."""

import tomllib

import pytest

from worldgen.errors import FormatError
from worldgen.grid_file import loads

GOOD = """%worldgen-grid 1
cell_size = 0.1
robot_radius = 0.07
start = [0.05, 0.15, 0.0]
target = [0.25, 0.15, 0.05]
[provenance]
family = "maze"
version = 1
seed = 7
params = { size = 3 }
[certificate]
kind = "witness"
clearance = 0.1
[failure]
controller = "turn-right"
motion = "swept"
seed = 1
verdict = "loop"
trace_digest = "00"
%cells
...
...
%timeline
1.0 0 0 burning
2.0 0 0 free
%witness
0.0 0.05 0.15
1.0 0.25 0.15
%end
"""
CUT = GOOD.replace('"witness"', '"cut"').replace("%witness\n0.0 0.05 0.15\n1.0 0.25 0.15\n", "%cut\n1 1\n1 -1\n")
DRAWN = "%worldgen-grid 1\ncell_size = 0.1\nrobot_radius = 0.04\n%cells\nS..\n..G\n%end\n"

# name: (old, new, line, what the message says)
HEADER_FAULTS = {
    "magic": ("%worldgen-grid 1", "hello", 1, "no .grid file: it begins with 'hello'; the first line is"),
    "version": ("%worldgen-grid 1", "%worldgen-grid 2", 1, "this program reads version 1"),
    "bom": ("%worldgen-grid 1", "\ufeff%worldgen-grid 1", 1, "byte order mark"),
    "only-magic": (GOOD[17:], "", 1, "ends before %cells"),
    "windows": ("\n", "\r\n", 1, "carriage return (CR); lines end with LF alone"),
    "one-cr": ("seed = 7", "seed = 7\r", 9, "carriage return"),
    "no-cells": (GOOD[GOOD.index("%cells") :], "", 19, "the file ends before %cells"),
    "not-toml": ("cell_size = 0.1", "cell_size: 0.1", 2, "the header is not TOML, column 10: Expected '='"),
    "nul": ("cell_size = 0.1", "cell_size = 0.1 # \0", 2, "not TOML"),
    "twice": ("robot_radius = 0.07", "cell_size = 0.07", 3, "Cannot overwrite a value"),
    "table-twice": ("[failure]", "[provenance]", 14, "Cannot declare ('provenance',) twice"),
    "open-string": ('family = "maze"', 'family = "maze', 7, "not TOML"),
    "open-long-string": ('family = "maze"', 'family = """maze', 7, "not TOML: Unterminated string"),
    "percent-in-string": ('family = "maze"', 'family = """\n%"""', 7, "not TOML: Unterminated string"),
    "unknown": ("robot_radius =", "robot_radios =", 3, "'robot_radios'; did you mean 'robot_radius'? known:"),
    "unknown-table": ("[failure]", "[failures]", 14, "'failures'; did you mean 'failure'?"),
    "unknown-in-table": (
        "family =",
        "famly =",
        7,
        "unknown key in [provenance]: 'famly'; did you mean 'family'?",
    ),
    "misplaced": ("version = 1", "robot_speed = 1", 8, "belongs above the first [table]"),
    "no-cell-size": ("cell_size = 0.1\n", "", 19, "the header has no cell_size; add `cell_size = ...`"),
    "no-radius": ("robot_radius = 0.07\n", "", 19, "the header has no robot_radius"),
    "no-start": (
        "start = [0.05, 0.15, 0.0]\n",
        "",
        19,
        "no start and no cell is marked S; add one of the two",
    ),
    "no-target": ("target = [0.25, 0.15, 0.05]\n", "", 19, "no target and no cell is marked G"),
    "text-size": ("cell_size = 0.1", 'cell_size = "0.1"', 2, "cell_size is text; write a number"),
    "true-size": ("cell_size = 0.1", "cell_size = true", 2, "cell_size is true or false; write a number"),
    "date-size": ("cell_size = 0.1", "cell_size = 2025-01-01", 2, "cell_size is a date or time"),
    "zero-size": ("cell_size = 0.1", "cell_size = 0", 2, "cell_size is 0.0; it is above 0"),
    "negative-radius": ("radius = 0.07", "radius = -1", 3, "robot_radius is -1.0; it is above 0"),
    "nan": ("cell_size = 0.1", "cell_size = nan", 2, "cell_size is nan; write a finite number"),
    "overflow": ("cell_size = 0.1", "cell_size = 1e999", 2, "cell_size is inf; write a finite number"),
    "huge-integer": ("cell_size = 0.1", "cell_size = 1" + 400 * "0", 2, "write a finite number"),
    "short-start": ("[0.05, 0.15, 0.0]", "[0.05, 0.15]", 4, "start is a list of 2; write three numbers"),
    "start-text": ("[0.05, 0.15, 0.0]", '[0.05, "a", 0]', 4, "start[1] is text"),
    "start-number": ("[0.05, 0.15, 0.0]", "0.05", 4, "start is a number; write three numbers"),
    "start-outside": ("[0.05, 0.15, 0.0]", "[0.05, 0.25, 0.0]", 4, "lies outside the grid of 0.3 x 0.2 m"),
    "target-outside": ("[0.25, 0.15,", "[-0.1, 0.15,", 5, "lies outside the grid"),
    "heading-inf": ("0.15, 0.0]", "0.15, inf]", 4, "start[2] is inf"),
    "target-radius": ("0.15, 0.05]", "0.15, 0]", 5, "the target's radius is 0.0; it is above 0"),
    "provenance-number": ("[provenance]", "provenance = 1\n[failure.x]", 6, "is an integer; it is a table"),
    "provenance-list": ("[provenance]", "[[provenance]]", 6, "provenance is a list; it is a table"),
    "no-family": ('family = "maze"\n', "", 6, "[provenance] has no family; add"),
    "family-number": ('family = "maze"', "family = 1", 7, "provenance.family is an integer; write text"),
    "version-float": ("version = 1", "version = 1.0", 8, "provenance.version is a number; write an integer"),
    "seed-bool": ("seed = 7", "seed = true", 9, "provenance.seed is true or false; write an integer"),
    "seed-huge": ("seed = 7", "seed = 1" + 400 * "0", 9, "an integer out of range"),
    "params-list": ("{ size = 3 }", "[]", 10, "provenance.params is a list; write a table"),
    "params-date": (
        "{ size = 3 }",
        "{ a = [2025-01-01] }",
        10,
        "provenance.params.a is a date or time; write it as",
    ),
    "params-inf": ("{ size = 3 }", "{ a = { b = -inf } }", 10, "provenance.params.a.b is -inf"),
    "params-lines": (
        "{ size = 3 }",
        "{ a = [\n1,\n# b = 2\n07:00:00] }",
        10,
        "provenance.params.a is a date",
    ),
    "params-dotted": ("params = { size = 3 }", "params.'a b'.c = nan", 10, "provenance.params.a b.c is nan"),
    "params-table": (
        "params = { size = 3 }",
        '[provenance.params] # x\n\n"k" = inf',
        12,
        "provenance.params.k",
    ),
    "params-huge": ("size = 3", "size = 0x1" + 256 * "0", 10, "an integer has at most 1024 bits"),
    "kind": ('kind = "witness"', 'kind = "proof"', 12, 'kind is \'proof\'; write "witness" or "cut"'),
    "kind-list": ('kind = "witness"', "kind = []", 12, "certificate kind is a list"),
    "no-clearance": ("clearance = 0.1\n", "", 11, "[certificate] has no clearance"),
    "clearance-inf": ("clearance = 0.1", "clearance = inf", 13, "clearance is inf"),
    "no-verdict": ('verdict = "loop"\n', "", 14, "[failure] has no verdict"),
    "verdict-number": ('verdict = "loop"', "verdict = 1", 18, "failure.verdict is an integer"),
    "kind-without-section": ('"witness"', '"cut"', 26, '%witness, but the header has kind = "cut"'),
    "section-without-kind": (
        GOOD[GOOD.index("[cert") : GOOD.index("[fail")],
        "",
        23,
        "the header has no [certificate]",
    ),
    "kind-missing-section": (
        GOOD[GOOD.index("%wit") : GOOD.index("%end")],
        "",
        12,
        "there is no section %witness",
    ),
    "brackets": ("{ size = 3 }", 40 * "[", 10, "nesting deeper than 32 levels"),
    "dots": ("cell_size", "a" + 40 * ".a", 2, "nesting deeper than 32 levels"),
    "values-deep": (
        "{ size = 3 }",
        "{ a." + 30 * "b." + "c = { d = [] } }",
        10,
        "nested deeper than 32 levels",
    ),
    "long-number": ("0.1\n", "0." + 3000 * "1" + "\n", 2, "a word of 3000 characters; the limit is 2000"),
    "long-header": ("cell_size", "#" + (1 << 20) * "x" + "\ncell_size", 2, "no %cells within 1048576 bytes"),
}
SECTION_FAULTS = {
    "section-name": ("%timeline", "%timelines", 23, "'%timelines' is no section; did you mean %timeline"),
    "section-space": ("%cells", "%cells ", 20, "'%cells ' is no section; did you mean %cells, alone"),
    "section-strange": ("%cells", "%\0\xff", 20, "is no section; known, in this order: %cells"),
    "order": ("%timeline", "%witness", 26, "a second %witness; each section comes once"),
    "cells-later": ("%cells", "%timeline", 20, "%timeline before %cells; the cells come first"),
    "cells-twice": ("%timeline", "%cells", 23, "a second %cells"),
    "no-end": ("%end\n", "", 28, "the file ends before %end"),
    "no-last-newline": ("%end\n", "%end", 29, "ends within the line %end; every line ends with LF"),
    "after-end": ("%end\n", "%end\n\n", 30, "1 bytes after %end; nothing follows it"),
    "two-worlds": ("%end\n", "%end\n" + GOOD, 30, "bytes after %end"),
    "no-rows": ("...\n...\n", "", 20, "%cells has no rows"),
    "short-row": ("...\n...\n", "...\n..\n", 22, "a row of 2 cells under a first row of 3"),
    "long-row": ("...\n...\n", "...\n....\n", 22, "a row of 4 cells under a first row of 3"),
    "uneven-but-divisible": ("...\n...\n", "...\n.\n.\n", 22, "a row of 1 cells under a first row of 3"),
    "empty-row": ("...\n...\n", "...\n\n...\n", 22, "an empty line in %cells"),
    "empty-first-row": ("...\n...\n", "\n...\n", 21, "an empty line in %cells"),
    "bad-cell": ("...\n...\n", "...\n.x.\n", 22, "'x' at column 2 is no cell; write # for solid"),
    "wide-letter": ("...\n...\n", "...\n.é.\n", 22, "'é' at column 2 is no cell"),
    "nul-cell": ("...\n...\n", "...\n.\0.\n", 22, r"'\x00' at column 2 is no cell"),
    "space": ("...\n...\n", "...\n... \n", 22, "' ' at column 4 is no cell"),
    "wide": ("...\n...\n", 20001 * "." + "\n", 21, "a row of 20001 cells; a side has at most 20000"),
    "high": ("...\n...\n", 20001 * ".\n", 20021, "more than 20000 rows"),
    "start-and-mark": ("...\n...\n", "...\n.S.\n", 22, "a cell is marked S, and the header has start"),
    "target-and-mark": ("...\n...\n", "...\n.G.\n", 22, "a cell is marked G, and the header has target"),
    "few-words": (
        "1.0 0 0 burning",
        "1.0 0 burning",
        24,
        "%timeline: '1.0 0 burning' is not `time ix iy state`",
    ),
    "two-spaces": ("1.0 0 0 burning", "1.0 0  0 burning", 24, "words with one space between them"),
    "empty-event": ("1.0 0 0 burning\n", "\n", 24, "%timeline: '' is not"),
    "state": (
        "0 burning",
        "0 burned",
        24,
        "state 'burned' is not one of free, solid, burning; did you mean 'burning'?",
    ),
    "time-word": ("1.0 0 0", "soon 0 0", 24, "time 'soon' is not a decimal number, 0 or more"),
    "time-negative": ("1.0 0 0", "-1.0 0 0", 24, "time '-1.0' is not a decimal number, 0 or more"),
    "time-inf": ("2.0 0 0", "inf 0 0", 25, "time 'inf' is not a decimal number"),
    "time-overflow": ("2.0 0 0", "1e999 0 0", 25, "time '1e999' is not a decimal number"),
    "time-falling": ("2.0 0 0", "0.5 0 0", 25, "time 0.5 comes after 1.0; sort the lines by time"),
    "index-float": ("1.0 0 0", "1.0 0.0 0", 24, "ix '0.0' is not a whole number, 0 or more"),
    "index-outside-x": ("2.0 0 0", "2.0 3 0", 25, "ix is 3; the grid has ix from 0 to 2"),
    "index-outside-y": ("2.0 0 0", "2.0 0 2", 25, "iy is 2; the grid has iy from 0 to 1"),
    "index-overflow": ("2.0 0 0", "2.0 9999999999999999999 0", 25, "ix '9999999999999999999' is not a whole"),
    "long-line": ("2.0 0 0", 5000 * "9" + " 0 0", 25, "is not `time ix iy state`"),
    "point-words": ("1.0 0.25 0.15", "1.0 0.25", 28, "'1.0 0.25' is not `time x y`"),
    "point-nan": ("1.0 0.25 0.15", "1.0 nan 0.15", 28, "x 'nan' is not a decimal number"),
    "point-overflow": ("0.0 0.05 0.15", "0.0 0.05 -1e400", 27, "y '-1e400' is not a decimal number"),
    "foreign-digits": ("0.0 0.05 0.15", "0.0 ٣ 0.15", 27, "x '٣' is not a decimal number"),
    "tab": ("0.0 0.05 0.15", "0.0\t0.05 0.15", 27, "words with one space between them"),
}


def complaint(data):
    with pytest.raises(FormatError) as caught:
        loads(data)
    return caught.value


def test_the_texts_that_are_spoilt_below_are_good():
    assert [loads(text.encode()).width for text in (GOOD, CUT, DRAWN)] == [3, 3, 3]


@pytest.mark.parametrize("name", [*HEADER_FAULTS, *SECTION_FAULTS])
def test_a_fault_has_its_line_and_its_message(name):
    old, new, line, message = (HEADER_FAULTS | SECTION_FAULTS)[name]
    count = -1 if name == "windows" else 1
    error = complaint(GOOD.replace(old, new, count).encode())
    assert (error.line, message in str(error.message)) == (line, True), str(error)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("1 -1", "1 -1 0", 28, "%cut: '1 -1 0' is not `ix iy`"),
        ("1 -1", "1 1.5", 28, "iy '1.5' is not a whole number"),
        ("1 -1", "-9999999999999999999 0", 28, "ix '-9999999999999999999' is not a whole number, of 64 bits"),
        ("%cut", "%timeline", 26, "a second %timeline"),
        ("%end", "%witness\n%end", 29, "%witness after %cut; the order is"),
    ],
    ids=["words", "float", "overflow", "timeline", "both"],
)
def test_a_fault_in_a_cut_has_its_line_and_its_message(old, new, line, message):
    error = complaint(CUT.replace(old, new, 1).encode())
    assert (error.line, message in str(error.message)) == (line, True), str(error)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("..G", "S.G", 6, "a second S; one cell is marked S: make the other one ."),
        ("S..", "SGG", 5, "a second G"),
        ("..G", "...", 4, "no target and no cell is marked G"),
        ("cell_size = 0.1", "cell_size = 1e308", 2, "the marked cell lies beyond the range of a float64"),
    ],
    ids=["two-starts", "two-targets", "no-target", "huge-cells"],
)
def test_a_fault_in_a_drawn_world_has_its_line_and_its_message(old, new, line, message):
    error = complaint(DRAWN.replace(old, new, 1).encode())
    assert (error.line, message in str(error.message)) == (line, True), str(error)


@pytest.mark.parametrize(
    ("data", "line", "message"),
    [
        (b"", 1, "the file is empty"),
        (b"\x1f\x8b\x08\0", 1, "this is gzip data; give the file a name that ends in .gz"),
        (b"\x89PNG\r\n\x1a\n", 1, "no .grid file"),
        (b"%worldgen-grid 1", 1, "the file ends after its first line"),
        (b"%worldgen-grid 1 \n", 1, "this program reads version 1"),
        (b"%worldgen-grid 1\nx = 1 # \xff\n%cells\n", 2, "byte 0xff is not UTF-8"),
        (GOOD.replace("...", ".\xff.", 1).encode("latin-1"), 21, "at column 2 is no cell"),
    ],
    ids=["empty", "gzip", "png", "one-line", "space", "not-utf8", "not-utf8-cells"],
)
def test_bytes_that_are_no_text_have_their_line_and_message(data, line, message):
    error = complaint(data)
    assert (error.line, message in str(error.message)) == (line, True), str(error)


def test_the_fault_in_the_last_of_many_lines_has_its_line():
    events = 200_000 * "0 0 0 free\n"  # more than one piece of the bulk reader
    error = complaint(GOOD.replace("1.0 0 0 burning\n", events + "0 0 9 free\n", 1).encode())
    assert error.line == 23 + 200_001


_LONG = 1_000_000
_SLOW_FOR_TOML = {
    "brackets": "a = " + _LONG * "[",
    "tables": "a = " + _LONG // 4 * "{a= ",
    "dotted key": "a" + _LONG // 2 * ".a" + " = 1",
    "dotted table": "[a" + _LONG // 2 * ".a" + "]",
    "quoted dotted key": _LONG // 4 * '"a".' + "a = 1",
    "digits": "a = 1" + _LONG * "0",
    "underscores": "a = 1" + _LONG // 2 * "_0",
    "quotes": _LONG * '"',
    "open strings": 'a = """' + _LONG // 4 * '"" ',
    "deep keys": "".join(f"a{20 * '.a'}.b{k} = 1\n" for k in range(15_000)),
    "many tables": "".join(f"[a{k}]\n" for k in range(90_000)),
}


_IN_LINEAR_TIME = {"quotes", "open strings", "deep keys", "many tables"}  # these tomllib may read


@pytest.mark.gate
@pytest.mark.parametrize("name", _SLOW_FOR_TOML)
def test_a_header_that_takes_tomllib_quadratic_time_is_refused_before_tomllib_reads_it(name, monkeypatch):
    read = []
    monkeypatch.setattr(tomllib, "loads", lambda text, loads=tomllib.loads: read.append(text) or loads(text))
    assert complaint(f"%worldgen-grid 1\n{_SLOW_FOR_TOML[name]}\n%cells\n.\n%end\n".encode()).line == 2
    assert bool(read) == (name in _IN_LINEAR_TIME)
