"""What happened in one run: the core's claims, for every motion model, and the verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeAlias

from sim._core import lib
from sim.evidence import (
    BudgetEvidence,
    Evidence,
    FaultEvidence,
    JointLoopEvidence,
    ReachedEvidence,
    WallEvidence,
    evidence_table,
)
from sim.trace import Trace
from sim.verdict import AT_ONCE, Verdict
from worldgen.errors import InvalidParameter
from worldgen.lattice import exact
from worldgen.plugins.entry_points import points_of
from worldgen.support.arrays import Words
from worldgen.world import World

LIMIT: Literal["limit"] = "limit"
"""The ending of a run that spent its budget."""

Ending: TypeAlias = Verdict | Literal["limit"]

ENDINGS: Mapping[int, Ending] = {
    lib.WG_LIMIT: LIMIT,
    lib.WG_REACHED: Verdict.REACHED,
    lib.WG_LOOP: Verdict.LOOP,
    lib.WG_TUNNEL: Verdict.TUNNEL,
    lib.WG_BURNED: Verdict.BURNED,
    lib.WG_INVALID_COMMAND: Verdict.INVALID_COMMAND,
    lib.WG_CRASH: Verdict.CRASH,
    lib.WG_COVERED: Verdict.COVERED,
    lib.WG_COLLISION: Verdict.COLLISION,
    lib.WG_CONTACT: Verdict.CONTACT,
}
"""The ending for each of the core's numbers."""


@dataclass(frozen=True)
class Shortfall:
    """What keeps the last state of a run from being an arrival; 0 is nothing.

    Args:
        distance: From the target's disc, m.
        heading: From the goal's heading, rad.
        speed: Speed with which the robot moves although it has to stop, m/s.
        turn_rate: The same for its turns, rad/s.
    """

    distance: float
    heading: float
    speed: float
    turn_rate: float


@dataclass(frozen=True)
class Outcome:
    """The core's claims about a run; checks of the evidence confirm them from the trace.

    Args:
        ending: ``limit``, ``reached``, ``loop``, ``tunnel``, ``burned``, ``contact``, or one of
            :data:`sim.verdict.BY_THE_CONTROLLER`.
        steps: Steps simulated.
        period: Length of the recurrence, steps; for ``loop``.
        entry: Step where it begins, for ``loop``; else -1.
        path_length: Distance driven, m.
        collisions: Times that the robot began to touch a wall.
        digest: 16 hex digits; meaningless unless requested.
        last_new_cell: Last step in which the centre entered a cell for the first time.
        hit_step: Step of the tunnel, contact, fire or debris; -1 if none.
        hit_cell: Its cell (ix, iy).
        hit_state: ``solid`` or ``burning``, for ``burned``.
        overlap_step: First step whose path cut a wall by more than the tolerance; -1 if none.
        overlap_cell: Its cell (ix, iy).
        cause: The move that let the robot into the wall, for a tunnel or overlap under
            ``stepped``: ``slide``, ``back-off`` or ``corner``; else empty.
        cause_step: Step of that move, from which the robot overlapped a wall; -1 if none.
        wall_step: First step that ended with the centre in a wall, if walls do not end the run;
            else -1.
        random_draws: Random numbers used.
        cells_visited: Cells that the centre has been in after a step, including the start's.
        points: Points of the path after the start.
        cells_left: Cells that a coverage task still requires.
        cells_wanted: Cells to visit; 0 for another task.
        goals: Goals that the robot arrived at.
        complete: Whether the recorded state alone decides the future.
        fault: The controller's fault, without the step; ``None`` if it made none or only the core
            knows it.
        trace: The recording, if requested.
        shortfall: As in :attr:`Episode.shortfall`.
    """

    ending: Ending
    steps: int
    period: int
    path_length: float
    collisions: int
    digest: str
    last_new_cell: int
    hit_step: int
    hit_cell: tuple[int, int]
    hit_state: str
    overlap_step: int
    overlap_cell: tuple[int, int]
    random_draws: int
    cells_visited: int = 0
    points: int = 0
    cells_left: int = 0
    cells_wanted: int = 0
    goals: int = 0
    entry: int = -1
    cause: str = ""
    cause_step: int = -1
    wall_step: int = -1
    complete: bool = True
    fault: FaultEvidence | None = None
    trace: Trace | None = None
    shortfall: Shortfall | None = None

    @property
    def verdict(self) -> Verdict:
        """The verdict; ``loop`` is only a claim of the core here, which the episode must prove."""
        ending = self.ending
        if ending in AT_ONCE:
            return Verdict(ending)
        if self.overlap_step >= 0:
            return Verdict.OVERLAP
        if ending != LIMIT:
            return ending
        return Verdict.STALLED if self.last_new_cell <= self.steps // 2 else Verdict.TIMEOUT


class Runnable(Protocol):
    """A world, a controller and options, packed for the core."""

    @property
    def last_event_step(self) -> int:
        """Step at whose beginning the world changes for the last time; 0 if it never changes."""
        ...

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Simulate up to ``steps`` steps from the start.

        Args:
            steps: Budget.
            find_loop: Whether a recurrence ends the run as soon as it is noticed, which may be
                only at the end of the budget.
            record: Whether to keep every state.
            digest: Whether to compute the trace's digest, which takes a fifth of the time.
        """
        ...

    def prove(self, entry: int, period: int, *, record: bool) -> tuple[Outcome, Words] | None:
        """Simulate a loop's first period, and compare the complete states at both of its ends.

        Args:
            entry: Step where the loop begins, as :meth:`run` found it.
            period: Its length, steps.
            record: Whether to keep every state.

        Returns:
            The outcome up to the end of the period and the state at the entry; ``None`` if that
            state does not recur.
        """
        ...

    def with_confinement(self, evidence: BudgetEvidence, outcome: Outcome) -> BudgetEvidence:
        """Add to the evidence of a run that stalled what confines the robot."""
        ...


@dataclass(frozen=True)
class Ran:
    """What a recorded episode ran, so that a notebook can show it.

    Args:
        world: The world.
        name: The controller's name.
        controller: The controller; for several robots the first one's.
        options: How it was run, a :class:`~sim.RunOptions`.
    """

    world: World
    name: str
    controller: Any
    options: Any


@dataclass(frozen=True)
class Episode:
    """What happened in one run.

    Args:
        verdict: How it ended.
        steps: Steps simulated; for a ``loop``, up to the first return of a state.
        time: Their duration, s.
        path_length: Distance driven, m.
        collisions: Times that the robot began to touch a wall.
        trace_digest: 16 hex digits, a digest of every state.
        evidence: The facts that confirm the verdict for a checker; a record of the verdict's kind.
        trace: The recorded states, if requested.
        cells_left: Cells that a coverage task still requires; ``None`` for another task.
        area_covered: Area of the cells that its centre was in after a step, including the start's,
            m2.
        goals_reached: How many of its waypoints and its target it arrived at; ``None`` for a robot
            without waypoints.
        shortfall: What the last state lacks, of a run that did not arrive at a goal with a heading,
            or at which a step has to end; else ``None``.
        ran: What was run, if it was recorded in this process.
    """

    verdict: Verdict
    steps: int
    time: float
    path_length: float
    collisions: int
    trace_digest: str
    evidence: Evidence
    trace: Trace | None = None
    area_covered: float = 0.0
    cells_left: int | None = None
    goals_reached: int | None = None
    shortfall: Shortfall | None = None
    ran: Ran | None = field(default=None, repr=False, compare=False)

    def show(self) -> Any:
        """Return the interactive player of this run, which a notebook shows below its cell.

        Raises:
            InvalidParameter: If the run was not recorded.
        """
        if self.ran is None:
            raise InvalidParameter(
                "not-recorded",
                "this run was not recorded in this process, so there is nothing to play",
                "simulate it with record=True",
            )
        return _viewer("page")(self, self.ran)

    def _repr_png_(self) -> bytes | None:
        """Return the picture that a notebook shows; ``None`` if the run was not recorded."""
        if self.ran is None:
            return None
        picture: bytes = _viewer("picture")(self, self.ran)
        return picture

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what was run: other processes have it, and a controller may be unable to go."""
        return {name: value for name, value in vars(self).items() if name != "ran"}

    @property
    def went_into_a_wall(self) -> bool:
        """Whether the robot went into a wall, even in a run that a wall does not end."""
        evidence = self.evidence
        entered = isinstance(evidence, ReachedEvidence) and evidence.wall_step is not None
        return entered or isinstance(evidence, WallEvidence)

    @property
    def robots(self) -> tuple[Episode, ...]:
        """Each robot's episode, in order: this one, unless there are several robots."""
        return (self,)

    def blockers(self, robot: int) -> tuple[int, ...]:
        """Return the robots that a robot drives into forever, all numbered from 1."""
        evidence = self.evidence
        pairs = evidence.blocked if isinstance(evidence, JointLoopEvidence) else ()
        return tuple(other for one, other in pairs if one == robot)

    def __repr__(self) -> str:
        evidence = "".join(
            f"\n  {name}: {value!r}" for name, value in evidence_table(self.evidence).items()
        )
        return (
            f"{self.verdict}: {self.steps} steps, {self.time:g} s, {self.path_length:.3f} m "
            f"driven, {self.collisions} collisions, trace {self.trace_digest}{evidence}"
        )


@dataclass(frozen=True, repr=False)
class FleetEpisode(Episode):
    """What happened in one run of several robots.

    ``path_length`` and ``collisions`` are sums over the robots, ``trace_digest`` is the digest of
    the robots' digests, and ``trace`` is ``None``, because each robot has its own. The other
    fields, such as ``verdict``, ``steps``, ``time`` and ``evidence``, describe the whole run as in
    :class:`Episode`.

    Args:
        robots: Each robot's episode, in order. A robot that has not arrived has the run's verdict,
            if that is about this robot, or else ``stalled`` or ``timeout``.
        random_draws: Random numbers that all robots used.
    """

    robots: tuple[Episode, ...] = ()
    random_draws: int = 0

    @property
    def went_into_a_wall(self) -> bool:
        """Whether one of the robots drove into a wall."""
        return any(one.went_into_a_wall for one in self.robots)


def _viewer(name: str) -> Any:
    """Return what shows episodes in notebooks; pictures and pages build on this module."""
    (point,) = (point for point in points_of("worldgen.viewers") if point.name == name)
    return point.load()


def wall_evidence(outcome: Outcome) -> WallEvidence:
    """Return where a run went into a wall and, if known, the move that let it in."""
    tunnelled = outcome.ending == Verdict.TUNNEL
    return WallEvidence(
        step=outcome.hit_step if tunnelled else outcome.overlap_step,
        cell=outcome.hit_cell if tunnelled else outcome.overlap_cell,
        cause=outcome.cause or None,
        since=outcome.cause_step if outcome.cause else None,
    )


def area_of(cells: int, world: World) -> float:
    """Return the area of this many cells, m2."""
    return float(cells * exact(world.cell_size) ** 2)
