"""Run a Python controller again, and see which of its lines run and what its state does."""

from __future__ import annotations

import contextlib
import functools
import io
import math
import sys
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from types import ModuleType
from typing import Any, TypeGuard

import numpy as np

from sim.controllers.base import Observation
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.catalogue.renewal import as_loaded
from sim.controllers.hidden_state import attributes
from sim.controllers.instances import origin_of
from sim.episode import Episode, prepare
from sim.options.run import RunOptions
from worldgen.errors import WorldgenError
from worldgen.plugins.counted_code import CountedCode, counted_module
from worldgen.plugins.registry import user_code
from worldgen.support.arrays import Floats
from worldgen.support.plain_text import rounded_angle
from worldgen.world import World

_METHODS = ("act", "act_many")
_DECLARED = ("reset", "senses", "needs")

# Different values of one attribute that are kept; if there are more, only their range is.
_MOST_VALUES = 4

# Units of what a controller senses; angles are converted, as people read degrees.
_DEGREES = "degrees"
_UNITS = dict.fromkeys(
    ("bump_bearing", "signal_heading", "heading", "target_heading", "odometry_heading"), _DEGREES
)
_UNITS |= dict.fromkeys(("x", "y", "target_distance", "radius", "odometry_x", "odometry_y"), "m")
_UNITS |= {"time_step": "s", "time": "s", "top_speed": "m/s"}

# Entries of a table, such as the blackboard of a behaviour tree, that are looked at one by one.
_MOST_ENTRIES = 16

# How far objects within objects are followed.
_DEEPEST = 2

# Running a longer run again would take too long.
_MOST_STEPS = 200_000

# Numbers of the state that are kept from the start of the run.
_MOST_NUMBERS = 64

# Only values of exactly these types are looked at. A subclass may run code of the user's when it is
# compared or printed, and may print an address, which differs each time.
_PLAIN = (bool, int, float, str, type(None))
_COLLECTIONS = (list, tuple, dict, set, frozenset, deque, bytes, bytearray)
_MOST_BITS = 63

# Characters of a value that is not a number.
_LONGEST_VALUE = 40


@dataclass
class StateValues:
    """The values of one attribute or number of the memory in a part of a run.

    Args:
        name: Such as ``self.side`` or ``memory[0]``.
        since: The step in which it took its first value of the part; 0 if it had it at the start.
        values: The different values, in the order in which they came, as text.
        low: Smallest value; ``None`` if it is not a number.
        high: Largest value.
        only_rises: True if no value is below the one before it.
        only_falls: True if no value is above the one before it.
        unit: Unit of the values; empty for none, or if it is not known.
    """

    name: str
    since: int = 0
    values: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None
    only_rises: bool = True
    only_falls: bool = True
    unit: str = ""

    def take(self, before: object, now: object) -> None:
        """Add a value.

        Args:
            before: The value before it, or the value itself if it is the first.
            now: The value.
        """
        is_angle = self.unit == _DEGREES
        text = rounded_angle(now) if is_angle and _is_number(now) else _as_text(now)
        if text not in self.values and len(self.values) <= _MOST_VALUES:
            self.values += (text,)
        if _is_number(now) and _is_number(before):
            self.low = now if self.low is None else min(self.low, now)
            self.high = now if self.high is None else max(self.high, now)
            self.only_rises &= now >= before
            self.only_falls &= now <= before
        else:
            self.only_rises = self.only_falls = False

    @property
    def is_constant(self) -> bool:
        """True if it has one value."""
        return len(self.values) == 1

    @property
    def has_many_values(self) -> bool:
        """True if not all of its values were kept."""
        return len(self.values) > _MOST_VALUES


@dataclass(frozen=True, eq=False)
class WatchedPart:
    """What ran inside a controller in a part of its run.

    Args:
        code: Its file.
        counts: By line, how often the statement that begins there ran in the part.
        state: What its attributes and its memory did in the part.
        senses: What the senses that it reads did.
        numbers: By name, the values of each number of its state, (n + 1,): at the start of the run,
            and after each time that it acted.
    """

    code: CountedCode
    counts: list[int]
    state: list[StateValues]
    senses: list[StateValues]
    numbers: dict[str, Floats]


def watched_part(
    world: World, name: str, options: RunOptions, episode: Episode, first: int
) -> WatchedPart | None:
    """Run an episode of a Python controller again, and watch it in the last part of the run.

    Args:
        world: World of the run.
        name: The controller's name.
        options: Options of the run.
        episode: The run, recorded.
        first: The number of steps before the part.

    Returns:
        What ran in the part; ``None`` for a controller without a source in Python, for a very long
        run, and if the run differs from the recorded one.
    """
    if episode.steps > _MOST_STEPS:
        return None
    # Let its functions count, and run the episode again.
    try:
        controller = CONTROLLERS.get(name)
        if origin_of(controller) is not None:
            controller = as_loaded(name)
        module = sys.modules.get(type(controller).__module__)
        if module is None or not str(getattr(module, "__file__", "")).endswith(".py"):
            return None
        # Its prints have been seen in the first run.
        with contextlib.redirect_stdout(io.StringIO()):
            again = _another(controller, module)
            if again is None:
                return None
            with counted_module(module) as code:
                watcher = _Watcher(again, code, first)
                if options.frozen_time and origin_of(controller) is not None:
                    watcher.renew_with(functools.partial(_another, controller, module))
                watched: Any = watcher
                run = prepare(world, watched, replace(options, steps=episode.steps))
                outcome = run.run(episode.steps, find_loop=False, record=True)
    except WorldgenError:
        return None
    # What another run shows says nothing about the recorded one.
    if outcome.trace is None or episode.trace is None:
        return None
    same = np.array_equal(outcome.trace.states, episode.trace.states)
    return watcher.part(code) if same else None


def _another(controller: Any, module: ModuleType) -> Any | None:
    """Return a controller as no run has changed it; ``None`` if it isn't known how to make one."""
    # The file may name an instance instead of a class.
    if any(value is controller for value in vars(module).values()):
        return controller
    origin = origin_of(controller)
    if origin is not None:
        return origin.another()
    kind = type(controller)
    if getattr(module, kind.__qualname__, None) is not kind:
        return None
    with user_code(f"{kind.__name__}: making it without arguments"):
        return kind()


class _Watcher:
    """A controller that lets another one act, and watches it."""

    def __init__(self, inner: Any, code: CountedCode, first: int) -> None:
        self._now = code.counts
        self._unpacked = _unpacked(code)
        read = frozenset[str]().union(*(one.fields for one in code.functions))
        self._senses = {f"observation.{name}": name for name in Observation._fields if name in read}
        self._first = first
        self._step = 0
        self._before: list[int] = []
        self._latest: dict[str, object] = {}
        self._since: dict[str, int] = {}
        self._seen: dict[str, StateValues] = {}
        self._numbers: dict[str, list[float]] = {}
        self._watch(inner)

    def _watch(self, inner: Any) -> None:
        self._inner = inner
        self.made_of = (inner,)
        for method in _METHODS:
            if hasattr(inner, method):
                setattr(self, method, self._watching(getattr(inner, method)))
        for declared in _DECLARED:
            if hasattr(inner, declared):
                setattr(self, declared, getattr(inner, declared))

    def renew_with(self, make: Callable[[], Any]) -> None:
        """Watch another controller from its reset on, as a run with frozen time does.

        Args:
            make: Returns another one.
        """
        reset = self._inner.reset

        @functools.wraps(reset)
        def renewed(*world: World) -> Any:
            self._watch(make())
            return self._inner.reset(*world)

        self.reset = renewed

    def _watching(self, act: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        def watched(observation: Any, memory: Any) -> Any:
            if self._step == 0:
                self._take_state(observation, memory)
            if self._step == self._first:
                self._before = list(self._now)
            self._step += 1
            answer = None
            try:
                answer = act(observation, memory)
                return answer
            finally:
                self._take_state(observation, _memory_in(answer))

        return watched

    def _take_state(self, observation: Any, memory: Any) -> None:
        """Compare the state with that before the step, and keep its values in the part."""
        numbers = memory if isinstance(memory, tuple) else np.ravel(memory).tolist()
        names = self._unpacked if len(self._unpacked) == len(numbers) else ()
        now = dict(_named_values("self", self._inner))
        for place, number in enumerate(numbers):
            now[f"{names[place]} (memory)" if names else f"memory[{place}]"] = number
        if self._step == 0:
            # A map has thousands of numbers, and none of them is looked at one by one.
            found = [name for name, value in now.items() if _is_number(value)]
            self._numbers = {name: [] for name in found[:_MOST_NUMBERS]}
        for name, values in self._numbers.items():
            value = now.get(name)
            values.append(float(value) if _is_number(value) else math.nan)
        if isinstance(observation, Observation):
            sensed = {place: getattr(observation, name) for place, name in self._senses.items()}
            now |= {
                place: math.degrees(value) if self._unit(place) == _DEGREES else value
                for place, value in sensed.items()
                if _is_number(value)
            }
        for name, value in now.items():
            before = self._latest.get(name, value)
            if before != value:
                self._since[name] = self._step
            if self._step > self._first:
                if name not in self._seen:
                    self._seen[name] = StateValues(
                        name, self._since.get(name, 0), unit=self._unit(name)
                    )
                    before = value
                self._seen[name].take(before, value)
        self._latest = now

    def _unit(self, place: str) -> str:
        return _UNITS.get(self._senses.get(place, ""), "")

    def part(self, code: CountedCode) -> WatchedPart | None:
        """Return what ran since the first step of the part; ``None`` if the run ended before it."""
        if not self._before:
            return None
        counts = [now - before for now, before in zip(self._now, self._before, strict=True)]
        senses = [one for name, one in self._seen.items() if name in self._senses]
        state = [one for name, one in self._seen.items() if name not in self._senses]
        numbers = {name: np.array(values) for name, values in self._numbers.items()}
        return WatchedPart(code, counts, state, senses, numbers)


def _memory_in(answer: Any) -> Any:
    """Return the memory in a controller's answer; none if the answer is not in the usual form."""
    memory = answer[1] if isinstance(answer, tuple) and len(answer) == 2 else ()
    return memory if isinstance(memory, tuple | np.ndarray) else ()


def _unpacked(code: CountedCode) -> tuple[str, ...]:
    """Return the names that ``act`` gives to the numbers of its memory, if it unpacks them."""
    acts = [one for one in code.functions if one.name in _METHODS]
    return acts[0].unpacked if len(acts) == 1 else ()


def _named_values(owner: str, thing: object, depth: int = 0) -> Iterator[tuple[str, object]]:
    """Yield the values of an object's attributes that can be shown.

    Of a collection, that is its length and, if it is small, its parts.
    """
    for name, given in attributes(thing).items():
        place = f"{owner}.{name}"
        is_numpy = isinstance(given, np.generic) or (type(given) is np.ndarray and given.ndim == 0)
        value = given.item() if is_numpy else given
        is_short = type(value) is tuple and len(value) <= _MOST_VALUES
        if _is_plain(value) or isinstance(value, Enum) or (is_short and all(map(_is_plain, value))):
            yield place, value
        elif type(value) in _COLLECTIONS or type(value) is np.ndarray:
            parts = [*_parts(value)]
            if type(value) is list or not parts:
                yield f"len({place})", len(value)
            for part, inner in parts:
                yield f"{place}[{part}]", inner
        # An object of the user's own has state too, such as a filter.
        elif depth < _DEEPEST and type(value).__module__ == type(thing).__module__:
            yield from _named_values(place, value, depth + 1)


def _parts(collection: Any) -> Iterator[tuple[str, object]]:
    """Yield the parts of a small collection that can be shown, such as a blackboard or a pose."""
    if type(collection) is dict and len(collection) <= _MOST_ENTRIES:
        for key, value in collection.items():
            if type(key) is str and (_is_plain(value) or isinstance(value, Enum)):
                yield _as_text(key), value
    elif type(collection) in (list, np.ndarray) and len(collection) <= _MOST_VALUES:
        values = collection.tolist() if type(collection) is np.ndarray else collection
        if all(map(_is_number, values)) and all(map(_is_plain, values)):
            yield from zip(map(str, range(len(values))), values, strict=True)


def _is_plain(value: object) -> bool:
    """Return True if a value can be compared and printed without running code of the user's."""
    if type(value) is int:
        return value.bit_length() <= _MOST_BITS
    return type(value) in _PLAIN


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _as_text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_as_text, value))})"
    if isinstance(value, Enum):
        return f"{type(value).__name__}.{value.name}"
    if isinstance(value, str):
        return repr(value if len(value) <= _LONGEST_VALUE else f"{value[:_LONGEST_VALUE]}...")
    return repr(value)
