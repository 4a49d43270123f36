"""The episode loop for a Python controller or a program: the kernel's own pieces, one call at a time."""

from __future__ import annotations

import contextlib
import pickle
import random
import re
import sys
import types
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sim.controllers.base import Command, Memory, Observation, PythonController
from sim.controllers.process import ProcessController
from sim.controllers.program import Misbehaviour
from sim.kernels import layout
from sim.kernels.lattice_episode import Arena, advance, apply_events, begin, hash_row, obey
from sim.kernels.lattice_sense import sense

__all__ = ["PythonLoop"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


class PythonLoop:
    """One episode; read ``counts``, ``sums``, ``rows``, ``complete`` and ``fault`` after :meth:`run`.

    Args:
        controller: What runs.
        arena: Surroundings at the start.
        settings: As for the compiled episode.
        scales: Likewise.
    """

    def __init__(self, controller: PythonController, arena: Arena, settings: Ints, scales: Floats) -> None:
        self._controller, self._arena, self._settings, self._scales = controller, arena, settings, scales
        self.counts, self.sums = np.zeros(layout.OUT_SIZE, np.int64), np.zeros(layout.SUM_SIZE)
        self.rows: list[Ints] = []
        self.complete = True
        self.fault: Misbehaviour | None = None
        self._chain, self._event = np.zeros((4, 2), np.int64), 0
        self._observation, self._command = np.zeros(layout.OBS_SIZE), np.zeros(layout.CMD_SIZE)

    def run(self, steps: int, *, find_loop: bool, record: bool) -> None:
        """Runs the episode; whatever the controller raises ends it as a crash, its exit from Python included.

        What it prints goes to stderr, so that stdout stays data. A program's memory cannot be seen: its run is not
        complete, and no recurrence ends it.
        """
        if isinstance(self._controller, ProcessController):
            self.complete = False
            self._controller.start()  # outside the guard: a program that is not there is nobody's crash
            self._guarded(steps, False, record)
            return
        hidden = _hidden_state(self._controller)
        with contextlib.redirect_stdout(sys.stderr):
            self._guarded(steps, find_loop, record)
        self.complete = hidden is not None and _hidden_state(self._controller) == hidden

    def _guarded(self, steps: int, find_loop: bool, record: bool) -> None:
        try:
            memory = _flat(self._controller.reset())
            state = np.zeros(layout.STATE_MEMORY + len(memory), np.int64)
            begin(self._settings, self._scales, state, self.counts, self.sums)
            state[layout.STATE_MEMORY :] = np.array(memory, np.float64).view(np.int64)
            self._loop(memory, state, steps, find_loop, record)
        except Misbehaviour as fault:
            self.fault = fault
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a controller may raise anything; it is the finding
            text = re.sub(r"0x[0-9a-fA-F]+", "0x...", f"{type(error).__name__}: {error}")
            self.fault = Misbehaviour("crash", text.encode("utf-8", "replace").decode())

    def _loop(self, memory: Memory, state: Ints, steps: int, find_loop: bool, record: bool) -> None:
        counts, quiet = self.counts, int(self._arena.events[-1, 0]) if len(self._arena.events) else 0
        if record:
            self.rows.append(np.concatenate([np.zeros(layout.ROW_STATE, np.int64), state]))
        anchor, power, period, touching = b"", 1, 0, False
        for step in range(1, steps + 1):
            counts[layout.OUT_STEPS] = step
            row, memory = self._step(memory, state, step)
            bumped = bool(row[layout.ROW_BUMP])
            counts[layout.OUT_COLLISIONS] += bumped and not touching
            touching = bumped
            hash_row(row, counts)
            if record:
                self.rows.append(row)
            if counts[layout.OUT_ENDING] != layout.LIMIT:
                break
            if find_loop and step > quiet:
                period += 1
                now = state.tobytes()
                if now == anchor:
                    counts[layout.OUT_ENDING], counts[layout.OUT_PERIOD] = layout.LOOP, period
                    break
                if period == power:
                    anchor, power, period = now, 2 * power, 0
        counts[layout.OUT_DRAWS] = state[layout.STATE_DRAWS]

    def _step(self, memory: Memory, state: Ints, step: int) -> tuple[Ints, Memory]:
        arena, settings, scales, counts = self._arena, self._settings, self._scales, self.counts
        if self._event < len(arena.events) and arena.events[self._event, 0] <= step:
            self._event = apply_events(arena, settings, step, self._event, state, counts)
        points, normal = 0, (0.0, 0.0)
        if counts[layout.OUT_ENDING] == layout.LIMIT:
            points, *contact = advance(arena, settings, scales, step, state, self._chain, counts, self.sums)
            normal = (contact[0], contact[1])
        if counts[layout.OUT_ENDING] == layout.LIMIT:
            pose = (int(state[0]), int(state[1]), int(state[2]))
            draws = int(state[layout.STATE_DRAWS])
            sense(arena.cells, settings, scales, pose, normal, draws, self._observation)
            command, after = self._controller.act(Observation.of(self._observation), memory)
            memory = _flat(after, len(memory))
            self._obey(Command(*command), state)
            state[layout.STATE_MEMORY :] = np.array(memory, np.float64).view(np.int64)
        row = np.zeros(layout.ROW_STATE + state.size, np.int64)
        row[layout.ROW_BUMP] = normal != (0.0, 0.0)
        row[layout.ROW_CORNERS] = max(points - 1, 0)
        for k in range(max(points - 1, 0)):
            row[layout.ROW_CORNER_1 + 2 * k : layout.ROW_CORNER_1 + 2 * k + 2] = self._chain[k]
        row[layout.ROW_STATE :] = state
        return row, memory

    def _obey(self, command: Command, state: Ints) -> None:
        try:
            self._command[:] = (
                float(command.speed),
                float(command.turn_rate),
                float(bool(command.used_random)),
            )
        except (TypeError, ValueError):
            self.counts[layout.OUT_ENDING] = layout.INVALID_COMMAND
            return
        obey(self._scales, self._command, state, self.counts)


def _hidden_state(controller: Any) -> bytes | None:
    """All state outside ``memory`` that we can see: attributes, slots, class and module data, random generators.

    ``None`` if some of it cannot be pickled and so cannot be compared.
    """
    kind = type(controller)
    slots = [name for base in kind.__mro__ for name in getattr(base, "__slots__", ()) if hasattr(controller, name)]
    module = sys.modules.get(kind.__module__)
    seen = [
        _data(getattr(controller, "__dict__", {})),
        {name: getattr(controller, name) for name in slots},
        *(_data(vars(base)) for base in kind.__mro__ if base is not object),
        _data(vars(module)) if module is not None and kind.__module__.startswith("_worldgen_user") else {},
        random.getstate(),
        np.random.get_state(),
    ]
    try:
        return pickle.dumps(seen)
    except Exception:  # noqa: BLE001 - whatever cannot be pickled cannot be compared
        return None


def _data(names: Mapping[str, Any]) -> dict[str, Any]:
    code = (type, types.FunctionType, types.ModuleType, types.MethodType, classmethod, staticmethod, property)
    return {
        name: value
        for name, value in names.items()
        if not name.startswith("__")
        and not isinstance(value, (*code, types.GetSetDescriptorType, types.MemberDescriptorType))
    }


def _flat(memory: Any, size: int | None = None) -> Memory:
    """The controller's memory as floats.

    Raises:
        TypeError: If it is not a tuple of numbers of a fixed length; the run then counts as a crash.
    """
    if not isinstance(memory, tuple) or not all(isinstance(value, int | float | np.number) for value in memory):
        raise TypeError(f"memory must be a tuple of numbers, not {memory!r}")
    if size is not None and len(memory) != size:
        raise TypeError(f"memory had {size} numbers and now has {len(memory)}; keep its length fixed")
    return tuple(float(value) for value in memory)
