"""A run as the page plays it: its states, the corners between them, and the steps that matter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzz.player.memory import drawn_memory
from fuzz.player.streams import bits, numbers
from sim.controllers.base import Controller
from sim.episode import Episode
from sim.evidence import BudgetEvidence, BurnedEvidence, LoopEvidence, WallEvidence
from sim.trace import BEHAVIOURS, Trace
from sim.verdict import Verdict
from worldgen.lattice import TURN, UNIT

__all__ = ["MOST_STEPS", "SHARE", "drawn_run"]

Ints = npt.NDArray[np.int64]

# Of a run that the page holds; 10 to 25 kB. Of a longer one it has every second, third, ... step.
MOST_STEPS = 4_000
SHARE = 256  # parts of a step: when in it a corner is reached

_BREACHES = {
    Verdict.TUNNEL: ("Breach", "goes through this wall"),
    Verdict.OVERLAP: ("Overlap", "cuts into this wall"),
    Verdict.BURNED: ("Caught", "is caught"),
}
_LEAD_UP = 300  # steps before a breach, and after it, that are kept rather than others


def drawn_run(
    episode: Episode,
    cell_size: float,
    judged: Episode | None = None,
    *,
    most: int = MOST_STEPS,
    controller: Controller | None = None,
) -> dict[str, Any] | None:
    """A recorded run, or ``None`` without a recording.

    Args:
        episode: The run.
        cell_size: m.
        judged: The run whose evidence counts, where that is another: a breach's ends at the wall.
        most: About how many steps are kept of a longer run.
        controller: Who drove, if its memory is to be shown.

    Returns:
        ``steps`` and ``dt`` (s); the columns ``at`` (step times ``SHARE``), ``x``, ``y`` (lattice
        units of the world), ``heading`` (units of a turn, without jumps), ``bump`` (bits) and, of a
        robot that has behaviours, ``active`` (which of ``behaviours`` acted; -1 none), one row a
        state or corner; ``thinned`` (one in how many steps is there, at the coarsest); ``loop``
        (entry and period), ``marks``, ``memory`` (``drawn_memory``), and whether it has
        ``breached`` a wall.
    """
    trace = episode.trace
    if trace is None:
        return None
    marks = _marks(judged or episode)
    loop = _loop(judged or episode)
    kept, coarsest = _kept_steps(trace.steps, _span_of_interest(trace.steps, loop, marks), most)
    columns, rows = _columns(trace, kept, cell_size)
    memory = None
    if controller is not None:
        memory = drawn_memory(trace, controller, kept, rows, cell_size=cell_size, most=most)
    return {
        "steps": trace.steps,
        "dt": trace.time_step,
        **columns,
        "memory": memory,
        "breached": (judged or episode).went_into_a_wall or episode.went_into_a_wall,
        "thinned": coarsest,
        "loop": loop,
        "marks": marks,
    }


def _columns(
    trace: Trace, kept: npt.NDArray[np.int64], cell_size: float
) -> tuple[dict[str, Any], npt.NDArray[np.int64]]:
    """The states of the steps that are kept, and in between the corners of their paths.

    And the step of each row.
    """
    step = trace.path_step
    share = np.rint(trace.path_share * SHARE).astype(np.int64)
    corner = np.isin(step, kept) & (step > 0) & (share < SHARE)
    at = np.concatenate([kept * SHARE, (step[corner] - 1) * SHARE + share[corner]])
    order = np.argsort(at, kind="stable")
    x = np.concatenate([trace.x[kept], trace.path_x[corner]])[order]
    y = np.concatenate([trace.y[kept], trace.path_y[corner]])[order]
    whose = np.concatenate([kept, step[corner]])[order]
    turns = np.unwrap(trace.heading[whose]) / (2.0 * math.pi)
    columns = {
        "at": numbers(at[order]),
        "x": numbers(np.rint(x / cell_size * UNIT)),
        "y": numbers(np.rint(y / cell_size * UNIT)),
        "heading": numbers(np.rint(turns * TURN)),
        "bump": bits(trace.bump[whose]),
        **(
            {}
            if trace.active is None
            else {"active": numbers(trace.active[whose]), "behaviours": list(BEHAVIOURS)}
        ),
    }
    return columns, whose


def _kept_steps(steps: int, span: tuple[int, int], most: int) -> tuple[npt.NDArray[np.int64], int]:
    """Which states are kept, at most about ``most``.

    Densely in the span of interest, the others evenly.
    """
    inside = span[1] - span[0]
    near = _stride(inside, most // 2)
    far = _stride(steps - inside, most - inside // near)
    parts = [
        np.arange(0, steps + 1, far),
        np.arange(span[0], span[1] + 1, near),
        np.array([*span, steps]),
    ]
    return np.unique(np.concatenate(parts)).astype(np.int64), max(near, far)


def _stride(count: int, room: int) -> int:
    return max(1, -(-count // room))


def _span_of_interest(
    steps: int, loop: list[int] | None, marks: list[dict[str, Any]]
) -> tuple[int, int]:
    """From which step to which a reader looks most closely."""
    if loop is not None:
        return min(loop[0], steps), min(loop[0] + loop[1], steps)
    centre = next((mark["step"] for mark in marks if "cell" in mark), steps)
    return max(0, centre - _LEAD_UP), min(steps, centre + _LEAD_UP)


def _loop(episode: Episode) -> list[int] | None:
    evidence = episode.evidence
    return [evidence.entry, evidence.period] if isinstance(evidence, LoopEvidence) else None


def _marks(episode: Episode) -> list[dict[str, Any]]:
    """The steps that the evidence names.

    Their name, what is said of them and, where it names one, the cell.
    """
    match episode.evidence:
        case LoopEvidence(entry=entry):
            return [_mark(entry, "entry", "Entry", "the loop is entered")]
        case WallEvidence() as wall:
            found = []
            if wall.since is not None:
                found.append(
                    _mark(wall.since, "cause", "Cause", f"a {wall.cause} lets it into the wall")
                )
            found.append(
                _mark(wall.step, "breach", *_BREACHES[episode.verdict]) | {"cell": list(wall.cell)}
            )
            if wall.reached is not None:
                found.append(
                    _mark(wall.reached, "last", "Arrives", "enters the target that walls shut off")
                )
            return found
        case BurnedEvidence(step=step, cell=cell):
            return [_mark(step, "breach", *_BREACHES[episode.verdict]) | {"cell": list(cell)}]
        case BudgetEvidence(last_new_cell=step):
            return [_mark(step, "last", "Nothing new after", "enters a new cell for the last time")]
    return []


def _mark(step: int, kind: str, name: str, text: str) -> dict[str, Any]:
    return {"step": step, "kind": kind, "name": name, "text": text}
