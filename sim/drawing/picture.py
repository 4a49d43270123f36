"""A run as something to draw over its world."""

from __future__ import annotations

import numpy as np

from sim.drawing.wall_penetrations import penetrated_cells
from sim.episode import Episode
from sim.evidence import LoopEvidence, WallEvidence
from sim.verdict import Verdict
from worldgen.render import Drive, EventMark, Trail
from worldgen.render.overlay import MarkKind
from worldgen.world import World

__all__ = ["drive_of", "trail_of"]

_MOST_BUMPS = 400  # marks beyond that hide the picture


def trail_of(episode: Episode, world: World | None = None) -> Trail | None:
    """The driven line of a recorded episode, its loop, bumps and breaches.

    ``None`` without a recording.

    Args:
        episode: The run.
        world: Where it was; without it the walls that the robot went into are not marked.
    """
    trace = episode.trace
    if trace is None:
        return None
    evidence = episode.evidence
    loop_from = None
    if isinstance(evidence, LoopEvidence):
        loop_from = int(np.searchsorted(trace.path_step, evidence.entry, side="right")) - 1
    onsets = np.flatnonzero(trace.bump[1:] & ~trace.bump[:-1]) + 1
    marks = [EventMark(float(trace.x[k]), float(trace.y[k]), "bump") for k in onsets[:_MOST_BUMPS]]
    if isinstance(evidence, WallEvidence) and 0 <= evidence.step <= trace.steps:
        step = evidence.step
        kind: MarkKind = "tunnel" if episode.verdict == Verdict.TUNNEL else "overlap"
        marks.append(EventMark(float(trace.x[step]), float(trace.y[step]), kind))
    if loop_from is None:
        marks.append(EventMark(float(trace.x[-1]), float(trace.y[-1]), "end"))
    return Trail(
        trace.path_x,
        trace.path_y,
        loop_from,
        marks,
        () if world is None else penetrated_cells(episode, world),
    )


def drive_of(episode: Episode, world: World, name: str = "") -> Drive:
    """What the robot of a recorded episode did, and when.

    One without a recording stays at its start.
    """
    trace = episode.trace
    trail = trail_of(episode, world)
    if trace is None or trail is None:
        start = world.start
        return Drive(
            name,
            Trail(np.array([start.x]), np.array([start.y])),
            np.zeros(1),
            np.array([start.heading]),
            1.0,
        )
    times = np.maximum(trace.path_step - 1 + trace.path_share, 0.0) * trace.time_step
    return Drive(name, trail, times, trace.heading, trace.time_step)
