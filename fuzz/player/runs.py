"""A run as the page plays it: its states, the corners between them, and the steps that matter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzz.player.memory import drawn_memory
from fuzz.player.streams import bits, numbers
from sim.controllers.base import Controller
from sim.episode import Episode
from sim.trace import BEHAVIOURS, Trace
from worldgen.lattice import TURN, UNIT
from worldgen.world import Value

__all__ = ["MOST_STEPS", "SHARE", "drawn_run"]

Ints = npt.NDArray[np.int64]

MOST_STEPS = 4_000  # of a run that the page holds; 10 to 25 kB. Of a longer one it has every second, third, ... step
SHARE = 256  # parts of a step: when in it a corner is reached

_BREACHES = {
    "tunnel": ("Breach", "goes through this wall"),
    "overlap": ("Overlap", "cuts into this wall"),
    "burned": ("Caught", "is caught"),
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
        ``steps`` and ``dt`` (s); the columns ``at`` (step times ``SHARE``), ``x``, ``y`` (lattice units of the world),
        ``heading`` (units of a turn, without jumps), ``bump`` (bits) and, of a robot that has behaviours, ``active``
        (which of ``behaviours`` acted; -1 none), one row a state or corner; ``thinned`` (one in
        how many steps is there, at the coarsest); ``loop`` (entry and period), ``marks``, ``memory``
        (``drawn_memory``), and whether it has ``breached`` a wall.
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
        "breached": _has_breached(judged or episode) or _has_breached(episode),
        "thinned": coarsest,
        "loop": loop,
        "marks": marks,
    }


def _columns(
    trace: Trace, kept: npt.NDArray[np.int64], cell_size: float
) -> tuple[dict[str, Any], npt.NDArray[np.int64]]:
    """The states of the steps that are kept, and in between the corners of their paths; and the step of each row."""
    step, share = trace.path_step, np.rint(trace.path_share * SHARE).astype(np.int64)
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
        **({} if trace.active is None else {"active": numbers(trace.active[whose]), "behaviours": list(BEHAVIOURS)}),
    }
    return columns, whose


def _kept_steps(steps: int, span: tuple[int, int], most: int) -> tuple[npt.NDArray[np.int64], int]:
    """Which states are kept, at most about ``most``: densely in the span of interest, the others evenly."""
    inside = span[1] - span[0]
    near = _stride(inside, most // 2)
    far = _stride(steps - inside, most - inside // near)
    parts = [np.arange(0, steps + 1, far), np.arange(span[0], span[1] + 1, near), np.array([*span, steps])]
    return np.unique(np.concatenate(parts)).astype(np.int64), max(near, far)


def _stride(count: int, room: int) -> int:
    return max(1, -(-count // room))


def _span_of_interest(steps: int, loop: list[int] | None, marks: list[dict[str, Any]]) -> tuple[int, int]:
    """From which step to which a reader looks most closely."""
    if loop is not None:
        return min(loop[0], steps), min(loop[0] + loop[1], steps)
    centre = next((mark["step"] for mark in marks if "cell" in mark), steps)
    return max(0, centre - _LEAD_UP), min(steps, centre + _LEAD_UP)


def _loop(episode: Episode) -> list[int] | None:
    entry, period = episode.evidence.get("entry"), episode.evidence.get("period")
    if episode.verdict != "loop" or not isinstance(entry, int) or not isinstance(period, int):
        return None
    return [entry, period]


def _marks(episode: Episode) -> list[dict[str, Any]]:
    """The steps that the evidence names: their name, what is said of them and, where it names one, the cell."""
    evidence, verdict = episode.evidence, episode.verdict
    found: list[dict[str, Any]] = []
    if verdict == "loop":
        found.append(_mark(evidence, "entry", "entry", "Entry", "the loop is entered"))
    if verdict in _BREACHES:
        found.append(_mark(evidence, "since", "cause", "Cause", f"a {evidence.get('cause')} lets it into the wall"))
        found.append(_mark(evidence, "step", "breach", *_BREACHES[verdict]) | {"cell": evidence.get("cell")})
        found.append(_mark(evidence, "reached", "last", "Arrives", "enters the target that walls shut off"))
    if verdict in ("stalled", "timeout"):
        found.append(
            _mark(evidence, "last_new_cell", "last", "Nothing new after", "enters a new cell for the last time")
        )
    return [mark for mark in found if "step" in mark]


def _has_breached(episode: Episode) -> bool:
    """Whether the robot went into a wall, by its verdict or as a run that walls do not end says."""
    return episode.verdict in ("tunnel", "overlap") or "wall_step" in episode.evidence


def _mark(evidence: Mapping[str, Value], key: str, kind: str, name: str, text: str) -> dict[str, Any]:
    step = evidence.get(key)
    return {"step": step, "kind": kind, "name": name, "text": text} if isinstance(step, int) else {}
