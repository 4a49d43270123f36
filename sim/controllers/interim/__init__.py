"""The library's controllers as numba compiles them, for what still runs in numba; goes when all of that is C."""

from __future__ import annotations

import ctypes
import importlib
from typing import Any

import numpy as np


def numba_act(name: str, address: int = 0) -> Any:
    """Return a controller's act by the name that it has in the core."""
    if name.startswith("lib:"):
        return _foreign(address)
    if name.endswith("-tuned"):
        return _tuned(name)
    module = "thesis" if name.startswith("turn-") else name.replace("-", "_")
    attribute = "wall_left" if name == "wall" else name.replace("-", "_")
    if name not in _MODULES:
        return None
    return getattr(importlib.import_module(f"sim.controllers.interim.{module}"), attribute).act


_MODULES = {
    "bug1", "bug2", "dynamic-window", "mapper", "potential-field", "q-learning", "random-walk", "tangent-bug",
    "three-layer", "turn-left", "turn-right", "turn-random", "vfh", "wall",
}  # fmt: skip


def _tuned(name: str) -> Any:
    from sim.controllers.interim import dynamic_window, potential_field, q_learning, three_layer, vfh

    potential_drive, numbers_p = potential_field.drive, potential_field.PotentialField
    vfh_drive, numbers_v = vfh.drive, vfh.VfhPlus
    dynamic_drive, numbers_d = dynamic_window.drive, dynamic_window.DynamicWindow
    three_drive, numbers_t = three_layer.drive, three_layer.ThreeLayer
    q_drive = q_learning.drive

    def potential(o: Any, m: Any, c: Any) -> None:
        potential_drive(o, m, c, numbers_p(m[0], m[1], m[2], m[3], m[4]))

    def sectors(o: Any, m: Any, c: Any) -> None:
        t = numbers_v(m[73], m[74], m[75], m[76], m[77], m[78], m[79], m[80], m[81], m[82])
        vfh_drive(o, m, c, np.zeros(72), t)

    def window(o: Any, m: Any, c: Any) -> None:
        t = numbers_d(m[2], m[3], m[4], m[5], int(m[6]), int(m[7]), m[8], m[9], m[10], m[11], m[12], m[13])
        dynamic_drive(o, m, c, np.zeros((o.size - 17, 2)), t)

    def layers(o: Any, m: Any, c: Any) -> None:
        t = numbers_t(m[110], m[111], m[112], m[113], m[114])
        three_drive(o, m, c, np.zeros(48, np.int64), np.zeros(48, np.int64), t)

    def table(o: Any, m: Any, c: Any) -> None:
        q_drive(o, m, c, m[2:].astype(np.int64))

    return {
        "potential-field-tuned": potential, "vfh-tuned": sectors, "dynamic-window-tuned": window,
        "three-layer-tuned": layers, "q-learning-tuned": table,
    }[name]  # fmt: skip


def _foreign(address: int) -> Any:
    """Return a function that calls a C function."""
    call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(address)

    def act(observation: Any, memory: Any, command: Any) -> None:
        seen, asked = np.empty(19), np.zeros(4)
        seen[:17] = observation[:17]
        words = seen.view(np.int64)
        words[17], words[18] = observation.ctypes.data + 136, observation.size - 17
        call(seen.ctypes, memory.ctypes, asked.ctypes)
        command[:] = asked[:3]
        if asked.view(np.int64)[3] != 0:
            raise RuntimeError("the controller reports an error")

    return act
