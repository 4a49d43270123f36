"""Errors as the page receives them: code, facts, the problem in words, and a remedy.

The library's remedies are written for users of the command line. The page has fields and buttons
instead of options, so it has its own remedies for some codes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from fuzz.studio.requests.protocol import Refusal, encoded
from worldgen.errors import Message, Note, WorldgenError
from worldgen.support.plain_text import quote
from worldgen.world import Value

_ANOTHER_FOLDER = "choose another folder"

REMEDIES: Mapping[str, str] = {
    "ambiguous-format": "choose it in Import options",
    "another-campaign": f"select it above and resume it, or {_ANOTHER_FOLDER}",
    "campaign-is-further": f"use {{units}} units or more, or {_ANOTHER_FOLDER}",
    "first-steps-too-slow": (
        "allow more seconds, or run it as a program, whose steps have a deadline"
    ),
    "file-exists": "overwrite it, or choose another name",
    "folder-holds-worlds": _ANOTHER_FOLDER,
    "invalid-campaign": _ANOTHER_FOLDER,
    "strategy-needs-keep-going": "choose another motion model than stepped+keep_going, or another "
    "family",
    "motion-for-one-robot": "choose the motion model swept or endpoint",
    "many-posts": "export as sdf, which has fewer, larger boxes",
    "motion-is-the-thesis-robots": "choose the motion model swept or endpoint for other "
    "controllers",
    "no-campaign": "start one with Begin",
    "ambiguous-layer": "choose one in Import options, layer",
    "layer-missing": "choose one in Import options, layer",
    "no-map-found": "add the .map file to this one",
    "no-scale": "set another Cell size, under World",
    "noise-filtered": "export as thesis filters the signal again",
    "not-a-micromouse-maze": "Generate makes mazes of any size",
    "no-failure": "open it on the page Play, and choose a controller there",
    "not-native": "choose the motion model swept or endpoint",
    "only-written": "open the file that it was made from, or choose another format in Options of "
    "the import",
    "option-without-effect": "choose the motion model {where}, or omit the option",
    "run-too-long": "use fewer steps",
    "scenario-beside-used": "use Seed of places to get other places",
    "signal-unknown": "the walls and target are kept, and an export as thesis will write the "
    "plain map",
    "signal-everywhere": "run it without that signal, or with the motion model swept",
    "step-too-long": "use a shorter time step",
    "step-too-short": "use a longer time step",
    "takes-no-number": "write {name}",
    "too-many-digits": "set the origin to 0,0 under Format options",
    "unknown-format": "choose one of the formats listed in Import options",
    "world-changes": "set the time to 0 under Format options for the cells at that time, or "
    "choose another format",
    "wrong-suffix": "use the suffix .png, or write a .yaml with a .pgm by exporting as ros",
}
"""The page's remedies by code, in place of those that need a terminal.

Each is a template that is filled with the error's facts.
"""

IMPORT_OPTIONS = frozenset(
    {"ambiguous-format", "ambiguous-layer", "layer-missing", "only-written", "unknown-format"}
)
"""Codes whose remedy is in the options of the import, which the page then opens."""

_FIELDS = {"--vary": "Vary"}  # options that can appear in facts, with the names of their fields
_LONGEST = 2_000  # characters of a fact; longer ones are quotes from a file


def refusal(error: WorldgenError | Message, folder: Path | None = None) -> Refusal:
    """Return an error as the page expects it.

    Args:
        error: The library's error.
        folder: The opened folder; paths in it are shown relative to it.
    """
    message = hide(error if isinstance(error, Message) else error.message, folder)
    own = REMEDIES.get(message.code) if message.at_terminal else None
    source = getattr(error, "source", None)
    return Refusal(
        code=message.code,
        problem="; ".join([message.problem, *map(describe_note, getattr(error, "notes", ()))]),
        remedy=message.remedy if own is None else message.word(own),
        terminal=message.at_terminal and own is None,
        opens="import" if message.code in IMPORT_OPTIONS else "",
        facts={name: _json(value) for name, value in message.facts.items()},
        frames=frames_of(error) if isinstance(error, WorldgenError) else [],
        line=getattr(error, "line", None),
        source=None if source is None else _hidden(source, folder),
    )


def frames_of(error: BaseException) -> list[dict[str, Value]]:
    """Return the place where the user's code failed, if that caused an error.

    Args:
        error: An error that was raised from the exception of the user's code.

    Returns:
        The innermost frames of the user's code, outermost first, each with ``file``, ``line`` and
        perhaps ``function`` and ``code``.
    """
    cause = error.__cause__
    if cause is None:
        return []
    from sim.controllers.crash_frames import crash_facts  # noqa: PLC0415 - loads the simulator

    found = crash_facts(cause, None).get("frames", [])
    frames = (
        [dict(one) for one in found if isinstance(one, dict)] if isinstance(found, list) else []
    )
    # Code that does not compile has no frame.
    if isinstance(cause, SyntaxError) and cause.filename and cause.lineno:
        place: dict[str, Value] = {"file": Path(cause.filename).name, "line": cause.lineno}
        frames.append(place | ({"code": cause.text.strip()} if cause.text else {}))
    return frames


def describe_note(note: str) -> str:
    """Return a note of an import or an export with a remedy that the page offers."""
    if not isinstance(note, Note):
        return note
    words = refusal(note.message)
    return "; ".join(filter(None, (words.problem, words.remedy))) + (
        " (at a terminal)" if words.terminal else ""
    )


def our_fault(error: Exception) -> Message:
    """Return the message for an error that no input should cause."""
    return Message(
        "our-fault",
        "internal error, not caused by your input: {kind}: {said}",
        kind=type(error).__name__,
        said=str(error),
    )


def hide(message: Message, folder: Path | None) -> Message:
    """Return a message whose facts contain no paths outside the opened folder.

    Paths inside become relative to it.
    """
    facts = {name: _hidden(value, folder) for name, value in message.facts.items()}
    if "option" in facts:
        facts["option"] = _FIELDS.get(facts["option"], facts["option"])
    return message.replaced(facts)


def _hidden(value: Any, folder: Path | None) -> Any:
    if isinstance(value, list | tuple):
        return [_hidden(item, folder) for item in value]
    if not isinstance(value, str):
        return value
    root = None if folder is None or str(folder) == folder.anchor else str(folder)
    if root is not None and value == root:
        return "the opened folder"
    if root is not None:
        value = value.removeprefix(f"{root}{os.sep}")
    return value if len(value) <= _LONGEST else f"{value[:_LONGEST]}..."


def _json(value: Any) -> Any:
    """Return a fact that a browser can read: no infinity, and only JSON's types."""
    try:
        return msgspec.json.decode(encoded(value))
    except (TypeError, ValueError, RecursionError):
        return quote(value)
