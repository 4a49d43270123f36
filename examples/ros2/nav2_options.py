"""Print the options of ``worldgen run`` and ``worldgen fuzz`` that stand for parameters of Nav2.

    python nav2_options.py nav2_params.yaml [GOAL_HEADING]

``controller_frequency`` becomes the time step, the first goal checker the target's radius and what
counts as arriving, and the first ``footprint`` the body. Use it in a command line:

    eval worldgen run w.grid --controller ./robot.py:Robot "$(python nav2_options.py nav2_params.yaml)"

The radius of a round robot belongs to the world: it is printed as a comment for the command that
makes it.
"""

import argparse
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

ARRIVALS = {"SimpleGoalChecker": "step", "StoppedGoalChecker": "stop"}
# Nav2's defaults, m, rad, m/s, rad/s and Hz.
TOLERANCE = 0.25
STOPPED = 0.25
FREQUENCY = 20.0


def tables(found: Any) -> Iterator[dict[str, Any]]:
    """Yield a mapping and all mappings below it."""
    if isinstance(found, dict):
        yield found
        for below in found.values():
            yield from tables(below)


def first(known: list[dict[str, Any]], name: str) -> Any:
    """Return the first value of this name that is not empty."""
    values = (table[name] for table in known if name in table)
    return next((value for value in values if value not in (None, "", "[]", [])), None)


def options_of(params: Any, heading: float | None) -> tuple[list[str], list[str]]:
    """Return the options, and remarks for the command that makes the world."""
    known = list(tables(params))
    options = [f"--time-step={1.0 / float(first(known, 'controller_frequency') or FREQUENCY):g}"]
    remarks = []

    footprint = first(known, "footprint")
    if footprint is not None:
        corners = yaml.safe_load(footprint) if isinstance(footprint, str) else footprint
        options.append("--footprint=" + " ".join(f"{x:g},{y:g}" for x, y in corners))
    elif (radius := first(known, "robot_radius")) is not None:
        remarks.append(f"--radius {radius:g}")

    for table in known:
        arrival = ARRIVALS.get(str(table.get("plugin", "")).replace("/", ":").split(":")[-1])
        if arrival is None:
            continue
        if arrival == "stop":
            speeds = ("trans_stopped_velocity", "rot_stopped_velocity")
            arrival = ":".join([arrival, *(f"{table.get(name, STOPPED):g}" for name in speeds)])
        options.append(f"--arrival={arrival}")
        options.append(f"--target-radius={table.get('xy_goal_tolerance', TOLERANCE):g}")
        if heading is not None:
            tolerance = table.get("yaw_goal_tolerance", TOLERANCE)
            options.append(f"--target-heading={heading:g}:{tolerance:g}")
        break
    return options, remarks


def main() -> None:
    """Print the options on one line, and remarks on stderr."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("params", type=Path, help="file of parameters of Nav2")
    parser.add_argument("heading", type=float, nargs="?", help="heading of the goal, rad")
    given = parser.parse_args()
    try:
        params = yaml.safe_load(given.params.read_text(encoding="utf-8"))
        options, remarks = options_of(params, given.heading)
    except (
        OSError,
        UnicodeError,
        yaml.YAMLError,
        TypeError,
        ValueError,
        ZeroDivisionError,
    ) as error:
        sys.exit(f"{given.params}: cannot be read as parameters of Nav2: {error}")
    print(shlex.join(options))
    if remarks:
        print(f"for worldgen import: {' '.join(remarks)}", file=sys.stderr)


if __name__ == "__main__":
    main()
