"""Verdicts in words."""

from __future__ import annotations

from collections.abc import Mapping

from sim.episode import Episode
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    Evidence,
    FaultEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.verdict import Verdict
from worldgen.timeline import CellState
from worldgen.world import Value

__all__ = ["describe_evidence", "describe_frames"]


def describe_evidence(episode: Episode) -> str:
    """What the evidence says, to stand behind the verdict; starts with a blank, or is empty."""
    match episode.evidence:
        case LoopEvidence(entry=entry, period=period):
            often = "in every step" if period == 1 else f"every {period} steps"
            return f" for ever (the state after step {entry} comes back {often})"
        case WallEvidence() as wall:
            since = "" if wall.cause is None else f", since a {wall.cause} in step {wall.since}"
            return f" (step {wall.step}, wall cell {wall.cell}{since})"
        case BurnedEvidence() as burned:
            cause = "fire" if burned.state == CellState.BURNING.word else "debris"
            return f" ({cause} in step {burned.step}, cell {burned.cell})"
        case BudgetEvidence() as budget if episode.verdict == Verdict.STALLED:
            seen = f"no new cell after step {budget.last_new_cell} of {episode.steps}"
            return f" ({_manner(budget)}{seen}{_multiple(budget)})"
        case BudgetEvidence() as budget:
            return (
                f" (still reaching new cells when its {episode.steps} steps were "
                f"over{_multiple(budget)})"
            )
        case FaultEvidence() as fault:
            return f" ({_fault(episode.verdict, fault)})"
    return ""


def describe_frames(evidence: Evidence | None) -> str:
    """Return where a controller crashed, a line such as ``  mine.py:12 in act: gap = 1 / free`` for each frame.

    The innermost frame comes last, as in Python's tracebacks; each line ends with a newline.
    """
    frames = evidence.frames if isinstance(evidence, FaultEvidence) else None
    return "".join(f"  {_frame(frame)}\n" for frame in frames or ())


def _frame(frame: Mapping[str, Value]) -> str:
    line = f":{frame['line']}" if "line" in frame else ""
    place = f"{frame.get('file', '')}{line}"
    inside = f"in {frame['function']}" if "function" in frame else ""
    code = f": {frame['code']}" if "code" in frame else ""
    return f"{place}{' ' if place and inside else ''}{inside}{code}"


def _multiple(budget: BudgetEvidence) -> str:
    """The budget in times of the witness, with a comma before it; empty where there is none."""
    return (
        ""
        if budget.witness_multiple is None
        else f", {budget.witness_multiple} times the witness's time"
    )


def _fault(verdict: Verdict, fault: FaultEvidence) -> str:
    """What the controller did wrong, with a program's last line on stderr."""
    error = (
        fault.error or "speed or turn rate is no finite number"
    )  # that is all that the core judges
    at = f", {fault.at}" if fault.at else ""
    within = "" if fault.deadline is None else f" within {fault.deadline} s"
    where = f" in step {fault.step}" if verdict != Verdict.CRASH or fault.stderr is not None else ""
    answer = "" if fault.answer is None else f", answer {fault.answer!r}"
    partly = "" if fault.unfinished is None else f", but {fault.unfinished!r} without newline"
    said = f"; stderr: {fault.stderr[-1]}" if fault.stderr else ""
    flush = "; does it flush its output?" if verdict == Verdict.HANG and fault.step == 1 else ""
    remedy = f"; {fault.remedy}" if fault.remedy else ""
    return f"{error}{at}{within}{where}{answer}{partly}{said}{flush}{remedy}"


def _manner(budget: BudgetEvidence) -> str:
    """In what manner a run stalls, with a comma behind it; empty where that is not known."""
    if budget.kind is None or budget.box is None:
        return ""
    columns, rows = budget.box
    how = f"drifting every {budget.period} steps in" if budget.kind == "drifting" else "confined to"
    return f"{how} {columns} x {rows} cells, "
