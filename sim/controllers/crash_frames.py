"""Find where a Python controller raised an exception: the frames of the user's code, in brief.

Frames name files without their folders, so that a failure reads the same in another checkout. They
quote the statement, which stays the same when other lines of its file move.
"""

from __future__ import annotations

import linecache
import sysconfig
from collections.abc import Iterator
from pathlib import Path, PurePath
from types import TracebackType

from worldgen.support.plain_text import shown
from worldgen.world import Value

MOST_FRAMES = 6
"""Number of frames to keep, counted from the innermost."""

# Characters of a statement that are kept.
_LONGEST_CODE = 160

# Folders that contain installed libraries; the second one is Debian's.
_INSTALLED = frozenset(("site-packages", "dist-packages"))
_OURS = Path(__file__).resolve().parents[2]
_OUR_PACKAGES = tuple(
    f"{_OURS / name}/" for name in ("sim", "fuzz", "worldgen", "worldgen_plugins")
)
_LIBRARIES = tuple(
    f"{Path(path).resolve()}/"
    for path in {
        sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")
    }
)


def crash_facts(error: BaseException, controller: object) -> dict[str, Value]:
    """Return the facts about a controller's fault in an exception's traceback.

    Args:
        error: The controller's exception.
        controller: The controller. Its file counts as the user's code wherever it is installed.

    Returns:
        ``at``, the innermost line of the controller's own file, and ``frames``, the innermost
        frames of the user's code, outermost first. A frame has ``file``, ``line``, ``function`` and
        ``code``, and ``repeat`` if an equal line precedes it in its function. Unknown facts are
        omitted.
    """
    act = getattr(controller, "act", None) or getattr(controller, "act_many", None)
    own_file = getattr(getattr(act, "__code__", None), "co_filename", "")

    # Source is read only for frames that are kept, so that a deep recursion costs little.
    calls = list(_calls(error))
    lines = [call.tb_lineno for call in calls if call.tb_frame.f_code.co_filename == own_file]
    of_the_user = [
        call
        for call in calls
        if (file := call.tb_frame.f_code.co_filename) == own_file or is_users_file(file)
    ]
    frames: list[Value] = [_frame(call) for call in _without_repetitions(of_the_user)]
    facts: dict[str, Value] = {"at": f"{Path(own_file).name}:{lines[-1]}"} if lines else {}
    return facts | ({"frames": frames} if frames else {})


def crash_text(error: BaseException) -> str:
    """Return an exception's type and message; the type alone if the message cannot be read."""
    name = type(error).__name__
    try:
        return f"{name}: {error}"
    except Exception:  # noqa: BLE001 - a controller's exception may raise anything
        return name


def _calls(error: BaseException) -> Iterator[TracebackType]:
    call = error.__traceback__
    while call is not None:
        yield call
        call = call.tb_next


def is_users_file(file: str) -> bool:
    """Return True if a file of code is neither ours nor an installed library's."""
    if file.startswith(("<frozen", *_OUR_PACKAGES, *_LIBRARIES)):
        return False
    return _INSTALLED.isdisjoint(PurePath(file).parts)


def _without_repetitions(calls: list[TracebackType]) -> list[TracebackType]:
    """Return the innermost calls; a line that calls its own function again counts once."""
    kept: list[TracebackType] = []
    for call in reversed(calls):
        if len(kept) == MOST_FRAMES:
            break
        if not kept or (call.tb_frame.f_code, call.tb_lineno) != (
            kept[-1].tb_frame.f_code,
            kept[-1].tb_lineno,
        ):
            kept.append(call)
    return kept[::-1]


def _frame(call: TracebackType) -> Value:
    code = call.tb_frame.f_code
    found: dict[str, Value] = {"file": shown(Path(code.co_filename).name), "line": call.tb_lineno}
    found["function"] = shown(code.co_name)
    return found | _statement(call)


def _statement(call: TracebackType) -> dict[str, Value]:
    """Return the failed statement on one line, and the number of equal lines before it."""
    code = call.tb_frame.f_code
    line = call.tb_lineno
    instruction = call.tb_lasti // 2

    # A call may span lines; the first line alone could not distinguish two `raise ValueError(`.
    positions = list(code.co_positions())
    last = positions[instruction][1] if 0 <= instruction < len(positions) else None
    linecache.checkcache(code.co_filename)
    source = linecache.getlines(code.co_filename)
    text = shown(
        " ".join(" ".join(source[line - 1 : min(max(last or line, line), line + 9)]).split())
    )
    if not text:
        return {}

    found: dict[str, Value] = {
        "code": text if len(text) <= _LONGEST_CODE else f"{text[:_LONGEST_CODE]}..."
    }
    begin = source[line - 1].strip()
    before = sum(other.strip() == begin for other in source[code.co_firstlineno - 1 : line - 1])
    return found | ({"repeat": before + 1} if before else {})
