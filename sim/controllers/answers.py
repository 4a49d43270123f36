"""Reuse the answers of slow controllers.

A controller that follows the contract answers the same whenever it observes and remembers the same,
bit for bit. One that also keeps state in attributes, which its ``reset`` clears, does so as long as
it has observed the same ever since. A failure is run many times: to find its loop, to prove it, to
check and describe it, and in worlds that differ from its own only where the robot never senses it.
If a step takes a millisecond, most of that time would be spent on answers that are known.

Whether a controller does so is checked, not assumed. All state that can be seen is compared before
and after each run, every so many reused answers are computed again, and the runs that prove a loop
or confirm a failure compute them all. A controller that breaks this once is never trusted again.
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
from sim.controllers.timeline_reads import are_reads_noted

T = TypeVar("T")

SLOW_STEP = 5e-5
"""Seconds of a step above which a controller is slow, so that its answers are worth reusing.

To know an answer again takes 4 us, and to compare the state before and after a run 0.2 ms.
"""

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

# The same for a controller with state in attributes: one in this many runs is computed in whole.
_CHECKED_RUNS = 16

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
    """Raised in a run that reused answers of a controller which keeps state outside its memory.

    From then on, fewer of its answers are reused, or none, so the run can simply be repeated.
    """


class Answers:
    """The answers of one controller, by what it observed and remembered.

    Attributes:
        is_off: Whether nothing is reused: the controller is quick, or does not follow the contract.
        is_trusted: Whether answers may be reused: a run has shown that they take long, and has left
            no state behind.
        by_history: Whether the controller keeps state in its attributes, so that an answer depends on
            all that it has observed since its ``reset``.
        differ: Whether the controller once gave another answer than before.
        ends: By the key of a run's last answer, whether its attributes then were as at the start.
        repeated_proofs: Number of runs that were to prove a loop, in which every answer was computed
            although an earlier run had given it, and was the same.
    """

    def __init__(self) -> None:
        self.is_off = False
        self.is_trusted = False
        self.by_history = False
        self.differ = False
        self.ends: dict[bytes, bool] = {}
        self.repeated_proofs = 0
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
            self.ends = {}

    def lend(
        self,
        controller: Any,
        drive: Callable[[Any], T],
        *,
        proved_if: Callable[[], bool] | None = None,
    ) -> tuple[T, bool | None]:
        """Run, and reuse answers where they are known.

        Args:
            controller: The controller, after its ``reset``.
            drive: Runs to the end; takes the function that acts.
            proved_if: For a run that proves a loop, which only reuses what such a run has computed
                before: returns at its end whether others may reuse it so.

        Returns:
            The result of the run; and whether the controller's attributes would be as at the start,
            ``None`` if they show it themselves.

        Raises:
            AnswersDiffer: If the run is worthless because the controller does not follow the
                contract.
        """
        begun = hidden_state(controller)
        # Without seeing its state there is no telling. Who watches the controller must see each call.
        if begun is None or sys.gettrace() is not None or are_reads_noted():
            return drive(timed(controller.act)), None
        kind = _RunByHistory if self.by_history else _Run
        run = kind(self, controller, begun, None if _leaves_proofs.get() else proved_if)
        try:
            result = drive(run.act)
        except Exception:
            run.check()
            raise
        return result, run.check()

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
        """Count an answer, or a run, that is to be reused; return True if it must be computed."""
        self._reused += 1
        return self._reused % (_CHECKED_RUNS if self.by_history else _CHECKED_EVERY) == 0

    def add(self, key: bytes, answer: bytes, seconds: float) -> None:
        """Keep a computed answer, and note how long that took."""
        self._keep(key, answer)
        self._calls += 1
        if self._calls > 1:
            self._seconds += seconds
        if self._calls == _TRIED and self._seconds < SLOW_STEP * (_TRIED - 1):
            self.give_up()

    def end_run(self, proved: set[bytes]) -> None:
        """Note that a run has left no state behind, and which answers it has computed for a proof."""
        self.is_trusted |= self._calls >= _TRIED
        self._proved |= proved

    def give_up(self) -> None:
        """Reuse nothing anymore."""
        self.is_off = True
        self.forget()

    def go_by_history(self) -> None:
        """Reuse an answer only if everything since ``reset`` was the same."""
        self.by_history = True
        self.forget()

    def _keep(self, key: bytes, answer: bytes) -> None:
        if key not in self._latest:
            self._bytes += len(answer) + _OVERHEAD
        self._latest[key] = answer
        if self._bytes > _MOST_BYTES // 2:
            self._older = self._latest
            self._latest = {}
            self._bytes = 0
            self._proved &= self._older.keys()
            self.ends = {}


class _Run:
    """One run that reuses answers."""

    def __init__(
        self,
        answers: Answers,
        controller: Any,
        begun: HiddenState,
        proved_if: Callable[[], bool] | None,
    ) -> None:
        self._answers = answers
        self._controller = controller
        self._begun = begun
        self._proved_if = proved_if
        self._proved: set[bytes] = set()
        self._act = timed(controller.act)
        # A plan, or an option, is part of what decides an answer.
        self._state = hashlib.blake2b(begun.own + begun.shared, digest_size=16).digest()
        self._is_light = len(begun.own) <= _LIGHT
        self._computed = 0
        # Whether an answer was computed that no earlier run had given.
        self._has_new = False
        self._has_reused = False
        self._ended: HiddenState | None = None

    def act(self, seen: Any, memory: Any) -> Any:
        """Return the controller's answer."""
        answers = self._answers
        # Quick, or found to keep state in the middle of this run.
        if answers.is_off or answers.by_history:
            self._has_new = True
            return self._act(seen, memory)
        key = _key(self._state, seen, memory)
        found = answers.find(key, proved_only=self._proved_if is not None)
        if found is not None and not answers.is_to_check():
            self._has_reused = True
            return marshal.loads(found)

        # The state of the object is compared at once; all of it, at the end of the run.
        is_watched = self._is_light and (
            self._computed < _WATCHED_EVERY or self._computed % _WATCHED_EVERY == 0
        )
        self._computed += 1
        before = own_attributes(self._controller) if is_watched else None
        answer = self._compute(key, seen, memory)
        if is_watched and own_attributes(self._controller) != before:
            self._answers.go_by_history()
            self._begin_again()
        return answer

    def check(self) -> bool | None:
        """Compare all state with that at the start.

        Returns:
            Whether the attributes are as at the start; ``None`` if the controller shows it itself.

        Raises:
            AnswersDiffer: If the run has reused an answer that may be wrong because of the state.
        """
        if self._answers.is_off:
            return None
        now = self._ended = hidden_state(self._controller)
        if now is None or now._replace(own=self._begun.own) != self._begun:
            self._answers.give_up()
            self._begin_again()
        elif now != self._begun and not self._answers.by_history:
            self._answers.go_by_history()
            self._begin_again()
        else:
            is_proved = self._proved_if is not None and self._proved_if()
            self._answers.end_run(self._proved if is_proved else set())
            self._answers.repeated_proofs += is_proved and not (self._has_new or self._has_reused)
        return None

    def _begin_again(self) -> None:
        if self._has_reused:
            raise AnswersDiffer

    def _compute(self, key: bytes, seen: Any, memory: Any) -> Any:
        """Let the controller act, compare its answer with the known one, and keep it."""
        began = time.perf_counter()
        answer = self._act(seen, memory)
        seconds = time.perf_counter() - began
        plain = _plain(answer)
        known = None if plain is None else self._answers.known(key)
        self._has_new |= known is None
        if plain is not None:
            if known not in (None, plain):
                self._differ()
            if self._proved_if is not None:
                self._proved.add(key)
            self._answers.add(key, plain, seconds)
        return answer

    def _differ(self) -> None:
        count_differences([UNKNOWN_SOURCE])
        self._answers.differ = True
        self._answers.give_up()
        raise AnswersDiffer


class _RunByHistory(_Run):
    """A run of a controller that keeps state in attributes: it acts from the first new step on.

    Until then all answers are known. To get into the state of that step, it then acts in the steps
    before, which also checks their answers.
    """

    def __init__(
        self,
        answers: Answers,
        controller: Any,
        begun: HiddenState,
        proved_if: Callable[[], bool] | None,
    ) -> None:
        super().__init__(answers, controller, begun, proved_if)
        self._past: list[tuple[Any, Any, bytes]] = []
        self._acts = answers.is_to_check()

    def act(self, seen: Any, memory: Any) -> Any:
        """Return the controller's answer."""
        answers = self._answers
        if answers.is_off:
            return self._act(seen, memory)
        self._state = key = _key(self._state, seen, memory)
        found = None if self._acts else answers.find(key, proved_only=self._proved_if is not None)
        if found is not None:
            self._past.append((seen, memory, found))
            return marshal.loads(found)
        self._catch_up()
        return self._compute(key, seen, memory)

    def check(self) -> bool | None:
        """Return whether the attributes would be as at the start, and compare all other state."""
        if not self._past or self._acts:
            self._acts = True
            super().check()
            if not self._answers.is_off:
                self._answers.ends[self._state] = self._ended == self._begun
            return None
        if self._state not in self._answers.ends:
            self._catch_up()
            return self.check()
        return self._answers.ends[self._state]

    def _catch_up(self) -> None:
        """Let the controller act in the steps whose answers were reused."""
        if self._acts:
            return
        self._acts = self._has_reused = True
        for seen, memory, known in self._past:
            try:
                answer = _plain(self._act(seen, memory))
            except Exception:  # noqa: BLE001 - it did not raise before
                answer = None
            if answer != known:
                self._differ()
        # All answers that were reused are right.
        self._has_reused = False


def _key(state: bytes, seen: Any, memory: Any) -> bytes:
    """Return a key for what a controller observes and remembers, and its state: 128 bits."""
    data = marshal.dumps((*seen, memory), _PLAIN_DATA)
    return hashlib.blake2b(data, digest_size=16, key=state).digest()


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
