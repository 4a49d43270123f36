"""A controller that is a separate program, in any language.

In each step it gets one line of JSON and answers with one. ``docs/reference/controllers.md``
specifies the protocol.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import shlex
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, BinaryIO

from sim.controllers.base import Command, Memory, Observation
from sim.controllers.controller_error import ControllerError
from sim.controllers.programs.batch import (
    Offer,
    batch_line,
    fill_commands,
    json_line,
    read_offer,
    reset_batch_line,
)
from sim.controllers.programs.program import (
    Program,
    ProgramLimits,
    find_program,
    invalid_answer,
    shown,
)
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.parameters import split_headed, split_options
from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Floats, Ints

PROTOCOL_VERSION = 1
PROGRAM_OPTIONS = ("deadline", "start", "memory")
"""Options that only a program has."""

_SIZE = re.compile(r"(?P<number>\d+)(?P<unit>[kMGT]?)")
_UNITS = {"": 1, "k": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}
# Bytes of a memory limit.
_LEAST_MEMORY = 1 << 20
_MOST_MEMORY = 1 << 62

# Seconds.
_LONGEST_DEADLINE = 3600.0
_EXAMPLE = "cmd:./mine --flag or cmd+deadline=0.2+memory=512M:./mine"
_KEYS = {"speed", "turn_rate", "used_random", "message"}


class ProcessController:
    """A controller that is a program.

    It reads observations and writes commands, each as a line of JSON. One process serves many
    episodes in turn. It is started when it is first needed, and again after each failure. It and
    everything that it started end with :meth:`close`, with this object, and with this process,
    however that ends. Two threads need two of these objects.

    Its memory is not visible, so a run that repeats forever is ``stalled`` or ``timeout``, never
    ``loop``. It may therefore read the clock at no further cost.

    Args:
        command: Program and arguments; they do not pass through a shell.
        deadline: Time for an answer, s; a program that exceeds it gets the verdict ``hang``.
        start_deadline: Time for the first answer of an episode, s, in which it may start up.
        memory_limit: Bytes of address space, or ``None`` for no limit; Linux only.

    Raises:
        InvalidParameter: If a limit is out of range, or the program does not exist.
    """

    senses = Observation._fields

    def __init__(
        self,
        command: Sequence[str],
        deadline: float = ProgramLimits.deadline,
        start_deadline: float = ProgramLimits.start_deadline,
        memory_limit: int | None = ProgramLimits.memory,
    ) -> None:
        if isinstance(command, str) or not command:
            raise InvalidParameter(
                "wrong-type",
                "command={command!r} must be a list of words, such as {example}",
                example='["./mine", "--flag"]',
                command=command,
            )
        for name, seconds in (("deadline", deadline), ("start_deadline", start_deadline)):
            check_between(name, seconds, 0.001, _LONGEST_DEADLINE, "s")
        if memory_limit is not None and not _LEAST_MEMORY <= memory_limit <= _MOST_MEMORY:
            raise InvalidParameter(
                "out-of-range",
                "memory_limit={memory_limit} is outside {least} to 2**62 bytes, or None",
                memory_limit=memory_limit,
                least=_LEAST_MEMORY,
            )
        self.command = tuple(command)
        self.limits = ProgramLimits(deadline, start_deadline, memory_limit)
        find_program(self.command)
        self._program: Program | None = None
        self._owner = 0
        self._stop: Callable[[], object] = _nothing
        # True if the next observation is the first of its episode.
        self._first = True
        # True if the program has answered before.
        self._served = False
        # The line that begins a batch.
        self._batch_reset = b""
        # The program's latest offer to drive many robots, from the first answer of an episode.
        self.offer: Offer | None = None
        self._transcript: BinaryIO | None = None

    @classmethod
    def of(cls, name: str) -> ProcessController:
        """Return the controller named ``cmd:PROGRAM ARGUMENTS``.

        Before the colon the name may have ``+deadline=`` (s), ``+start=`` (s) or ``+memory=``.

        Raises:
            InvalidParameter: If the name is not in this form, or the program does not exist.
        """
        parts = split_headed(name, "cmd")
        if parts is None:
            raise InvalidParameter(
                "not-a-command",
                "controller {name!r} is not a command",
                "write {example}",
                name=name,
                example=_EXAMPLE,
            )
        settings: dict[str, Any] = {}
        head, command = parts
        _, options = split_options(head, "cmd+deadline=0.2:./mine")
        for key, value in options.items():
            if key in ("deadline", "start"):
                settings["deadline" if key == "deadline" else "start_deadline"] = _seconds(
                    key, value or ""
                )
            elif key == "memory":
                settings["memory_limit"] = _bytes(value or "")
            else:
                known = f"{', '.join(PROGRAM_OPTIONS)} and the run's"
                raise InvalidParameter(
                    "unknown-name",
                    "controller {name!r}: there is no option {key!r}; the options are {known}",
                    "write {example}",
                    name=name,
                    key=key,
                    known=known,
                    example=_EXAMPLE,
                )
        return cls(_words(name, command), **settings)

    def __repr__(self) -> str:
        return f"ProcessController({list(self.command)!r})"

    def __enter__(self) -> ProcessController:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def another(self) -> ProcessController:
        """Return a controller that runs the same command in its own process."""
        limits = self.limits
        return ProcessController(
            self.command, limits.deadline, limits.start_deadline, limits.memory
        )

    def close(self) -> None:
        """End the program; the next episode starts it again."""
        self._stop()
        self._program = None
        self._stop = _nothing

    def start(self) -> None:
        """Make sure that the program runs and has no unread output.

        Raises:
            InvalidParameter: If it cannot be started.
        """
        if self._program is None or self._owner != os.getpid() or not self._program.is_ready:
            self._start()

    @contextlib.contextmanager
    def transcript(self, out: BinaryIO) -> Iterator[None]:
        """Write each line that the program is sent to a file, for the duration of the block.

        Only the lines of the last episode are kept. Fed to the program's stdin, they repeat the
        episode: ``gdb ./mine``, then ``run < transcript.jsonl``.

        Args:
            out: A file that can be truncated.
        """
        self._transcript = out
        try:
            yield
        finally:
            self._transcript = None
            out.flush()

    def reset(self) -> Memory:
        """Begin an episode; the program learns of it from the first observation."""
        self._first = True
        return ()

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Ask the program for a command.

        Raises:
            ControllerError: If it crashes, hangs, or answers with anything but a command.
        """
        try:
            return self._command_after(observation), memory
        except ControllerError as found:
            if found.verdict == Verdict.CRASH and observation.bump:
                found.evidence = replace(found.evidence, bump=True)
            raise

    def _command_after(self, observation: Observation) -> Command:
        """Send an observation, after the reset line if it is the first, and return the answer."""
        line = observation_line(observation)
        if not self._first:
            self._write_down(line)
            return self._ask(line, self.limits.deadline)

        # An episode begins: the transcript starts over, and the program may take time to start up.
        self.start()
        lines = _reset_line(observation) + line
        self._first = False
        if self._transcript is not None:
            self._transcript.seek(0)
            self._transcript.truncate()
        self._write_down(lines)
        served = self._served
        self._served = True
        try:
            return self._ask(lines, self.limits.start_deadline, is_first=True)
        except ControllerError as found:
            if not served or found.verdict != Verdict.CRASH:
                raise
        # It may serve a single episode and then end.
        # Starting it again shows whether it really crashes.
        self._start()
        self._served = True
        return self._ask(lines, self.limits.start_deadline, is_first=True)

    def _write_down(self, lines: bytes) -> None:
        if self._transcript is not None:
            self._transcript.write(lines)

    def _start(self) -> Program:
        if self._owner == os.getpid():  # A forked process must leave its parent's program alone.
            self.close()
        program = Program(self.command, self.limits.memory)
        self._program = program
        self._owner = os.getpid()
        self._served = False
        self._stop = weakref.finalize(self, _stop_own, program, self._owner)
        return program

    def _ask(self, lines: bytes, seconds: float, *, is_first: bool = False) -> Command:
        program = self._program or self._start()
        answer = program.ask(lines, seconds)
        try:
            if not is_first:
                return read_command(answer)
            command, self.offer = read_answer(answer)
            return command
        except ControllerError as found:
            raise program.ended_by(found) from None

    def begin_batch(self, robots: int) -> None:
        """Begin to drive many robots; the program learns of it from the first observations.

        Args:
            robots: The largest number of robots; they are numbered from 0.
        """
        self.start()
        self._first = True
        self._batch_reset = reset_batch_line(PROTOCOL_VERSION, robots)

    def act_in_batch(
        self, offer: Offer, robots: Ints, fresh: Ints, seen: Floats, command: Floats
    ) -> None:
        """Ask the program for the commands of some robots of the batch.

        Args:
            offer: The program's offer.
            robots: (n,) numbers of the robots.
            fresh: Numbers of the robots that begin an episode.
            seen: (n, OBS_SIZE + beams + OBS_TAIL) the robots' observations.
            command: (n, CMD_SIZE), filled in.

        Raises:
            ControllerError: If it crashes, hangs, or answers with anything but commands.
        """
        program = self._program or self._start()
        lines = batch_line(offer, robots, fresh, seen)
        seconds = self.limits.deadline
        if self._first:
            lines = self._batch_reset + lines
            seconds = self.limits.start_deadline
            self._first = False
            self._served = True
        answer = program.ask(lines, seconds)
        try:
            fill_commands(answer, command)
        except ControllerError as found:
            raise program.ended_by(found) from None


def is_process_name(name: str) -> bool:
    """Return True if a controller's name is a command."""
    return name.startswith(("cmd:", "cmd+"))


def observation_line(observation: Observation) -> bytes:
    """Return an observation as a line of JSON."""
    values = observation._asdict()
    # A robot that does not sense others, whose goal has no heading or whose floor is level gets
    # lines in the original form.
    neighbours = values.pop("neighbours")
    if neighbours:
        values["neighbours"] = [one._asdict() for one in neighbours]
    if math.isnan(observation.goal_heading):
        del values["goal_heading"]
    if observation.tilt == 0.0:
        del values["tilt"], values["tilt_heading"]
    return json_line(values)


def _reset_line(observation: Observation) -> bytes:
    reset = {name: getattr(observation, name) for name in ("time_step", "top_speed", "radius")}
    return json_line({"worldgen": PROTOCOL_VERSION, "reset": reset})


def read_command(answer: bytes) -> Command:
    """Read an answer.

    Raises:
        ControllerError: If it is not a command.
    """
    return _command(_object(answer), answer)


def read_answer(answer: bytes) -> tuple[Command, Offer | None]:
    """Read the first answer of an episode, which may offer to drive many robots.

    Raises:
        ControllerError: If it is not a command, or the offer is not valid.
    """
    found = _object(answer)
    offer = read_offer(found.pop("batch"), answer) if "batch" in found else None
    return _command(found, answer), offer


def _object(answer: bytes) -> dict[str, Any]:
    try:
        found = json.loads(answer.decode())
    except (ValueError, RecursionError):
        raise invalid_answer("not JSON", answer, "not") from None
    if not isinstance(found, dict):
        raise invalid_answer("no object", answer)
    return found


def _command(found: dict[str, Any], answer: bytes) -> Command:
    for key in ("speed", "turn_rate"):
        if key not in found:
            raise invalid_answer(f"no {key}", answer)
    if len(found) > 2 and not found.keys() <= _KEYS:
        unknown = sorted(found.keys() - _KEYS)[0]
        name = shown(unknown.encode("utf-8", "replace"))
        raise invalid_answer(f"unknown key {name!r}", answer, "unknown-key")
    used_random = found.get("used_random", False)
    if not isinstance(used_random, bool):
        raise invalid_answer("used_random is neither true nor false", answer)
    speed = _number(found, "speed", answer)
    turn_rate = _number(found, "turn_rate", answer)
    return Command(speed, turn_rate, used_random, _message(found, answer))


def _message(found: dict[str, Any], answer: bytes) -> tuple[float, ...]:
    """Return the numbers to send to the neighbours; empty if the answer has none."""
    message = found.get("message", [])
    if not isinstance(message, list):
        raise invalid_answer("message is not a list of numbers", answer)
    return tuple(_number({"message": one}, "message", answer) for one in message)


def _number(found: dict[str, Any], key: str, answer: bytes) -> float:
    value = found[key]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise invalid_answer(f"{key} is not a number", answer)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise invalid_answer(f"{key} is not finite", answer)
    return number


def _words(name: str, command: str) -> list[str]:
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise InvalidParameter(
            "invalid-quoting",
            "controller {name!r}: {reason}",
            "quote it as for a shell",
            name=name,
            reason=str(error),
        ) from error
    if not words:
        raise InvalidParameter(
            "no-program-named",
            "controller {name!r} names no program",
            "write {example}",
            name=name,
            example=_EXAMPLE,
        )
    return words


def _seconds(key: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InvalidParameter(
            "not-a-number",
            "{key}={text!r} is not a number",
            "write seconds, such as 0.2",
            key=key,
            text=text,
        ) from None


def _bytes(text: str) -> int | None:
    parts = _SIZE.fullmatch(text)
    if parts is None and text != "none":
        raise InvalidParameter(
            "not-a-size",
            "memory={text!r} is not a size",
            "write it as in 512M or 4G, or none for no limit",
            text=text,
        )
    return int(parts["number"]) * _UNITS[parts["unit"]] if parts else None


def _stop_own(program: Program, owner: int) -> None:
    if owner == os.getpid():
        program.stop()


def _nothing() -> None:
    """Do nothing; used while no program runs."""
