"""Play the changes of a MuJoCo model that worldgen wrote.

Cells become solid, free or burning. NAME_player.py is next to NAME.xml and NAME_events.json. Run it
to watch the model in MuJoCo's viewer, or import it:

    model = mujoco.MjModel.from_xml_path("NAME.xml")
    data = mujoco.MjData(model)
    play(model, data, until=30.0)  # mj_step with the events at their times
    apply(model, data)             # or, in your own loop: puts all bodies where they belong at
    data.time

It needs only the standard library and mujoco.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco

# s; data.time is a sum of many steps, and a step that ends this close to an event ends on it.
_ROUNDING = 1e-9


def _table() -> dict[str, Any]:
    here = Path(__file__)
    name = here.name.removesuffix("_player.py") + "_events.json"
    table: dict[str, Any] = json.loads(here.with_name(name).read_text(encoding="utf-8"))
    return table


_TABLE = _table()


def events() -> list[tuple[float, str, float]]:
    """Return the time, s, the body, and the height of its centre from then on, m.

    In order of time, beginning at time 0.
    """
    return [(time, name, z) for time, name, z in _TABLE["events"]]


def _move(model: Any, data: Any, name: str, z: float) -> None:
    x, y = _TABLE["bodies"][name]
    data.mocap_pos[model.body(name).mocapid[0]] = (x, y, z)


def apply(model: Any, data: Any) -> None:
    """Put every body where it belongs at ``data.time``, and tell the engine.

    Args:
        model: The MjModel.
        data: Its MjData.
    """
    latest = {name: z for time, name, z in events() if time <= data.time + _ROUNDING}
    for name, z in latest.items():
        _move(model, data, name, z)
    mujoco.mj_kinematics(model, data)


def play(
    model: Any, data: Any, until: float, control: Callable[[Any, Any], None] | None = None
) -> None:
    """Step the engine to a time.

    Every change happens before the first step that begins at or after its time.

    Args:
        model: The MjModel.
        data: Its MjData.
        until: Time, s, at which to stop.
        control: Called with both before every step.
    """
    apply(model, data)
    waiting = [event for event in events() if event[0] > data.time + _ROUNDING]
    done = 0
    while data.time < until - _ROUNDING:
        while done < len(waiting) and waiting[done][0] <= data.time + _ROUNDING:
            _, name, z = waiting[done]
            _move(model, data, name, z)
            done += 1
        if control is not None:
            control(model, data)
        mujoco.mj_step(model, data)
    apply(model, data)


def _watch() -> None:
    """Run the model in MuJoCo's viewer, in real time."""
    import time  # noqa: PLC0415

    import mujoco.viewer  # noqa: PLC0415

    model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name(_TABLE["model"])))
    data = mujoco.MjData(model)
    with mujoco.viewer.launch_passive(model, data) as viewer:
        begin = time.monotonic()
        while viewer.is_running():
            play(model, data, time.monotonic() - begin)
            viewer.sync()
            time.sleep(1 / 60)


if __name__ == "__main__":
    _watch()
