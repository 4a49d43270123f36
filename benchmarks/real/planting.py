"""The twelve controllers, the line that makes each faulty, and files to give to a command."""

from __future__ import annotations

import functools
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from sim import CONTROLLERS, Command, Observation, simulate
from sim.controllers.base import Memory
from worldgen import generate

FOLDER = Path(__file__).parent / "controllers"
# Length of the sum whose time is measured, about a millisecond.
_NUMBERS = 50_000


@dataclass(frozen=True)
class Robot:
    """A controller, and the one line that makes it faulty.

    Args:
        file: Name of its file in ``controllers/``, without ``.py``.
        kind: Name of its class.
        line: A line of the file, without its indent.
        planted: The same line, faulty.
        fault: What is wrong, and why the robot then fails.
        words: A screen that has one of these, or the planted line, names the cause.
        arrives: Share of small worlds in which it arrives without the fault, within 8 times the
            witness's time. A bug algorithm may turn the wrong way at first.
        name: Its name, if several faults share a file.
    """

    file: str
    kind: str
    line: str
    planted: str
    fault: str
    words: tuple[str, ...]
    arrives: float = 1.0
    name: str = ""

    def text(self, faulty: bool) -> str:
        """Return the source.

        Raises:
            ValueError: If the line is not there exactly once.
        """
        text = (FOLDER / f"{self.file}.py").read_text(encoding="utf-8")
        if text.count(self.line) != 1:
            raise ValueError(
                f"{self.file}.py has {self.line!r} {text.count(self.line)} times, not once"
            )
        return text.replace(self.line, self.planted) if faulty else text


ROBOTS = {
    robot.file: robot
    for robot in (
        Robot(
            file="dwa",
            kind="Dwa",
            line="if abs(bearing) > 2.0 or not admissible.any():",
            planted="if abs(bearing) > 2.0:",
            fault=(
                "It has no fallback if no velocity is admissible, so it takes the first of the "
                "window: slowly, turning hard to the right. In a tight place it circles on the "
                "spot."
            ),
            words=("circle", "turns on the spot", "turns in place", "spins"),
        ),
        Robot(
            file="vfh",
            kind="Vfh",
            line="reach = 1.6  # radii within which an obstacle blocks sectors",
            planted="reach = 3.2  # radii within which an obstacle blocks sectors",
            fault=(
                "Obstacles twice as far away block sectors, so in a narrow place most "
                "directions are closed, and it turns back from a gap that it could pass."
            ),
            words=("circle", "back and forth", "to and fro", "turns away"),
        ),
        Robot(
            file="pursuit",
            kind="Pursuit",
            line="speed = min(seen.top_speed, self.turn_rate / max(abs(curvature), 1e-6))",
            planted="speed = seen.top_speed",
            fault=(
                "It does not slow down on a tight arc, and its turn rate is limited, so it "
                "orbits a point that is closer than its turning circle."
            ),
            words=("orbit", "circle"),
        ),
        Robot(
            file="hybrid",
            kind="Hybrid",
            line="walls = self.seen_at > 0",
            planted="walls = self.seen_at > self.now - 20",
            fault=(
                "It forgets walls that it has not seen for 20 steps, so it plans through a dead "
                "end that it has already left, and goes back and forth."
            ),
            words=("back and forth", "alternates between", "turns back"),
        ),
        Robot(
            file="tree",
            kind="Tree",
            line="self.tries += 1",
            planted="self.tries = self.tries % 2 + 1",
            fault=(
                "Two of the three recoveries alternate, and the one that lowers the distance "
                "from walls never runs. Where only a tight gap leads on, it turns and backs up "
                "endlessly."
            ),
            words=("alternat", "turns and backs", "backs up", "to and fro", "back and forth"),
        ),
        Robot(
            file="mppi",
            kind="Mppi",
            line="goal = self.path[min(self.k + 4, len(self.path) - 1)]",
            planted="goal = self.path[min(self.k + 12, len(self.path) - 1)]",
            fault=(
                "It aims at a place too far along the path, which may be behind a wall, and its "
                "few samples do not lead around that wall: it pushes against it."
            ),
            words=("against a wall", "against the wall", "pushes", "stuck", "behind a wall"),
        ),
        Robot(
            file="pid",
            kind="Pid",
            line="limit = 0.005  # rad s, of the integral",
            planted="limit = 5.0  # rad s, of the integral",
            fault=(
                "The integral winds up while the robot turns, and keeps it turning after it "
                "faces the goal."
            ),
            words=("circle", "orbit", "overshoot", "grows", "turns on the spot", "spins"),
        ),
        Robot(
            file="smoother",
            kind="Smoother",
            line="return max(speed, self.dead_band)",
            planted="return speed if speed >= self.dead_band else 0.0",
            fault=(
                "Speeds in the dead band become zero. Where it is tight, it asks for less than "
                "the dead band and stands still."
            ),
            words=("stands still", "does not move", "stops", "motionless", "freezes"),
        ),
        Robot(
            file="wall_follower",
            kind="WallFollower",
            line="wall -= 0.5",
            planted="wall -= 0.03",
            fault=(
                "It turns too little at an outer corner, so it loses the wall, and meets "
                "another one or the same one again."
            ),
            words=("loses the wall", "outer corner", "leaves a wall and comes back", "circle"),
            arrives=0.85,
        ),
        Robot(
            file="frontier",
            kind="Frontier",
            line="return math.dist(here, place) + math.dist(place, self.target)",
            planted="return math.dist(place, self.target) - math.dist(here, place)",
            fault=(
                "The way to a frontier counts as a gain, not as a cost, so it turns to another "
                "one, farther away, before it has reached any: it goes back and forth between "
                "them."
            ),
            words=("back and forth", "alternates between", "to and fro"),
        ),
        Robot(
            file="tangent",
            kind="Tangent",
            line="shortest = min(shortest, seen.target_distance)",
            planted="shortest = seen.target_distance",
            fault=(
                "It forgets the shortest distance to the target on the wall that it follows, so "
                "it leaves the wall too early and comes back to it."
            ),
            words=("comes back", "leaves the wall", "back and forth", "same wall"),
            arrives=0.95,
        ),
        Robot(
            file="potential",
            kind="Potential",
            line="noise = 1.2  # rad",
            planted="noise = math.radians(1.2)",
            fault=(
                "The noise is converted to radians twice, so it is too weak to leave a local "
                "minimum."
            ),
            words=(
                "local minimum",
                "stands still",
                "trembles",
                "stuck",
                "to and fro",
                "back and forth",
            ),
        ),
    )
}
"""The robots by the names of their files."""


def _needs_a_history(name: str, line: str, planted: str, fault: str, *words: str) -> Robot:
    return Robot("histories", "Histories", line, planted, fault, words, arrives=0.85, name=name)


DEEP = {
    robot.name: robot
    for robot in (
        _needs_a_history(
            "long_wall",
            "effort = 1.0",
            "effort = 1.0 if steps < 2_000 else 0.0",
            "It stops after 2,000 steps along one wall.",
            *("stands still", "stops", "turns on the spot"),
        ),
        _needs_a_history(
            "windings",
            "speed = seen.top_speed",
            "speed = seen.top_speed if abs(turned) < 3 * math.tau else 0.0",
            "It stops once it has turned three times around on one wall.",
            *("stands still", "stops", "turns on the spot"),
        ),
        _needs_a_history(
            "counter",
            "return gained and walls > 0",
            "return gained and walls < 25",
            "It never leaves the 25th wall that it meets, and goes around it.",
            *("around", "circles", "same wall"),
        ),
        _needs_a_history(
            "recovery",
            "room = seen.beams[0] / seen.radius",
            "room = seen.beam[0] / seen.radius",
            "A branch for a robot that gets no closer for 1,500 steps has a wrong name in it.",
            *("attributeerror", "beam"),
        ),
    )
}
"""Faults that show only after a long history, by their own names."""

PURPOSES = {
    "n": "natural worlds",
    "e": "explaining",
    "k": "shrinking",
    "s": "screening",
    "p": "proving",
    "t": "trying out",
}
"""Why a campaign calls ``act``, by the letter that each call writes."""

# Finds the purpose of a call in the modules that led to it, so the controller keeps no state for it.
_COUNTING = """
import os
import sys

CALLS = os.open({calls!r}, os.O_WRONLY | os.O_CREAT | os.O_APPEND)


def purpose():
    names = set()
    frame = sys._getframe(2)
    while frame is not None:
        names.add(frame.f_globals.get("__name__", ""))
        frame = frame.f_back
    path = " ".join(names)
    if "fuzz.overview.natural" in path:
        return b"n"
    if "fuzz.overview" in path:
        return b"e"
    if "fuzz.shrink" in path:
        return b"k"
    if "fuzz.campaign.unit" not in path:
        return b"t"
    return b"p" if "fuzz.triage" in path or "fuzz.oracles" in path else b"s"
"""
_ACT = "    def act(self, seen, memory):\n"


def write(
    robot: Robot, folder: Path, *, faulty: bool, pace: float = 0.0, calls: Path | None = None
) -> str:
    """Write a robot's file, and the one that it imports, into a folder.

    Args:
        robot: The robot.
        folder: Where to write.
        faulty: True to plant its fault.
        pace: CPU time of each ``act``, ms, if it takes less by itself. A sum of the right length
            pads it: a controller that read a clock would be another controller.
        calls: A file that gets a letter of ``PURPOSES`` for each call of ``act``; state of the
            controller's own would change its verdicts.

    Returns:
        The controller's name for ``--controller``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(FOLDER / "routes.py", folder)
    file = folder / f"{robot.file}.py"
    text = robot.text(faulty)
    begin, body = text.split(_ACT)
    if pace:
        missing = max(0.0, 1e-3 * pace - _seconds_of_act(robot))
        body = f"        sum(range({round(missing / _seconds_of_a_number())}))\n{body}"
    if calls is not None:
        body = f"        os.write(CALLS, purpose())\n{body}\n{_COUNTING.format(calls=str(calls))}"
    file.write_text(begin + _ACT + body, encoding="utf-8")
    return f"{file}:{robot.kind}"


@functools.cache
def _seconds_of_a_number() -> float:
    """Return the CPU time that a sum takes for each of its numbers, in the least of some tries."""
    return min(_cpu_seconds(lambda: sum(range(_NUMBERS))) for _ in range(20)) / _NUMBERS


@functools.cache
def _seconds_of_act(robot: Robot) -> float:
    """Return the mean CPU time of a call of ``act`` in a few rooms, without the fault."""
    spent = []
    controller = CONTROLLERS.get(f"{FOLDER / robot.file}.py:{robot.kind}")

    class Timed(type(controller)):  # type: ignore[misc]
        def act(self, seen: Observation, memory: Memory) -> tuple[Command, Memory]:
            begin = time.process_time()
            answer = super().act(seen, memory)
            spent.append(time.process_time() - begin)
            return answer

    for seed in range(3):
        simulate(generate("rooms", seed, size=16), Timed())
    return sum(spent) / len(spent)


def _cpu_seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin
