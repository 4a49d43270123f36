"""A recorded trajectory, or a plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from worldgen.errors import InvalidParameter, Message
from worldgen.support.arrays import Floats

# Largest coordinate, m and also cells.
FURTHEST = 1e9

# Largest time, s.
_LATEST = 1e12

# Largest heading, rad; beyond it, float64 rounds too much.
_MOST_TURNED = 1e6


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The recorded positions of the robot's centre or axle, and its headings, or those of a plan.

    Args:
        times: (n,) float64, s, finite and never decreasing; at least two. For a plan, the number of
            each pose, from 0.
        x: (n,) float64, m, in the world's frame.
        y: (n,) float64, m, in the world's frame.
        headings: (n,) float64, rad, counter-clockwise from the x axis; ``None`` if unknown.
        is_plan: True for a plan without times.

    Raises:
        InvalidParameter: If the arrays break these rules; the message names the sample, counted
            from 0.
    """

    times: Floats
    x: Floats
    y: Floats
    headings: Floats | None = None
    is_plan: bool = False

    def __post_init__(self) -> None:
        names = ("times", "x", "y", *(() if self.headings is None else ("headings",)))
        for name in names:
            array = np.array(getattr(self, name), np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        fault = self.fault(self.times, self.x, self.y, self.headings)
        if fault is not None:
            sample, message = fault
            if sample >= 0:
                message = message.behind("trajectory: sample {sample}: ", sample=sample)
            raise InvalidParameter.of(message)

    @classmethod
    def plan(cls, x: Floats, y: Floats, headings: Floats | None = None) -> Trajectory:
        """Return a plan without times: poses in order, (n,) each, m, m and rad."""
        return cls(np.arange(len(x), dtype=np.float64), x, y, headings, is_plan=True)

    @staticmethod
    def fault(
        times: Floats, x: Floats, y: Floats, headings: Floats | None = None
    ) -> tuple[int, Message] | None:
        """Return the first sample that breaks a rule, and a message about it.

        The sample is -1 if the fault is in the trajectory as a whole. Without a fault, return
        ``None``.
        """
        columns = [("t", times, _LATEST), ("x", x, FURTHEST), ("y", y, FURTHEST)]
        if headings is not None:
            columns.append(("heading", headings, _MOST_TURNED))
        if any(values.shape != (len(x),) for _, values, _ in columns):
            return -1, Message(
                "wrong-shape", "trajectory: times, x, y and headings must be flat arrays of equal "
                "length",
            )  # fmt: skip
        if len(times) < 2:
            return -1, Message(
                "too-few-samples",
                "a trajectory needs at least two samples, not {count}",
                "use more",
                count=len(times),
            )
        for name, values, most in columns:
            with np.errstate(invalid="ignore"):
                wrong = np.flatnonzero(~(np.isfinite(values) & (np.abs(values) <= most)))
            if len(wrong):
                unit = {"t": "seconds", "heading": "radians"}.get(name, "metres")
                value = float(values[wrong[0]])
                return int(wrong[0]), Message(
                    "out-of-range",
                    "{name} = {value:g} is not a number of {unit}, or is too large",
                    "remove lines like this one",
                    name=name,
                    value=value,
                    unit=unit,
                )
        falls = np.flatnonzero(times[1:] < times[:-1])
        if len(falls):
            at = int(falls[0]) + 1
            return at, Message(
                "times-fall",
                "t = {time!r} s comes after {before!r} s",
                "sort the samples by time",
                time=float(times[at]),
                before=float(times[at - 1]),
            )
        return None
