"""A running program that answers line by line: start it, ask it with a deadline, and end it."""

from __future__ import annotations

import contextlib
import os
import re
import select
import shlex
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from sim.clock.controller_time import timed
from sim.clock.stopping import unbreakable
from sim.controllers.controller_error import NO_ANSWER, ControllerError, how_it_ended, rule_of
from sim.controllers.programs.crash_report import report_of
from sim.evidence import evidence_table
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.world import Value

# Bytes of an answer, not counting its newline.
LONGEST_LINE = 64 << 10

# Bytes that are read at a time. An answer is kept up to this much beyond LONGEST_LINE.
_CHUNK = 64 << 10

# Number of bytes kept from the end of stderr. A sanitizer's report takes up to 10 KB.
_KEPT = 64 << 10

# Lines of stderr in the evidence, and characters of each.
_LAST_LINES = 5
_LINE_WIDTH = 200

# Seconds between two checks of a silent program. A grandchild may hold the pipes open after the
# program has ended, so open pipes do not prove that it still runs.
_LOOK_AGAIN = 0.05

# Seconds that a program may take to exit after it has closed its output.
_TO_EXIT = 1.0

# Seconds between SIGTERM and SIGKILL.
_TO_TIDY_UP = 0.5

# The keeper is a shell that outlives this process. However this process ends, even by SIGKILL, the
# pipe that the keeper reads is closed, and the keeper then kills the program's group. The spelling
# `-s KILL --` is for dash, which does not take a group after -KILL.
_SHELL = "/bin/sh"
_KEEPER = 'read -r line || kill -s KILL -- "-$1"'


@dataclass(frozen=True)
class ProgramLimits:
    """Limits on a program.

    Args:
        deadline: Time for an answer, s.
        start_deadline: Time for the first answer after a reset, s, including the start-up.
        memory: Bytes of address space (``RLIMIT_AS``), or ``None``; ignored on systems that cannot
            limit it.
    """

    deadline: float = 1.0
    start_deadline: float = 10.0
    memory: int | None = 2 << 30


class WantsMemory(InvalidParameter):
    """Raised if a program cannot even start within its limit of address space.

    No run can then show anything about it, so this is a usage error.
    """


_SANITIZER_RESERVES = re.compile(
    r"ReserveShadowMemoryRange failed|[Ss]hadow memory range interleaves|Sanitizer failed to "
    r"(?:allocate|reserve|mmap)"
    r"|Sanitizer: unexpected memory mapping|ERROR: Failed to mmap"
)
"""Messages of sanitizers, which reserve terabytes, under a memory limit.

Which one appears depends on how far the program got before the limit was set.
"""

_RUNTIME_RESERVES = re.compile(
    r"Failed to reserve (?:virtual )?memory|Could not reserve enough space|failed to reserve page "
    r"summary memory"
    r"|Error occurred during initialization of VM|Fatal process OOM in|cannot allocate memory in "
    r"static TLS"
)
"""Messages of Node, Java and Go, which reserve more than they use when they start."""


def find_program(command: tuple[str, ...]) -> str:
    """Return the path of a program's file.

    Raises:
        InvalidParameter: If it does not exist or is not executable, or the system is not POSIX.
    """
    if os.name != "posix":
        raise InvalidParameter(
            "needs-posix",
            "a program can be a controller only on POSIX systems",
            "use a Python class instead",
        )
    found = shutil.which(command[0])
    if found is not None:
        return found
    if "/" not in command[0] and os.access(command[0], os.X_OK):
        raise InvalidParameter(
            "program-not-on-path",
            "controller program {program!r} is not on PATH, but is in this folder: write "
            "./{program}",
            program=command[0],
        )
    if os.path.isfile(command[0]):  # noqa: PTH113 - a text from outside, which Path may refuse
        raise InvalidParameter(
            "not-executable",
            "controller program {program!r} is not executable",
            "chmod +x {program}",
            at_terminal=True,
            program=command[0],
        )
    raise InvalidParameter(
        "program-missing",
        "controller program {program!r} does not exist",
        "use its path, such as ./mine, or a name that is on PATH",
        program=command[0],
    )


class Program:
    """A child process in its own session, with pipes for lines.

    Args:
        command: Program and arguments.
        memory: Limit on its memory, as in :class:`ProgramLimits`.

    Raises:
        InvalidParameter: If it cannot be started.
    """

    def __init__(self, command: tuple[str, ...], memory: int | None) -> None:
        file = find_program(command)
        self._command = command
        self._memory = memory
        self._answers = 0
        self._sources = (Path.cwd(), Path(file).resolve().parent)
        self._process = _started(command, file)
        self.stopped = False
        self._group_ended = False
        # True once stdout is at its end.
        self._ended = False
        self._keeper: subprocess.Popen[bytes] | None = None

        # All reading and writing is non-blocking, so that deadlines can be kept.
        self._stdin, self._stdout, self._stderr = (
            pipe.fileno()
            for pipe in (self._process.stdin, self._process.stdout, self._process.stderr)
            if pipe
        )
        for pipe in (self._stdin, self._stdout, self._stderr):
            os.set_blocking(pipe, False)
        self._poll = select.poll()
        self._poll.register(self._stdout, select.POLLIN)
        self._poll.register(self._stderr, select.POLLIN)
        self._answer = bytearray()
        self._said = bytearray()
        try:
            self._keeper = _keeper_of(self._process.pid)
            self._limit_memory(memory)
        except BaseException:
            self.stop()
            raise

    def _limit_memory(self, memory: int | None) -> None:
        import resource  # noqa: PLC0415 - POSIX only

        if memory is None or not hasattr(resource, "prlimit"):
            # Without prlimit, as on macOS, which ignores RLIMIT_AS anyway.
            return
        try:
            resource.prlimit(self._process.pid, resource.RLIMIT_AS, (memory, memory))
        except ProcessLookupError:  # It has already ended; reading its first answer will show this.
            return
        except (OSError, ValueError) as error:
            raise InvalidParameter(
                "cannot-limit-memory",
                "the memory limit of {memory} bytes cannot be set: {reason}",
                "use another limit, or none",
                memory=memory,
                reason=str(error),
            ) from error

    @property
    def is_ready(self) -> bool:
        """True if it runs and has no unread output."""
        if self.stopped:
            return False
        self._hear(0)
        return not (self._ended or self._answer or self._has_exited())

    @unbreakable
    def ask(self, line: bytes, seconds: float) -> bytes:
        """Send a line and wait for one.

        Args:
            line: The line, with its newline.
            seconds: Deadline for the answer, s.

        Returns:
            The answer without its newline.

        Raises:
            ControllerError: If no answer comes, or more than one line. The program is then
                ended, as with any other exception here, because its next output would not be an
                answer to the next question.
        """
        end = time.monotonic() + seconds
        try:
            self._hear(0)
            if self._answer:
                raise invalid_answer("more than one line", self._answer)
            answer = self._exchange(line, end, seconds)
            self._answers += 1
            return answer
        except ControllerError as found:
            raise self.ended_by(found) from None
        except BaseException:
            self.stop()
            raise

    @timed
    def _exchange(self, line: bytes, end: float, seconds: float) -> bytes:
        """Send a line and receive one; the time spent waiting counts as the program's own."""
        self._send(line, end, seconds)
        return self._receive(end, seconds)

    def ended_by(self, found: ControllerError) -> ControllerError:
        """End the program, and return the error with what its stderr reveals."""
        said = self._last_words()
        self.stop()
        lines: list[Value] = [line[-_LINE_WIDTH:] for line in said.splitlines() if line.strip()]
        facts: dict[str, Value] = {"stderr": lines[-_LAST_LINES:]} if lines else {}

        # A program that failed to reserve memory points to its limit, and is not a finding. Java
        # complains about it on stdout, where the answer was expected.
        said_instead = str(found.evidence.answer or "")
        if self._memory is not None and _wants_memory(
            said + said_instead, starting=self._answers == 0
        ):
            size = f"{self._memory / (1 << 30):.3g} GiB"
            raise WantsMemory(
                "address-space-too-small",
                "controller program {program!r} reserves more than its limit of {size} of address "
                "space, and ended with: {said!r}",
                "lift the limit: --controller 'cmd+memory=none:{command}'",
                at_terminal=True,
                program=self._command[0],
                size=size,
                said=str(_telling_line([said_instead, *lines])),
                command=shlex.join(self._command),
            )

        # A crash often comes with a report that names its reason and place.
        report = report_of(said, self._sources) if found.verdict == Verdict.CRASH else {}
        return ControllerError(
            found.verdict, found.error, evidence_table(found.evidence) | facts | report
        )

    def _send(self, line: bytes, end: float, seconds: float) -> None:
        try:
            sent = self._write(line)
            if sent == len(line):
                return
            self._poll.register(self._stdin, select.POLLOUT)
            while sent < len(line):
                self._wait(end, seconds)
                sent += self._write(line[sent:])
        except BrokenPipeError:  # It no longer reads, but its last output may still arrive.
            pass
        with contextlib.suppress(KeyError):
            self._poll.unregister(self._stdin)

    def _write(self, data: bytes) -> int:
        try:
            return os.write(self._stdin, data)
        except BlockingIOError:
            return 0

    def _receive(self, end: float, seconds: float) -> bytes:
        answer = self._answer
        while (newline := answer.find(b"\n")) < 0:
            if len(answer) > LONGEST_LINE:
                break
            if self._ended:
                raise self._ending()
            self._wait(end, seconds)
        if newline > LONGEST_LINE or newline < 0:
            error = f"a line of more than {LONGEST_LINE} bytes"
            raise invalid_answer(error, answer, "a-line-of-more-than-bytes")
        line = bytes(answer[:newline])
        del answer[: newline + 1]
        return line

    def _wait(self, end: float, seconds: float) -> None:
        """Read the next output; if there is none, check the process itself."""
        left = end - time.monotonic()
        if self._hear(min(max(left, 0.0), _LOOK_AGAIN)):
            return  # Accept it even if it is late, because this process may have been the slow one.
        if self._has_exited():
            self._hear(0)
            self._ended = True
        elif left <= 0.0:
            partly = {"unfinished": shown(self._answer)} if self._answer else {}
            raise ControllerError(Verdict.HANG, NO_ANSWER, {"deadline": seconds, **partly})

    def _hear(self, seconds: float) -> bool:
        """Read the output that arrives within that time, up to a chunk from each pipe.

        Returns:
            True if something came from stdout, or it reached its end.
        """
        heard = False
        for pipe, _ in self._poll.poll(seconds * 1000.0):
            data = None if pipe == self._stdin else self._read(pipe)
            if data is None:
                continue
            heard = heard or pipe == self._stdout
            if not data:
                self._poll.unregister(pipe)
                self._ended = self._ended or pipe == self._stdout
            elif pipe == self._stdout:
                self._answer += data
                del self._answer[LONGEST_LINE + _CHUNK :]
            else:
                self._said += data
                del self._said[:-_KEPT]
        return heard

    def _read(self, pipe: int) -> bytes | None:
        try:
            return os.read(pipe, _CHUNK)
        except BlockingIOError:
            return None

    def _has_exited(self) -> bool:
        """Return True if the process has ended.

        If the system allows it, the process is not reaped yet, so that its number is not reused
        before :meth:`stop`.
        """
        if self._process.returncode is not None:
            return True
        if not hasattr(os, "waitid"):
            return self._process.poll() is not None
        try:
            return (
                os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG)
                is not None
            )
        except ChildProcessError:  # The system reaps children itself if SIGCHLD is ignored.
            return True

    def _ending(self) -> ControllerError:
        """Return the error that describes how it ended, by exit code or signal."""
        if not self._exits_within(_TO_EXIT):
            return ControllerError(Verdict.CRASH, "closed its output")
        self._end_group()
        return ControllerError(Verdict.CRASH, *how_it_ended(self._process.wait()))

    def _exits_within(self, seconds: float) -> bool:
        end = time.monotonic() + seconds
        pause = 0.0005
        while not self._has_exited():
            if time.monotonic() > end:
                return False
            self._hear(0)  # A full pipe must not keep it from exiting.
            time.sleep(pause)
            pause = min(2 * pause, 0.02)
        return True

    def _last_words(self) -> str:
        """Return the end of stderr as plain text."""
        for _ in range(_KEPT):  # This is bounded, because a grandchild may write forever.
            data = self._read(self._stderr)
            if not data:
                break
            self._said += data
            del self._said[:-_KEPT]
        return _plain(self._said)

    @unbreakable
    def stop(self) -> None:
        """End it: send SIGTERM to its whole group, wait half a second, then send SIGKILL."""
        if self.stopped:
            return
        self.stopped = True
        if not self._has_exited():
            self._kill(signal.SIGTERM)
            self._exits_within(_TO_TIDY_UP)
        self._end_group()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            if pipe is not None:
                pipe.close()
        if self._keeper is not None:
            self._keeper.communicate(b"done\n")

    def _end_group(self) -> None:
        """End all processes that it started and left behind.

        This must happen before the process is reaped, when its number may go to another.
        """
        if not self._group_ended:
            self._kill(signal.SIGKILL)
        self._group_ended = True

    def _kill(self, number: signal.Signals) -> None:
        try:
            os.killpg(self._process.pid, number)
        except (ProcessLookupError, PermissionError):
            # The group is empty; on macOS the second also means that only dead members remain.
            return


# The program gets a session, so that everything it starts can be ended as one group.
def _started(command: tuple[str, ...], file: str) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(
            command,
            executable=file,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,
        )
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise InvalidParameter(
            "cannot-start",
            "controller program {program!r} cannot be started: {reason}",
            "is it a program for this machine, or a script that begins with #! and its "
            "interpreter?",
            program=command[0],
            reason=reason,
        ) from error


def _keeper_of(group: int) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(
            [_SHELL, "-c", _KEEPER, "worldgen-keeper", str(group)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError as error:
        raise InvalidParameter(
            "cannot-start",
            "{program}, which would end a controller's program if this process is killed, cannot "
            "be started: {reason}",
            program=_SHELL,
            reason=error.strerror,
        ) from error


def _wants_memory(said: str, *, starting: bool) -> bool:
    return bool(_SANITIZER_RESERVES.search(said) or (starting and _RUNTIME_RESERVES.search(said)))


def _telling_line(lines: list[Value]) -> Value:
    """Return the line that reports the lack of memory, or otherwise the last line."""
    return ([line for line in lines if _wants_memory(str(line), starting=True)] or lines)[-1]


def _plain(data: bytes | bytearray) -> str:
    """Return output as text without control sequences, safe for a file and a terminal."""
    text = re.sub(r"\x1b\[[0-9;?]*[ -/]*[@-~]", "", bytes(data).decode("utf-8", "replace"))
    return "".join(char if char.isprintable() or char == "\n" else " " for char in text)


def invalid_answer(error: str, answer: bytes | bytearray, rule: str = "") -> ControllerError:
    """Return the error for a program's answer.

    Replays compare these errors with the ones in stored failures, so their wording must not change.

    Args:
        error: The fault.
        answer: The answer, to quote.
        rule: Name of the rule that it breaks, if that is not :func:`rule_of` the error; buckets
            are named after it.
    """
    facts: dict[str, Value] = {"rule": rule or rule_of(error), "answer": shown(answer)}
    return ControllerError(Verdict.INVALID_COMMAND, error, facts)


def shown(data: bytes | bytearray) -> str:
    """Return the beginning of an answer, to quote in the evidence."""
    first = bytes(data[: 4 * _LINE_WIDTH]).partition(b"\n")[0]
    text = _plain(first)
    return text if len(text) <= _LINE_WIDTH else f"{text[:_LINE_WIDTH]}..."
