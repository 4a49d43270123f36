"""A run as the page plays it: its states, the corners between them, and its important steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fuzz.player.memory import drawn_memory
from fuzz.player.streams import bits, numbers
from sim.controllers.base import Controller, robot_for
from sim.controllers.behaviours.arbitration import Arbitration, acted_at
from sim.episode import Episode
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    ContactEvidence,
    JointLoopEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.motion import MOTIONS, Motion
from sim.options.run import COVER, RunOptions
from sim.outcome import FleetEpisode
from sim.trace import BEHAVIOURS, Trace
from sim.verdict import Verdict
from worldgen.lattice import TURN, UNIT
from worldgen.support.arrays import Ints

# Steps of a run that the page includes, 10 to 25 kB. A longer run is reduced to every second step,
# or every third, and so on.
MOST_STEPS = 4_000
SHARE = 256  # parts of a step, for the time at which a corner is reached

_FEWEST_STEPS = 400  # per robot's run, however many robots there are

_BREACHES = {
    Verdict.TUNNEL: ("Breach", "goes through this wall"),
    Verdict.OVERLAP: ("Overlap", "cuts into this wall"),
    Verdict.CONTACT: ("Contact", "touches this wall"),
    Verdict.BURNED: ("Caught", "is caught"),
}
_LEAD_UP = 300  # steps around a breach that take precedence over others


def drawn_run(
    episode: Episode,
    cell_size: float,
    judged: Episode | None = None,
    *,
    motion: Motion | None = None,
    most: int = MOST_STEPS,
    controller: Controller | None = None,
) -> dict[str, Any] | None:
    """Return a recorded run for the page, or ``None`` without a recording.

    Args:
        episode: The run.
        cell_size: Size of a cell, m.
        judged: The run with the evidence, if it is another one: a breach's ends at the wall.
        motion: The motion model; if omitted, the page marks only walls that the evidence names.
        most: Approximate number of steps to include of a longer run.
        controller: The controller, if its memory and its behaviours should be shown.

    Returns:
        ``steps`` and ``dt`` (s). The columns ``at`` (parts of a step), ``x``, ``y`` (parts of a
        cell), ``heading`` (parts of a turn, without jumps), ``bump`` (bits) and, for a robot with
        behaviours, ``active`` (index into ``behaviours`` of the one that acted, -1 for none), with
        one row per state or corner; ``per``, the number of parts of a ``step``, ``cell`` and
        ``turn``. ``thinned`` (at the coarsest, one step in this many is included), ``loop`` (entry
        and period), ``marks``, ``memory`` (see ``drawn_memory``), and ``tolerance``: if it has
        entered a wall, the depth in cells beyond which the motion model reports that.
    """
    trace = episode.trace
    if trace is None:
        return None
    # Keep more steps where readers look closely.
    evident = judged or episode
    marks = sorted([*_first_touch(trace), *_marks(evident)], key=lambda mark: int(mark["step"]))
    loop = _loop(evident)
    span = _span_of_interest(trace.steps, loop, marks)
    kept, coarsest = _kept_steps(trace.steps, span, most)
    marked = np.array([mark["step"] for mark in marks], np.int64)
    kept = np.union1d(kept, marked[marked <= trace.steps])
    columns, rows = _columns(trace, kept, cell_size)
    memory = None
    if controller is not None:
        memory = drawn_memory(trace, controller, kept, rows, cell_size=cell_size, most=most)
    breached = evident.went_into_a_wall or episode.went_into_a_wall
    return {
        "steps": trace.steps,
        "dt": trace.time_step,
        **columns,
        **_acted(trace, controller, kept, rows),
        "memory": memory,
        "tolerance": motion.overlap_tolerance if motion is not None and breached else None,
        "thinned": coarsest,
        "loop": loop,
        "covers": trace.task == COVER,
        "marks": marks,
    }


def drawn_robots(
    shown: Episode,
    cell_size: float,
    judged: Episode | None = None,
    *,
    motion: Motion | None = None,
    most: int = MOST_STEPS,
    controller: Controller | None = None,
) -> dict[str, Any]:
    """Return what the player draws of a run: one robot, or the first robot and the others.

    Args:
        shown: The run, of one robot or of several.
        cell_size: Size of a cell, m.
        judged: As for :func:`drawn_run`.
        motion: As for :func:`drawn_run`.
        most: As for :func:`drawn_run`; several robots share it.
        controller: As for :func:`drawn_run`.

    Returns:
        ``run``; with several robots also ``number`` of the first one, and ``others``, each with
        ``run`` and ``number``. Their runs also have ``blocked_by``: the numbers of the robots that
        they drive into forever.
    """
    if not isinstance(shown, FleetEpisode):
        run = drawn_run(shown, cell_size, judged, motion=motion, most=most, controller=controller)
        return {"run": run}
    share = max(most // len(shown.robots), _FEWEST_STEPS)
    drawn: list[dict[str, Any]] = []
    for number, robot in enumerate(shown.robots, start=1):
        run = drawn_run(robot, cell_size, motion=motion, most=share, controller=controller)
        if run is not None:
            run["blocked_by"] = [*shown.blockers(number)]
            drawn.append({"run": run, "number": number})
    return {**drawn[0], "others": drawn[1:]} if drawn else {"run": None}


def sensors_of(controller: Controller, options: RunOptions, side: float) -> dict[str, Any]:
    """Return the range beams, in cells and rad, and whether to tint the floor by the signal.

    The floor can only be tinted by a signal that walls do not block.

    Args:
        controller: The controller.
        options: Options of the run.
        side: Size of a cell, m.
    """
    if not MOTIONS.get(options.motion).on_lattice:
        return {"beams": 0, "signal": options.thesis.signal == "open"}
    robot = robot_for(controller, options.robot)
    return {
        "beams": robot.beams,
        "range": min(robot.beam_range / side, 1e6),
        "field": robot.beam_field,
        "signal": robot.signal == "open",
    }


def _columns(trace: Trace, kept: Ints, cell_size: float) -> tuple[dict[str, Any], Ints]:
    """Return the included states with the corners in between, and the step of each row."""
    # Take the corners inside the included steps; a corner at the end of a step is its state.
    step = trace.path_step
    share = np.rint(trace.path_share * SHARE).astype(np.int64)
    corner = np.isin(step, kept) & (step > 0) & (share < SHARE)
    at = np.concatenate([kept * SHARE, (step[corner] - 1) * SHARE + share[corner]])
    order = np.argsort(at, kind="stable")
    x = np.concatenate([trace.x[kept], trace.path_x[corner]])[order]
    y = np.concatenate([trace.y[kept], trace.path_y[corner]])[order]
    whose = np.concatenate([kept, step[corner]])[order]
    # Unwrap the headings at pi, so that the player can interpolate.
    turns = np.unwrap(trace.heading[whose]) / (2.0 * math.pi)
    columns = {
        "per": {"step": SHARE, "cell": UNIT, "turn": TURN},
        "at": numbers(at[order]),
        "x": numbers(np.rint(x / cell_size * UNIT)),
        "y": numbers(np.rint(y / cell_size * UNIT)),
        "heading": numbers(np.rint(turns * TURN)),
        "bump": bits(trace.bump[whose]),
    }
    return columns, whose


def _acted(trace: Trace, controller: Controller | None, kept: Ints, rows: Ints) -> dict[str, Any]:
    """Return the behaviour that acted by row, for a robot with behaviours that can be seen."""
    arbitration: Arbitration | None = getattr(controller, "arbitration", None)
    if trace.active is not None:
        return {"active": numbers(trace.active[rows]), "behaviours": list(BEHAVIOURS)}
    if arbitration is None or not trace.memory_size:
        return {}
    acted = acted_at(arbitration, trace, kept)
    return {
        "active": numbers(acted[np.searchsorted(kept, rows)]),
        "behaviours": list(arbitration.names),
    }


def _kept_steps(steps: int, span: tuple[int, int], most: int) -> tuple[Ints, int]:
    """Return the steps to include, about ``most`` of them.

    They are dense in the interesting part and even elsewhere.
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


def _stride(count: int, most: int) -> int:
    return max(1, -(-count // most))


def _span_of_interest(
    steps: int, loop: list[int] | None, marks: list[dict[str, Any]]
) -> tuple[int, int]:
    """Return the first and last step of the part that a reader examines most closely."""
    if loop is not None:
        return min(loop[0], steps), min(loop[0] + loop[1], steps)
    centre = next((mark["step"] for mark in marks if "cell" in mark), steps)
    return max(0, centre - _LEAD_UP), min(steps, centre + _LEAD_UP)


def _loop(episode: Episode) -> list[int] | None:
    evidence = episode.evidence
    if isinstance(evidence, LoopEvidence):
        return [evidence.entry, evidence.period]
    if isinstance(evidence, JointLoopEvidence):
        return [evidence.entry, evidence.driven_period]
    return None


def _first_touch(trace: Trace) -> list[dict[str, Any]]:
    """Return the mark of the first step in which the robot touches something; none if it never does."""
    steps = np.flatnonzero(trace.bump)[:1].tolist()
    return [
        _mark(step, "touch", "First bump", "touches something for the first time") for step in steps
    ]


def _marks(episode: Episode) -> list[dict[str, Any]]:
    """Return the steps in the evidence, each with a name, a description and perhaps a cell."""
    match episode.evidence:
        case LoopEvidence(entry=entry):
            return [_mark(entry, "entry", "Entry", "the loop is entered")]
        case JointLoopEvidence(entry=entry):
            return [_mark(entry, "entry", "Entry", "the joint state recurs from here on")]
        case WallEvidence() as wall:
            found = []
            # The move that let the robot into the wall comes before the breach itself.
            if wall.since is not None:
                found.append(
                    _mark(wall.since, "cause", "Cause", f"a {wall.cause} takes it into the wall")
                )
            found.append(
                _mark(wall.step, "breach", *_BREACHES[episode.verdict]) | {"cell": list(wall.cell)}
            )
            if wall.reached is not None:
                found.append(_mark(wall.reached, "last", "Arrives", "enters the walled-off target"))
            return found
        case BurnedEvidence(step=step, cell=cell) | ContactEvidence(step=step, cell=cell):
            return [_mark(step, "caught", *_BREACHES[episode.verdict]) | {"cell": list(cell)}]
        case BudgetEvidence(last_new_cell=step):
            return [
                _mark(step, "stays", "Nothing new after", "enters a new cell for the last time")
            ]
    return []


def _mark(step: int, kind: str, name: str, text: str) -> dict[str, Any]:
    return {"step": step, "kind": kind, "name": name, "text": text}
