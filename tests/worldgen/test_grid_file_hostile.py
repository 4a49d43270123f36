"""Invalid files: each gets one message, with the line, the value and the remedy."""

import pytest

from tests.helpers.raising import check_says
from worldgen.errors import FormatError
from worldgen.files.grid import loads

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
CUT = GOOD.replace('"witness"', '"cut"').replace(
    "%witness\n0.0 0.05 0.15\n1.0 0.25 0.15\n", "%cut\n1 1\n1 -1\n"
)
DRAWN = "%worldgen-grid 1\ncell_size = 0.1\nrobot_radius = 0.04\n%cells\nS..\n..G\n%end\n"

# name: (old, new, line, part of the message)
HEADER_FAULTS = {
    "magic": ("%worldgen-grid 1", "hello", 1, {"code": "not-a-grid", "came": "hello"}),
    "version": ("%worldgen-grid 1", "%worldgen-grid 3", 1, {"code": "other-version"}),
    "bom": ("%worldgen-grid 1", "\ufeff%worldgen-grid 1", 1, {"code": "byte-order-mark"}),
    "only-magic": (GOOD[17:], "", 1, {"code": "cut-short"}),
    "windows": ("\n", "\r\n", 1, {"code": "carriage-return"}),
    "one-cr": ("seed = 7", "seed = 7\r", 9, {"code": "carriage-return"}),
    "no-cells": (GOOD[GOOD.index("%cells") :], "", 19, {"code": "cut-short"}),
    "not-toml": (
        "cell_size = 0.1",
        "cell_size: 0.1",
        2,
        {"code": "not-toml", "noun": "the header", "column": 10},
    ),
    "nul": ("cell_size = 0.1", "cell_size = 0.1 # \0", 2, {"code": "not-toml"}),
    "twice": ("robot_radius = 0.07", "cell_size = 0.07", 3, {"code": "not-toml"}),
    "table-twice": ("[failure]", "[provenance]", 14, {"code": "not-toml"}),
    "open-string": ('family = "maze"', 'family = "maze', 7, {"code": "not-toml"}),
    "open-long-string": ('family = "maze"', 'family = """maze', 7, {"code": "not-toml"}),
    "percent-in-string": ('family = "maze"', 'family = """\n%"""', 7, {"code": "not-toml"}),
    "unknown": (
        "robot_radius =",
        "robot_radios =",
        3,
        {"code": "unknown-name", "name": "robot_radios", "near": "robot_radius"},
    ),
    "unknown-table": (
        "[failure]",
        "[failures]",
        14,
        {"code": "unknown-name", "name": "failures", "near": "failure"},
    ),
    "unknown-in-table": (
        "family =",
        "famly =",
        7,
        {"code": "unknown-name", "name": "famly", "what": "key in [provenance]", "near": "family"},
    ),
    "misplaced": (
        "version = 1",
        "robot_speed = 1",
        8,
        {"code": "wrong-place", "key": "robot_speed"},
    ),
    "no-cell-size": ("cell_size = 0.1\n", "", 19, {"code": "missing-key", "key": "cell_size"}),
    "no-radius": ("robot_radius = 0.07\n", "", 19, {"code": "missing-key", "key": "robot_radius"}),
    "no-start": (
        "start = [0.05, 0.15, 0.0]\n",
        "",
        19,
        {"code": "missing-key", "key": "start", "letter": "S"},
    ),
    "no-target": (
        "target = [0.25, 0.15, 0.05]\n",
        "",
        19,
        {"code": "missing-key", "key": "target", "letter": "G"},
    ),
    "text-size": (
        "cell_size = 0.1",
        'cell_size = "0.1"',
        2,
        {"code": "wrong-type", "what": "cell_size", "kind": "text"},
    ),
    "true-size": (
        "cell_size = 0.1",
        "cell_size = true",
        2,
        {"code": "wrong-type", "what": "cell_size", "kind": "true or false"},
    ),
    "date-size": (
        "cell_size = 0.1",
        "cell_size = 2025-01-01",
        2,
        {"code": "wrong-type", "what": "cell_size", "kind": "a date or time"},
    ),
    "zero-size": (
        "cell_size = 0.1",
        "cell_size = 0",
        2,
        {"code": "not-positive", "what": "cell_size"},
    ),
    "huge-cells": (
        "cell_size = 0.1",
        "cell_size = 1e7",
        2,
        {"code": "out-of-range", "name": "cell_size"},
    ),
    "tiny-radius": (
        "radius = 0.07",
        "radius = 1e-8",
        3,
        {"code": "out-of-range", "name": "robot_radius"},
    ),
    "huge-target": (
        "0.15, 0.05]",
        "0.15, 3e3]",
        5,
        {"code": "out-of-range", "name": "target radius"},
    ),
    "negative-radius": (
        "radius = 0.07",
        "radius = -1",
        3,
        {"code": "not-positive", "what": "robot_radius"},
    ),
    "nan": ("cell_size = 0.1", "cell_size = nan", 2, {"code": "not-finite", "what": "cell_size"}),
    "overflow": (
        "cell_size = 0.1",
        "cell_size = 1e999",
        2,
        {"code": "not-finite", "what": "cell_size"},
    ),
    "huge-integer": ("cell_size = 0.1", "cell_size = 1" + 400 * "0", 2, {"code": "not-finite"}),
    "short-start": (
        "[0.05, 0.15, 0.0]",
        "[0.05, 0.15]",
        4,
        {"code": "wrong-type", "what": "start", "kind": "a list of 2"},
    ),
    "start-text": (
        "[0.05, 0.15, 0.0]",
        '[0.05, "a", 0]',
        4,
        {"code": "wrong-type", "what": "start[1]", "kind": "text"},
    ),
    "start-number": (
        "[0.05, 0.15, 0.0]",
        "0.05",
        4,
        {"code": "wrong-type", "what": "start", "kind": "a number"},
    ),
    "start-outside": (
        "[0.05, 0.15, 0.0]",
        "[0.05, 0.25, 0.0]",
        4,
        {"code": "outside-grid", "name": "start", "height": 0.2},
    ),
    "target-outside": (
        "[0.25, 0.15,",
        "[-0.1, 0.15,",
        5,
        {"code": "outside-grid", "name": "target"},
    ),
    "heading-inf": ("0.15, 0.0]", "0.15, inf]", 4, {"code": "not-finite", "what": "start[2]"}),
    "target-radius": ("0.15, 0.05]", "0.15, 0]", 5, {"code": "not-positive"}),
    "provenance-number": (
        "[provenance]",
        "provenance = 1\n[failure.x]",
        6,
        {"code": "wrong-type", "key": "provenance", "kind": "an integer"},
    ),
    "provenance-list": (
        "[provenance]",
        "[[provenance]]",
        6,
        {"code": "wrong-type", "key": "provenance", "kind": "a list"},
    ),
    "no-family": (
        'family = "maze"\n',
        "",
        6,
        {"code": "missing-key", "key": "family", "place": "[provenance]"},
    ),
    "family-number": (
        'family = "maze"',
        "family = 1",
        7,
        {"code": "wrong-type", "what": "provenance.family", "kind": "an integer"},
    ),
    "version-float": (
        "version = 1",
        "version = 1.0",
        8,
        {"code": "wrong-type", "what": "provenance.version", "kind": "a number"},
    ),
    "seed-bool": (
        "seed = 7",
        "seed = true",
        9,
        {"code": "wrong-type", "what": "provenance.seed", "kind": "true or false"},
    ),
    "seed-huge": (
        "seed = 7",
        "seed = 1" + 400 * "0",
        9,
        {"code": "wrong-type", "what": "provenance.seed", "kind": "an integer out of range"},
    ),
    "params-list": (
        "{ size = 3 }",
        "[]",
        10,
        {"code": "wrong-type", "what": "provenance.params", "kind": "a list"},
    ),
    "params-date": (
        "{ size = 3 }",
        "{ a = [2025-01-01] }",
        10,
        {"code": "wrong-type", "what": "provenance.params.a", "kind": "a date or time"},
    ),
    "params-inf": (
        "{ size = 3 }",
        "{ a = { b = -inf } }",
        10,
        {"code": "not-finite", "what": "provenance.params.a.b"},
    ),
    "params-lines": (
        "{ size = 3 }",
        "{ a = [\n1,\n# b = 2\n07:00:00] }",
        10,
        {"code": "wrong-type", "what": "provenance.params.a"},
    ),
    "params-dotted": (
        "params = { size = 3 }",
        "params.'a b'.c = nan",
        10,
        {"code": "not-finite", "what": "provenance.params.a b.c"},
    ),
    "params-table": (
        "params = { size = 3 }",
        '[provenance.params] # x\n\n"k" = inf',
        12,
        {"code": "not-finite", "what": "provenance.params.k"},
    ),
    "params-huge": ("size = 3", "size = 0x1" + 256 * "0", 10, {"code": "too-large", "most": 1024}),
    "kind": ('kind = "witness"', 'kind = "proof"', 12, {"code": "unknown-name", "came": "'proof'"}),
    "kind-list": ('kind = "witness"', "kind = []", 12, {"code": "unknown-name", "came": "a list"}),
    "no-clearance": (
        "clearance = 0.1\n",
        "",
        11,
        {"code": "missing-key", "key": "clearance", "place": "[certificate]"},
    ),
    "clearance-inf": (
        "clearance = 0.1",
        "clearance = inf",
        13,
        {"code": "not-finite", "what": "certificate.clearance"},
    ),
    "no-verdict": (
        'verdict = "loop"\n',
        "",
        14,
        {"code": "missing-key", "key": "verdict", "place": "[failure]"},
    ),
    "verdict-number": (
        'verdict = "loop"',
        "verdict = 1",
        18,
        {"code": "wrong-type", "what": "failure.verdict", "kind": "an integer"},
    ),
    "kind-without-section": ('"witness"', '"cut"', 26, {"code": "conflict", "kind": "witness"}),
    "section-without-kind": (
        GOOD[GOOD.index("[cert") : GOOD.index("[fail")],
        "",
        23,
        {"code": "conflict"},
    ),
    "kind-missing-section": (
        GOOD[GOOD.index("%wit") : GOOD.index("%end")],
        "",
        12,
        {"code": "missing-section", "kind": "witness"},
    ),
    "brackets": ("{ size = 3 }", 40 * "[", 10, {"code": "nested-too-deep", "most": 32}),
    "dots": ("cell_size", "a" + 40 * ".a", 2, {"code": "nested-too-deep", "most": 32}),
    "values-deep": (
        "{ size = 3 }",
        "{ a." + 30 * "b." + "c = { d = [] } }",
        10,
        {"code": "nested-too-deep", "most": 32},
    ),
    "long-number": (
        "0.1\n",
        "0." + 3000 * "1" + "\n",
        2,
        {"code": "too-large", "characters": 3000, "most": 2000},
    ),
    "long-header": (
        "cell_size",
        "#" + (1 << 20) * "x" + "\ncell_size",
        2,
        {"code": "cut-short", "most": 1048576},
    ),
}
SECTION_FAULTS = {
    "section-name": (
        "%timeline",
        "%timelines",
        23,
        {"code": "unknown-name", "name": "%timelines", "near": "timeline"},
    ),
    "section-space": (
        "%cells",
        "%cells ",
        20,
        {"code": "unknown-name", "name": "%cells ", "near": "cells"},
    ),
    "section-strange": ("%cells", "%\0\xff", 20, {"code": "unknown-name", "name": "%\u0000ÿ"}),
    "order": ("%timeline", "%witness", 26, {"code": "twice", "section": "%witness"}),
    "cells-later": ("%cells", "%timeline", 20, {"code": "wrong-order", "section": "%timeline"}),
    "cells-twice": ("%timeline", "%cells", 23, {"code": "twice", "section": "%cells"}),
    "no-end": ("%end\n", "", 28, {"code": "cut-short"}),
    "no-last-newline": ("%end\n", "%end", 29, {"code": "cut-short", "section": "%end"}),
    "after-end": ("%end\n", "%end\n\n", 30, {"code": "after-end", "extra": 1}),
    "two-worlds": ("%end\n", "%end\n" + GOOD, 30, {"code": "after-end"}),
    "no-rows": ("...\n...\n", "", 20, {"code": "empty"}),
    "short-row": ("...\n...\n", "...\n..\n", 22, {"code": "ragged-rows", "cells": 2, "width": 3}),
    "long-row": ("...\n...\n", "...\n....\n", 22, {"code": "ragged-rows", "cells": 4, "width": 3}),
    "uneven-but-divisible": (
        "...\n...\n",
        "...\n.\n.\n",
        22,
        {"code": "ragged-rows", "cells": 1, "width": 3},
    ),
    "empty-row": ("...\n...\n", "...\n\n...\n", 22, {"code": "empty"}),
    "empty-first-row": ("...\n...\n", "\n...\n", 21, {"code": "empty"}),
    "bad-cell": (
        "...\n...\n",
        "...\n.x.\n",
        22,
        {"code": "unknown-sign", "sign": "x", "column": 2, "solid": "#"},
    ),
    "wide-letter": (
        "...\n...\n",
        "...\n.é.\n",
        22,
        {"code": "unknown-sign", "sign": "é", "column": 2},
    ),
    "nul-cell": ("...\n...\n", "...\n.\0.\n", 22, {"code": "unknown-sign", "column": 2}),
    "space": ("...\n...\n", "...\n... \n", 22, {"code": "unknown-sign", "sign": " ", "column": 4}),
    "wide": (
        "...\n...\n",
        20001 * "." + "\n",
        21,
        {"code": "too-large", "cells": 20001, "most": 20000},
    ),
    "high": ("...\n...\n", 20001 * ".\n", 20021, {"code": "too-large", "most": 20000}),
    "start-and-mark": (
        "...\n...\n",
        "...\n.S.\n",
        22,
        {"code": "conflict", "key": "start", "letter": "S"},
    ),
    "target-and-mark": (
        "...\n...\n",
        "...\n.G.\n",
        22,
        {"code": "conflict", "key": "target", "letter": "G"},
    ),
    "few-words": (
        "1.0 0 0 burning",
        "1.0 0 burning",
        24,
        {"code": "wrong-form", "section": "timeline", "came": "1.0 0 burning"},
    ),
    "two-spaces": ("1.0 0 0 burning", "1.0 0  0 burning", 24, {"code": "wrong-form"}),
    "empty-event": ("1.0 0 0 burning\n", "\n", 24, {"code": "wrong-form", "section": "timeline"}),
    "state": (
        "0 burning",
        "0 burned",
        24,
        {"code": "wrong-form", "field": "state", "word": "burned", "near": "burning"},
    ),
    "time-word": (
        "1.0 0 0",
        "soon 0 0",
        24,
        {"code": "wrong-form", "field": "time", "word": "soon"},
    ),
    "time-negative": (
        "1.0 0 0",
        "-1.0 0 0",
        24,
        {"code": "wrong-form", "field": "time", "word": "-1.0"},
    ),
    "time-inf": ("2.0 0 0", "inf 0 0", 25, {"code": "wrong-form", "field": "time", "word": "inf"}),
    "time-late": ("2.0 0 0", "1.1e9 0 0", 25, {"code": "out-of-range", "name": "time"}),
    "time-overflow": (
        "2.0 0 0",
        "1e999 0 0",
        25,
        {"code": "wrong-form", "field": "time", "word": "1e999"},
    ),
    "time-falling": ("2.0 0 0", "0.5 0 0", 25, {"code": "not-sorted", "time": 0.5}),
    "index-float": (
        "1.0 0 0",
        "1.0 0.0 0",
        24,
        {"code": "wrong-form", "field": "ix", "word": "0.0"},
    ),
    "index-outside-x": (
        "2.0 0 0",
        "2.0 3 0",
        25,
        {"code": "out-of-range", "name": "ix", "index": 3, "last": 2},
    ),
    "index-outside-y": (
        "2.0 0 0",
        "2.0 0 2",
        25,
        {"code": "out-of-range", "name": "iy", "index": 2, "last": 1},
    ),
    "index-overflow": (
        "2.0 0 0",
        "2.0 9999999999999999999 0",
        25,
        {"code": "wrong-form", "field": "ix", "word": "9999999999999999999"},
    ),
    "long-line": ("2.0 0 0", 5000 * "9" + " 0 0", 25, {"code": "wrong-form"}),
    "point-words": ("1.0 0.25 0.15", "1.0 0.25", 28, {"code": "wrong-form", "came": "1.0 0.25"}),
    "point-nan": (
        "1.0 0.25 0.15",
        "1.0 nan 0.15",
        28,
        {"code": "wrong-form", "field": "x", "word": "nan"},
    ),
    "point-overflow": (
        "0.0 0.05 0.15",
        "0.0 0.05 -1e400",
        27,
        {"code": "wrong-form", "field": "y", "word": "-1e400"},
    ),
    "foreign-digits": (
        "0.0 0.05 0.15",
        "0.0 ٣ 0.15",
        27,
        {"code": "wrong-form", "field": "x", "word": "٣"},
    ),
    "tab": ("0.0 0.05 0.15", "0.0\t0.05 0.15", 27, {"code": "wrong-form"}),
}


def complaint(data):
    with pytest.raises(FormatError) as caught:
        loads(data)
    return caught.value


def test_the_texts_that_are_spoilt_below_are_good():
    assert [loads(text.encode()).width for text in (GOOD, CUT, DRAWN)] == [3, 3, 3]


@pytest.mark.parametrize("name", [*HEADER_FAULTS, *SECTION_FAULTS])
def test_a_fault_has_its_line_and_its_message(name):
    old, new, line, expected = (HEADER_FAULTS | SECTION_FAULTS)[name]
    count = -1 if name == "windows" else 1
    error = complaint(GOOD.replace(old, new, count).encode())
    assert error.line == line, str(error)
    check_says(error, **expected)


@pytest.mark.parametrize(
    ("old", "new", "line", "expected"),
    [
        ("1 -1", "1 -1 0", 28, {"code": "wrong-form", "section": "cut", "came": "1 -1 0"}),
        ("1 -1", "1 1.5", 28, {"code": "wrong-form", "field": "iy", "word": "1.5"}),
        (
            "1 -1",
            "-9999999999999999999 0",
            28,
            {"code": "wrong-form", "field": "ix", "word": "-9999999999999999999"},
        ),
        ("%cut", "%timeline", 26, {"code": "twice", "section": "%timeline"}),
        (
            "%end",
            "%witness\n%end",
            29,
            {"code": "wrong-order", "section": "%witness", "previous": "cut"},
        ),
    ],
    ids=["words", "float", "overflow", "timeline", "both"],
)
def test_a_fault_in_a_cut_has_its_line_and_its_message(old, new, line, expected):
    error = complaint(CUT.replace(old, new, 1).encode())
    assert error.line == line, str(error)
    check_says(error, **expected)


@pytest.mark.parametrize(
    ("old", "new", "line", "expected"),
    [
        ("..G", "S.G", 6, {"code": "twice", "letter": "S", "free": "."}),
        ("S..", "SGG", 5, {"code": "twice", "letter": "G"}),
        ("..G", "...", 4, {"code": "missing-key", "key": "target", "letter": "G"}),
        ("cell_size = 0.1", "cell_size = 1e308", 2, {"code": "out-of-range", "name": "cell_size"}),
    ],
    ids=["two-starts", "two-targets", "no-target", "huge-cells"],
)
def test_a_fault_in_a_drawn_world_has_its_line_and_its_message(old, new, line, expected):
    error = complaint(DRAWN.replace(old, new, 1).encode())
    assert error.line == line, str(error)
    check_says(error, **expected)


@pytest.mark.parametrize(
    ("data", "line", "expected"),
    [
        (b"", 1, {"code": "empty"}),
        (b"\x1f\x8b\x08\0", 1, {"code": "packed-file"}),
        (b"\x89PNG\r\n\x1a\n", 1, {"code": "not-a-grid"}),
        (b"%worldgen-grid 1", 1, {"code": "cut-short"}),
        (b"%worldgen-grid 1 \n", 1, {"code": "other-version"}),
        (b"%worldgen-grid 1\nx = 1 # \xff\n%cells\n", 2, {"code": "not-utf8"}),
        (
            GOOD.replace("...", ".\xff.", 1).encode("latin-1"),
            21,
            {"code": "unknown-sign", "column": 2},
        ),
    ],
    ids=["empty", "gzip", "png", "one-line", "space", "not-utf8", "not-utf8-cells"],
)
def test_bytes_that_are_no_text_have_their_line_and_message(data, line, expected):
    error = complaint(data)
    assert error.line == line, str(error)
    check_says(error, **expected)


def test_the_fault_in_the_last_of_many_lines_has_its_line():
    events = 200_000 * "0 0 0 free\n"  # more than one piece of the bulk reader
    error = complaint(GOOD.replace("1.0 0 0 burning\n", events + "0 0 9 free\n", 1).encode())
    assert error.line == 23 + 200_001
