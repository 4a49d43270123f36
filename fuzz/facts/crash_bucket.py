"""Buckets of crashes: decide which crashes are the same.

Two crashes are the same if the same statement of the user's code raised the same type of exception
and was called from the same function. Line numbers do not count, because they change with every
edit above them. The text of the statement does count, so that two faults in one function stay
separate. A program shows no frames, so its report on stderr is used instead. If a program reports
nothing, only its exit status and the place of the run can be compared.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import PurePath

from sim.evidence import FaultEvidence
from worldgen.world import Value

FACTS = ("reason", "message", "frames", "bump")
"""Evidence that only buckets and people use.

A replay does not compare it, and files written by older versions lack it.
"""

NAMED = ("exception", "exit_code", "signal", "rule")
"""Evidence that names a fault; files written by older versions lack it as well."""

_FRAMES = 2  # the innermost frames: the function that raised, and its caller
_LONGEST_WORD = 40
_DIGITS = 4  # hex digits that identify the statement
_CHOSEN_SIGNALS = ("SIGABRT", "SIGTRAP")  # a program sends them to itself
_NAME = re.compile(r"\w+")


def has_facts(evidence: FaultEvidence) -> bool:
    """Return True if a crash's evidence is detailed enough to compare it with another's."""
    return any(getattr(evidence, name) is not None for name in FACTS)


def crash_bucket(evidence: FaultEvidence) -> str:
    """Return a readable name for a crash, usable as a file name; equal for equal crashes.

    Args:
        evidence: Evidence of a run with verdict ``crash``.
    """
    ended = _how_it_ended(evidence)
    frames = _frames(evidence)
    reason = evidence.reason or ""
    message = evidence.message or ""
    of_a_program = evidence.exception is None
    # Which function overflows the stack depends on the order of calls, so ignore the order.
    if ended == "RecursionError":
        return _joined(ended, *_names(sorted(frames, key=_name)))
    words = [ended, _word(_plain(reason).partition(": ")[0]), *_names(frames)]
    if of_a_program and not frames and not reason:
        words += _of_last_line(evidence)
    words.append(_digest(reason, message, frames))
    if of_a_program and not frames:
        words += _where_it_stood(evidence)
    return _joined(*words)


def _how_it_ended(evidence: FaultEvidence) -> str:
    """Return the exception's name, or how a program ended; empty if neither is known."""
    if evidence.exit_code is not None:
        return f"exit-{evidence.exit_code}"
    name = evidence.exception or evidence.signal or ""
    return name if _NAME.fullmatch(name) else ""


def _of_last_line(evidence: FaultEvidence) -> list[str]:
    """Return a program's last words, if it ended by itself.

    Otherwise a signal interrupted it, and its last line is arbitrary. If that line begins with the
    name of an exception, only the name is used.
    """
    chose_to_end = evidence.exit_code is not None or evidence.signal in _CHOSEN_SIGNALS
    if not evidence.stderr or not chose_to_end:
        return []
    last = evidence.stderr[-1]
    kind = re.match(r"(\w*(?:Error|Exception))\b", last)
    return [kind[1] if kind else _word(_plain(last))]


def _where_it_stood(evidence: FaultEvidence) -> list[str]:
    """Return ``first`` if the run ended in step one, and ``bump`` if it then touched a wall."""
    first = ["first"] if evidence.step == 1 else []
    return first + (["bump"] if evidence.bump else [])


def _frames(evidence: FaultEvidence) -> list[Mapping[str, Value]]:
    """Return the innermost frames; a function that calls itself counts once."""
    kept: list[Mapping[str, Value]] = []
    for frame in evidence.frames or ():
        if kept and _name(kept[-1]) == _name(frame):
            kept.pop()
        kept.append(frame)
    return kept[-_FRAMES:]


def _name(frame: Mapping[str, Value]) -> str:
    """Return a frame's name, such as ``mine.act``.

    If neither function nor statement is known, the line is used, although edits change it.
    """
    file = PurePath(str(frame.get("file", ""))).stem
    inside = frame.get("function", "" if "code" in frame else frame.get("line", ""))
    return ".".join(_word(str(part)) for part in (file, inside) if part)


def _names(frames: list[Mapping[str, Value]]) -> list[str]:
    """Return the frames' names, without repeating a file's name."""
    names: list[str] = []
    before = ""
    for frame in frames:
        file, _, inside = _name(frame).partition(".")
        names.append(inside if inside and file == before else _name(frame))
        before = file
    return names


def _digest(reason: str, message: str, frames: list[Mapping[str, Value]]) -> str:
    """Return a few digits that distinguish statements in one function.

    Empty if nothing is known about them.
    """
    statement = (
        " ".join(str(frames[-1][key]) for key in ("code", "repeat") if key in frames[-1])
        if frames
        else ""
    )
    parts = [statement, _plain(message), _plain(reason) if ": " in reason and not statement else ""]
    text = "\n".join(part for part in parts if part)
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:_DIGITS] if text else ""


def _plain(text: str) -> str:
    """Return a text without the parts that differ between runs: addresses, numbers, folders."""
    text = re.sub(r"0x[0-9a-fA-F]+", "", text)
    text = re.sub(r"(?:/[^\s/:]+)+/", "", text)
    return re.sub(r"[-+]?(?:\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|\b(?:nan|inf(?:inity)?)\b)", "", text)


def _word(text: str) -> str:
    """Return the part of a text that can be used in a file name."""
    return re.sub(r"[^A-Za-z0-9_]+", "-", text)[:_LONGEST_WORD].strip("-_")


def _joined(*words: str) -> str:
    return "-".join(word for word in words if word)
