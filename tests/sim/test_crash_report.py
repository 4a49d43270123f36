"""Parse the stderr of a crashed program:

reports of sanitizers, assertions, panics and tracebacks.
"""

from __future__ import annotations

import pytest

from sim.controllers.programs import crash_report
from sim.controllers.programs.crash_report import report_of

ADDRESS_SANITIZER = """\
pose 3 4
=================================================================
==4213==ERROR: AddressSanitizer: heap-buffer-overflow on address 0x602000000014 at pc 0x5581 bp 0x7ffc sp 0x7ffc
WRITE of size 1 at 0x602000000014 thread T0
    #0 0x7f12a1 in __interceptor_memcpy ../../../../src/libsanitizer/asan/memcpy.cpp:12
    #1 0x5581ab in act /home/ann/robot.c:11
    #2 0x5581cd in main /home/ann/robot.c:23
    #3 0x7f1234 in __libc_start_call_main ../sysdeps/nptl/libc_start_call_main.h:58
    #4 0x5581f0 in _start (/home/ann/robot+0x1180)

0x602000000014 is located 0 bytes to the right of 4-byte region
allocated by thread T0 here:
    #0 0x7f9c in __interceptor_malloc ../../../../src/libsanitizer/asan/asan_malloc_linux.cpp:69
    #1 0x5582 in plan /home/ann/robot.c:4

SUMMARY: AddressSanitizer: heap-buffer-overflow /home/ann/robot.c:11 in act
"""
RUST = """\
thread 'main' panicked at src/main.rs:12:9:
index out of bounds: the len is 3 but the index is 7
note: run with `RUST_BACKTRACE=1` environment variable to display a backtrace
"""
RUST_STACK = """\
thread 'main' (77) panicked at src/main.rs:12:9:
no plan
stack backtrace:
   0: rust_begin_unwind
             at /rustc/9fc6b/library/std/src/panicking.rs:647:5
   1: core::panicking::panic_fmt
             at /rustc/9fc6b/library/core/src/panicking.rs:72:14
   2: robot::act
             at ./src/main.rs:12:9
   3: robot::main
             at ./src/main.rs:30:5
"""
GO = """\
panic: runtime error: index out of range [7] with length 3

goroutine 1 [running]:
main.act(...)
\t/home/ann/robot.go:12
main.main()
\t/home/ann/robot.go:30 +0x1d
exit status 2
"""
PYTHON = """\
Traceback (most recent call last):
  File "/home/ann/robot.py", line 30, in <module>
    act(line)
  File "/home/ann/geometry.py", line 7, in gap
    return 1 / free
           ~~^~~~~~
  File "/usr/lib/python3.11/json/decoder.py", line 355, in raw_decode
    raise JSONDecodeError("no", s, 0)
json.decoder.JSONDecodeError: no: line 1 column 1 (char 0)
"""
NODE = """\
/home/ann/robot.js:2
    return o.missing.thing;
                     ^

TypeError: Cannot read properties of undefined (reading 'thing')
    at act (/home/ann/robot.js:2:52)
    at Interface.<anonymous> (/home/ann/robot.js:9:3)
    at Interface.emit (node:events:517:28)

Node.js v18.19.0
"""
JAVA = """\
Exception in thread "main" java.lang.ArrayIndexOutOfBoundsException: Index 4 out of bounds for length 4
\tat Robot.act(Robot.java:12)
\tat Robot.main(Robot.java:30)
"""


@pytest.mark.parametrize(
    ("said", "reason", "functions"),
    [
        pytest.param(
            ADDRESS_SANITIZER, "heap-buffer-overflow", ["main", "act"], id="address-sanitizer"
        ),
        pytest.param(
            "robot: src/robot.c:12: act: Assertion `gap > 0' failed.\n",
            "assertion",
            ["act"],
            id="glibc",
        ),
        pytest.param(
            "Assertion failed: (gap > 0), function act, file robot.c, line 12.\n",
            "assertion",
            ["act"],
            id="macos",
        ),
        pytest.param(
            "Assertion failed: gap > 0 (robot.c: act: 12)\n", "assertion", ["act"], id="musl"
        ),
        pytest.param(
            "robot: robot.cpp:12: int Robot::act(const Plan&): Assertion `gap > 0' failed.\n",
            "assertion",
            ["Robot::act"],
            id="c++",
        ),
        pytest.param(RUST, "panic", [None], id="rust"),
        pytest.param(RUST_STACK, "panic", ["robot::main", "robot::act"], id="rust-with-its-stack"),
        pytest.param(GO, "panic", ["main.main", "main.act"], id="go"),
        pytest.param(PYTHON, "JSONDecodeError", ["<module>", "gap"], id="python"),
        pytest.param(NODE, "TypeError", ["Interface.<anonymous>", "act"], id="node"),
        pytest.param(
            JAVA, "ArrayIndexOutOfBoundsException", ["Robot.main", "Robot.act"], id="java"
        ),
        pytest.param(
            "double free or corruption (out)\n",
            "double free or corruption (out)",
            [],
            id="allocator",
        ),
        pytest.param(
            "*** stack smashing detected ***: terminated\n",
            "stack smashing detected",
            [],
            id="stack",
        ),
        pytest.param(
            "robot.c:15:9: runtime error: division by zero\n",
            "division by zero",
            [None],
            id="undefined-behaviour",
        ),
        pytest.param(
            "terminate called after throwing an instance of 'std::out_of_range'\n  what():  no\n",
            "std::out_of_range",
            [],
            id="c++-exception",
        ),
    ],
)
def test_a_report_is_read_for_its_reason_and_the_innermost_own_functions(said, reason, functions):
    report = report_of(said)
    assert report["reason"] == reason
    assert [frame.get("function") for frame in report.get("frames", [])] == functions


def test_stderr_without_a_report_says_nothing():
    assert report_of("step 3\nturning left\nfatal: no plan\n") == {}


def test_a_frame_names_its_file_without_the_folder():
    assert {frame["file"] for frame in report_of(ADDRESS_SANITIZER)["frames"]} == {"robot.c"}


def test_the_innermost_frame_quotes_a_source_that_is_at_hand(tmp_path):
    (tmp_path / "robot.c").write_text("\n" * 10 + "    p[step] = 1;\n")
    said = ADDRESS_SANITIZER.replace("/home/ann", str(tmp_path))
    assert report_of(said, [tmp_path])["frames"][-1]["code"] == "p[step] = 1;"


def test_a_source_outside_the_program_s_folders_is_not_read(tmp_path):
    (tmp_path / "robot.c").write_text("\n" * 10 + "    p[step] = 1;\n")
    said = ADDRESS_SANITIZER.replace("/home/ann", str(tmp_path))
    assert "code" not in report_of(said, [tmp_path / "elsewhere"])["frames"][-1]


def test_no_line_that_is_read_is_long(monkeypatch):
    read = []
    monkeypatch.setattr(crash_report, "_sanitizer", lambda said: read.append(said) or {})
    report_of("a" * 65_536 + "\nshort\n" + "a:1: " * 13_000)
    assert [len(line) for line in read[0].split("\n")] == [1_000, 5, 1_000]


@pytest.mark.parametrize(
    "said",
    [
        pytest.param("a" * 65_536, id="one-word"),
        pytest.param("a:1: " * 13_000, id="one-line-of-places"),
        pytest.param(("a:1: " * 199 + "\n") * 65, id="lines-of-places"),
        pytest.param(("a:1: : Assertion `" * 55 + "\n") * 65, id="assertions-without-an-end"),
        pytest.param("9" * 65_536 + ":1: runtime error: ", id="one-number"),
    ],
)
def test_what_only_begins_like_a_report_says_nothing_or_no_more_than_a_reason(said):
    assert len(str(report_of(said))) < 2_000


def test_a_search_for_a_file_begins_only_where_a_name_can():
    places = (crash_report._UNDEFINED, crash_report._ASSERTIONS[0])
    assert all(pattern.search("x" * 50, 1) is None for pattern in places)
    assert crash_report._UNDEFINED.search("robot.c:15:9: runtime error: no", 1) is None


def test_a_long_line_is_read_at_both_its_ends():
    said = (
        f"robot: robot.cpp:12: int act({'const Plan&, ' * 1_000}int): Assertion `gap > 0' failed.\n"
    )
    assert report_of(said) == {
        "reason": "assertion",
        "frames": [{"file": "robot.cpp", "line": 12, "function": "act", "code": "gap > 0"}],
    }


def test_a_number_that_no_line_has_is_left_out():
    said = f"robot.c:{'1' * 5_000}:9: runtime error: division by zero\n"
    assert all("line" not in frame for frame in report_of(said).get("frames", []))
