"""Verdicts: how a run ended, in one word."""

from __future__ import annotations

from enum import StrEnum


class Verdict(StrEnum):
    """How a run ended; equal to its word, as written in files and JSON.

    Tables use this order: success first, then failures from mild to grave.
    """

    REACHED = "reached"
    COVERED = "covered"
    LOOP = "loop"
    LIVELOCK = "livelock"
    DEADLOCK = "deadlock"
    STARVED = "starved"
    STALLED = "stalled"
    TIMEOUT = "timeout"
    TUNNEL = "tunnel"
    OVERLAP = "overlap"
    COLLISION = "collision"
    CONTACT = "contact"
    BURNED = "burned"
    CRASH = "crash"
    HANG = "hang"
    INVALID_COMMAND = "invalid-command"


ARRIVALS = (Verdict.REACHED, Verdict.COVERED)
"""Verdicts on a robot that completed its task."""

FAILURES = tuple(verdict for verdict in Verdict if verdict not in ARRIVALS)
"""Verdicts on a robot that did not complete its task."""

JOINT_LOOPS = (Verdict.LIVELOCK, Verdict.DEADLOCK, Verdict.STARVED)
"""Verdicts on several robots whose joint state provably recurs."""

NEVER = (Verdict.LOOP, *JOINT_LOOPS)
"""Verdicts that prove that a robot never arrives, however long it drives."""

STUCK = (*NEVER, Verdict.STALLED)
"""Verdicts on robots that get nowhere new, proved or not."""

OUT_OF_BUDGET = (Verdict.STALLED, Verdict.TIMEOUT)
"""Verdicts on a run that ended because its budget was spent."""

UNENDED = (*NEVER, *OUT_OF_BUDGET)
"""Verdicts on a run that ended only because of its budget, or because it provably repeats."""

BY_THE_CONTROLLER = (Verdict.CRASH, Verdict.HANG, Verdict.INVALID_COMMAND)
"""Verdicts on a fault of the controller itself, wherever the robot was."""

AT_ONCE = (Verdict.TUNNEL, Verdict.COLLISION, Verdict.CONTACT, Verdict.BURNED, *BY_THE_CONTROLLER)
"""Verdicts on an event that ends a run in the step in which it happens."""


def without_arrival(verdict: str) -> str:
    """Return how to put that a run with this verdict did not arrive.

    Every text that could promise something about the future takes its words from here: ``never`` is
    for verdicts that prove it.
    """
    return "never" if verdict in NEVER else "no arrival"


MEANINGS = {
    Verdict.REACHED: "The robot arrives.",
    Verdict.COVERED: "The robot has visited every cell of its coverage task.",
    Verdict.LOOP: "The robot returns to a complete state that it was in before, so it repeats "
    "itself endlessly and never arrives, although its target can be reached.",
    Verdict.LIVELOCK: (
        "The robots return to a joint state that they were in before and some of them move in "
        "between, so they repeat themselves endlessly and two or more never arrive."
    ),
    Verdict.DEADLOCK: (
        "The robots return to a joint state that they were in before and none of them moves in "
        "between, so they stand still forever and two or more never arrive."
    ),
    Verdict.STARVED: (
        "All robots but one arrive, and the joint state recurs, so the last robot never arrives."
    ),
    Verdict.STALLED: (
        "The robot enters no new cell in the second half of its budget, which is many times longer "
        "than the path to its target takes."
    ),
    Verdict.TIMEOUT: (
        "The robot has not arrived within its budget, which is many times longer than the path to "
        "its target takes."
    ),
    Verdict.TUNNEL: "The robot's centre passes through a wall.",
    Verdict.OVERLAP: "The robot's disc cuts into a wall by more than the motion model's tolerance.",
    Verdict.COLLISION: "Two robots drive through each other.",
    Verdict.CONTACT: "The robot touches a wall, which its goal forbids.",
    Verdict.BURNED: "Fire or falling debris catches the robot.",
    Verdict.CRASH: "The controller raises an exception, or its program ends.",
    Verdict.HANG: "The controller gives no answer in time.",
    Verdict.INVALID_COMMAND: "The controller commands what no robot can do.",
}
"""One sentence on each verdict, for readers who do not know the word."""
