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
from sim.kernels.lattice_episode import Arena, advance, begin, hash_step, new_robot, obey
from sim.kernels.lattice_sense import sense

__all__ = ["PythonLoop"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


class PythonLoop:
    """One episode; read ``robot``, ``complete`` and ``fault``, and :meth:`recording`, after :meth:`run`.

    Args:
        controller: What runs.
        arena: Surroundings at the start.
        settings: As for the compiled episode.
        scales: Likewise.
    """

    def __init__(self, controller: PythonController, arena: Arena, settings: Ints, scales: Floats) -> None:
        self._controller, self._arena, self._settings, self._scales = controller, arena, settings, scales
        self.robot = new_robot(0, arena.events)
        self.complete = True
        self.fault: Misbehaviour | None = None
        self._rows: list[Ints] = []
        self._path: list[Ints] = []
        self._event = 0
        self._observation = np.full(layout.OBS_SIZE + settings[layout.SET_BEAMS], np.nan)
        self._command = np.zeros(layout.CMD_SIZE)

    def run(self, steps: int, *, record: bool) -> None:
        """Runs the episode; whatever the controller raises ends it as a crash, its exit from Python included.

        What it prints goes to stderr, so that stdout stays data. A program's memory cannot be seen: its run is not
        complete, and no recurrence ends it.
        """
        if isinstance(self._controller, ProcessController):
            self.complete = False
            self._controller.start()  # outside the guard: a program that is not there is nobody's crash
            self._settings[layout.SET_FIND_LOOP] = 0
            self._guarded(steps, record)
            return
        hidden = _hidden_state(self._controller)
        with contextlib.redirect_stdout(sys.stderr):
            self._guarded(steps, record)
        self.complete = hidden is not None and _hidden_state(self._controller) == hidden

    def recording(self) -> tuple[Ints, Ints]:
        """The states as rows, and the points of the path, as the compiled episode writes them."""
        width = layout.ROW_STATE + self.robot.state.size
        path = np.concatenate(self._path) if self._path else np.zeros((0, layout.POINT_SIZE), np.int64)
        return np.array(self._rows, np.int64).reshape(-1, width), path

    def _guarded(self, steps: int, record: bool) -> None:
        try:
            memory = _flat(self._controller.reset())
            self.robot = new_robot(len(memory), self._arena.events)
            begin(self._settings, self._scales, self.robot)
            self._remember(memory)
            self._loop(memory, steps, record)
        except Misbehaviour as fault:
            self.fault = fault
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a controller may raise anything; it is the finding
            text = re.sub(r"0x[0-9a-fA-F]+", "0x...", f"{type(error).__name__}: {error}")
            self.fault = Misbehaviour("crash", text.encode("utf-8", "replace").decode())

    def _remember(self, memory: Memory) -> None:
        self.robot.state[layout.STATE_MEMORY :] = np.array(memory, np.float64).view(np.int64)

    def _loop(self, memory: Memory, steps: int, record: bool) -> None:
        robot, counts, events = self.robot, self.robot.counts, self._arena.events
        quiet = int(events[-1, layout.EVENT_STEP]) if len(events) else 0
        find_loop, hashed = bool(self._settings[layout.SET_FIND_LOOP]), bool(self._settings[layout.SET_DIGEST])
        if record:
            self._rows.append(np.concatenate([np.zeros(layout.ROW_STATE, np.int64), robot.state]))
        anchor, power, period, touching = b"", 1, 0, False
        for step in range(1, steps + 1):
            counts[layout.OUT_STEPS] = step
            count, bumped, memory = self._step(memory, step)
            counts[layout.OUT_COLLISIONS] += bumped and not touching
            touching = bumped
            if hashed:
                hash_step(robot, count, bumped)
            if record:
                self._record(step, count, bumped)
            if counts[layout.OUT_ENDING] != layout.LIMIT:
                break
            if find_loop and step > quiet:
                period += 1
                now = robot.state.tobytes()
                if now == anchor:
                    counts[layout.OUT_ENDING], counts[layout.OUT_PERIOD] = layout.LOOP, period
                    break
                if period == power:
                    anchor, power, period = now, 2 * power, 0

    def _step(self, memory: Memory, step: int) -> tuple[int, bool, Memory]:
        """One step: points of its path, whether a wall was touched, and the memory after it."""
        arena, settings, scales, robot = self._arena, self._settings, self._scales, self.robot
        self._event, count, *normal = advance(arena, settings, scales, step, self._event, robot)
        if robot.counts[layout.OUT_ENDING] == layout.LIMIT:
            contact = (normal[0], normal[1])
            sense(
                arena.cells, arena.headings, settings, scales, robot.state, robot.odometry, contact, step,
                self._observation,
            )  # fmt: skip
            command, after = self._controller.act(Observation.of(self._observation), memory)
            memory = _flat(after, len(memory))
            self._obey(Command(*command), step)
            self._remember(memory)
        return count, normal != [0.0, 0.0], memory

    def _record(self, step: int, count: int, bumped: bool) -> None:
        self._rows.append(np.concatenate([[int(bumped)], self.robot.state]))
        points = np.empty((count, layout.POINT_SIZE), np.int64)
        points[:, layout.POINT_STEP] = step
        points[:, layout.POINT_TIME] = self.robot.chain[:count, 2]
        points[:, layout.POINT_X : layout.POINT_Y + 1] = self.robot.chain[:count, :2]
        self._path.append(points)

    def _obey(self, command: Command, step: int) -> None:
        try:
            self._command[:] = (
                float(command.speed),
                float(command.turn_rate),
                float(bool(command.used_random)),
            )
        except (TypeError, ValueError):
            self.robot.counts[layout.OUT_ENDING] = layout.INVALID_COMMAND
            return
        obey(self._settings, self._scales, self._command, step, self.robot)


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
