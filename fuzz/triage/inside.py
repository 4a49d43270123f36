"""Show what runs inside a Python controller in the part of its run that goes wrong.

The moves say what the robot does. The lines that run there, and the values of its state, say which
decision of the controller does it.
"""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple

from fuzz.failure import Failure
from fuzz.triage.repeated_moves import last_part
from sim.controllers.base import Observation
from sim.episode import Episode
from sim.episode.watched import StateValues, WatchedPart, watched_part
from worldgen.plugins.counted_code import CodeFunction
from worldgen.support.plain_text import rounded_angle, shown


class CodeLine(NamedTuple):
    """A line of a controller's file.

    Args:
        number: Its number; 0 for a gap between lines.
        times: How often it ran in the part; ``None`` for a line that does not run by itself.
        text: Its text.
    """

    number: int
    times: int | None
    text: str


# Lines of an excerpt, to fit on a screen, and characters of a line.
_MOST_LINES = 50
_LONGEST_LINE = 120

# Lines that are kept at both ends of a block that is cut.
_KEPT = 2

# Parts of the state that are described one by one.
_MOST_STATE = 10

_GAP = CodeLine(0, None, "...")

_PARAMETERS = frozenset(f"observation.{name}" for name in ("time_step", "top_speed", "radius"))

# Methods that only run before the first step.
_AT_THE_START = frozenset(("reset", "__init__", "__post_init__"))


@dataclass(frozen=True)
class Inside:
    """What ran inside a controller in the last part of its run.

    Args:
        file: Name of its file, without folders.
        part: The part of the run, in words.
        lines: The functions that ran in it, cut to fit on a screen.
        unused: Functions that did not run in it.
        reads: The fields of the observation that the functions read that ran in it.
        state: What its attributes, its memory and the senses that it reads did, as pairs of a name
            and words.
    """

    file: str
    part: str
    lines: list[CodeLine] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)
    reads: list[str] = field(default_factory=list)
    state: list[tuple[str, str]] = field(default_factory=list)

    def text(self) -> list[str]:
        """Return the lines for the terminal."""
        found = []
        if self.state:
            found.append(f"its state and what it senses in {self.part}:")
            found += [f"  {name} {words}" for name, words in self.state]
        found.append(f"lines of {self.file} in {self.part}, and how often each runs:")
        for number, times, text in self.lines:
            often = "" if times is None else f"{times:,} x" if times else "never"
            found.append(f"{often:>10} {number or '':>5} | {text}".rstrip())
        if self.unused:
            found.append(f"never runs there: {', '.join(self.unused)}")
        if self.reads:
            found.append(f"reads there, of what it senses: {', '.join(self.reads)}")
        return [shown(line) for line in found]


def inside(failure: Failure, episode: Episode) -> Inside | None:
    """Return what ran inside a failure's controller in the part of its run that goes wrong.

    This runs the controller again.

    Args:
        failure: The failure.
        episode: Its run, recorded.

    Returns:
        The lines and the state; ``None`` where :func:`watched` returns ``None``.

    Raises:
        OutOfTime: If there is no more time.
    """
    found = watched(failure, episode)
    return None if found is None else described(found, episode)


def watched(failure: Failure, episode: Episode) -> WatchedPart | None:
    """Run a failure's controller again, and watch it in the part of its run that goes wrong.

    ``None`` for several robots, for a controller without lines in Python, and for one that does not
    do the same again.

    Raises:
        OutOfTime: If there is no more time.
    """
    part = last_part(episode)
    if part is None or failure.world.is_fleet:
        return None
    found = watched_part(
        failure.world, failure.record.controller, failure.options, episode, part.first
    )
    return None if found is None or not any(found.counts) else found


def described(found: WatchedPart, episode: Episode) -> Inside:
    """Return what ran inside a controller, for people.

    Args:
        found: What ran.
        episode: The run, recorded.
    """
    part = last_part(episode)
    assert part is not None, "it was watched in this part"
    ran = [one for one in found.code.functions if _runs(one, found)]
    names = Counter(one.name for one in found.code.functions)
    return Inside(
        file=shown(found.code.file.name),
        part=part.words,
        lines=_excerpt(found, ran),
        unused=[
            # Several classes of a file have an ``act``.
            one.name if names[one.name] == 1 else f"{one.name} (line {one.first})"
            for one in found.code.functions
            if one not in ran and one.name not in _AT_THE_START
        ],
        reads=[name for name in Observation._fields if any(name in one.fields for one in ran)],
        state=_state(found, part.first),
    )


def reads_there(found: WatchedPart, name: str) -> bool:
    """Return True if the lines that run in the part read a number of the state."""
    return _is_read(name, _read(found))


def _read(found: WatchedPart) -> frozenset[str]:
    return frozenset[str]().union(
        *(found.code.reads[line] for line in found.code.statements if found.counts[line])
    )


def _runs(function: CodeFunction, found: WatchedPart) -> bool:
    return any(found.counts[function.first : function.last + 1])


def _excerpt(found: WatchedPart, functions: list[CodeFunction]) -> list[CodeLine]:
    """Return the lines of functions and the constants that they read, cut to fit on a screen."""
    lines = _lines(found, functions, has_comments=True)
    if len(lines) > _MOST_LINES:
        lines = _lines(found, functions, has_comments=False)
    # Long blocks that never run say the least, and then functions that decide nothing there.
    if len(lines) > _MOST_LINES:
        lines = _without_middles(lines, unused_only=True)
    if len(lines) > _MOST_LINES:
        deciding = [one for one in functions if _decides(one, found)]
        lines = _lines(found, deciding or functions, has_comments=False)
        lines = _without_middles(lines, unused_only=True)
    if len(lines) > _MOST_LINES:
        lines = _without_middles(lines, unused_only=False)
    if len(lines) > _MOST_LINES:
        lines = [*lines[: _MOST_LINES - 1], _GAP]
    return lines


def _decides(function: CodeFunction, found: WatchedPart) -> bool:
    """Return True if some statements of a function run more often than others."""
    own = {
        found.counts[first]
        for first in found.code.statements
        if function.body <= first <= function.last
    }
    return len(own) > 1


def _lines(
    found: WatchedPart, functions: list[CodeFunction], *, has_comments: bool
) -> list[CodeLine]:
    """Return the lines of functions, without their docstrings, and the constants that they read."""
    # Choose the lines.
    numbers: set[int] = set()
    for one in functions:
        numbers.update((one.first, *range(one.body, one.last + 1)))
        names = one.names & found.code.constants.keys()
        numbers.update(found.code.constants[name] for name in names)
    # A statement's count holds for all of its lines.
    counts: dict[int, int] = {}
    for first, own in sorted(found.code.statements.items()):
        counts.update(dict.fromkeys(own, found.counts[first]))

    # Show them in order, and mark each gap.
    lines: list[CodeLine] = []
    is_gap = False
    for number, line in enumerate(found.code.source, start=1):
        text = shown(line.expandtabs(4))[:_LONGEST_LINE]
        is_code = bool(text.strip()) and not text.lstrip().startswith("#")
        if number not in numbers:
            is_gap |= is_code
        elif is_code or has_comments:
            if is_gap and lines:
                lines.append(_GAP)
            is_gap = False
            lines.append(CodeLine(number, counts.get(number) if is_code else None, text))
    return lines


def _without_middles(lines: list[CodeLine], *, unused_only: bool) -> list[CodeLine]:
    """Return lines without the middle of long blocks that never run, or that all run alike."""
    found: list[CodeLine] = []
    for times, block in itertools.groupby(lines, key=lambda line: line.times):
        own = list(block)
        is_long = times is not None and len(own) > 2 * _KEPT + 1
        if is_long and not (unused_only and times):
            own = [*own[:_KEPT], _GAP, *own[-_KEPT:]]
        found.extend(own)
    return found


def _state(found: WatchedPart, first: int) -> list[tuple[str, str]]:
    """Return what the state did, that which probably decides first; then the senses.

    What the lines read that run in the part comes before what they don't read, and what changed
    last just before the part comes before what had settled long ago.
    """
    fixed = [one for one in found.state if one.is_constant and not one.since]
    read = _read(found)
    others = sorted(
        (one for one in found.state if not (one.is_constant and not one.since)),
        key=lambda one: (not _is_read(one.name, read), abs(one.since - first)),
    )
    words = [
        (
            one.name,
            f"is {one.values[0]} since step {one.since:,}" if one.is_constant else _change(one),
        )
        for one in others[:_MOST_STATE]
    ]
    if len(others) > _MOST_STATE:
        words.append(("and", f"{len(others) - _MOST_STATE} more that change"))
    if fixed:
        same = ", ".join(f"{one.name} = {one.values[0]}" for one in fixed[:_MOST_STATE])
        words.append(("the same in the whole run:", same))
    # Numbers of the robot and of the run are the same in every step of every run.
    sensed = [one for one in found.senses if one.name not in _PARAMETERS]
    words += [(one.name, _change(one)) for one in sensed if not one.is_constant][:_MOST_STATE]
    settled = [
        f"{one.name} = {one.values[0]}{f' {one.unit}' if one.unit else ''}"
        for one in sensed
        if one.is_constant
    ]
    if settled:
        words.append(("the same in each of these steps:", ", ".join(settled)))
    return words


def _is_read(name: str, read: frozenset[str]) -> bool:
    """Return True if the statements that run read a part of the state."""
    # ``self.filter.gain`` is read as ``gain``, ``side (memory)`` as ``side``.
    own = name.removeprefix("len(").removesuffix(")").removesuffix(" (memory")
    if own.endswith("']"):
        return own[own.index("[") :] in read
    if own.startswith("memory["):
        return own in read or any(one.startswith("memory[") and ":" in one for one in read)
    # ``self.pose[0]`` is read as ``pose``.
    return own.rpartition(".")[2].partition("[")[0] in read


def _change(values: StateValues) -> str:
    """Return how a value changes: ``takes -1, 1``, ``only rises, from 3 to 51``."""
    unit = f" {values.unit}" if values.unit else ""
    if not values.has_many_values:
        return f"takes {', '.join(values.values)}{unit}"
    if values.low is None or values.high is None:
        return "changes"
    low, high = (
        rounded_angle(value)
        if values.unit == "degrees"
        else f"{value:.4g}"
        if isinstance(value, float)
        else f"{value:,}"
        for value in (values.low, values.high)
    )
    if values.only_rises:
        return f"only rises, from {low} to {high}{unit}"
    if values.only_falls:
        return f"only falls, from {high} to {low}{unit}"
    return f"varies from {low} to {high}{unit}"
