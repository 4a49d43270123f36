"""Show a controller in Python simulated time and seeded chance, so that its runs repeat.

Only what its own code and the libraries that it calls read is replaced, and only while they run.
Code of ours that runs in the meantime, such as a deadline's signal handler, still reads the real
clock, and so do other threads.
"""

from __future__ import annotations

import copyreg
import datetime
import functools
import gc
import os
import random
import sys
import threading
import time
import types
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from sim.clock.stopping import unbreakable
from sim.controllers.crash_frames import is_users_file
from sim.controllers.hidden_state import attributes, modules_of_user
from worldgen.domain import MASK64

# Each reading in a step after the first takes a moment, so that no duration is zero: code that
# measures itself divides by it. A loop that waits for the clock would take forever that way. So after
# this many readings, which are more than a step needs to measure something, each further one takes
# longer: a planner that may think for 20 ms gets some forty rounds.
_READINGS = 16
_PER_READING = 1e-6  # s
_PER_LATE_READING = 1e-3  # s

# First steps of a run in which each call is seen, to notice a clock that is out of reach.
# Seeing them takes as long as the calls themselves, and whoever reads a clock does so early.
_STEPS_SEEN = 2

_OURS = ("sim.", "fuzz.", "worldgen.", "worldgen_plugins.")
# Clocks that count from an arbitrary moment, so that one time fits them all.
_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
# Those that turn a time into a text or its parts, and read the clock if they get none.
_OF_A_TIME = (time.gmtime, time.localtime, time.ctime, time.asctime, time.strftime)
_READERS = frozenset(
    {
        *(getattr(time, f"{name}{unit}") for name in _CLOCKS for unit in ("", "_ns")),
        *(
            getattr(time, name)
            for name in ("clock_gettime", "clock_gettime_ns")
            if hasattr(time, name)
        ),
        os.times,
        os.urandom,
    }
)
_READERS_OF_DATES = ("now", "today", "utcnow")
# Names by which nearly every other call is told apart at once.
_NAMES = frozenset({*_READERS_OF_DATES, *(one.__name__ for one in (*_OF_A_TIME, *_READERS))})
# NumPy's generators, and what seeds them.
_GENERATORS = ("RandomState", "SeedSequence", "MT19937", "PCG64", "PCG64DXSM", "Philox", "SFC64")
_DATE = datetime.date
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
        proves: Number of steps after which a run that proves a loop must read no clock that is out
            of reach; ``None`` for another run.
    """

    def __init__(
        self, seed: int, time_step: float, *, only_watches: bool = False, proves: int | None = None
    ) -> None:
        self.only_watches = only_watches
        self._proves = proves
        self._seed = seed
        self._time_step = time_step
        self._now = 0.0
        self._steps = 0
        self._made = 0
        self._readings = 0
        self._read_here = 0
        # How to set each place, what it really holds, and what replaces that.
        self._places: list[tuple[Callable[[Any], None], Any, Any]] = []
        self._thread = 0
        self._sources: dict[str, None] = {}
        self._out_of_reach: set[str] = set()
        self._seeded_by_user: set[str] = set()

    @property
    def sources(self) -> tuple[str, ...]:
        """What it has read that differs from run to run without this, each with its first line."""
        return tuple(self._sources)

    @property
    def out_of_reach(self) -> tuple[str, ...]:
        """Those of the sources that cannot be frozen where it holds them, as far as was noticed."""
        return tuple(sorted(self._out_of_reach))

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
        news = {id(getattr(place, name)): new for place, name, new in replaced}
        self._places = [
            (functools.partial(setattr, place, name), getattr(place, name), new)
            for place, name, new in replaced
        ]
        # ``from time import monotonic`` has made a name of its own.
        parts = (controller, *getattr(controller, "made_of", ()))
        modules = [*dict.fromkeys(one for part in parts for one in modules_of_user(type(part)))]
        self._places += [
            (functools.partial(setattr, module, name), value, news[id(value)])
            for module in modules
            for name, value in vars(module).items()
            if id(value) in news
        ]
        if self.only_watches:
            yield
            return
        self._places += _held(parts, modules, news)
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
            sees_all = is_step and self._steps <= _STEPS_SEEN and sys.getprofile() is None
            try:
                self._freeze()
                if sees_all:
                    sys.setprofile(self._note_real)
                return call(*arguments)
            finally:
                if sees_all:
                    sys.setprofile(None)
                self._thaw()

        return frozen

    def seen_in_time(self, act: Callable[..., Any]) -> Callable[..., Any]:
        """Wrap a method that acts so that not all of its calls are seen, but those that prove a loop.

        Seeing them takes as long as the calls themselves. Those of the first steps are seen, too,
        because whoever reads a clock does so early. Call the result in :meth:`watching`.
        """
        first = (self._proves or 0) if self.only_watches else 0
        # Another profiler's place is not taken.
        if first <= _STEPS_SEEN or sys.getprofile() is not None:
            return act
        steps = 0

        def counted(*arguments: Any) -> Any:
            nonlocal steps
            if steps == _STEPS_SEEN:
                sys.setprofile(None)
            elif steps == first:
                sys.setprofile(self._note_real)
            steps += 1
            return act(*arguments)

        return counted

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Note what is read in this block, which has all steps of the run.

        What is read is real, so the names may stay replaced between the steps.
        """
        # Another profiler's place is not taken.
        sees_all = self._proves is not None and sys.getprofile() is None
        if self.only_watches:
            self._steps = 1
        try:
            if self.only_watches:
                self._freeze()
            if sees_all:
                sys.setprofile(self._note_real)
            yield
        finally:
            if sees_all:
                sys.setprofile(None)
            self._thaw()

    def _note_real(self, frame: types.FrameType, event: str, called: Any) -> None:
        """Note a call of a real clock, or of the system's chance, wherever the caller got it from.

        Names that are replaced call the real one from here, so what is left is out of reach: a
        clock in a class, a closure or a library.
        """
        if event != "c_call" or getattr(called, "__name__", "") not in _NAMES:
            return
        is_of_a_date = (
            called.__name__ in _READERS_OF_DATES
            and isinstance(owner := getattr(called, "__self__", None), type)
            and issubclass(owner, datetime.date)
        )
        # A library passes them a time: logging does in each line.
        is_of_a_time = called in _OF_A_TIME and is_users_file(frame.f_code.co_filename)
        if not (is_of_a_date or is_of_a_time or called in _READERS):
            return
        if _is_of_the_collector(frame):
            return
        caller: types.FrameType | None = frame
        while caller is not None and not _is_own(caller):
            if is_users_file(caller.f_code.co_filename):
                break
            caller = caller.f_back
        if caller is None or _is_own(caller):
            return
        module = "os" if called.__module__ == "posix" else called.__module__
        source = "datetime." if is_of_a_date else f"{module}."
        self._out_of_reach.add(self._note(f"{source}{called.__name__}()", caller))

    # Neither is interrupted: half of the names would stay replaced.

    @unbreakable
    def _freeze(self) -> None:
        self._thread = threading.get_ident()
        copyreg.dispatch_table.update(_REDUCED)
        for place, _, new in self._places:
            place(new)

    @unbreakable
    def _thaw(self) -> None:
        for kind in _REDUCED:
            copyreg.dispatch_table.pop(kind, None)
        for place, real, _ in self._places:
            place(real)

    def _is_ours(self, depth: int = 2) -> bool:
        """Return True if the caller of a replaced function is ours, or none of the controller's."""
        frame = sys._getframe(depth)
        caller = str(frame.f_globals.get("__name__", ""))
        return (
            threading.get_ident() != self._thread
            or caller.startswith(_OURS)
            or _is_of_the_collector(frame)
        )

    def _is_meant(self, source: str) -> bool:
        """Note where the caller of a replaced function is, unless it is ours.

        Return True if it is to get something else than the real clock or real chance.
        """
        if self._is_ours(3):
            return False
        # What ``reset`` reads is the same in every run.
        self._readings += self._steps > 0
        self._note(source, sys._getframe(2))
        return not self.only_watches

    def _note(self, source: str, caller: types.FrameType) -> str:
        """Note a source unless it is known from another line; return it with its first line."""
        for known in self._sources:
            if known.startswith(f"{source} ("):
                return known
        noted = f"{source} ({Path(caller.f_code.co_filename).name}:{caller.f_lineno})"
        self._sources[noted] = None
        return noted

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
            *(
                (time, name, self._numbered(name, scale))
                for name, scale in (("clock_gettime", 1.0), ("clock_gettime_ns", 1e9))
                if hasattr(time, name)
            ),
            (os, "times", self._times(os.times)),
            (time, "gmtime", self._broken_down(time.gmtime)),
            (time, "localtime", self._broken_down(time.localtime)),
            (time, "ctime", self._text_of(time.ctime, time.asctime)),
            (time, "asctime", self._text_of(time.asctime, time.asctime)),
            (time, "strftime", self._formatted(time.strftime)),
            (datetime, "datetime", self._dated(datetime.datetime)),
            (datetime, "date", self._dated(datetime.date)),
            (random, "Random", self._seeded(random.Random)),
            *(
                (np.random, name, self._seeded_by_argument(getattr(np.random, name)))
                for name in _GENERATORS
            ),
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

    def _numbered(self, name: str, scale: float) -> Callable[[int], Any]:
        real = getattr(time, name)
        kind = float if scale == 1.0 else round

        def clock(number: int, /) -> Any:
            return kind(self._read() * scale) if self._is_meant(f"time.{name}()") else real(number)

        return clock

    def _times(self, real: Callable[[], os.times_result]) -> Callable[[], os.times_result]:
        def times() -> os.times_result:
            if not self._is_meant("os.times()"):
                return real()
            now = self._read()
            return os.times_result((now, 0.0, 0.0, 0.0, now))

        return times

    def _text_of(self, real: Callable[..., str], of: Callable[..., str]) -> Callable[..., str]:
        real_gmtime = time.gmtime

        def text(moment: Any = None, /) -> str:
            if moment is None and self._is_meant(f"time.{real.__name__}()"):
                return of(real_gmtime(self._read()))
            return real() if moment is None else real(moment)

        return text

    def _formatted(self, real: Callable[..., str]) -> Callable[..., str]:
        real_gmtime = time.gmtime

        def formatted(style: str, moment: Any = None, /) -> str:
            if moment is None and self._is_meant("time.strftime()"):
                return real(style, real_gmtime(self._read()))
            return real(style) if moment is None else real(style, moment)

        return formatted

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
        def begin(self_: random.Random, seed: Any = None) -> None:
            is_left = seed is None and self._is_meant("random.Random() without a seed")
            real.__init__(self_, self._next_seed() if is_left else seed)

        return _alias(real, random, {"__init__": begin})

    def _seeded_by_argument(self, real: type) -> type:
        def new(_: type, seed: Any = None, *more: Any, **named: Any) -> Any:
            source = f"numpy.random.{real.__name__}() without a seed"
            # Each class has its own name for it.
            given = next((named.pop(one) for one in ("seed", "entropy") if one in named), seed)
            if given is None and self._is_meant(source):
                given = self._next_seed() % 2**32
            return real(given, *more, **named)

        return _alias(real, np.random, {"__new__": new})

    def _dated(self, real: type) -> type:
        def moment(kind: Any, zone: datetime.tzinfo | None = None) -> Any:
            now = _EPOCH + datetime.timedelta(seconds=self._read())
            now = now.replace(tzinfo=None) if zone is None else now.astimezone(zone)
            if real is _DATE:
                return kind(now.year, now.month, now.day)
            return kind.combine(now.date(), now.time(), now.tzinfo)

        # The real ones make instances of the class that they are called on, too.
        def now(kind: type, tz: datetime.tzinfo | None = None) -> Any:
            if self._is_meant("datetime.now()"):
                return moment(kind, tz)
            return vars(real)["now"].__get__(None, kind)(tz)

        def utcnow(kind: type) -> Any:
            if self._is_meant("datetime.utcnow()"):
                return moment(kind)
            return vars(real)["utcnow"].__get__(None, kind)()

        def today(kind: type) -> Any:
            if self._is_meant(f"{real.__name__}.today()"):
                return moment(kind)
            return vars(_DATE)["today"].__get__(None, kind)()

        methods: dict[str, Any] = {"today": classmethod(today)}
        if real is not _DATE:
            methods |= {"now": classmethod(now), "utcnow": classmethod(utcnow)}
        return _alias(real, datetime, methods)


def _is_of_the_collector(frame: types.FrameType | None) -> bool:
    """Return True if the garbage collector has called, which it does in any step.

    Hypothesis measures it so, with a clock that is not the controller's.
    """
    callbacks = {getattr(one, "__code__", None) for one in gc.callbacks}
    while callbacks and frame is not None:
        if frame.f_code in callbacks:
            return True
        frame = frame.f_back
    return False


def _is_own(frame: types.FrameType) -> bool:
    return str(frame.f_globals.get("__name__", "")).startswith(_OURS)


def _held(
    parts: tuple[object, ...], modules: list[types.ModuleType], news: Mapping[int, Any]
) -> list[tuple[Callable[[Any], None], Any, Any]]:
    """Return the places outside module names in which a user's code holds something replaced.

    Args:
        parts: The controller and its parts.
        modules: The user's modules.
        news: By the identity of what is replaced, what replaces it.

    Returns:
        How to set each place, what it holds, and what it is to hold. A clock in any other place,
        such as a ``functools.partial``, stays real; a run that proves a loop notices it.
    """
    names = {one.__name__ for one in modules}
    places: list[tuple[Callable[[Any], None], Any, Any]] = []

    def take(set_: Callable[[Any], None], value: Any) -> None:
        inner = value.__func__ if isinstance(value, staticmethod) else value
        if id(inner) in news:
            new = news[id(inner)]
            places.append((set_, value, staticmethod(new) if inner is not value else new))
        elif isinstance(inner, types.FunctionType) and inner.__module__ in names:
            take_function(inner)
        elif isinstance(value, dict | list):
            items = value.items() if isinstance(value, dict) else enumerate(value)
            places.extend(
                (functools.partial(value.__setitem__, key), one, news[id(one)])
                for key, one in items
                if id(one) in news
            )

    def take_function(function: types.FunctionType) -> None:
        old = function.__defaults__ or ()
        new = tuple(news.get(id(one), one) for one in old)
        if any(one is not other for one, other in zip(old, new, strict=True)):
            places.append((functools.partial(setattr, function, "__defaults__"), old, new))
        named = function.__kwdefaults__ or {}
        for name, value in named.items():
            if id(value) in news:
                places.append((functools.partial(named.__setitem__, name), value, news[id(value)]))
        for cell in function.__closure__ or ():
            value = cell.cell_contents if cell != types.CellType() else None
            if id(value) in news:
                set_ = functools.partial(setattr, cell, "cell_contents")
                places.append((set_, value, news[id(value)]))

    kinds = [base for part in parts for base in type(part).__mro__ if base.__module__ in names]
    for module in modules:
        for name, value in vars(module).items():
            if isinstance(value, type) and value.__module__ in names:
                kinds.append(value)
            # Names themselves are replaced in any case.
            elif id(value) not in news:
                take(functools.partial(setattr, module, name), value)
    for kind in dict.fromkeys(kinds):
        for name, value in vars(kind).items():
            take(functools.partial(setattr, kind, name), value)
    for part in parts:
        for name, value in attributes(part).items():
            # A frozen dataclass refuses the usual way of setting an attribute.
            take(functools.partial(object.__setattr__, part, name), value)
    return places


def _state_of_numpy() -> tuple[Any, ...]:
    """Return the state of NumPy's own generator in a form that can be compared."""
    name, keys, *rest = np.random.get_state()
    return name, np.asarray(keys).tobytes(), *rest


def _alias(real: Any, module: types.ModuleType, methods: Mapping[str, Any]) -> type:
    """Return a class that stands for another one, and has the instances of the other, too.

    Its own instances are pickled as those of the class that its name in the module then means.
    """

    class Alias(type):
        def __instancecheck__(cls, instance: object) -> bool:
            return (
                isinstance(instance, real) if cls is made else super().__instancecheck__(instance)
            )

        def __subclasscheck__(cls, kind: type) -> bool:
            return issubclass(kind, real) if cls is made else super().__subclasscheck__(kind)

    def reduced(self: Any, protocol: Any) -> Any:
        kind, *rest = real.__reduce_ex__(self, protocol)
        return getattr(module, real.__name__) if kind is made else kind, *rest

    names = {"__module__": real.__module__, "__reduce_ex__": reduced}
    made = Alias(real.__name__, (real,), names | dict(methods))
    return made


def _reduced(module: types.ModuleType, real: Any) -> Callable[[Any], tuple[Any, ...]]:
    return lambda one: (getattr(module, real.__name__), *real.__reduce_ex__(one, 2)[1:])


# How instances of the real classes are pickled while their names mean others.
_REDUCED: dict[type, Callable[[Any], tuple[Any, ...]]] = {
    real: _reduced(module, real)
    for module, real in (
        (datetime, datetime.datetime),
        (datetime, datetime.date),
        (random, random.Random),
    )
}
