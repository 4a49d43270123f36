"""The archive strategy: mutate scenes, and keep the simplest one of each kind of behaviour.

In random scenes most robots drive straight to their target. The archive's cells are kinds of runs
that arrive, by detour, density of the world, how often the robot revisits a place, and how close it
gets to walls. Mutated copies of the scenes in them fill other cells, and some fail. Scenes in which
the robot fails have no children; the archive keeps them on a separate map.

Source: Jean-Baptiste Mouret and Jeff Clune, "Illuminating search spaces by mapping elites", 2015.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzz.layouts.layout_bytes import FEATURE_BYTES, HEAD_BYTES, MAX_FEATURES, SCENE_BYTES
from fuzz.screening import Screening
from fuzz.search import small
from fuzz.search.histories import is_extreme
from fuzz.search.native import look_through, scenes, unit_size_of
from fuzz.search.task import SearchTask
from fuzz.unit.result import Elite
from sim.verdict import Verdict
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bytes, Floats, Ints

ARCHIVE = "archive"

_UNRELATED = 10  # one in this many scenes of a generation has no parents
_EDITS = 3  # largest number of changed bytes in a child; at least one changes
# Small changes of a byte: a move by one or three cells, a different kind, one feature more or less.
_SMALL = np.array([-3, -1, 1, 3])

Cell = tuple[int, ...]


@dataclass(frozen=True)
class _Axis:
    """A number that describes a run, divided into cells of the archive.

    Args:
        name: Name in reports.
        edges: Values at which the next cell begins.
    """

    name: str
    edges: tuple[float, ...]

    def cells(self, values: Floats) -> Ints:
        """Return (n,) int64, the cell's index of each value."""
        return np.searchsorted(np.array(self.edges), values, side="right")


_DETOUR = _Axis("detour", (1.05, 1.15, 1.3, 1.5, 1.8, 2.2, 2.8, 3.6, 5.0, 8.0))
_DENSITY = _Axis("density", (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4))
_REVISITS = _Axis("revisits", (0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 5.0))
_CLEARANCE = _Axis("clearance", (1.3, 1.6, 2.0, 2.5))

_MAP = (_DETOUR, _DENSITY)
"""Axes of the map of failures, and of the map that reports show."""

_ARRIVED = len(_MAP) + 2  # indices of a run that arrived


def search(task: SearchTask) -> None:
    """Screen children of the archive's elites, and hand the smallest failures to triage."""
    elites = {cell: one for cell, one in task.memory.elites.items() if not is_extreme(cell)}
    brought = task.triage.result.elites
    count = unit_size_of(task.config).generation

    def draw(stream: RandomStream) -> Bytes:
        # Vary only layouts where the robot arrives: their cells have more axes than failures do.
        parents = [elite.layout for cell, elite in sorted(elites.items()) if len(cell) == _ARRIVED]
        if not parents:
            return scenes(stream, count)
        pool = np.frombuffer(b"".join(parents), np.uint8).reshape(-1, SCENE_BYTES)
        unrelated = count // _UNRELATED
        return np.concatenate(
            # Some unrelated scenes keep the archive from narrowing to one lineage.
            [_children(pool, stream, count - unrelated), scenes(stream, unrelated)]
        )

    def seen(looks: Screening) -> None:
        for cell, elite in _best(looks).items():
            if cell not in elites or elite.quality > elites[cell].quality:
                elites[cell] = brought[cell] = elite

    look_through(task, draw, seen)
    # Once a campaign has been through what takes little, it also looks for what takes long.
    if task.unit >= small.SETTLED:
        small.grow(task)


def _best(looks: Screening) -> dict[Cell, Elite]:
    """Return the run with the fewest solid cells for each cell of the archive.

    A cell has four indices if its run arrived, two if it failed.
    """
    # The straight distance is 0 where nothing ran, or where the robot starts at its target.
    with np.errstate(divide="ignore", invalid="ignore"):
        detour = looks.driven / looks.straight
    numbers = ((_DETOUR, detour), (_DENSITY, looks.density), (_REVISITS, looks.revisits))
    indices = [
        axis.cells(values) for axis, values in (*numbers, (_CLEARANCE, looks.mean_clearance))
    ]
    cells = np.stack(indices, axis=1)
    solid = looks.solid
    verdicts = looks.verdict
    best: dict[Cell, Elite] = {}
    for n in np.flatnonzero(looks.ran)[np.argsort(solid[looks.ran], kind="stable")].tolist():
        verdict = str(verdicts[n])
        cell = tuple(
            cells[n].tolist() if verdict == Verdict.REACHED else cells[n, : len(_MAP)].tolist()
        )
        best.setdefault(cell, Elite(looks.layouts[n].tobytes(), -float(solid[n]), verdict))
    return best


def _children(pool: Bytes, stream: RandomStream, count: int) -> Bytes:
    """Return (count, SCENE_BYTES) uint8, children of scenes in a pool.

    One in three gets a feature of another scene; in each, up to three bytes change.
    """
    child, other = (pool[_below(stream, count, len(pool))].copy() for _ in range(2))
    rows = np.arange(count)
    crossed = np.flatnonzero(_below(stream, count, 3) == 0)
    to, by = (_feature(_below(stream, count, MAX_FEATURES)) for _ in range(2))
    child[crossed[:, None], to[crossed]] = other[crossed[:, None], by[crossed]]
    for edit in range(_EDITS):
        at, small, byte = (
            _below(stream, count, bound) for bound in (SCENE_BYTES, len(_SMALL), 256)
        )
        way = _below(stream, count, 4)
        value = np.where(way == 0, byte, (child[rows, at] + _SMALL[small]) % 256)
        left = (way == 3) & (edit > 0)
        child[rows, at] = np.where(left, child[rows, at], value)
    return child


def _feature(index: Ints) -> Ints:
    """Return (n, FEATURE_BYTES) int64, the positions of the features' bytes in a scene."""
    where: Ints = HEAD_BYTES + FEATURE_BYTES * index[:, None] + np.arange(FEATURE_BYTES)
    return where


def _below(stream: RandomStream, count: int, bound: int) -> Ints:
    return (stream.bits(count) % np.uint64(bound)).astype(np.int64)


def archive_table(elites: Mapping[Cell, Elite]) -> dict[str, Any] | None:
    """Return the archive as a table for a campaign's summary; ``None`` if it is empty.

    Each cell of detour and density shows its simplest failure, or its simplest run if none failed.

    Args:
        elites: The archive, as the search state keeps it.
    """
    cells: dict[Cell, Elite] = {}
    for cell, elite in sorted(
        elites.items(), key=lambda one: (len(one[0]), -one[1].quality, one[0])
    ):
        # A store may hold cells that another version had.
        if not is_extreme(cell) and all(
            at <= len(axis.edges) for at, axis in zip(cell, _MAP, strict=False)
        ):
            cells.setdefault(cell[: len(_MAP)], elite)
    axes = [{"name": axis.name, "edges": list(axis.edges)} for axis in _MAP]
    shown = [[*cell, elite.quality, elite.verdict] for cell, elite in sorted(cells.items())]
    return {"axes": axes, "cells": shown} if shown else None
