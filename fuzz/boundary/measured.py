"""Measure the boundaries of a failure, and describe those in its record."""

from __future__ import annotations

import contextlib

from fuzz.boundary.axes import AXES, Axis, Subject
from fuzz.boundary.search import Boundary, BoundaryRuns, RecordedBoundary, nearest_boundary
from fuzz.failure import Failure
from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.noise import is_random
from sim.scenario import Scenario
from worldgen.files.json_file import converted
from worldgen.world import Value

# Axes measured for each failure; the others are only recorded if a strategy found them.
_MEASURED = ("radius", "speed", "time-step")


def is_bounded(scenario: Scenario) -> bool:
    """Return True if failures of a scenario have a boundary.

    Runs that depend on randomness have no boundaries.
    """
    controller = CONTROLLERS.get(scenario.controller)
    return not is_random(controller, scenario.run)


def subject_of(failure: Failure) -> Subject | None:
    """Return the subject to vary for a failure.

    It is ``None`` if the failure is not a failure to arrive, or depends on randomness.
    """
    if failure.oracle is not None or failure.is_breach:
        return None
    return Subject(failure.world, failure.scenario) if is_bounded(failure.scenario) else None


def with_boundaries(failure: Failure, found: Failure) -> Failure:
    """Return the failure with its boundaries in this world in its record.

    Compiled controllers are run at other radii, speeds and time steps. Others, whose runs take
    long, only vary along the axes on which the failure was found.

    Args:
        failure: Failure to complete.
        found: The failure as it was found.
    """
    subject = subject_of(failure)
    if subject is None:
        return failure
    axes = [AXES[one.axis] for one in _recorded(found)]
    if isinstance(CONTROLLERS.get(failure.record.controller), CompiledController):
        axes += [AXES[name] for name in _MEASURED if AXES[name] not in axes]
    begins: list[Value] = [
        boundary.record() for axis in axes if (boundary := _boundary(subject, axis)) is not None
    ]
    return failure.noting(boundaries=begins) if begins else failure


def _boundary(subject: Subject, axis: Axis) -> Boundary | None:
    start = axis.index(subject)
    return None if start is None else nearest_boundary(BoundaryRuns(subject, axis), start)


def _recorded(failure: Failure) -> list[RecordedBoundary]:
    """Return the boundaries in a failure's record.

    Records may come from anywhere, so malformed boundaries are skipped.
    """
    listed = failure.record.details.get("boundaries")
    found = []
    for one in listed if isinstance(listed, list) else []:
        with contextlib.suppress(ValueError):
            found.append(converted(one, RecordedBoundary))
    return [one for one in found if one.axis in AXES]


def describe_boundaries(failure: Failure) -> str:
    """Describe a failure's boundaries in words; empty if its record has none."""
    said = [
        f"{one.axis} {one.fails_at:g} {AXES[one.axis].unit} ({one.passes_at:g} passes)"
        for one in _recorded(failure)
    ]
    return f"begins at {', '.join(said)}" if said else ""
