"""Run watchdogs over proved runs, and count what they miss and what they interrupt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import msgspec
import numpy as np

from fuzz.watchdogs.drives import Drive
from fuzz.watchdogs.watchdog import Watchdog, watchdog_named
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.plugins.registry import user_code
from worldgen.plugins.trust import admit_argument
from worldgen.support.intervals import interval_95


class WatchdogResult(msgspec.Struct, frozen=True):
    """How a watchdog did.

    Args:
        watchdog: Its name.
        loops: Proved loops that it was run over.
        missed: Names of those in which it raised no alarm.
        arrivals: Proved arrivals that it was run over.
        interrupted: Names of those in which it did.
        latencies: s from the beginning of each loop to the alarm, ascending; 0 if it came before.
    """

    watchdog: str
    loops: int
    missed: tuple[str, ...]
    arrivals: int
    interrupted: tuple[str, ...]
    latencies: tuple[float, ...]

    @property
    def missed_interval(self) -> tuple[float, float]:
        """95 % interval of the probability that it misses a loop."""
        return interval_95(len(self.missed), self.loops)

    @property
    def interrupted_interval(self) -> tuple[float, float]:
        """95 % interval of the probability that it interrupts an arrival."""
        return interval_95(len(self.interrupted), self.arrivals)

    def latency(self, share: float) -> float | None:
        """Return the latency that this share of the caught loops does not exceed, s."""
        if not self.latencies:
            return None
        last = len(self.latencies) - 1
        return median(self.latencies) if share == 0.5 else self.latencies[round(share * last)]


def judge(
    names: Sequence[str],
    drives: Sequence[Drive],
    *,
    horizon: float = 60.0,
    progress: Callable[[str], None] = lambda _: None,
) -> list[WatchdogResult]:
    """Run each watchdog over each run.

    Args:
        names: Names of the watchdogs; see :func:`watchdog_named`.
        drives: The runs.
        horizon: s after a loop's beginning in which the alarm has to come, or two periods if they
            take longer.
        progress: Called with what is being judged.

    Raises:
        InvalidParameter: If a name is unknown, or a watchdog fails or returns something else than a
            bool.
    """
    admit_argument(*names)
    results = []
    for name in names:
        watchdog = watchdog_named(name)
        beams = _beams_of(watchdog, name)
        missed: list[str] = []
        interrupted: list[str] = []
        latencies: list[float] = []
        loops = arrivals = 0
        for number, drive in enumerate(drives):
            progress(f"{name}, run {number + 1} of {len(drives)}")
            if beams and not drive.has_beams:
                continue
            alarm = _alarm(watchdog, name, drive, horizon, beams)
            loops += drive.loops
            arrivals += not drive.loops
            if drive.loops and alarm is not None:
                latencies.append(max(alarm - drive.entry, 0.0))
            elif drive.loops:
                missed.append(drive.name)
            elif alarm is not None:
                interrupted.append(drive.name)
        results.append(
            WatchdogResult(
                name, loops, tuple(missed), arrivals, tuple(interrupted), tuple(sorted(latencies))
            )
        )
    return results


def _alarm(watchdog: Watchdog, name: str, drive: Drive, horizon: float, beams: int) -> float | None:
    """Return when the watchdog raises the alarm, s from the start; None if it does not."""
    answer: Any = False
    time = 0.0
    # Entering this for each step would take longer than most watchdogs.
    with user_code(f"watchdog {name!r}"):
        watchdog.reset()
        for observation in drive.observations(horizon, beams):
            answer = watchdog.step(observation)
            time = observation.time
            # Anything but False is an alarm, or wrong.
            if answer is not False and (answer or not isinstance(answer, np.bool)):
                break
    if not isinstance(answer, bool | np.bool):
        raise InvalidParameter(
            "not-a-bool",
            "step() of watchdog {name!r} returned {answer}",
            "return True for an alarm, otherwise False",
            name=name,
            answer=repr(answer),
        )
    return time if answer else None


def _beams_of(watchdog: Watchdog, name: str) -> int:
    """Return how many beams a watchdog needs."""
    needs = getattr(watchdog, "needs", RobotOptions())
    if not isinstance(needs, RobotOptions):
        raise InvalidParameter(
            "wrong-needs",
            "needs of watchdog {name!r} is {needs}",
            "write needs = RobotOptions(beams=24)",
            name=name,
            needs=repr(needs),
        )
    return needs.beams
