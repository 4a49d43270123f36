"""Reuse the answers of slow controllers.

A controller that follows the contract answers the same whenever it observes and remembers the same,
bit for bit. A failure is run many times: to find its loop, to prove it, to check and describe it,
and in worlds that differ from its own only where the robot never senses it. If a step takes a
millisecond, most of that time would be spent on answers that are known.

Whether a controller follows the contract is checked, not assumed. It must not change any state that
can be seen, every so many reused answers are computed again, and the runs that prove a loop or
confirm a failure compute them all. A controller that breaks this once is never trusted again.
"""

from __future__ import annotations

import hashlib
import marshal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

from sim.clock.controller_time import UNKNOWN_SOURCE, count_differences, timed
from sim.controllers.hidden_state import HiddenState, hidden_state, own_attributes

T = TypeVar("T")

# Seconds that a step must take. To know an answer again takes 4 us, and to compare the state before
# and after a run 0.2 ms.
_SLOW = 5e-5

# Calls after which the time of a step is known. The first one is not counted, because many
# controllers do work in it that they do only once.
_TRIED = 32

# One in this many reused answers is computed again: it costs 3 % of what reuse saves.
_CHECKED_EVERY = 32

# The state of the object is compared around the first calls of a run, and around one in this many
# later ones, if its size in bytes is at most the second number: then it takes a few microseconds.
_WATCHED_EVERY = 16
_LIGHT = 1 << 14

# Bytes of the answers that are kept, half of them the latest ones, and what each takes in addition
# to its own.
_MOST_BYTES = 1 << 25
_OVERHEAD = 200

# The version of this format that has no references, so that equal data has equal bytes.
_PLAIN_DATA = 2


# Whether proofs may reuse any known answer.
_leaves_proofs: ContextVar[bool] = ContextVar("leaves_proofs", default=False)


@contextmanager
def leaving_proofs() -> Iterator[None]:
    """Let the proofs of loops in this block reuse any known answer.

    That is for runs whose loops nobody relies on: attempts, whose result is proved in the end, and
    runs that only show whether the robot arrives.
    """
    token = _leaves_proofs.set(True)
    try:
        yield
    finally:
        _leaves_proofs.reset(token)


class AnswersDiffer(Exception):
    """Raised in a run that reused answers of a controller which does not follow the contract.

    From then on, nothing of it is reused, so the run can simply be repeated.
    """


class Answers:
    """The answers of one controller, by what it observed and remembered.

    Attributes:
        is_off: Whether nothing is reused: the controller is quick, or does not follow the contract.
        is_trusted: Whether answers may be reused: a run has shown that they take long, and has left
            no state behind.
    """

    def __init__(self) -> None:
        self.is_off = False
        self.is_trusted = False
        self._latest: dict[bytes, bytes] = {}
        self._older: dict[bytes, bytes] = {}
        self._bytes = 0
        # Keys of the answers that a proof has computed.
        self._proved: set[bytes] = set()
        self._calls = 0
        self._seconds = 0.0
        self._reused = 0

    def forget(self, *, proofs_only: bool = False) -> None:
        """Compute answers again from now on.

        Args:
            proofs_only: Keep the answers, but let the next proof of a loop compute all of its own.
        """
        self._proved.clear()
        if not proofs_only:
            self._latest = {}
            self._older = {}
            self._bytes = 0

    def lend(self, controller: Any, drive: Callable[[Any], T], *, proves: bool) -> T:
        """Return the result of a run in which answers are reused where they are known.

        Args:
            controller: The controller, after its ``reset``.
            drive: Runs to the end; takes the function that acts.
            proves: Whether the run proves a loop, so that it may only reuse what such a run has
                computed before.

        Raises:
            AnswersDiffer: If the run is worthless because the controller does not follow the
                contract.
        """
        begun = hidden_state(controller)
        # Without seeing its state there is no telling. A debugger must see each call.
        if begun is None or sys.gettrace() is not None:
            return drive(timed(controller.act))
        run = _Run(self, controller, begun, proves=proves and not _leaves_proofs.get())
        try:
            result = drive(run.act)
        except Exception:
            run.check()
            raise
        run.check()
        return result

    def find(self, key: bytes, *, proved_only: bool) -> bytes | None:
        """Return a known answer."""
        if not self.is_trusted or (proved_only and key not in self._proved):
            return None
        return self.known(key)

    def known(self, key: bytes) -> bytes | None:
        """Return an answer that was computed before, whether or not it may be reused."""
        answer = self._latest.get(key)
        if answer is None and (answer := self._older.get(key)) is not None:
            self._keep(key, answer)
        return answer

    def is_to_check(self) -> bool:
        """Count an answer that is about to be reused; return True if it must be computed."""
        self._reused += 1
        return self._reused % _CHECKED_EVERY == 0

    def add(self, key: bytes, answer: bytes, seconds: float) -> None:
        """Keep a computed answer, and note how long that took."""
        self._keep(key, answer)
        self._calls += 1
        if self._calls > 1:
            self._seconds += seconds
        if self._calls == _TRIED and self._seconds < _SLOW * (_TRIED - 1):
            self.give_up()

    def end_run(self, proved: set[bytes]) -> None:
        """Note that a run has left no state behind, and which answers it has computed for a proof."""
        self.is_trusted |= self._calls >= _TRIED
        self._proved |= proved

    def give_up(self) -> None:
        """Reuse nothing anymore."""
        self.is_off = True
        self.forget()

    def _keep(self, key: bytes, answer: bytes) -> None:
        self._latest[key] = answer
        self._bytes += len(answer) + _OVERHEAD
        if self._bytes > _MOST_BYTES // 2:
            self._older = self._latest
            self._latest = {}
            self._bytes = 0
            self._proved &= self._older.keys()


class _Run:
    """One run that reuses answers."""

    def __init__(
        self, answers: Answers, controller: Any, begun: HiddenState, *, proves: bool
    ) -> None:
        self._answers = answers
        self._controller = controller
        self._begun = begun
        self._proves = proves
        self._proved: set[bytes] = set()
        self._act = timed(controller.act)
        # A plan, or an option, is part of what decides an answer.
        self._state = hashlib.blake2b(begun.own + begun.shared, digest_size=16).digest()
        self._is_light = len(begun.own) <= _LIGHT
        self._computed = 0
        self._has_reused = False

    def act(self, seen: Any, memory: Any) -> Any:
        """Return the controller's answer."""
        answers = self._answers
        if answers.is_off:
            return self._act(seen, memory)
        data = marshal.dumps((*seen, memory), _PLAIN_DATA)
        key = hashlib.blake2b(data, digest_size=16, key=self._state).digest()
        found = answers.find(key, proved_only=self._proves)
        if found is not None and not answers.is_to_check():
            self._has_reused = True
            return marshal.loads(found)
        return self._compute(key, seen, memory)

    def check(self) -> None:
        """Give up if the run has changed any state.

        Raises:
            AnswersDiffer: If the run also reused an answer, which may then be wrong.
        """
        if self._answers.is_off:
            return
        if hidden_state(self._controller) != self._begun:
            self._give_up()
        else:
            self._answers.end_run(self._proved)

    def _compute(self, key: bytes, seen: Any, memory: Any) -> Any:
        is_watched = self._is_light and (
            self._computed < _WATCHED_EVERY or self._computed % _WATCHED_EVERY == 0
        )
        self._computed += 1
        before = own_attributes(self._controller) if is_watched else None
        began = time.perf_counter()
        answer = self._act(seen, memory)
        seconds = time.perf_counter() - began
        if is_watched and own_attributes(self._controller) != before:
            self._give_up()
            return answer
        plain = _plain(answer)
        if plain is None:
            return answer
        known = self._answers.known(key)
        if known is not None and known != plain:
            count_differences([UNKNOWN_SOURCE])
            self._answers.give_up()
            raise AnswersDiffer
        if self._proves:
            self._proved.add(key)
        self._answers.add(key, plain, seconds)
        return answer

    def _give_up(self) -> None:
        self._answers.give_up()
        if self._has_reused:
            raise AnswersDiffer


def _plain(answer: Any) -> bytes | None:
    """Return an answer as bytes; ``None`` if it is not in the usual form, and so must be judged."""
    if type(answer) is not tuple or len(answer) != 2:
        return None
    command, memory = answer
    if not isinstance(command, tuple) or type(memory) is not tuple or len(command) < 2:
        return None
    try:
        speed, turn_rate = float(command[0]), float(command[1])
        has_drawn = bool(command[2]) if len(command) > 2 else False
        numbers = tuple(map(float, memory))
    except Exception:  # noqa: BLE001 - the loop judges it, and says what is wrong
        return None
    return marshal.dumps(((speed, turn_rate, has_drawn), numbers), _PLAIN_DATA)
