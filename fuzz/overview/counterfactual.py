"""Explain a failure by counterfactuals: the smallest changes after which the robot arrives.

A failure shows that a controller does not arrive. A developer needs to know which detail it depends
on: one wall, a radius that is a millimetre too large, a heading, an option. So each of these is
changed alone, and the changed scenario runs again with the budget of a fresh proof. A change counts
only if the target is still provably reachable, so no change makes the world easier by cheating.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fuzz.boundary import (
    AXES,
    Axis,
    BoundaryRun,
    BoundaryRuns,
    Subject,
    axis_of_field,
    nearest_boundary,
    run_subject,
    subject_of,
)
from fuzz.facts.changed_worlds import SMALLER_BODIES, smaller
from fuzz.failure import Failure
from sim.clock.stopping import OutOfTime, check_time
from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.catalogue import own_words
from sim.controllers.learning import LEARNED
from sim.controllers.noise import is_noisy
from sim.episode import Episode
from sim.evidence import LoopEvidence
from sim.options.run import switch_sets
from sim.outcome import Outcome
from sim.verdict import ARRIVALS, OUT_OF_BUDGET
from worldgen.errors import InvalidParameter
from worldgen.parameters import Parameter, with_options
from worldgen.support.plain_text import alternatives
from worldgen.world import Pose, Value, World

# Numbers that every scenario has. A different start heading explains more than a different time
# step, so this is also the order in which they are reported.
_AXES = ("heading", "radius", "speed", "time-step")

# Number of indices of an axis to search on either side: half a turn, and a factor of about four.
_REACH = {"heading": 180}
_REACH_OF_NUMBERS = 512

# The kinds of changes in the order of a report.
_ORDER = ("cell", "memory", "event", "option", "field", "footprint", *_AXES)

# The witness's times of an early run, and limits on the cells and on the other changes
# that get one: together these runs take as long as four that do not arrive in the full budget.
_EARLY = 8.0
_MOST_EARLY = 12

# Limit on the solid cells that are freed one by one, those nearest to the repeated part of the path
# first. A shrunk failure has a dozen; in a world of thousands the wall that matters is close to the
# path.
_MOST_CELLS = 256

# Limit on the events that are dropped one by one.
_MOST_EVENTS = 64

# Limit on the places of a loop at which the robot starts without memory.
_MOST_RESTARTS = 8

# Words of a recorded state between the pose and the memory.
_SPEED_AND_DRAWS = slice(3, 5)

# Limit on the simulated steps of one explanation: about a second of the C core, and of Python code.
_MOST_STEPS = 30_000_000
_MOST_STEPS_IN_PYTHON = 300_000

# Runs that the search for the nearest value of a number takes, about.
_RUNS_OF_AN_AXIS = 10

# Fields of the controller's class are tried with this share of the steps that are left: a class may
# have dozens, and the robot's own numbers come after them.
_SHARE_OF_FIELDS = 1 / 3

# First and largest distance from a field's own value, in three-digit numbers: 4 to 28 percent, and a
# factor of ten or more, because a value that somebody guessed may be far off.
_FIRST_STEP_OF_FIELDS = 32
_REACH_OF_FIELDS = 1024

# Largest distance from a whole number's own value, at least.
_REACH_OF_WHOLE = 64

_MOST_NAMED = 3

# Largest changes that are reported as slight: a fraction of the number, and degrees.
_SLIGHT = 0.03
_SLIGHT_TURN = 3.0


@dataclass(frozen=True)
class Change:
    """One change of a failure's scenario, after which the robot arrives.

    Args:
        what: ``cell`` (a solid cell is free), ``memory`` (it starts without memory in its loop),
            ``event`` (a cell does not change), ``option`` (an option of the run, or the
            controller's own, is at its default), ``field`` (a field of the controller's class has
            another value), ``footprint`` (it has a share of its size), or the name of one of
            :data:`fuzz.boundary.AXES`.
        value: The value with which the robot arrives: the cell ``[ix, iy]``, the pose
            ``[x, y, heading]``, the option's name, the field's name and value, or a number.
        was: The value in the failure: the time of the event in s, the option's value, or the
            number.
        unit: Unit of a number, such as ``m``.
    """

    what: str
    value: Any
    was: Any = None
    unit: str = ""

    @property
    def is_slight(self) -> bool:
        """True for a number that hardly changes: a heading by 3 degrees, others by 3 %."""
        if not isinstance(self.value, int | float) or not isinstance(self.was, int | float):
            return False
        if self.what == "option":
            return False
        limit = _SLIGHT_TURN if self.what == "heading" else _SLIGHT * abs(self.was)
        return abs(self.value - self.was) <= limit

    def describe(self) -> str:
        """Return the change as a condition: ``if cell (3, 4) is free``."""
        match self.what:
            case "cell":
                return f"if cell {_cell(self.value)} is free"
            case "memory":
                return "if its memory is cleared in the loop"
            case "event":
                return f"if cell {_cell(self.value)} does not change at {self.was:g} s"
            case "option":
                return f"without +{self.value}{'' if self.was is True else f'={self.was}'}"
            case "footprint":
                return f"with a footprint of {self.value:g} times its size"
            case "field":
                field, value = self.value
                return f"with {field} {_short(value)} instead of {_short(self.was)}"
        name = self.what.replace("-", " ")
        return f"with {name} {self.value:g} {self.unit} instead of {self.was:g} {self.unit}"


@dataclass(frozen=True)
class Counterfactuals:
    """The changes of one failure that make its robot arrive.

    Args:
        changes: Cells first, nearest to the repeated part of the path first; then memory, events,
            options and numbers.
        runs: Number of changed scenarios that ran.
        is_complete: False if the runs took too many steps for all changes to be tried.
    """

    changes: tuple[Change, ...]
    runs: int
    is_complete: bool

    @property
    def cells(self) -> list[tuple[int, int]]:
        """The cells that one of the changes concerns, to be marked in a picture."""
        return named_cells(self.changes)

    def table(self) -> dict[str, object]:
        """Return the form of this record in JSON."""
        return {
            "changes": [vars(change) for change in self.changes],
            "runs": self.runs,
            "complete": self.is_complete,
            "sentence": self.describe(),
        }

    def describe(self) -> str:
        """Return one sentence: ``arrives if cell (3, 4) is free, or with radius 0.06 m ...``."""
        if self.changes:
            return describe_changes(self.changes)
        tried = f"{self.runs} single changes of its walls, robot and options"
        return f"fails with each of {tried}" + ("" if self.is_complete else " that were tried")


def describe_changes(changes: Sequence[Change], most: int | None = None) -> str:
    """Return with which of the changes a robot arrives, to follow ``it``.

    Args:
        changes: At least one.
        most: Conditions to name, the others are counted; ``None`` for all.
    """
    others = [change for change in changes if change.what != "cell"]
    slight = [change.what.replace("-", " ") for change in others if change.is_slight]
    conditions = [_describe_cells(changes)]
    conditions += [change.describe() for change in others if not change.is_slight]
    # If the slightest change helps, its exact size does not matter.
    if slight:
        conditions.append(f"with a slightly different {alternatives(slight)}")
    known = [condition for condition in conditions if condition]
    shown = known[:most]
    more = f" (or {len(known) - len(shown)} more)" if len(known) > len(shown) else ""
    if len(shown) > 1:
        return f"arrives {', '.join(shown[:-1])}, or {shown[-1]}{more}"
    return f"arrives {shown[0]}{more}"


def _describe_cells(changes: Iterable[Change]) -> str:
    cells = [change.value for change in changes if change.what == "cell"]
    if len(cells) <= 1:
        return "".join(f"if cell {_cell(cell)} is free" for cell in cells)
    named = ", ".join(_cell(cell) for cell in cells[:_MOST_NAMED])
    more = len(cells) - _MOST_NAMED
    others = f" or one of {more} others" if more > 1 else " or one other" if more == 1 else ""
    return f"if one of the cells {named}{others} is free"


def named_cells(changes: Iterable[Change], world: World | None = None) -> list[tuple[int, int]]:
    """Return the cells that changes concern.

    Args:
        changes: The changes; they may come from any file.
        world: Only return cells of this world; ``None`` for all cells.
    """
    found: list[tuple[int, int]] = []
    for change in changes:
        match change:
            case Change("cell" | "event", [int(ix), int(iy)]) if (ix, iy) not in found:
                found.append((ix, iy))
    if world is None:
        return found
    return [(ix, iy) for ix, iy in found if 0 <= ix < world.width and 0 <= iy < world.height]


def counterfactuals(
    failure: Failure,
    *,
    effort: float = 1.0,
    most_steps: float = math.inf,
    most_runs: float = math.inf,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Counterfactuals:
    """Return the single changes after which a failure's robot arrives.

    Short runs with the changes that tell most come first, and what they leave open last, because
    time may run out before a slow controller has run with each change.

    Deterministic, unless :func:`sim.clock.stopping.stopping_when` ends it before all changes are
    tried: equal failures give equal answers, on every machine.

    Args:
        failure: A robot that does not arrive.
        effort: Fraction of the usual number of steps that it may take.
        most_steps: Limit on these steps, for a slow controller.
        most_runs: Limit on the changes to run. In a large world the proof takes longer than a run.
        progress: Called after each run with the number of runs so far, and about how many are made
            in all.

    Raises:
        InvalidParameter: If no single change can explain the failure: its outcome depends on
            randomness, an oracle reported it, or its target is walled off.
        WorldgenError: If the controller is unknown here.
    """
    subject = _subject(failure)
    search = _ChangedRuns(subject, effort, most_steps, most_runs, progress)
    changes: list[Change] = []
    tries: list[_Try] = []
    is_complete = False
    with contextlib.suppress(_OutOfStepsError, OutOfTime):
        tries = [*_tries(subject, failure.run())]
        for change in _changes(search, tries):
            changes.append(change)
        is_complete = not search.is_cut
    # The order of a report is not that of the runs.
    order = [one.change for one in tries]
    changes.sort(key=lambda one: (_ORDER.index(one.what), order.index(one) if one in order else 0))
    return Counterfactuals(tuple(changes), search.runs, is_complete)


def _subject(failure: Failure) -> Subject:
    """Return the scenario to change.

    Raises:
        InvalidParameter: If no single change can explain the failure.
    """
    subject = subject_of(failure)
    if subject is not None:
        return subject
    if failure.oracle is not None or failure.is_breach:
        how = "is a failure only because an oracle objects"
        if failure.is_breach:
            how = "fails because it reaches a walled-off target"
    else:
        # A library that declares no senses has them all, but this run may draw no random number.
        subject = Subject(failure.world, failure.scenario)
        controller = CONTROLLERS.get(subject.scenario.controller)
        if not failure.world.is_fleet and not is_noisy(controller, subject.scenario.run):
            ran = run_subject(subject)
            if ran is not None and isinstance(ran[1], Outcome) and not ran[1].random_draws:
                return subject
        how = "may fail by chance, because random numbers may decide its run"
    raise InvalidParameter(
        "no-counterfactual",
        "{who} {how}, which no single change explains",
        "explain a failure of a robot that never arrives, whatever it draws",
        who=failure.who,
        how=how,
    )


class _OutOfStepsError(Exception):
    """Raised if the runs of one explanation took too many steps."""


class _ChangedRuns:
    """Runs changed scenarios and counts their steps."""

    def __init__(
        self,
        subject: Subject,
        effort: float,
        most_steps: float,
        most_runs: float,
        progress: Callable[[int, int], None],
    ) -> None:
        self.subject = subject
        self.runs = 0
        self._progress = progress
        world = subject.world
        self._about = (
            min(int(world.walls.sum()), _MOST_CELLS)
            + min(len(world.timeline), _MOST_EVENTS)
            + len(subject.scenario.run.changed())
            + _RUNS_OF_AN_AXIS * len(_AXES)
        )
        self.is_cut = False
        self._most_runs = most_runs
        controller = CONTROLLERS.get(subject.scenario.controller)
        is_compiled = isinstance(controller, CompiledController)
        usual = effort * (_MOST_STEPS if is_compiled else _MOST_STEPS_IN_PYTHON)
        self._left = min(usual, most_steps)

    def arrives(self, subject: Subject) -> bool:
        """Return True if the robot arrives, and does nothing else that is wrong."""
        return bool(self.arrives_within(math.inf, subject))

    def arrives_within(self, multiple: float, subject: Subject) -> bool | None:
        """Return the same for a shorter budget, a multiple of the witness's time.

        ``None`` if the run is over before that shows.
        """
        ran = run_subject(subject, multiple=multiple)
        if ran is None:
            return False
        self._count(ran[1].steps)
        is_short = multiple < math.inf and ran[1].verdict in OUT_OF_BUDGET
        return None if is_short else ran[1].verdict in ARRIVALS

    def boundary(self, name: str) -> Change | None:
        """Return the nearest value of an axis at which the robot arrives, if there is one."""
        axis = AXES[name]
        index = axis.index(self.subject)
        if index is None:
            return None
        found = self._nearest(axis, index, _REACH.get(name, _REACH_OF_NUMBERS))
        if found is None:
            return None
        return Change(name, found, axis.value(index), axis.unit)

    def field(self, field: Parameter) -> Change | None:
        """Return the nearest value of a class's field at which the robot arrives, if there is one.

        Words have no neighbours, so they are left alone.
        """
        scenario = self.subject.scenario
        own = scenario.value_of(field)
        if isinstance(own, bool):
            other = replace(self.subject, scenario=scenario.with_option(field.name, not own))
            return Change("field", [field.name, not own], own) if self.arrives(other) else None
        if not isinstance(own, int | float):
            return None
        axis = axis_of_field(scenario, field.name)
        index = axis.index(self.subject)
        if index is None:
            return None
        if isinstance(own, int):
            found = self._nearest(axis, index, max(2 * abs(own), _REACH_OF_WHOLE))
        else:
            found = self._nearest(axis, index, _REACH_OF_FIELDS, _FIRST_STEP_OF_FIELDS)
        return None if found is None else Change("field", [field.name, field.kind(found)], own)

    def _nearest(self, axis: Axis, index: int, reach: int, step: int = 1) -> float | None:
        runs = BoundaryRuns(self.subject, axis, seen=self._count_run)
        found = nearest_boundary(runs, index, reach=reach, step=step)
        return None if found is None else found.passes.value

    @contextmanager
    def within(self, share: float) -> Iterator[None]:
        """End the block once it has used up a share of the steps that are left."""
        kept = self._left * (1.0 - share)
        self._left -= kept
        try:
            yield
        except _OutOfStepsError:
            if self.runs > self._most_runs:
                raise
            self.is_cut = True
        finally:
            self._left += kept

    def _count_run(self, run: BoundaryRun) -> None:
        self._count(run.outcome.steps)

    def _count(self, steps: int) -> None:
        check_time()
        self.runs += 1
        self._left -= steps
        self._progress(self.runs, max(self._about, self.runs))
        if self._left < 0 or self.runs > self._most_runs:
            raise _OutOfStepsError


class _Try(NamedTuple):
    """A change to try, with the scenario in which the robot may arrive."""

    change: Change
    subject: Subject


def _changes(search: _ChangedRuns, tries: Sequence[_Try]) -> Iterator[Change]:
    """Yield the changes after which the robot arrives, those first that cost little and tell most."""
    cells = [one for one in tries if one.change.what == "cell"]
    restarts = [one for one in tries if one.change.what == "memory"]
    others = [one for one in tries if one.change.what not in ("cell", "memory")]

    # Most robots that arrive do so soon. The answers of the others are known when they run longer.
    left = []
    for one in cells[:_MOST_EARLY] + restarts[:1] + others[:_MOST_EARLY]:
        arrives = search.arrives_within(_EARLY, one.subject)
        if arrives:
            yield one.change
        elif arrives is None:
            left.append(one)
        if one.change.what == "memory" and not arrives:
            left += restarts[1:]
    yield from _field_changes(search)
    yield from _boundaries(search)
    yield from _helpful(search, left + cells[_MOST_EARLY:] + others[_MOST_EARLY:])


def _helpful(search: _ChangedRuns, tries: Iterable[_Try]) -> Iterator[Change]:
    """Yield those changes after which the robot arrives."""
    helped = set()
    for one in tries:
        # Of the places where the memory is cleared, and of the sizes, the first is enough.
        is_needless = one.change.what in ("memory", "footprint") and one.change.what in helped
        if not is_needless and search.arrives(one.subject):
            helped.add(one.change.what)
            yield one.change


def _boundaries(search: _ChangedRuns) -> Iterator[Change]:
    for name in _AXES:
        change = search.boundary(name)
        if change is not None:
            yield change


def _tries(subject: Subject, episode: Episode) -> Iterator[_Try]:
    """Yield the changes to try one by one, in the order of a report."""
    for ix, iy in _solid_cells(subject, episode):
        walls = subject.world.walls.copy()
        walls[iy, ix] = False
        yield _Try(Change("cell", [ix, iy]), _with_world(subject, walls=walls))
    yield from _restarts(subject, episode)
    yield from _events(subject)
    yield from _options(subject)
    # Discs have an axis of their radius.
    robot = subject.world.robots[0]
    for share in () if robot.is_disc else reversed(SMALLER_BODIES):
        robots = (smaller(robot, share),)
        yield _Try(Change("footprint", share, 1.0), _with_world(subject, robots=robots))


def _restarts(subject: Subject, episode: Episode) -> Iterator[_Try]:
    """Yield places of the loop from which a robot starts without memory.

    If it arrives from one, its memory, not its place, keeps it in the loop.
    """
    loop = episode.evidence
    trace = episode.trace
    # In a world that changes, the walls would be different after a new start.
    if not isinstance(loop, LoopEvidence) or trace is None or subject.world.is_dynamic:
        return
    # A robot without memory has none to lose, and pushes would happen again. The thesis's robot
    # does not show its state.
    if not trace.memory_size or trace.robot is None or trace.robot.pushes:
        return

    # Nothing but the memory may change, so restart only where everything else in the state except
    # the pose is as at a start.
    own = trace.states[loop.entry : loop.entry + loop.period, _SPEED_AND_DRAWS]
    steps = loop.entry + np.flatnonzero((own == trace.states[0, _SPEED_AND_DRAWS]).all(axis=1))
    every = max(1.0, len(steps) / _MOST_RESTARTS)
    for step in steps[np.arange(0, len(steps), every).astype(int)].tolist():
        pose = [float(values[step]) for values in (trace.x, trace.y, trace.heading)]
        yield _Try(Change("memory", list(pose)), _with_world(subject, start=Pose(*pose)))


def _events(subject: Subject) -> Iterator[_Try]:
    timeline = subject.world.timeline
    for number, event in enumerate(timeline):
        if number == _MOST_EVENTS:
            return
        change = Change("event", [event.ix, event.iy], event.time)
        yield _Try(change, _with_world(subject, timeline=timeline.without(number)))


def _options(subject: Subject) -> Iterator[_Try]:
    scenario = subject.scenario
    given = scenario.run.changed()
    for name, value in given.items():
        others = {key: kept for key, kept in given.items() if key != name}
        usual = scenario.with_run(**switch_sets(scenario.run.motion, others))
        yield _Try(Change("option", name, value), replace(subject, scenario=usual))
    # A controller may have options of its own. What it learned is not one of them.
    base, words = own_words(scenario.controller)
    for name, text in words.items():
        kept = {key: word for key, word in words.items() if key != name}
        plain = replace(scenario, controller=with_options(base, kept))
        if name != LEARNED:
            yield _Try(Change("option", name, text or True), replace(subject, scenario=plain))


def _field_changes(search: _ChangedRuns) -> Iterator[Change]:
    with search.within(_SHARE_OF_FIELDS):
        for field in search.subject.scenario.fields:
            change = search.field(field)
            if change is not None:
                yield change


def _with_world(subject: Subject, **changes: object) -> Subject:
    """Return the scenario in a changed world, without the witness of the old one."""
    return replace(subject, world=replace(subject.world.bare, **changes))  # type: ignore[arg-type]


def _solid_cells(subject: Subject, episode: Episode) -> list[tuple[int, int]]:
    """Return the solid cells to free, nearest to the part of the path that repeats first."""
    world = subject.world
    rows, columns = np.nonzero(world.walls)
    trace = episode.trace
    if trace is None or len(rows) == 0:
        return []
    # Take the states of one period, or of the second half of a run that does not repeat.
    loop = episode.evidence
    first = loop.entry if isinstance(loop, LoopEvidence) else trace.steps // 2
    last = loop.entry + loop.period if isinstance(loop, LoopEvidence) else trace.steps
    # A few hundred places are enough to find the nearby walls.
    every = max(1, math.ceil((last - first) / _MOST_CELLS))
    x = trace.x[first : last + 1 : every] / world.cell_size
    y = trace.y[first : last + 1 : every] / world.cell_size
    nearest = np.full(len(rows), math.inf)
    for at_x, at_y in zip(x.tolist(), y.tolist(), strict=True):
        nearest = np.minimum(nearest, (columns + 0.5 - at_x) ** 2 + (rows + 0.5 - at_y) ** 2)
    # Rows and columns break ties, so that the order is the same everywhere.
    order = np.lexsort((columns, rows, np.round(nearest, 9)))[:_MOST_CELLS]
    return [(int(columns[k]), int(rows[k])) for k in order]


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _cell(value: Value) -> str:
    ix, iy = value if isinstance(value, list) else (value, value)
    return f"({ix}, {iy})"
