"""Show a controller in Python simulated time and seeded chance, so that its runs repeat.

Only what its own code and the libraries that it calls read is replaced, and only while they run.
Code of ours that runs in the meantime, such as a deadline's signal handler, still reads the real
clock, and so do other threads.
"""

from __future__ import annotations

import datetime
import random
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from sim.clock.stopping import unbreakable
from sim.controllers.hidden_state import modules_of_user
from worldgen.domain import MASK64

# Each reading in a step after the first takes a moment, so that no duration is zero: code that
# measures itself divides by it. A loop that waits for the clock would take forever that way. So after
# this many readings, which are more than a step needs to measure something, each further one takes
# longer: a planner that may think for 20 ms gets some forty rounds.
_READINGS = 16
_PER_READING = 1e-6  # s
_PER_LATE_READING = 1e-3  # s

_OURS = ("sim.", "fuzz.", "worldgen.", "worldgen_plugins.")
# Clocks that count from an arbitrary moment, so that one time fits them all.
_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)


class FrozenTime:
    """The clock and the chance that a controller sees in one run.

    In a step, the clock shows the number of the step times the time step, and a microsecond more
    with each further reading. ``random`` and NumPy's own generator begin with the run's seed, and so
    does every generator that is made without one.

    Args:
        seed: Seed of the run.
        time_step: Duration of a step, s.
        only_watches: True to show the real clock and real chance, and only note what is read.
    """

    def __init__(self, seed: int, time_step: float, *, only_watches: bool = False) -> None:
        self.only_watches = only_watches
        self._seed = seed
        self._time_step = time_step
        self._now = 0.0
        self._steps = 0
        self._made = 0
        self._readings = 0
        self._read_here = 0
        self._places: list[tuple[dict[str, Any], str, Any]] = []
        self._real: list[Any] = []
        self._thread = 0
        self._sources: dict[str, None] = {}
        self._seeded_by_user: set[str] = set()

    @property
    def sources(self) -> tuple[str, ...]:
        """What it has read that differs from run to run without this, each with its first line."""
        return tuple(self._sources)

    @property
    def was_read(self) -> bool:
        """Whether a step has read the clock or made a generator: a state that never recurs."""
        return self._readings > 0

    @contextmanager
    def run(self, controller: object) -> Iterator[None]:
        """Begin a run in this block, and leave all generators as they were.

        Args:
            controller: The controller; names in its modules that mean a clock are replaced, too.
        """
        self._now = 0.0
        self._steps = self._made = self._readings = self._read_here = 0
        replaced = self._replacements()
        originals = {id(getattr(place, name)): new for place, name, new in replaced}
        self._places = [(vars(place), name, new) for place, name, new in replaced]
        # ``from time import monotonic`` has made a name of its own.
        parts = (controller, *getattr(controller, "made_of", ()))
        modules = [one for part in parts for one in modules_of_user(type(part))]
        self._places += [
            (vars(module), name, originals[id(value)])
            for module in dict.fromkeys(modules)
            for name, value in vars(module).items()
            if id(value) in originals
        ]
        self._real = [place[name] for place, name, _ in self._places]
        if self.only_watches:
            yield
            return
        kept = random.getstate(), np.random.get_state()
        random.seed(self._seed)
        np.random.seed(self._seed % 2**32)
        begun = random.getstate(), _state_of_numpy()
        try:
            yield
        finally:
            self._thaw()
            ended = random.getstate(), _state_of_numpy()
            for module, first, last in zip(("random", "numpy.random"), begun, ended, strict=True):
                if first != last and module not in self._seeded_by_user:
                    self._sources[f"{module} without a seed"] = None
            random.setstate(kept[0])
            np.random.set_state(kept[1])

    def seen_by(self, call: Callable[..., Any], *, is_step: bool = False) -> Callable[..., Any]:
        """Wrap a function of the controller so that it sees this time.

        Args:
            call: The function.
            is_step: Whether each call is a step of the run.
        """
        if self.only_watches:
            return call

        def frozen(*arguments: Any) -> Any:
            if is_step:
                self._steps += 1
                self._now = max(self._now, self._steps * self._time_step)
                self._read_here = 0
            try:
                self._freeze()
                return call(*arguments)
            finally:
                self._thaw()

        return frozen

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Note what is read in this block, which has all steps of the run.

        What is read is real, so the names may stay replaced between the steps.
        """
        if not self.only_watches:
            yield
            return
        self._steps = 1
        try:
            self._freeze()
            yield
        finally:
            self._thaw()

    # Neither is interrupted: half of the names would stay replaced.

    @unbreakable
    def _freeze(self) -> None:
        self._thread = threading.get_ident()
        for place, name, new in self._places:
            place[name] = new

    @unbreakable
    def _thaw(self) -> None:
        for (place, name, _), real in zip(self._places, self._real, strict=True):
            place[name] = real

    def _is_ours(self, depth: int = 2) -> bool:
        """Return True if the caller of a replaced function is ours, or another thread."""
        caller = str(sys._getframe(depth).f_globals.get("__name__", ""))
        return threading.get_ident() != self._thread or caller.startswith(_OURS)

    def _is_meant(self, source: str) -> bool:
        """Note where the caller of a replaced function is, unless it is ours.

        Return True if it is to get something else than the real clock or real chance.
        """
        if self._is_ours(3):
            return False
        # What ``reset`` reads is the same in every run.
        self._readings += self._steps > 0
        caller = sys._getframe(2)
        if all(not known.startswith(f"{source} (") for known in self._sources):
            place = f"{Path(caller.f_code.co_filename).name}:{caller.f_lineno}"
            self._sources[f"{source} ({place})"] = None
        return not self.only_watches

    def _read(self) -> float:
        self._read_here += 1
        if self._read_here > 1:
            self._now += _PER_READING if self._read_here <= _READINGS else _PER_LATE_READING
        return self._now

    def _next_seed(self) -> int:
        self._made += 1
        return (self._seed + self._made * 0x9E3779B97F4A7C15) & MASK64

    def _replacements(self) -> list[tuple[Any, str, Any]]:
        """Return each replaced name with its module and what replaces it."""
        clocks = [(name, 1.0) for name in _CLOCKS] + [(f"{name}_ns", 1e9) for name in _CLOCKS]
        return [
            *((time, name, self._clock(name, scale)) for name, scale in clocks),
            (time, "sleep", self._sleep(time.sleep)),
            (time, "gmtime", self._broken_down(time.gmtime)),
            (time, "localtime", self._broken_down(time.localtime)),
            (datetime, "datetime", self._dated(datetime.datetime)),
            (datetime, "date", self._dated(datetime.date)),
            (random, "Random", self._seeded(random.Random)),
            (random, "seed", self._seeding("random", random.seed)),
            (np.random, "seed", self._seeding("numpy.random", np.random.seed)),
            (np.random, "default_rng", self._seeding("numpy.random", np.random.default_rng)),
        ]

    def _clock(self, name: str, scale: float) -> Callable[[], Any]:
        real = getattr(time, name)
        kind = float if scale == 1.0 else round

        def clock() -> Any:
            return kind(self._read() * scale) if self._is_meant(f"time.{name}()") else real()

        return clock

    def _sleep(self, real: Callable[[float], None]) -> Callable[[float], None]:
        def sleep(seconds: float, /) -> None:
            if self.only_watches or self._is_ours():
                real(seconds)
            else:
                self._now += max(float(seconds), 0.0)

        return sleep

    def _broken_down(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def broken_down(seconds: float | None = None, /) -> Any:
            if seconds is None and self._is_meant(f"time.{real.__name__}()"):
                # Local time differs between machines.
                return time.gmtime(self._read())
            return real(seconds)

        return broken_down

    def _seeding(self, module: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def seeding(seed: Any = None, *more: Any, **named: Any) -> Any:
            if seed is None and self._is_meant(f"{module}.{real.__name__}() without a seed"):
                # NumPy's own generator takes no more bits.
                seed = self._next_seed() % 2**32
            elif real.__name__ == "seed":
                self._seeded_by_user.add(module)
            return real(seed, *more, **named)

        return seeding

    def _seeded(self, real: type[random.Random]) -> type:
        def new(_: type, seed: Any = None) -> random.Random:
            is_left = seed is None and self._is_meant("random.Random() without a seed")
            return real(self._next_seed() if is_left else seed)

        return _alias(real, {"__new__": new})

    def _dated(self, real: type) -> type:
        def moment(zone: datetime.tzinfo | None = None) -> datetime.datetime:
            now = _EPOCH + datetime.timedelta(seconds=self._read())
            return now.replace(tzinfo=None) if zone is None else now.astimezone(zone)

        def now(_: type, tz: datetime.tzinfo | None = None) -> Any:
            return moment(tz) if self._is_meant("datetime.now()") else real.now(tz)  # type: ignore[attr-defined]

        def utcnow(_: type) -> Any:
            return moment() if self._is_meant("datetime.utcnow()") else real.utcnow()  # type: ignore[attr-defined]

        def today(_: type) -> Any:
            if not self._is_meant(f"{real.__name__}.today()"):
                return real.today()  # type: ignore[attr-defined]
            return moment() if real is datetime.datetime else moment().date()

        def new(_: type, *arguments: Any, **named: Any) -> Any:
            return real(*arguments, **named)

        methods = {"__new__": new, "today": classmethod(today)}
        if real is datetime.datetime:
            methods |= {"now": classmethod(now), "utcnow": classmethod(utcnow)}
        return _alias(real, methods)


def _state_of_numpy() -> tuple[Any, ...]:
    """Return the state of NumPy's own generator in a form that can be compared."""
    name, keys, *rest = np.random.get_state()
    return name, np.asarray(keys).tobytes(), *rest


def _alias(real: type, methods: Mapping[str, Any]) -> type:
    """Return a class that stands for another one; its instances are those of the other."""

    class Alias(type):
        def __instancecheck__(cls, instance: object) -> bool:
            return isinstance(instance, real)

        def __subclasscheck__(cls, kind: type) -> bool:
            return issubclass(kind, real)

    return Alias(real.__name__, (real,), dict(methods))
