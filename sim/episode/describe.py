"""Describe verdicts and their evidence for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sim.episode import Episode
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    CollisionEvidence,
    ContactEvidence,
    CoveredEvidence,
    Evidence,
    FaultEvidence,
    JointLoopEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.verdict import Verdict
from worldgen.robot_overrides import describe_waypoint
from worldgen.support.plain_text import Styled, joined, shown
from worldgen.timeline import CellState
from worldgen.world import Value, World

_BLOCKED = "the target cannot be reached in this world, whatever the controller does"
_BLOCKED_TOUR = (
    "the target cannot be reached through its waypoints in this world, whatever the controller does"
)
_BLOCKED_CAR = (
    "the target cannot be reached in this world by a car that only its wheels move, whatever the "
    "controller does"
)
_BLOCKED_TOGETHER = "the robots cannot all arrive in this world, whatever the controllers do"
_UNDECIDED = "it is undecided whether the target can be reached in this world"
_UNDECIDED_TOGETHER = "it is undecided whether all robots can arrive in this world"

# Limit on the pairs of robots that are named.
_MOST_BLOCKS = 4


def describe_unreachable(world: World, *, undecided: bool, proof: str = "") -> str:
    """Return a sentence about a run that failed in a world without a witness.

    Args:
        world: The world.
        undecided: True if it is not proved either that the robots cannot all arrive.
        proof: One word for the proof; empty if it is not known. A confinement of a car says
            nothing about drift and pushes.
    """
    if undecided:
        return _UNDECIDED_TOGETHER if world.is_fleet else _UNDECIDED
    # One robot's note does not name the proof: it is a cut unless the world changes.
    if not world.is_fleet:
        if proof == "confinement" and world.robots[0].drive.is_car:
            return _BLOCKED_CAR
        return _BLOCKED_TOUR if world.robots[0].waypoints else _BLOCKED
    return f"{_BLOCKED_TOGETHER} (proved by a {proof})" if proof else _BLOCKED_TOGETHER


def describe_evidence(episode: Episode) -> str:
    """Return a phrase about the evidence to put after the verdict: a space and text, or nothing."""
    match episode.evidence:
        case LoopEvidence(entry=entry, period=period):
            often = "in every step" if period == 1 else f"every {period} steps"
            recurs = f"the state after step {entry} recurs {often}"
            return f" forever ({recurs}{_end(episode)})"
        case JointLoopEvidence() as joint:
            return f" forever ({_joint(joint)})"
        case CoveredEvidence(cells=cells):
            return f" ({cells} cells)"
        case WallEvidence() as wall:
            since = "" if wall.cause is None else f", since a {wall.cause} in step {wall.since}"
            return f" ({_of_robot(wall.robot)}step {wall.step}, wall cell {wall.cell}{since})"
        case CollisionEvidence(step=step, robots=robots):
            return f" (robots {robots[0]} and {robots[1]} in step {step})"
        case ContactEvidence(step=step, cell=cell):
            return f" (step {step}, wall cell {cell})"
        case BurnedEvidence() as burned:
            cause = "fire" if burned.state == CellState.BURNING.word else "debris"
            of_robot = _of_robot(burned.robot)
            return f" ({of_robot}{cause} in step {burned.step}, cell {burned.cell})"
        case BudgetEvidence() as budget if episode.verdict == Verdict.STALLED:
            seen = f"no new cell after step {budget.last_new_cell} of {episode.steps}"
            return f" ({_manner(budget)}{seen}{_multiple(budget)}{_end(episode)})"
        case BudgetEvidence() as budget:
            return (
                f" (still reaching new cells when its {episode.steps} steps were used "
                f"up{_multiple(budget)}{_end(episode)})"
            )
        case FaultEvidence() as fault:
            return f" ({_of_robot(fault.robot)}{shown(_fault(episode.verdict, fault))})"
    return ""


def describe_missed_goal(world: World, episode: Episode) -> str:
    """Return which goal a robot with waypoints never reached; empty without one."""
    robot = world.robots[0]
    reached = episode.goals_reached
    if reached is None or reached >= len(robot.goals):
        return ""
    # Only a loop shows that the robot would not have arrived later.
    verb = "never reaches" if episode.verdict == Verdict.LOOP else "has not reached"
    return f"{verb} {describe_waypoint(robot, reached)}"


def _end(episode: Episode) -> str:
    """Return what the last state lacks of an arrival, after a semicolon; may be empty."""
    shortfall = episode.shortfall
    if shortfall is None:
        return ""
    away = shortfall.distance
    place = f"{_length(away)} from" if away > 0.0 else "in"
    goal = "target" if episode.goals_reached is None else "goal"
    lacks = [f"; it ends {place} the {goal}'s disc"]
    if shortfall.heading > 0.0:
        lacks.append(f"{shortfall.heading:.2g} rad off the goal's heading")
    if shortfall.speed > 0.0:
        lacks.append(f"still moving at {shortfall.speed:.2g} m/s")
    if shortfall.turn_rate > 0.0:
        lacks.append(f"still turning at {shortfall.turn_rate:.2g} rad/s")
    return ", ".join(lacks)


def _length(metres: float) -> str:
    return f"{metres:.2g} m" if metres >= 1.0 else f"{100.0 * metres:.2g} cm"


def _joint(joint: JointLoopEvidence) -> str:
    """Return what recurs, and which robots block which."""
    often = "in every step" if joint.period == 1 else f"every {joint.period:,} steps"
    back = f"the joint state after step {joint.entry} recurs {often}"
    if joint.periods:
        back += f", because {_own_loops(joint)} apart from each other"
    parked = {number for number, _ in joint.parked}
    face_to_face = [pair for pair in joint.blocked if pair[::-1] in joint.blocked]
    blocks = [f"robots {one} and {by} block each other" for one, by in face_to_face if one < by]
    blocks += [
        f"robot {one} is blocked by robot {by}{', which has parked' if by in parked else ''}"
        for one, by in joint.blocked
        if (one, by) not in face_to_face
    ]
    blocks = blocks or [_never_arrive(joint)]
    named = blocks[:_MOST_BLOCKS]
    more = f", and {len(blocks) - len(named)} more" if len(blocks) > len(named) else ""
    return f"{back}: {', '.join(named)}{more}"


def _own_loops(joint: JointLoopEvidence) -> str:
    """Describe how robots that never meet repeat themselves."""
    loops: dict[int, list[int]] = {}
    for number, period in joint.periods or ():
        loops.setdefault(period, []).append(number)
    parts = [
        f"{_robots(numbers)} loop{'s' if len(numbers) == 1 else ''} every {period:,} steps"
        for period, numbers in loops.items()
    ]
    return f"{', '.join(parts[:-1])} and {parts[-1]}"


def _never_arrive(joint: JointLoopEvidence) -> str:
    """Return a statement that robots never arrive although none of them touches another one."""
    never = "never arrives" if len(joint.waiting) == 1 else "never arrive"
    # A robot that has arrived can be in another one's way without being touched.
    numbers = [number for number, _ in joint.parked]
    parked = (
        f"; {_robots(numbers)} {'has' if len(numbers) == 1 else 'have'} parked" if numbers else ""
    )
    return f"{_robots(joint.waiting)} {never}, and no robot drives into another{parked}"


def _robots(numbers: Sequence[int]) -> str:
    return f"robot{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"


def _of_robot(number: int | None) -> str:
    return "" if number is None else f"robot {number}, "


def describe_frames(evidence: Evidence | None) -> Styled:
    """Return where a controller crashed: one line for each frame, the innermost last.

    A line reads ``  mine.py:12 in act: gap = 1 / free`` and ends with a newline.
    """
    frames = evidence.frames if isinstance(evidence, FaultEvidence) else None
    return joined(*(f"  {shown(_frame(frame))}\n" for frame in frames or ()))


def _frame(frame: Mapping[str, Value]) -> str:
    line = f":{frame['line']}" if "line" in frame else ""
    place = f"{frame.get('file', '')}{line}"
    inside = f"in {frame['function']}" if "function" in frame else ""
    code = f": {frame['code']}" if "code" in frame else ""
    return f"{place}{' ' if place and inside else ''}{inside}{code}"


def _multiple(budget: BudgetEvidence) -> str:
    """Return the budget as a multiple of the witness's time, after a comma; may be empty."""
    times = budget.witness_multiple
    return "" if times is None else f", {times} times the witness's time"


def _fault(verdict: Verdict, fault: FaultEvidence) -> str:
    """Return the controller's fault, with the last line that a program wrote to stderr."""
    # The core reports an error only for commands that are not finite, and leaves it empty.
    error = fault.error or "speed or turn rate is not a finite number"
    at = f", {fault.at}" if fault.at else ""
    within = "" if fault.deadline is None else f" within {fault.deadline} s"
    where = f" in step {fault.step}" if verdict != Verdict.CRASH or fault.stderr is not None else ""
    answer = "" if fault.answer is None else f", answer {fault.answer!r}"
    partly = "" if fault.unfinished is None else f", but {fault.unfinished!r} without newline"
    said = f"; stderr: {fault.stderr[-1]}" if fault.stderr else ""
    # The last line of a report may be a hint.
    if fault.message and fault.report and fault.message not in said:
        said = f"; stderr: {fault.report}"
    flush = "; does it flush its output?" if verdict == Verdict.HANG and fault.step == 1 else ""
    remedy = f"; {fault.remedy}" if fault.remedy else ""
    return f"{error}{at}{within}{where}{answer}{partly}{said}{flush}{remedy}"


def describe_memory_drift(budget: BudgetEvidence) -> str:
    """Return what changes in a memory while the pose repeats, and the way out; may be empty."""
    if budget.memory_drift is None:
        return ""
    number, change = budget.memory_drift
    by = f"changes by {change:.1g} a step"
    return f"memory[{number}] {by}: round it, and the loop may be proved"


def _manner(budget: BudgetEvidence) -> str:
    """Return how a run stalls, followed by a comma; empty if that is not known."""
    if budget.memory_drift is not None:
        often = "in every step" if budget.period == 1 else f"every {budget.period} steps"
        return f"the pose repeats {often}; {describe_memory_drift(budget)}; "
    if budget.kind is None or budget.box is None:
        return ""
    columns, rows = budget.box
    how = f"drifting every {budget.period} steps in" if budget.kind == "drifting" else "confined to"
    return f"{how} {columns} x {rows} cells, "
