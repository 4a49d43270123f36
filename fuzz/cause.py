"""The causes that failures are sorted into: what a robot does wrong, in one sentence each.

A cause names the motion that repeats, or the move that ended the run; it is never a place in a
world. Its circumstance, if one is known, tells where or how that happens: it completes the sentence
and decides where to look in the controller.
"""

from __future__ import annotations

from enum import IntEnum, StrEnum
from typing import NamedTuple

from worldgen.render.body_parts import tight_words
from worldgen.world import World


class Severity(IntEnum):
    """How bad a cause is; the worst comes first."""

    THROUGH_WALLS = 0
    THROUGH_ROBOTS = 1
    CONTROLLER_ERROR = 2
    HARMED = 3
    NEVER_ARRIVES = 4
    TOO_SLOW = 5
    QUESTIONABLE = 6
    UNSENSED = 7

    @property
    def word(self) -> str:
        """The name in JSON: ``through-walls``."""
        return self.name.lower().replace("_", "-")

    @property
    def phrase(self) -> str:
        """What the robot does, for a sentence such as ``it loops or stalls in 12 worlds``."""
        return _PHRASES[self]


_PHRASES = {
    Severity.THROUGH_WALLS: "goes through walls",
    Severity.THROUGH_ROBOTS: "drives through another robot",
    Severity.CONTROLLER_ERROR: "its controller fails",
    Severity.HARMED: "runs into a hazard that it can sense",
    Severity.NEVER_ARRIVES: "does not arrive",
    Severity.TOO_SLOW: "runs out of time",
    Severity.QUESTIONABLE: "breaks a rule that you set",
    Severity.UNSENSED: "is harmed by something that it cannot sense",
}


class Cause(StrEnum):
    """Why a robot fails.

    Equal to its name in JSON and on the command line. ``docs/reference/verdicts.md`` describes how
    each is recognised in the run.
    """

    GOES_THROUGH_A_WALL = "goes-through-a-wall"
    COLLIDES = "collides"

    # Errors of the controller itself.
    CRASHES = "crashes"
    GIVES_NO_ANSWER = "gives-no-answer"
    INVALID_COMMAND = "invalid-command"

    # Hazards, and walls that may not be touched.
    TOUCHES_A_WALL = "touches-a-wall"
    DRIVES_INTO_A_HAZARD = "drives-into-a-hazard"
    CAUGHT_BY_A_CHANGE = "caught-by-a-change"

    # The robot is at its target, but does not arrive as its goal asks.
    PASSES_ITS_GOAL = "passes-its-goal"
    NEVER_SETTLES = "never-settles"

    # The robot does not arrive: what it repeats.
    STANDS_STILL = "stands-still"
    PUSHES_A_WALL = "pushes-a-wall"
    TURNS_ON_THE_SPOT = "turns-on-the-spot"
    GOES_BACK_AND_FORTH = "goes-back-and-forth"
    CIRCLES_AN_OBSTACLE = "circles-an-obstacle"
    RETURNS_TO_A_WALL = "returns-to-a-wall"
    DRIVES_IN_CIRCLES = "drives-in-circles"
    WANDERS = "wanders"
    HELD_UP_BY_ROBOTS = "held-up-by-robots"

    # Not the controller's fault, or not a known reason.
    BREAKS_A_RULE = "breaks-a-rule"
    HARMED_UNSENSED = "harmed-by-what-it-cannot-sense"
    PUSHED_TOO_HARD = "pushed-too-hard"
    UNKNOWN = "unknown"

    @property
    def sentence(self) -> str:
        """What the robot does wrong: one sentence."""
        return Diagnosis(self).sentence()

    @property
    def advice(self) -> str:
        """The place to look at in the controller: one sentence."""
        return _TEXTS[self].advice

    @property
    def severity(self) -> Severity:
        """Its severity."""
        return _TEXTS[self].severity

    @property
    def phrase(self) -> str:
        """What the robot does, to follow its name: the severity's sentence, unless too general."""
        return _TEXTS[self].phrase or self.severity.phrase

    @property
    def has_reasons(self) -> bool:
        """True if failures of this cause have different reasons, such as an error at one line."""
        return self.is_vague or self == Cause.BREAKS_A_RULE

    @property
    def is_vague(self) -> bool:
        """True if the run's description, such as an error's message, says more than the sentence."""
        return self == Cause.UNKNOWN or self.severity == Severity.CONTROLLER_ERROR


CAUSE = "cause"
"""Name of the detail of a failure's record that holds its cause."""

CIRCUMSTANCE = "circumstance"
"""Name of the detail that holds its circumstance, if one is known."""

GAP = "gap"
"""Name of the detail that holds the width of the gap in front of it, in radii of the robot."""


class Circumstance(StrEnum):
    """Where or how a robot does what its cause names; the record of a failure has its name."""

    # How its controller crashes. The evidence says so, and no record repeats it.
    KILLED = "killed"
    EXITS = "exits"

    # How it goes through a wall.
    LONG_STEP = "long-step"
    CORNER = "corner"
    SLIDING = "sliding"

    # Where it repeats its motion.
    AMONG_CHANGES = "among-changes"
    AT_A_GAP = "at-a-gap"
    AT_THE_TARGET = "at-the-target"
    BEHIND_A_WALL = "behind-a-wall"

    # What it does at walls between two touches.
    FOLLOWS_NO_WALL = "follows-no-wall"

    # How several robots hold each other up.
    FACE_TO_FACE = "face-to-face"
    CIRCULAR_WAIT = "circular-wait"
    PARKED_ROBOT = "parked-robot"
    QUEUE = "queue"
    GIVING_WAY = "giving-way"


class Diagnosis(NamedTuple):
    """A cause with its circumstance.

    Args:
        cause: The cause.
        circumstance: Where or how it happens; ``None`` if nothing more is known.
        gap: For :attr:`Circumstance.AT_A_GAP`, the width of the gap in radii of the robot; 0 if
            the robot need not drive through it, and otherwise.
    """

    cause: Cause
    circumstance: Circumstance | None = None
    gap: float = 0.0

    def sentence(self, world: World | None = None) -> str:
        """Return what the robot does wrong, in one sentence or two.

        Args:
            world: The world; of several robots, the sentence is about one of them.
        """
        several = world is not None and world.is_fleet
        text = _TEXTS[self.cause].sentence
        more = _CIRCUMSTANCES[self.circumstance] if self.circumstance else _Additions()
        if more.sentence:
            text = more.sentence
        gap = f" of {self.gap:.2g} radii" if self.gap else ""
        if self.circumstance == Circumstance.AT_A_GAP and world is not None:
            # Radii say nothing of a body that is not a disc.
            tight = tight_words(world)
            gap = f" ({tight})" if tight else gap
        return text.format(
            It="A robot" if several else "It",
            Its="A robot's" if several else "Its",
            where=more.where.format(gap=gap),
        )

    @property
    def advice(self) -> str:
        """The place to look at in the controller: one sentence."""
        more = _CIRCUMSTANCES[self.circumstance] if self.circumstance else _Additions()
        return more.advice or self.cause.advice


class _Texts(NamedTuple):
    """The texts of a cause; the sentence's subject is the robot, or one of several."""

    sentence: str
    advice: str
    severity: Severity = Severity.NEVER_ARRIVES
    phrase: str = ""


_TEXTS = {
    Cause.GOES_THROUGH_A_WALL: _Texts(
        "{It} goes through a wall.",
        "Slow down near walls, or make the time step smaller.",
        Severity.THROUGH_WALLS,
    ),
    Cause.COLLIDES: _Texts(
        "{It} drives into another robot in the middle of a step, which its motion model does not "
        "check.",
        "Make the time step smaller, or keep more distance.",
        Severity.THROUGH_ROBOTS,
    ),
    Cause.CRASHES: _Texts(
        "{Its} code raises an error.",
        "Fix the error that it names; the world reproduces it.",
        Severity.CONTROLLER_ERROR,
        "its controller crashes",
    ),
    Cause.GIVES_NO_ANSWER: _Texts(
        "{Its} code does not answer in time.",
        "Look for an endless loop or a slow step, or give it more time.",
        Severity.CONTROLLER_ERROR,
        "its controller does not answer",
    ),
    Cause.INVALID_COMMAND: _Texts(
        "{It} sends a command that is not a valid speed and turn rate.",
        "Look in the computation of the command for a division by zero, a root of a negative number, "
        "or a sense that it reads but does not declare, which is not a number.",
        Severity.CONTROLLER_ERROR,
        "its controller sends invalid commands",
    ),
    Cause.TOUCHES_A_WALL: _Texts(
        "{It} touches a wall, which its goal forbids.",
        "Keep the radius of the robot, and the length of a step, away from walls.",
        Severity.HARMED,
        "touches walls",
    ),
    Cause.DRIVES_INTO_A_HAZARD: _Texts(
        "{It} drives into a cell that is already burning or solid.",
        "Check its reaction to walls sensed ahead.",
        Severity.HARMED,
    ),
    Cause.CAUGHT_BY_A_CHANGE: _Texts(
        "{It} is in a cell when the cell catches fire or becomes solid.",
        "Check how soon it leaves cells that it can sense are about to close.",
        Severity.HARMED,
    ),
    Cause.PASSES_ITS_GOAL: _Texts(
        "{It} drives through its target between the ends of two steps, and never ends a step in it.",
        "Slow down near the target, or make the time step smaller: a step must be shorter than the "
        "target is wide.",
    ),
    Cause.NEVER_SETTLES: _Texts(
        "{It} gets to its target, but does not settle there with the heading, or as still, as its goal asks.",
        "Check what it does last: a turn may move it out of the target again, and its own "
        "tolerances may be wider than the goal's.",
    ),
    Cause.STANDS_STILL: _Texts(
        "{It} stops for good{where}.",
        "Look for a condition under which no command is sent, or speed is 0.",
    ),
    Cause.PUSHES_A_WALL: _Texts(
        "{It} keeps driving into a wall{where}.",
        "Check what it does after a bump: does it turn away, and what makes it turn back?",
    ),
    Cause.TURNS_ON_THE_SPOT: _Texts(
        "{It} keeps turning at one place{where}.",
        "Look for two decisions that undo each other, and for an angle that is not wrapped to half "
        "a turn.",
    ),
    Cause.GOES_BACK_AND_FORTH: _Texts(
        "{It} goes back and forth{where}.",
        "Look for two decisions that undo each other: each should hold until it has led somewhere.",
    ),
    Cause.CIRCLES_AN_OBSTACLE: _Texts(
        "{It} goes all the way around an obstacle, again and again{where}.",
        "Check the condition under which it leaves a wall: it does not hold here.",
    ),
    Cause.RETURNS_TO_A_WALL: _Texts(
        "{It} leaves a wall and comes back to it, again and again{where}.",
        "Check what makes it leave a wall: it must get closer to the target each time, or remember "
        "the wall.",
    ),
    Cause.DRIVES_IN_CIRCLES: _Texts(
        "{It} drives the same closed path again and again{where}.",
        "Look for a state that it enters again and again without getting closer.",
    ),
    Cause.WANDERS: _Texts(
        "{It} still reaches new places when its time is up.",
        "Give it more time, or check whether it makes progress.",
        Severity.TOO_SLOW,
    ),
    Cause.HELD_UP_BY_ROBOTS: _Texts(
        "Robots stop because of each other, although each of them would arrive alone.",
        "Decide who goes first, and let the others make room for it.",
    ),
    Cause.BREAKS_A_RULE: _Texts(
        "{It} breaks a rule that you asked about with --oracle.",
        "The violation names the rule, and by how much it is broken.",
        Severity.QUESTIONABLE,
    ),
    Cause.HARMED_UNSENSED: _Texts(
        "{It} is caught by fire, debris or a moved wall that it neither senses nor has read about.",
        "Give it a sensor that detects the hazard, or exclude such worlds.",
        Severity.UNSENSED,
    ),
    Cause.PUSHED_TOO_HARD: _Texts(
        "{It} is moved farther than any controller can be certain to correct.",
        "Compare with a run without pushes, tilts and decoys.",
        Severity.UNSENSED,
    ),
    Cause.UNKNOWN: _Texts(
        "{It} fails; the reason is unknown, because its controller could not be run here, or not "
        "in time.",
        "Replay it on a machine that has its controller.",
    ),
}


class _Additions(NamedTuple):
    """The texts of a circumstance.

    Args:
        where: What it adds to the cause's sentence.
        advice: Advice in place of the cause's; empty if that fits.
        sentence: A sentence in place of the cause's; empty if that fits.
    """

    where: str = ""
    advice: str = ""
    sentence: str = ""


_CIRCUMSTANCES = {
    Circumstance.KILLED: _Additions(
        advice="A segmentation fault is an index out of range or a bad pointer, an abort a failed "
        "assertion or an exception that nothing catches: build it with -g, and run this world under "
        "a debugger.",
        sentence="{Its} code is killed by a signal.",
    ),
    Circumstance.EXITS: _Additions(
        advice="Fix the error that its last output names; the world reproduces it.",
        sentence="{Its} program exits in the middle of a run.",
    ),
    Circumstance.LONG_STEP: _Additions(
        advice="Slow down near walls, or make the time step smaller: a step must be shorter than "
        "the thinnest wall.",
        sentence="{It} drives so far in one step that it passes a wall, or the corner of one, "
        "without noticing.",
    ),
    Circumstance.CORNER: _Additions(
        advice="Keep the radius of the robot away from corners, not only its centre.",
        sentence="{Its} edge cuts the corner of a wall as it passes.",
    ),
    Circumstance.SLIDING: _Additions(
        advice="This is a fault of the motion model stepped; compare with --motion swept.",
        sentence="{It} slides along a wall, or backs off from one, into another wall.",
    ),
    Circumstance.AMONG_CHANGES: _Additions(
        where=" because cells change while it drives",
        advice="Check what it remembers about walls: they may have changed since it saw them. It "
        "arrives if they have all changed before it starts.",
    ),
    Circumstance.AT_A_GAP: _Additions(
        where=" in front of a gap{gap}",
        advice="Check how much clearance it requires at walls and in turns: its own size must be "
        "enough. A smaller robot arrives.",
    ),
    Circumstance.AT_THE_TARGET: _Additions(
        where=" next to the target with nothing in between",
        advice="Check how it slows down and aims close to the target.",
    ),
    Circumstance.BEHIND_A_WALL: _Additions(
        where=" where a wall is between it and the target",
        advice="It needs a way out of places where every direct move leads away from the target: "
        "follow the wall, or plan; if it does, check why that does not help here.",
    ),
    Circumstance.FOLLOWS_NO_WALL: _Additions(
        advice="A robot that turns by the same rule at each wall repeats itself: add memory, "
        "chance or wall following.",
        sentence="{It} drives from wall to wall on a path that repeats.",
    ),
    Circumstance.FACE_TO_FACE: _Additions(
        advice="Break the symmetry: give one robot priority, or make both keep to the same side.",
        sentence="Two robots drive into each other, and neither gives way.",
    ),
    Circumstance.CIRCULAR_WAIT: _Additions(
        advice="Let the robot that has waited longest go first, and make the others yield.",
        sentence="Three or more robots wait for each other in a circle.",
    ),
    Circumstance.PARKED_ROBOT: _Additions(
        advice="Drive around a robot that has stopped, or let it move aside.",
        sentence="A robot that has arrived is in another robot's way.",
    ),
    Circumstance.QUEUE: _Additions(
        advice="Look at the robot in front: it is the one that fails.",
        sentence="A robot waits behind another one that does not arrive.",
    ),
    Circumstance.GIVING_WAY: _Additions(
        advice="Decide who goes first by a fixed property, not by behaviour that both share.",
        sentence="Robots avoid each other again and again and get nowhere.",
    ),
}
