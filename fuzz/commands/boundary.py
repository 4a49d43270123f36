"""``worldgen boundary``: find the value of one number at which a controller begins to fail."""

from __future__ import annotations

import bisect
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import CONTROLLER_HELP, PATH, SEED, emit_json, json_option, note, say
from worldgen.cli.usage import missing

if TYPE_CHECKING:
    from fuzz.boundary import Axis, BoundaryRun, Subject
    from fuzz.find import Stretch

EXAMPLES = (
    "\b\n  worldgen boundary w.grid --controller turn-right --axis radius\n"
    "  worldgen boundary failures/loop.grid --axis speed --json\n"
    "  worldgen boundary trap.grid --controller bug2 --axis depth\n"
    "  worldgen boundary w.grid --controller ./mine.py:Robot --axis lookahead"
)
# Number of values in a scan.
_POINTS = 65
# Factor above and below the scenario's own value.
_FACTOR = 2


@click.command(epilog=EXAMPLES)
@click.argument("path", type=PATH)
@click.option("--controller", help=f"{CONTROLLER_HELP} [default: the one in a failure's record]")
@click.option(
    "--motion", default="swept", show_default=True, help="Motion model, with --controller."
)
@click.option(
    "--time-step", type=float, help="Duration of a step, s, with --controller.  [default: 0.015]"
)
@click.option("--seed", type=SEED, default=0, help="Seed of random controllers.")
@click.option(
    "--axis",
    "name",
    required=True,
    metavar="radius|speed|time-step|heading|depth|FIELD",
    help="What to vary: the robot's radius or speed, the time step, the start heading, a trap's "
    "depth, or a field of your controller's class that is a number.",
)
@json_option
def boundary(
    path: Path,
    controller: str | None,
    motion: str,
    time_step: float | None,
    seed: int,
    name: str,
    as_json: bool,
) -> None:
    """Find the radius, speed, heading or field at which failures begin.

    Runs the scenario at 65 values, from half to twice the original (headings: a full turn; depths:
    1 to 65 cells; whole numbers: at least 32 more and less), and narrows each change down to two
    neighbouring values. It misses an outcome that changes twice between two of the values. Exits
    with 0 if the robot arrives at every value at which the target can be reached, with 1 otherwise.
    Ctrl-C reports the values run so far and exits with 130.
    """
    from fuzz.boundary import AXES, axis_of_field
    from fuzz.find import AxisScan
    from worldgen.errors import InvalidParameter
    from worldgen.parameters.known_names import nearest, unknown_name
    from worldgen.support.progress import working

    # A misspelt axis comes before a missing controller; its class may have a field of that name.
    if controller is None and name not in AXES and nearest(name, AXES):
        raise InvalidParameter.of(unknown_name("--axis {name!r} is not an axis", name, AXES))

    # Find the value to start from.
    subject = _subject(path, controller, motion, time_step, seed)
    if name in AXES and name.replace("-", "_") in {one.name for one in subject.scenario.fields}:
        note(f"note: --axis {name} is the robot's or the run's; rename the field {name} to vary it")
    axis = AXES.get(name) or axis_of_field(subject.scenario, name.replace("-", "_"))
    start = axis.index(subject)
    if start is None and axis.name == "radius":
        raise InvalidParameter(
            "no-radius",
            "the robot of {path} has a footprint, so there is no radius to vary",
            "vary another number, such as speed",
            path=path,
        )
    if start is None:
        raise InvalidParameter(
            "not-a-trap",
            "the provenance of {path} does not name the trap family, so there is no depth to vary",
            path=path,
        )
    # Scan the axis; Ctrl-C keeps what is known so far.
    seen: list[BoundaryRun] = []
    scan = AxisScan(subject, axis, _scanned(axis, start))
    stopped = False
    with working(f"running it at values of {axis.name}") as work:
        work.say(
            lambda: f"{len(seen)} runs, the last at {_amount(seen[-1].value, axis)}" if seen else ""
        )
        try:
            seen.extend(scan.run())
        except KeyboardInterrupt:
            stopped = True
    stretches = scan.stretches()
    # Print the ranges of values that have the same outcome.
    if as_json:
        emit_json(
            {"axis": axis.name, "unit": axis.unit, "stretches": [_plain(one) for one in stretches]}
        )
    else:
        for one in stretches:
            verdicts = f" ({', '.join(one.verdicts)})" if one.outcome == "fails" else ""
            values = "" if one.first == one.last else f"{one.first:g} to "
            values += _amount(one.last, axis)
            say(f"{axis.name} {values}: {one.outcome}{verdicts}, {one.runs} runs")
    if stopped:
        note("interrupted; these are the values run so far")
        raise SystemExit(130)
    if any(one.outcome == "fails" for one in stretches):
        raise SystemExit(1)


def _subject(
    path: Path, controller: str | None, motion: str, time_step: float | None, seed: int
) -> Subject:
    from fuzz.boundary import Subject
    from fuzz.failure import Failure
    from sim.episode.try_out import try_out
    from sim.options.run import RunOptions
    from sim.scenario import Scenario
    from worldgen.files.worlds import read_whole_world

    world = read_whole_world(path)
    if controller is not None:
        step = RunOptions.time_step if time_step is None else time_step
        scenario = Scenario.parse(controller, motion=motion, time_step=step, seed=seed)
        try_out(scenario)
        return Subject(world, scenario)
    failure = Failure.found_in(world)
    if failure is None:
        raise missing("controller", f"{path} holds no failure, which would name one")
    return Subject(failure.world, failure.scenario)


def _scanned(axis: Axis, start: int) -> range:
    """Return the indices of a scan, including the scenario's own value if an axis has no end."""
    if axis.name == "depth":
        return range(axis.low, axis.low + _POINTS)
    if axis.name == "heading":
        return range(axis.low, axis.high + 1, 5)
    value = axis.value(start)
    # Around zero, half and twice the value are the value itself.
    least, most = sorted((value / _FACTOR, value * _FACTOR)) if value else (-1.0, 1.0)
    if axis.is_whole:
        # Twice a small number is near, and a count is never negative.
        floor = 0.0 if value >= 0.0 else -math.inf
        least = max(min(least, value - _POINTS // 2), floor)
        most = max(most, value + _POINTS // 2)
    indices = range(axis.low, axis.high + 1)
    low = indices[bisect.bisect_left(indices, least, key=axis.value)]
    high = indices[bisect.bisect_right(indices, most, key=axis.value) - 1]
    step = max((high - low) // (_POINTS - 1), 1)
    return range(
        max(start - (start - low) // step * step, axis.low), min(high, axis.high) + 1, step
    )


def _amount(value: float, axis: Axis) -> str:
    return f"{value:g} {axis.unit}".rstrip()


def _plain(one: Stretch) -> dict[str, object]:
    return {
        "outcome": one.outcome,
        "first": one.first,
        "last": one.last,
        "verdicts": list(one.verdicts),
        "runs": one.runs,
    }
