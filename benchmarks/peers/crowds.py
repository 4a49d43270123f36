"""Measure how many steps of a robot another simulator of several robots makes per second.

``PYTHON benchmarks/peers/crowds.py LIBRARY`` reads halls, one JSON object a line, from standard
input, and prints a JSON object: the best rate of each hall, in the order given, and the version. It
runs in the peer's own environment, so it uses only the standard library and the peer. Rates are per
second of the process's CPU time, over calls of the simulator's own step.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import math
import sys
import time
from collections.abc import Callable
from typing import Any

Step = Callable[[int], Any]

# Grid cells of POGEMA per metre: a robot of 0.14 m needs a cell of 0.2 m.
PER_METRE = 5


def _pyrvo(hall: dict[str, Any]) -> Step:
    """RVO2: no walls. The robots prefer the same velocities throughout, the ones at the start."""
    library: Any = importlib.import_module("pyrvo")
    simulator = library.RVOSimulator(hall["step"], 2.0, 8, 2.0, 2.0, hall["radius"], hall["speed"])
    for start, target in zip(hall["starts"], hall["targets"], strict=True):
        agent = simulator.add_agent(tuple(start))
        far = max(math.dist(start, target), 1e-9)
        simulator.set_agent_pref_velocity(
            agent, tuple((b - a) / far * hall["speed"] for a, b in zip(start, target, strict=True))
        )
    return lambda _: simulator.do_step()


def _navground(behaviour: str) -> Callable[[dict[str, Any]], Step]:
    def make(hall: dict[str, Any]) -> Step:
        """Make a world with the hall's walls, where robots see 2 m far."""
        # The walls of the hall.
        core: Any = importlib.import_module("navground.core")
        library: Any = importlib.import_module("navground.sim")
        world = library.World()
        width = hall["width"]
        height = hall["height"]
        corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
        for k in range(4):
            world.add_wall(library.Wall(corners[k], corners[k - 1]))
        # The robots: each drives to its target and then stops.
        for start, target in zip(hall["starts"], hall["targets"], strict=True):
            kinematics = core.kinematics.OmnidirectionalKinematics(hall["speed"], 10.0)
            driver = core.Behavior.make_type(behaviour)
            driver.kinematics = kinematics
            driver.radius = hall["radius"]
            driver.optimal_speed = hall["speed"]
            driver.horizon = 2.0
            agent = library.Agent(
                radius=hall["radius"],
                behavior=driver,
                kinematics=kinematics,
                task=library.tasks.WaypointsTask([target], loop=False, tolerance=0.05),
                state_estimations=[library.state_estimations.BoundedStateEstimation(2.0)],
            )
            agent.position = start
            world.add_agent(agent)
        return lambda _: world.update(hall["step"])

    return make


def _pogema(hall: dict[str, Any]) -> Step:
    """An empty grid, with random moves drawn beforehand. Robots that arrive stay."""
    library: Any = importlib.import_module("pogema")
    random = importlib.import_module("random").Random(0)
    # Put starts and targets into cells.
    rows, columns = (round(hall[side] * PER_METRE) for side in ("height", "width"))
    cells = [
        [
            [min(int(v * PER_METRE), most - 1) for v, most in ((y, rows), (x, columns))]
            for x, y in ends
        ]
        for ends in (hall["starts"], hall["targets"])
    ]
    count = len(hall["starts"])
    env = library.pogema_v0(
        grid_config=library.GridConfig(
            map=[[0] * columns for _ in range(rows)],
            num_agents=count,
            agents_xy=cells[0],
            targets_xy=cells[1],
            obs_radius=5,
            on_target="nothing",
            max_episode_steps=10**9,
            integration=None,
            seed=0,
        )
    )
    env.reset()
    # Drawing the moves is not part of what is measured.
    actions = [[random.randrange(5) for _ in range(count)] for _ in range(64)]
    return lambda k: env.step(actions[k % 64])


LIBRARIES: dict[str, dict[str, Callable[[dict[str, Any]], Step]]] = {
    "navground": {name: _navground(name) for name in ("Dummy", "HL", "ORCA")},
    "pogema": {"random moves": _pogema},
    "pyrvo": {"RVO2": _pyrvo},
}


def main() -> None:
    """Measure the library that the command line names."""
    (name,) = sys.argv[1:]
    halls = [json.loads(line) for line in sys.stdin]
    rates: dict[str, list[float]] = {}
    for case, make in LIBRARIES[name].items():
        rates[case] = []
        for hall in halls:
            step = make(hall)
            begin = time.process_time()
            for k in range(hall["steps"]):
                step(k)
            seconds = max(time.process_time() - begin, 1e-9)
            rates[case].append(hall["steps"] * len(hall["starts"]) / seconds)
    version = importlib.metadata.version(name)
    sys.stdout.write(json.dumps({"version": version, "rates": rates}) + "\n")


if __name__ == "__main__":
    main()
