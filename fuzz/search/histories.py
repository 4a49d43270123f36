"""Search for failures that need a long history, guided by what can be seen of a controller's state.

In most worlds a counter stays small: the robot arrives long before it has driven 2,000 steps along
one wall. A world in which a number of the controller's memory, or of its attributes, is larger or
smaller than ever before, or in which a line runs that never ran, is kept and grown: its parts are
repeated, and its road continues behind the target. A failure of a run that got there is proved even
if its cause is known.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from fuzz.layouts.grown_worlds import grown, new_genome
from fuzz.unit.result import Elite
from sim.controllers.hidden_state import attributes
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.random_streams import RandomStream

Cell: TypeAlias = tuple[int, ...]
"""What a number is of, its index, and 1 for its largest value, 0 for its smallest."""

_MEMORY, _ATTRIBUTE, _LINE = range(3)
# Numbers of a memory that are watched. Those that never change, such as a plan, are not.
_MOST_NUMBERS = 64
# Attributes and lines are known by a number below this.
_MOST_NAMES = 1_000
# One in this many worlds is not grown from another.
_NEW = 4
# A value is more extreme than another if it exceeds it by this share.
_FURTHER = 0.02
# Parts into which the share of each number is divided.
_SHARES = 1 << 16


class Histories:
    """The most extreme histories so far, from which the next ones are grown.

    Args:
        elites: The search state's elites; those of the archive are left alone.
    """

    def __init__(self, elites: Mapping[Cell, Elite]) -> None:
        self._elites = {cell: one for cell, one in sorted(elites.items()) if is_extreme(cell)}
        # How often each was grown further, and how often that led further.
        self._tries: Counter[Cell] = Counter()
        self._gains: Counter[Cell] = Counter()
        self._parent: Cell | None = None
        self.brought: dict[Cell, Elite] = {}

    @property
    def is_empty(self) -> bool:
        """True if no run has changed any number yet."""
        return not self._elites

    def draw(self, stream: RandomStream) -> bytes:
        """Return the genome of the next world.

        Numbers that grow when their worlds are grown get most of them.

        Args:
            stream: Source of randomness; it is advanced.
        """
        self._parent = None
        if not self._elites or stream.below(_NEW) == 0:
            return new_genome(stream)
        shares = {
            cell: _SHARES * (1 + self._gains[cell]) // (1 + self._tries[cell])
            for cell in self._elites
        }
        point = stream.below(sum(shares.values()))
        for cell, share in shares.items():
            point -= share
            if point < 0:
                self._parent = cell
                break
        assert self._parent is not None, "the shares add up to more than any point"
        return grown(self._elites[self._parent].layout, stream)

    def take(self, genome: bytes, extremes: Mapping[Cell, float], verdict: str) -> bool:
        """Keep a world in which a run has an extreme value and arrives; return whether it has one.

        A robot that circles in one place reaches any count, wherever it is.

        Args:
            genome: The world's genome.
            extremes: From :func:`extremes_of`; a smallest value is negated.
            verdict: How the run ended.
        """
        better = [cell for cell, value in extremes.items() if self._is_further(cell, value)]
        if self._parent is not None:
            self._tries[self._parent] += 1
            self._gains[self._parent] += self._parent in better
        for cell in better if verdict == Verdict.REACHED else ():
            self._elites[cell] = self.brought[cell] = Elite(genome, extremes[cell], verdict)
        return bool(better)

    def _is_further(self, cell: Cell, value: float) -> bool:
        before = self._elites.get(cell)
        return before is None or value - before.quality > _FURTHER * abs(before.quality)


def is_extreme(cell: tuple[int, ...]) -> bool:
    """Return True if a cell of a search state's elites is an extreme value's."""
    return len(cell) == 3


def line_cell(line: int) -> Cell:
    """Return the cell of the first world in which a line of the controller ran."""
    return _LINE, line % _MOST_NAMES, 1


def extremes_of(controller: Any, trace: Trace) -> dict[Cell, float]:
    """Return the largest and smallest values of the numbers that a run has changed.

    Of a memory, those of all steps; of attributes, those after the run. A smallest value is negated.

    Args:
        controller: The controller, after the run.
        trace: The run's recording.
    """
    found: dict[Cell, float] = {}
    if trace.memory_size and trace.recall is None:
        memory = trace.memories
        changed = np.flatnonzero((memory != memory[0]).any(axis=0))[:_MOST_NUMBERS]
        for number in changed.tolist():
            values = memory[np.isfinite(memory[:, number]), number]
            if len(values):
                found[_MEMORY, number, 1] = float(values.max())
                found[_MEMORY, number, 0] = -float(values.min())
    for name, value in attributes(controller).items():
        number = _number_of(value)
        if number is not None:
            index = zlib.crc32(name.encode()) % _MOST_NAMES
            found[_ATTRIBUTE, index, 1] = number
            found[_ATTRIBUTE, index, 0] = -number
    return found


def _number_of(value: object) -> float | None:
    """Return a number or the size of a collection; ``None`` for anything else."""
    if type(value) in (list, dict, set, tuple):
        return float(len(value))  # type: ignore[arg-type]
    is_number = type(value) in (int, float) or isinstance(value, np.integer | np.floating)
    number = float(value) if is_number else np.nan  # type: ignore[arg-type]
    return number if np.isfinite(number) else None
