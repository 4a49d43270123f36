"""Read what a program reports on stderr when it dies.

It understands reports of sanitizers, assertions, panics and tracebacks. Two facts are taken from a
report: what went wrong, and the innermost frames of the program's own code. Addresses, process
numbers and folders are dropped, because they differ between runs and machines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path, PurePath

from worldgen.support.plain_text import shown
from worldgen.world import Value

# Number of frames to keep, counted from the innermost.
_MOST_FRAMES = 6

# Characters of a reason or a statement.
_LONGEST = 160

# Bytes; a larger source file is not searched for a frame's line.
_LARGEST_SOURCE = 4 << 20

# Number of characters to read at both ends of a long line; the rest is dropped.
_LINE_BEGIN = 700
_LINE_END = 300

# Digits of a line's number.
_LONGEST_NUMBER = 9

# A program may write anything, so every pattern must take time at most proportional to the text.
# Therefore a file's name is searched for only where one can begin, and white space before a frame
# ends with its line.
_SANITIZER = re.compile(r"(?:ERROR|WARNING): \w+Sanitizer: ?([\w-]+(?: [\w-]+)?)")
_UNDEFINED = re.compile(
    r"(?<![^\s:])(?P<file>[^\s:]+):(?P<line>\d+):\d+: runtime error: (?P<reason>.*)"
)
_SANITIZER_FRAME = re.compile(
    r"\s*#\d+ 0x[0-9a-f]+ (?:in (?P<function>.+?) )?"
    r"(?:(?P<file>[^\s()]+?):(?P<line>\d+)(?::\d+)?|\((?P<object>\S+)\+0x.*)$"
)
_RUNTIME_FRAME = re.compile(
    r"__(?:asan|tsan|msan|ubsan|lsan|sanitizer|interceptor)|(?:lib(?:sanitizer|asan|tsan|ubsan|lsan)\b)|compiler-rt"
    r"|sysdeps/|libc-start|csu/"
)
_ASSERTIONS = (
    re.compile(  # glibc
        r"^(?=.*: Assertion [`'].*' failed\.?$).*?(?<![^\s:])(?P<file>[^\s:]+):(?P<line>\d+): "
        r"(?P<function>.+)"
        r": Assertion [`'](?P<code>.*)' failed\.?$",
        re.MULTILINE,
    ),
    re.compile(  # macOS
        r"^Assertion failed: \((?P<code>.*)\), function (?P<function>.+), file (?P<file>.+), line "
        r"(?P<line>\d+)\.?$",
        re.MULTILINE,
    ),
    re.compile(
        r"^Assertion failed: (?P<code>.*) \((?P<file>[^\s:]+): (?P<function>\w+): (?P<line>\d+)\)$",
        re.MULTILINE,
    ),
)
_ALLOCATOR = re.compile(
    r"^(?:\*\*\* )?(?P<reason>(?:\w+\(\): [\w<>()., /-]+)|double free or "
    r"corruption[^:\n]*|corrupted [\w .<>-]+"
    r"|stack smashing detected|buffer overflow detected)(?: \*\*\*.*)?$",
    re.MULTILINE,
)
_THROWN = re.compile(
    r"terminate called after throwing an instance of "
    r"'(?P<reason>[^'\n]+)'(?:\s+what\(\):\s*(?P<code>.*))?"
)
_RUST = re.compile(
    r"thread '[^'\n]*'(?: \(\d+\))? panicked at (?:'(?P<old>.*?)', )?"
    r"(?P<file>[^\s:]+):(?P<line>\d+):\d+:?(?:\n(?P<new>.*))?"
)
_RUST_FRAME = re.compile(
    r"^[ \t]*\d+: (?P<function>\S+)\n\s+at (?P<file>\S+?):(?P<line>\d+)(?::\d+)?$", re.MULTILINE
)
_RUST_LIBRARY = re.compile(
    r"/rustc/|/library/(?:std|core|alloc)/|^(?:std|core|alloc|rust_begin_unwind)\b|<"
)
_GO = re.compile(r"^(?:panic|fatal error): (?P<reason>.*)$", re.MULTILINE)
_GO_FRAME = re.compile(
    r"^(?P<function>[\w./*()-]+)\(.*\)\n\s+(?P<file>\S+\.go):(?P<line>\d+)", re.MULTILINE
)
_PYTHON_FRAME = re.compile(
    r'^  File "(?P<file>[^"\n]+)", line (?P<line>\d+)(?:, in (?P<function>\S+))?(?:\n    (?! '
    r"*[\^~])(?P<code>.*))?$",
    re.MULTILINE,
)
_PYTHON_END = re.compile(r"^(?P<reason>[A-Za-z_][\w.]*)(?::.*)?$", re.MULTILINE)
_PYTHON_LIBRARY = re.compile(
    r"^<frozen|/(?:site|dist)-packages/|/lib/python3[^/]*/|/sim/(?:host|controllers/\w+)\.py$"
)
_SCRIPT = re.compile(
    r"^(?:Uncaught |Exception in thread \"[^\"]*\" "
    r")?(?P<reason>[\w.$]*(?:Error|Exception)\b)[^\n]*\n(?=\s+at )",
    re.MULTILINE,
)
_SCRIPT_FRAME = re.compile(
    r"^[ \t]+at (?:(?:async |new )?(?P<function>[\w.$<>]+) "
    r"?\()?(?P<file>[^\s()]+?):(?P<line>\d+)(?::\d+)?\)?$",
    re.MULTILINE,
)
_SCRIPT_LIBRARY = re.compile(r"^(?:node:|internal/)|/node_modules/")


def report_of(said: str, sources: Iterable[Path] = ()) -> dict[str, Value]:
    """Return the facts about a program's death in its stderr.

    Args:
        said: The end of its stderr, without control sequences.
        sources: Folders in or below which the program's source may be. The line of a frame found
            there is quoted.

    Returns:
        ``reason``, such as ``heap-buffer-overflow`` or ``ZeroDivisionError``, and ``frames``, as in
        :func:`sim.controllers.crash_frames.crash_facts`; empty if no known report is found.
    """
    # Specific reports come first: a program under a sanitizer, for example, may also print the
    # allocator's message.
    said = "\n".join(map(_without_its_middle, said.split("\n")))
    for reader in (
        _sanitizer,
        _assertion,
        _thrown,
        _rust,
        _go,
        _python,
        _script,
        _allocator,
        _undefined,
    ):
        found = reader(said)
        if found:
            return _with_code(found, said, tuple(sources))
    return {}


def _without_its_middle(line: str) -> str:
    """Drop the middle of a very long line; a report is at its two ends."""
    return line if len(line) <= _LINE_BEGIN + _LINE_END else line[:_LINE_BEGIN] + line[-_LINE_END:]


def _with_code(report: dict[str, Value], said: str, folders: tuple[Path, ...]) -> dict[str, Value]:
    """Quote the line of the innermost frame, so that two faults in one function differ."""
    frames = report.get("frames")
    frame = frames[-1] if isinstance(frames, list) else None
    if not isinstance(frame, dict) or "code" in frame or not {"file", "line"} <= frame.keys():
        return report
    name = str(frame["file"])
    line = int(str(frame["line"]))
    # The report has the file's path as it was compiled; look for it below each folder.
    written = re.search(rf"(?<![^\s()\"'])[^\s()\"']*{re.escape(name)}(?=:{line}\b)", said)
    for folder in folders if written else ():
        source = (folder / written[0]).resolve() if written else folder
        if source.is_relative_to(folder.resolve()) and (text := _line_of(source, line)):
            frame["code"] = _short(text)
            break
    return report


def _line_of(source: Path, line: int) -> str:
    try:
        if not source.is_file() or source.stat().st_size > _LARGEST_SOURCE:
            return ""
        lines = source.read_text("utf-8", "replace").splitlines()
    except OSError:
        return ""
    return shown(lines[line - 1].strip()) if 0 < line <= len(lines) else ""


def _sanitizer(said: str) -> dict[str, Value]:
    found = _SANITIZER.search(said)
    if found is None:
        return {}
    words = found[1].split(" ")
    reason = words[0] if words[0] not in ("data", "detected", "attempting") else "-".join(words)

    # Only the first stack shows where it happened; later ones show where memory was allocated and
    # freed.
    frames = []
    begun = False
    for line in said[found.end() :].splitlines():
        frame = _SANITIZER_FRAME.match(line)
        if frame is None and begun:
            break
        begun = begun or frame is not None
        if (
            frame is not None
            and not _RUNTIME_FRAME.search(line)
            and (frame["file"] or _has_a_name(frame))
        ):
            frames.append(_frame(frame["file"] or "", frame["line"], frame["function"]))
    return _report(reason, frames[::-1])


def _has_a_name(frame: re.Match[str]) -> bool:
    """Return True if a frame without a source file is the program's own, not a library's."""
    return (
        bool(frame["function"])
        and not re.search(r"\.so\b|\.dylib\b", frame["object"] or "")
        and (frame["function"] != "_start")
    )


def _undefined(said: str) -> dict[str, Value]:
    reports = list(_UNDEFINED.finditer(said))
    if not reports:
        return {}
    last = reports[-1]  # A program may continue after the other kinds of report.
    return _report(last["reason"], [_frame(last["file"], last["line"])])


def _assertion(said: str) -> dict[str, Value]:
    for pattern in _ASSERTIONS:
        found = pattern.search(said)
        if found:
            frame = _frame(found["file"], found["line"], found["function"], found["code"])
            return _report("assertion", [frame])
    return {}


def _thrown(said: str) -> dict[str, Value]:
    found = _THROWN.search(said)
    if found is None:
        return {}
    report = _report(found["reason"], [])
    return report | ({"message": _short(found["code"])} if found["code"] else {})


def _allocator(said: str) -> dict[str, Value]:
    found = _ALLOCATOR.search(said)
    return _report(found["reason"], []) if found else {}


def _rust(said: str) -> dict[str, Value]:
    found = _RUST.search(said)
    if found is None:
        return {}
    frames = [
        _frame(frame["file"], frame["line"], frame["function"])
        for frame in _RUST_FRAME.finditer(said, found.end())
        if not (_RUST_LIBRARY.search(frame["file"]) or _RUST_LIBRARY.search(frame["function"]))
    ]
    report = _report("panic", frames[::-1] or [_frame(found["file"], found["line"])])
    return report | {"message": _short(found["old"] or found["new"] or "")}


def _go(said: str) -> dict[str, Value]:
    found = _GO.search(said)
    if found is None or "goroutine" not in said:
        return {}
    stack = said[found.end() :].partition("\ngoroutine ")[2].partition("\n\n")[0]
    frames = [
        _frame(frame["file"], frame["line"], frame["function"])
        for frame in _GO_FRAME.finditer(stack)
        if not re.search(r"/src/(?:runtime|internal)/", frame["file"])
        and frame["function"] != "panic"
    ]
    return _report("panic", frames[::-1]) | {"message": _short(found["reason"])}


def _python(said: str) -> dict[str, Value]:
    whole = said.rpartition("Traceback (most recent call last):\n")[2]
    calls = list(_PYTHON_FRAME.finditer(whole))
    end = _PYTHON_END.search(whole, calls[-1].end()) if calls else None
    if end is None:
        return {}
    frames = [
        _frame(call["file"], call["line"], call["function"], call["code"])
        for call in calls
        if not _PYTHON_LIBRARY.search(call["file"])
    ]
    return _report(end["reason"].rpartition(".")[2], frames)


def _script(said: str) -> dict[str, Value]:
    """Read the stack of a JavaScript or Java program, whose innermost frame comes first."""
    found = _SCRIPT.search(said)
    if found is None:
        return {}
    stack = said[found.end() :].partition("\n\n")[0]
    frames = [
        _frame(frame["file"], frame["line"], frame["function"])
        for frame in _SCRIPT_FRAME.finditer(stack)
        if not _SCRIPT_LIBRARY.search(frame["file"])
    ]
    return _report(found["reason"].rpartition(".")[2], frames[::-1])


def _report(reason: str, frames: list[Value]) -> dict[str, Value]:
    report: dict[str, Value] = {"reason": _short(reason)}
    if frames:
        report["frames"] = frames[-_MOST_FRAMES:]
    return report


def _frame(
    file: str, line: str | None, function: str | None = None, code: str | None = None
) -> Value:
    found: dict[str, Value] = {"file": PurePath(file).name} if file else {}
    if line and len(line) <= _LONGEST_NUMBER:
        found["line"] = int(line)
    if function:
        found["function"] = _short(_without_arguments(function))
    if code:
        found["code"] = _short(code)
    return found


def _without_arguments(function: str) -> str:
    """Shorten a C++ signature: ``Command Robot::act(const Observation&)`` to ``Robot::act``."""
    name = function.partition("(")[0].strip() or function
    return name.split(" ")[-1]


def _short(text: str) -> str:
    plain = " ".join(text.split())
    return plain if len(plain) <= _LONGEST else f"{plain[:_LONGEST]}..."
