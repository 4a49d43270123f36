"""Search an axis for two neighbouring values: the robot arrives at one and fails at the other."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec

from fuzz.boundary.axes import Axis, Subject
from fuzz.facts.proofs import certified
from sim.controllers import CONTROLLERS
from sim.episode import Episode, prepare, simulate
from sim.outcome import Outcome
from sim.verdict import ARRIVALS
from worldgen.errors import WorldgenError
from worldgen.files.json_file import plain
from worldgen.world import Value, Witness, World

# Number of values; with three digits, a factor of nearly 4.
_REACH = 512


@dataclass(frozen=True)
class BoundaryRun:
    """The robot's behaviour at one value.

    Args:
        index: Index of the value.
        value: The value in the axis's unit.
        subject: The scenario with that value; its world carries a witness.
        outcome: Outcome of the run, with the witness's budget.
    """

    index: int
    value: float
    subject: Subject
    outcome: Outcome | Episode

    @property
    def arrives(self) -> bool:
        """True if the robot reaches the target and does nothing else wrong."""
        return self.outcome.verdict in ARRIVALS


class BoundaryRuns:
    """Runs a subject at values of an axis, each value only once.

    Args:
        subject: The scenario.
        axis: The number to vary.
        seen: Called with each run.
        spare: Fraction by which a wider robot must also be able to get there. If the robot only
            just fits, all controllers fail.
    """

    def __init__(
        self,
        subject: Subject,
        axis: Axis,
        seen: Callable[[BoundaryRun], None] | None = None,
        spare: float = 0.0,
    ) -> None:
        self._subject = subject
        self.axis = axis
        self._seen = seen
        self._spare = spare
        self._known: dict[int, BoundaryRun | None] = {}

    def __call__(self, index: int) -> BoundaryRun | None:
        """Return the run at a value; ``None`` if there is none or its target may be unreachable."""
        if index not in self._known:
            look = self._known[index] = self._run(index)
            if look is not None and self._seen is not None:
                self._seen(look)
        return self._known[index]

    def seen_at(self, index: int) -> BoundaryRun | None:
        """Return the run at a value if it has been done already."""
        return self._known.get(index)

    def _run(self, index: int) -> BoundaryRun | None:
        value = self.axis.value(index)
        if not self.axis.low <= index <= self.axis.high:
            return None
        try:
            subject = self.axis.at(self._subject, value)
        # There is no such world.
        except WorldgenError:
            return None
        ran = run_subject(subject, self._spare)
        return None if ran is None else BoundaryRun(index, value, *ran)


def run_subject(
    subject: Subject, spare: float = 0.0, multiple: float = math.inf
) -> tuple[Subject, Outcome | Episode] | None:
    """Run a scenario with the budget of a fresh proof that its target can be reached.

    Args:
        subject: The scenario; its world's own witness is used if it is wide enough.
        spare: Fraction by which a wider robot must also be able to get there.
        multiple: Limit on the budget, as a multiple of the witness's time.

    Returns:
        The scenario with the witness in its world, and how the run ended; ``None`` if the target is
        not provably reachable, or the simulator refuses such numbers.
    """
    try:
        world = _proved(subject.world, spare)
        if world is None:
            return None
        options = subject.scenario.options(world)
        if isinstance(world.certificate, Witness) and multiple < math.inf:
            most = math.ceil(multiple * world.certificate.duration / options.time_step)
            options = replace(options, steps=max(1, min(options.steps, most)))
        controller = CONTROLLERS.get(subject.scenario.controller)
        outcome: Outcome | Episode
        if world.is_fleet:
            outcome = simulate(world, controller, options)
        else:
            run = prepare(world, controller, options)
            outcome = run.run(options.steps, find_loop=True, record=False, digest=False)
    except WorldgenError:
        return None
    return replace(subject, world=world), outcome


def _proved(world: World, spare: float) -> World | None:
    """Return a world with a witness for a robot wider by ``spare``, or the old one."""
    needed = world.robot_radius * (1.0 + spare)
    witness = world.certificate
    if isinstance(witness, Witness) and not world.is_dynamic and witness.clearance >= needed:
        return world
    proved = certified(replace(world, robot_radius=needed))
    return None if proved is None else replace(proved, robot_radius=world.robot_radius)


class RecordedBoundary(msgspec.Struct, frozen=True):
    """A boundary in a failure's record.

    Args:
        axis: Name of the number that varied.
        fails_at: The value at which the robot does not arrive.
        passes_at: The neighbouring value at which it does.
    """

    axis: str
    fails_at: float
    passes_at: float


@dataclass(frozen=True)
class Boundary:
    """Two neighbouring values of an axis with different outcomes.

    Args:
        axis: The number that varied.
        passes: The run that arrives.
        fails: The run that does not.
    """

    axis: Axis
    passes: BoundaryRun
    fails: BoundaryRun

    def record(self) -> dict[str, Value]:
        """Return the entry for a failure's record."""
        return plain(RecordedBoundary(self.axis.name, self.fails.value, self.passes.value))


def nearest_boundary(
    looks: BoundaryRuns, start: int, *, reach: int = _REACH, step: int = 1
) -> Boundary | None:
    """Return the first boundary that doubling steps from a value find, narrowed down by bisection.

    Outcomes need not be monotone, so other boundaries may exist, even nearer ones.

    Args:
        looks: The runs.
        start: Index of the value to start from.
        reach: Largest distance in values; 900 values are a factor of ten.
        step: First distance in values; with a larger one, fewer values are run.
    """
    here = looks(start)
    if here is None:
        return None
    # Go both ways with doubling steps.
    last = {-1: here, 1: here}
    open_ends = [-1, 1]
    while step <= reach and open_ends:
        for way in tuple(open_ends):
            look = looks(start + way * step)
            # At the end of the axis, bisect towards the last value that has a run.
            if look is None:
                open_ends.remove(way)
                look = _last_that_differs(looks, last[way], start + way * step)
            if look is not None and look.arrives != here.arrives:
                return _narrowed(looks, last[way], look)
            last[way] = look or last[way]
        step *= 2
    return None


def _last_that_differs(looks: BoundaryRuns, good: BoundaryRun, without: int) -> BoundaryRun | None:
    """Bisect towards the last value that has a run.

    Return the first run along the way with a different outcome, if there is one.
    """
    while abs(good.index - without) > 1:
        middle = (good.index + without) // 2
        look = looks(middle)
        if look is None:
            without = middle
        elif look.arrives != good.arrives:
            return look
        else:
            good = look
    return None


def _narrowed(looks: BoundaryRuns, one: BoundaryRun, other: BoundaryRun) -> Boundary | None:
    """Bisect between two values of different outcome.

    Return ``None`` if a value between them cannot be judged.
    """
    while abs(one.index - other.index) > 1:
        middle = looks((one.index + other.index) // 2)
        if middle is None:
            return None
        if middle.arrives == one.arrives:
            one = middle
        else:
            other = middle
    passes, fails = (one, other) if one.arrives else (other, one)
    return Boundary(looks.axis, passes, fails)
