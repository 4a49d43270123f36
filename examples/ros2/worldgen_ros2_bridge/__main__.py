"""``python -m worldgen_ros2_bridge``: the program to name in ``--controller 'cmd:...'``.

See README.md.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from worldgen_ros2_bridge.lockstep import Bridge, Settings, serve
from worldgen_ros2_bridge.messages import Grid, grid_of


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m worldgen_ros2_bridge", description="Drive worldgen's robot over ROS 2."
    )
    parser.add_argument(
        "--map",
        type=Path,
        help=".grid file to publish as /map, with the origin of the map it came from",
    )
    parser.add_argument(
        "--beam-range", type=float, default=Settings.beam_range, help="the run's +beam_range, m"
    )
    parser.add_argument(
        "--beam-field", type=float, default=Settings.beam_field, help="the run's +beam_field, rad"
    )
    parser.add_argument(
        "--timeout",
        type=float,
        default=Settings.timeout,
        help="s of real time to wait for a command",
    )
    parser.add_argument(
        "--keep",
        type=float,
        default=Settings.keep,
        help="s of simulated time for which a command holds",
    )
    parser.add_argument("--stamped", action="store_true", help="/cmd_vel is a TwistStamped")
    parser.add_argument(
        "--reset", action="append", default=[], metavar="SERVICE", help="std_srvs/Trigger to call"
    )
    return parser.parse_args()


def _grid(path: Path) -> Grid:
    try:
        return grid_of(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        sys.exit(f"--map {path}: {error}; use the .grid file that is run")


def _drive(given: argparse.Namespace, grid: Grid | None) -> None:
    """Serve the protocol on stdin and stdout until stdin ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # Anything else that prints, prints to stderr.
    os.dup2(2, 1)
    try:
        import rclpy  # noqa: PLC0415 - slow, and --help needs none
    except ModuleNotFoundError:
        sys.exit(
            "rclpy is not there; source ROS 2's setup.bash, and run this with the python3 that ROS "
            "uses"
        )

    from worldgen_ros2_bridge.node import RosPorts  # noqa: PLC0415 - likewise

    rclpy.init(args=[])
    node = rclpy.create_node("worldgen_bridge")
    try:
        ports = RosPorts(node, stamped=given.stamped, reset_services=tuple(given.reset))
        settings = Settings(given.beam_range, given.beam_field, given.timeout, given.keep)
        serve(Bridge(ports, grid, settings), sys.stdin, answers)
    except (RuntimeError, ValueError) as error:
        sys.exit(f"the bridge ends: {error}")
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def main() -> None:
    """Run the bridge with the options from the command line."""
    given = _arguments()
    _drive(given, _grid(given.map) if given.map else None)


if __name__ == "__main__":
    main()
