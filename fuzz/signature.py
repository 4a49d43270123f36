"""Classes of failures: what two failures have in common, stable under mirror, rotation and shift."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np

from fuzz.oracles._plain import cell_of, integer
from sim.episode import Episode
from sim.trace import Trace
from worldgen.world import Value, World

__all__ = ["failure_class"]


def failure_class(world: World, episode: Episode) -> str:
    """A short name for the kind of failure, fit for a file name.

    ``loop``: how often the robot touches a wall and how often it turns round in one period, and how far it
    gets. ``tunnel`` and ``overlap``: which move let the robot in, where the motion model knows, and what kind of
    wall gives way; ``breach`` instead, if a walled-off target is then reached. ``stalled``: in what manner, where
    that is known, and how far the robot still gets. ``crash``: the exception, exit code or signal.
    ``invalid-command``: what is wrong with it.

    Args:
        world: Where it happened.
        episode: The run, recorded.
    """
    verdict, trace, evidence = episode.verdict, episode.trace, episode.evidence
    if verdict == "invalid-command":
        return _joined(verdict, re.sub("[^a-z]+", "-", str(evidence.get("error", "")).partition("'")[0]).strip("-"))
    if verdict == "crash":
        return _joined(verdict, _crash(evidence))
    if trace is None:
        return verdict
    if verdict == "loop":
        entry, period = integer(evidence, "entry"), integer(evidence, "period")
        bumps, turns = _touches(trace, entry, entry + period), _turns(trace, entry, entry + period)
        extent = _extent(world, trace, entry, entry + period)
        return f"loop-{_few(bumps, 4)}bump-{_few(turns, 2)}turn-{extent}"
    if verdict in ("tunnel", "overlap"):
        cell = cell_of(evidence)
        what = "breach" if "reached" in evidence else verdict
        return _joined(what, evidence.get("cause"), _wall_kind(world, *cell) if cell else None)
    if verdict in ("stalled", "timeout"):
        extent = _extent(world, trace, trace.steps // 2, trace.steps)
        return _joined(verdict, evidence.get("kind"), extent)
    if verdict == "burned":
        return f"burned-{evidence.get('state', 'burning')}"
    return verdict


def _crash(evidence: Mapping[str, Value]) -> str:
    """The exception's name, or how a program ended, in words fit for a file name."""
    error = str(evidence.get("error", ""))
    kind = error.partition(":")[0]
    if kind.isidentifier():
        return kind
    said = evidence.get("stderr")
    last = re.match(r"(\w*(?:Error|Exception))\b", str(said[-1])) if isinstance(said, list) and said else None
    ended = re.match(r"(?:exit code|killed by) (\w+)", error)
    return _joined(f"exit-{ended[1]}" if ended and ended[1].isdigit() else ended and ended[1], last and last[1])


def _joined(*words: object) -> str:
    return "-".join(str(word) for word in words if word)


def _few(count: int, most: int) -> str:
    return str(count) if count <= most else "many"


def _touches(trace: Trace, first: int, last: int) -> int:
    bump = trace.bump[first : last + 1]
    return int(np.count_nonzero(bump[1:] & ~bump[:-1]))


def _turns(trace: Trace, first: int, last: int) -> int:
    """Whole turns of the heading, without sign, from one state to the same state again."""
    change = np.diff(trace.heading[first : last + 1])
    wrapped = (change + math.pi) % (2 * math.pi) - math.pi
    return abs(round(float(np.sum(wrapped)) / (2 * math.pi)))


def _extent(world: World, trace: Trace, first: int, last: int) -> str:
    x, y = trace.x[first : last + 1], trace.y[first : last + 1]
    cells = max(float(np.ptp(x)), float(np.ptp(y))) / world.cell_size
    for name, limit in (("spot", 0.5), ("near", 4.0), ("wide", 16.0)):
        if cells <= limit:
            return name
    return "far"


def _wall_kind(world: World, ix: int, iy: int) -> str:
    """What a solid cell is part of, by its solid neighbours across edges."""
    if not (0 <= ix < world.width and 0 <= iy < world.height):
        return "border"
    solid = np.pad(world.walls, 1, constant_values=True)
    around = int(solid[iy, ix + 1]) + int(solid[iy + 2, ix + 1]) + int(solid[iy + 1, ix]) + int(solid[iy + 1, ix + 2])
    return ("post", "wall-end", "wall", "block", "block")[around]
