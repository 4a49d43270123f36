"""Evidence: what a verdict claims about its run, with one record type for each kind of claim.

A checker confirms the claim from the recorded trace. Only this module knows how evidence is written
to files and to JSON: as a table of the known fields.
"""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, TypeAlias

import msgspec

from sim.verdict import Verdict
from worldgen.world import Value

Cell: TypeAlias = tuple[int, int]
Manner: TypeAlias = Literal["drifting", "confined"]
CrashFrame: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class ReachedEvidence:
    """The robot arrived.

    Args:
        step: Step of the arrival.
        wall_step: First step that ended with the centre in a wall, if walls did not end the run.
    """

    step: int
    wall_step: int | None = None


@dataclass(frozen=True, kw_only=True)
class CoveredEvidence:
    """The robot has visited every cell that its coverage task requires.

    Args:
        step: Step in which it entered the last one.
        cells: Number of cells that the task requires.
    """

    step: int
    cells: int


@dataclass(frozen=True, kw_only=True)
class LoopEvidence:
    """The complete state recurred, so the run repeats itself endlessly.

    Args:
        entry: Step after which the loop begins.
        period: Length of the loop, steps.
        state_digest: 16 hex digits, the digest of the state at the entry.
    """

    entry: int
    period: int
    state_digest: str


@dataclass(frozen=True, kw_only=True)
class JointLoopEvidence:
    """The joint state of several robots recurred: ``livelock``, ``deadlock`` or ``starved``.

    The joint state is every robot's pose, speed, memory and message, and whether it has parked.
    Robots are numbered from 1.

    Args:
        entry: Step after which the loop begins.
        period: Length of the loop, steps.
        state_digest: 16 hex digits, the digest of the joint state at the entry.
        waiting: Robots that never arrive.
        moving: Robots whose centres move within the period.
        blocked: Pairs: a robot that drives into another one within the period, and that one.
        parked: Pairs: a robot that has arrived, and the step in which it did.
        periods: Pairs: a waiting robot and its own period, if robots repeat themselves apart from
            each other, and ``period``, the least common multiple, is too long to be driven.
    """

    entry: int
    period: int
    state_digest: str
    waiting: tuple[int, ...]
    moving: tuple[int, ...]
    blocked: tuple[tuple[int, int], ...]
    parked: tuple[tuple[int, int], ...]
    periods: tuple[tuple[int, int], ...] | None = None

    @property
    def driven_period(self) -> int:
        """The longest period that the run drove, steps."""
        return max(period for _, period in self.periods) if self.periods else self.period


@dataclass(frozen=True, kw_only=True)
class CollisionEvidence:
    """Two robots drove through each other.

    Args:
        step: Step in which they did.
        robots: Their numbers, from 1.
    """

    step: int
    robots: tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class BudgetEvidence:
    """The budget was spent without an arrival or a proof: ``stalled`` or ``timeout``.

    Args:
        last_new_cell: Last step in which the centre entered a cell for the first time.
        witness_multiple: The run's time divided by the witness's; ``None`` without a witness.
        kind: How a run under ``stepped`` stalls: ``drifting`` if its poses recur except for
            rounding, or ``confined``.
        entry: Step from which the poses of a drifting run recur.
        period: Steps after which they recur.
        memory_drift: If poses recur on the lattice and the memory does, too, except for rounding:
            the index of the number that changes most, and its change per step. Only known for a
            recorded run.
        box: Columns and rows of cells that the centre visited in the second half of the run.
    """

    last_new_cell: int
    witness_multiple: float | None = None
    kind: Manner | None = None
    entry: int | None = None
    period: int | None = None
    box: tuple[int, int] | None = None
    memory_drift: tuple[int, float] | None = None


@dataclass(frozen=True, kw_only=True)
class WallEvidence:
    """The robot went into a wall: ``tunnel`` or ``overlap``.

    Args:
        step: Step in which it did.
        cell: The wall's cell (ix, iy).
        cause: The move that let it in, if the motion model knows: ``slide``, ``back-off`` or
            ``corner``.
        since: Step of that move.
        reached: For a breach, the step in which the robot arrives if walls do not end the run.
        robot: The robot's number, from 1, if there are several.
    """

    step: int
    cell: Cell
    cause: str | None = None
    since: int | None = None
    reached: int | None = None
    robot: int | None = None


@dataclass(frozen=True, kw_only=True)
class ContactEvidence:
    """A wall cut a move short, and the goal forbids contact.

    Args:
        step: Step of the move.
        cell: The wall's cell (ix, iy).
    """

    step: int
    cell: Cell


@dataclass(frozen=True, kw_only=True)
class BurnedEvidence:
    """Fire or falling debris caught the robot.

    Args:
        step: Step in which it did.
        cell: Cell of the fire or debris (ix, iy).
        state: ``burning`` or ``solid``.
        robot: The robot's number, from 1, if there are several.
    """

    step: int
    cell: Cell
    state: str
    robot: int | None = None


@dataclass(frozen=True, kw_only=True)
class FaultEvidence:
    """A fault of the controller: ``crash``, ``hang`` or ``invalid-command``.

    Args:
        error: The fault, in the same words in every replay; ``None`` if a command is not finite.
        exception: Type of the exception that the controller raised.
        exit_code: Exit code of a program that ended by itself.
        signal: Signal that killed a program: its name, or its number if it has none.
        rule: Name of the rule that an invalid answer breaks, in lower case with dashes.
        step: Step in which it did.
        deadline: Time that it had to answer, s.
        answer: The answer that could not be read.
        unfinished: The part of an answer that arrived before the deadline.
        stderr: The last lines that a program wrote to stderr.
        at: The innermost line of the controller's own file.
        remedy: How to keep the contract.
        reason: Why a program died, according to its report on stderr.
        message: The message of a compiled controller's exception.
        frames: Frames of the user's code, the innermost last.
        bump: True if the robot touched a wall; recorded only for crashes of programs.
        robot: The robot's number, from 1, if there are several.
    """

    error: str | None = None
    exception: str | None = None
    exit_code: int | None = None
    signal: str | None = None
    rule: str | None = None
    step: int | None = None
    deadline: float | None = None
    answer: str | None = None
    unfinished: str | None = None
    stderr: tuple[str, ...] | None = None
    at: str | None = None
    remedy: str | None = None
    reason: str | None = None
    message: str | None = None
    frames: tuple[CrashFrame, ...] | None = None
    bump: bool | None = None
    robot: int | None = None

    @property
    def report(self) -> str:
        """What the program's own report says beyond the error: ``panic: index out of bounds``."""
        said = ": ".join(filter(None, (self.reason, self.message)))
        return "" if self.message is None or self.message in (self.error or "") else said


Evidence: TypeAlias = (
    ReachedEvidence
    | CoveredEvidence
    | LoopEvidence
    | JointLoopEvidence
    | BudgetEvidence
    | WallEvidence
    | CollisionEvidence
    | ContactEvidence
    | BurnedEvidence
    | FaultEvidence
)

_KINDS: Mapping[Verdict, type[Evidence]] = {
    Verdict.REACHED: ReachedEvidence,
    Verdict.COVERED: CoveredEvidence,
    Verdict.LOOP: LoopEvidence,
    Verdict.LIVELOCK: JointLoopEvidence,
    Verdict.DEADLOCK: JointLoopEvidence,
    Verdict.STARVED: JointLoopEvidence,
    Verdict.STALLED: BudgetEvidence,
    Verdict.TIMEOUT: BudgetEvidence,
    Verdict.TUNNEL: WallEvidence,
    Verdict.OVERLAP: WallEvidence,
    Verdict.COLLISION: CollisionEvidence,
    Verdict.CONTACT: ContactEvidence,
    Verdict.BURNED: BurnedEvidence,
    Verdict.CRASH: FaultEvidence,
    Verdict.HANG: FaultEvidence,
    Verdict.INVALID_COMMAND: FaultEvidence,
}
_TYPES: Mapping[type[object], Mapping[str, Any]] = {
    kind: typing.get_type_hints(kind) for kind in _KINDS.values()
}


def evidence_table(evidence: Evidence) -> dict[str, Value]:
    """Return evidence as a table of its known fields, the form used in files and JSON."""
    known = {field.name: getattr(evidence, field.name) for field in fields(evidence)}
    return {name: _plain(value) for name, value in known.items() if value is not None}


def fault_evidence(facts: Mapping[str, Value]) -> FaultEvidence:
    """Return a controller's fault, read from its table."""
    return FaultEvidence(**_values(FaultEvidence, facts))


def read_evidence(verdict: Verdict, table: Mapping[str, Value]) -> Evidence | None:
    """Return the evidence for a verdict, read from its table.

    The reader is lenient, because a file may come from anywhere and a replay compares its table
    word by word anyway. It ignores unknown names, and treats an optional field of the wrong type as
    unknown.

    Args:
        verdict: The verdict that the evidence is for.
        table: A table as :func:`evidence_table` writes it.

    Returns:
        The evidence, or ``None`` if a required field is missing.
    """
    kind = _KINDS[verdict]
    values = _values(kind, table)
    needed = (name for name, wanted in _TYPES[kind].items() if not _is_optional(wanted))
    return None if any(values[name] is None for name in needed) else kind(**values)


def _values(kind: type[object], table: Mapping[str, Value]) -> dict[str, Any]:
    return {name: _of_type(table.get(name), wanted) for name, wanted in _TYPES[kind].items()}


def _is_optional(wanted: Any) -> bool:
    return type(None) in typing.get_args(wanted)


def _of_type(value: Value | None, wanted: Any) -> Any:
    """Return a value from a file in a field's type; ``None`` if it is of another type."""
    try:
        return msgspec.convert(value, wanted)
    except msgspec.ValidationError:
        return None


def _plain(value: Any) -> Value:
    plain: Value = [_plain(one) for one in value] if isinstance(value, tuple) else value
    return plain
