"""The causes that failures are sorted into: what a robot does wrong, in one sentence each.

A bucket describes what a failure looks like; hundreds of buckets can have one reason. A cause is
that reason, as far as the run reveals it: the decision that repeats, or the move that ended the
run. It is never a place in a world.
"""

from __future__ import annotations

from collections.abc import Collection
from enum import IntEnum, StrEnum

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

    # Through walls.
    STEPS_OVER_A_WALL = "steps-over-a-wall"
    CUTS_A_CORNER = "cuts-a-corner"
    SLIDES_INTO_A_WALL = "slides-into-a-wall"

    # Through another robot.
    COLLIDES = "collides"

    # Errors of the controller itself.
    CRASHES = "crashes"
    GIVES_NO_ANSWER = "gives-no-answer"
    INVALID_COMMAND = "invalid-command"

    # Hazards.
    DRIVES_INTO_A_HAZARD = "drives-into-a-hazard"
    CAUGHT_BY_A_CHANGE = "caught-by-a-change"

    # The robot does not arrive.
    CONFUSED_BY_CHANGES = "confused-by-changes"
    NEEDS_A_WIDER_GAP = "needs-a-wider-gap"
    STANDS_STILL = "stands-still"
    PUSHES_A_WALL = "pushes-a-wall"
    TURNS_BACK_AND_FORTH = "turns-back-and-forth"
    MISSES_THE_TARGET = "misses-the-target"
    CIRCLES_A_WALL = "circles-a-wall"
    RETURNS_TO_THE_WALL = "returns-to-the-wall"
    LEAVES_WALLS_WRONGLY = "leaves-walls-wrongly"
    BOUNCES_BETWEEN_WALLS = "bounces-between-walls"
    TRAPPED_BEHIND_A_WALL = "trapped-behind-a-wall"
    DRIVES_IN_CIRCLES = "drives-in-circles"
    WANDERS = "wanders"

    # Several robots do not arrive.
    FACE_TO_FACE = "face-to-face"
    WAITS_IN_A_CIRCLE = "waits-in-a-circle"
    BLOCKED_BY_PARKED = "blocked-by-a-parked-robot"
    WAITS_IN_A_QUEUE = "waits-in-a-queue"
    GIVES_WAY_FOREVER = "gives-way-forever"
    WAITS_FOR_OTHERS = "waits-for-others"

    # Not the controller's fault, or not a known reason.
    BREAKS_A_RULE = "breaks-a-rule"
    HARMED_UNSENSED = "harmed-by-what-it-cannot-sense"
    PUSHED_TOO_HARD = "pushed-too-hard"
    UNKNOWN = "unknown"

    @property
    def parts(self) -> tuple[Cause, ...]:
        """The causes that it joins; for most causes, only itself."""
        return _PARTS.get(self, (self,))

    @property
    def sentence(self) -> str:
        """What the robot does wrong: one sentence."""
        return _SENTENCES[self].format(It="It", Its="Its")

    def sentence_in(self, world: World) -> str:
        """Return the sentence for a world; of several robots, it is about one of them."""
        if not world.others:
            return self.sentence
        return _SENTENCES[self].format(It="A robot", Its="A robot's")

    @property
    def is_vague(self) -> bool:
        """True if the run's description, such as an error's message, says more than the sentence."""
        return self == Cause.UNKNOWN or self.severity == Severity.CONTROLLER_ERROR

    @property
    def phrase(self) -> str:
        """What the robot does, to follow its name: the severity's sentence, unless too general."""
        return _OWN_PHRASES.get(self, self.severity.phrase)

    @property
    def advice(self) -> str:
        """The place to look at in the controller: one sentence."""
        return _ADVICE[self]

    @property
    def severity(self) -> Severity:
        """Its severity."""
        return _SEVERITIES.get(self, Severity.NEVER_ARRIVES)


# One condition in the controller decides both. Which of the two happens depends on the world, so a
# controller that shows both has one fault.
_PARTS = {Cause.LEAVES_WALLS_WRONGLY: (Cause.CIRCLES_A_WALL, Cause.RETURNS_TO_THE_WALL)}

# The subject is the robot, or one of several.
_SENTENCES = {
    Cause.STEPS_OVER_A_WALL: "{It} drives so far in one step that it passes a wall, or the corner of "
    "one, without noticing.",
    Cause.CUTS_A_CORNER: "{Its} edge cuts the corner of a wall as it passes.",
    Cause.SLIDES_INTO_A_WALL: "{It} slides along a wall, or backs off from one, into another wall.",
    Cause.COLLIDES: (
        "{It} drives into another robot in the middle of a step, which its motion model does not "
        "check."
    ),
    Cause.CRASHES: "{Its} code raises an error.",
    Cause.GIVES_NO_ANSWER: "{Its} code does not answer in time.",
    Cause.INVALID_COMMAND: "{It} sends a command that is not a valid speed and turn rate.",
    Cause.DRIVES_INTO_A_HAZARD: "{It} drives into a cell that is already burning or solid.",
    Cause.CAUGHT_BY_A_CHANGE: "{It} is in a cell when the cell catches fire or becomes solid.",
    Cause.CONFUSED_BY_CHANGES: (
        "{It} fails because cells change while it drives: it arrives if they have "
        "all changed before it starts."
    ),
    Cause.NEEDS_A_WIDER_GAP: (
        "{It} does not drive through a gap, or up to a wall, although it would fit; a smaller robot "
        "arrives."
    ),
    Cause.STANDS_STILL: "{It} stops in the open and does not move again.",
    Cause.PUSHES_A_WALL: "{It} keeps driving into a wall and does not get away from it.",
    Cause.TURNS_BACK_AND_FORTH: "{It} turns back and forth, or in circles, instead of moving on.",
    Cause.MISSES_THE_TARGET: (
        "{It} gets close to the target on a clear path, but passes it again and again."
    ),
    Cause.CIRCLES_A_WALL: "{It} follows a wall all the way around and does not leave it.",
    Cause.RETURNS_TO_THE_WALL: "{It} leaves a wall too early and comes back to the same wall.",
    Cause.LEAVES_WALLS_WRONGLY: (
        "{It} leaves some walls too early and comes back, and does not leave others."
    ),
    Cause.BOUNCES_BETWEEN_WALLS: "{It} bounces from wall to wall on a path that repeats.",
    Cause.TRAPPED_BEHIND_A_WALL: (
        "{It} stays where it is nearest to the target, although a wall is in between."
    ),
    Cause.DRIVES_IN_CIRCLES: "{It} drives the same closed path again and again, far from any wall.",
    Cause.WANDERS: "{It} still reaches new places when its time is up.",
    Cause.FACE_TO_FACE: "Two robots drive into each other, and neither gives way.",
    Cause.WAITS_IN_A_CIRCLE: "Three or more robots wait for each other in a circle.",
    Cause.BLOCKED_BY_PARKED: "A robot that has arrived is in another robot's way.",
    Cause.WAITS_IN_A_QUEUE: "A robot waits behind another one that does not arrive.",
    Cause.GIVES_WAY_FOREVER: "Robots avoid each other again and again and get nowhere.",
    Cause.WAITS_FOR_OTHERS: (
        "Robots stop because of each other, although each of them would arrive alone."
    ),
    Cause.BREAKS_A_RULE: "{It} breaks a rule that you asked about with --oracle.",
    Cause.HARMED_UNSENSED: (
        "{It} is caught by fire, debris or a moved wall that it neither senses nor has read about."
    ),
    Cause.PUSHED_TOO_HARD: "{It} is moved farther than any controller can be certain to correct.",
    Cause.UNKNOWN: (
        "{It} fails; the reason is unknown, because its controller could not be run here, or not in "
        "time."
    ),
}

_OWN_PHRASES = {
    Cause.CRASHES: "its controller crashes",
    Cause.GIVES_NO_ANSWER: "its controller does not answer",
    Cause.INVALID_COMMAND: "its controller sends invalid commands",
}

_ADVICE = {
    Cause.STEPS_OVER_A_WALL: "Slow down near walls, or make the time step smaller: a step must be "
    "shorter than the thinnest wall.",
    Cause.CUTS_A_CORNER: "Keep the radius of the robot away from corners, not only its centre.",
    Cause.SLIDES_INTO_A_WALL: "This is a fault of the motion model stepped; compare with --motion "
    "swept.",
    Cause.COLLIDES: "Make the time step smaller, or keep more distance.",
    Cause.CRASHES: "Fix the error that it names; the world reproduces it.",
    Cause.GIVES_NO_ANSWER: "Look for an endless loop or a slow step, or give it more time.",
    Cause.INVALID_COMMAND: "Look for a division by zero or a root of a negative number in the "
    "computation of the command.",
    Cause.DRIVES_INTO_A_HAZARD: "Check its reaction to walls sensed ahead.",
    Cause.CAUGHT_BY_A_CHANGE: (
        "Check how soon it leaves cells that it can sense are about to close."
    ),
    Cause.CONFUSED_BY_CHANGES: (
        "Check what it remembers about walls: they may have changed since it saw them."
    ),
    Cause.NEEDS_A_WIDER_GAP: (
        "Check how much clearance it requires at walls and in turns: its radius must be enough."
    ),
    Cause.STANDS_STILL: "Look for a condition under which no command is sent, or speed is 0.",
    Cause.PUSHES_A_WALL: (
        "Check what it does after a bump: does it turn away, and what makes it turn back?"
    ),
    Cause.TURNS_BACK_AND_FORTH: (
        "Look for two decisions that undo each other, and for an angle that is not wrapped to half "
        "a turn."
    ),
    Cause.MISSES_THE_TARGET: "Check how it slows down and aims close to the target.",
    Cause.CIRCLES_A_WALL: "Check the condition under which it leaves a wall: it does not hold here.",
    Cause.RETURNS_TO_THE_WALL: (
        "Check what makes it leave a wall: it must get closer to the target each time, or remember "
        "the wall."
    ),
    Cause.LEAVES_WALLS_WRONGLY: (
        "Check the condition under which it leaves a wall: one condition explains both."
    ),
    Cause.BOUNCES_BETWEEN_WALLS: (
        "A robot that turns by the same rule at each wall repeats itself: add memory, chance or "
        "wall following, or check why what it has does not help."
    ),
    Cause.TRAPPED_BEHIND_A_WALL: (
        "It needs a way out of places where every direct move leads away from the target: follow "
        "the wall, or plan."
    ),
    Cause.DRIVES_IN_CIRCLES: "Look for a state that it enters again and again without getting "
    "closer.",
    Cause.WANDERS: "Give it more time, or check whether it makes progress.",
    Cause.FACE_TO_FACE: "Break the symmetry: give one robot priority, or make both keep to the "
    "same side.",
    Cause.WAITS_IN_A_CIRCLE: (
        "Let the robot that has waited longest go first, and make the others yield."
    ),
    Cause.BLOCKED_BY_PARKED: "Drive around a robot that has stopped, or let it move aside.",
    Cause.WAITS_IN_A_QUEUE: "Look at the robot in front: it is the one that fails.",
    Cause.GIVES_WAY_FOREVER: "Decide who goes first by a fixed property, not by behaviour that "
    "both share.",
    Cause.WAITS_FOR_OTHERS: "Decide who goes first, and let the others make room for it.",
    Cause.BREAKS_A_RULE: "The violation names the rule, and by how much it is broken.",
    Cause.HARMED_UNSENSED: "Give it a sensor that detects the hazard, or exclude such worlds.",
    Cause.PUSHED_TOO_HARD: "Compare with a run without pushes, tilts and decoys.",
    Cause.UNKNOWN: "Replay it on a machine that has its controller.",
}

_SEVERITIES = {
    Cause.STEPS_OVER_A_WALL: Severity.THROUGH_WALLS,
    Cause.CUTS_A_CORNER: Severity.THROUGH_WALLS,
    Cause.SLIDES_INTO_A_WALL: Severity.THROUGH_WALLS,
    Cause.COLLIDES: Severity.THROUGH_ROBOTS,
    Cause.CRASHES: Severity.CONTROLLER_ERROR,
    Cause.GIVES_NO_ANSWER: Severity.CONTROLLER_ERROR,
    Cause.INVALID_COMMAND: Severity.CONTROLLER_ERROR,
    Cause.DRIVES_INTO_A_HAZARD: Severity.HARMED,
    Cause.CAUGHT_BY_A_CHANGE: Severity.HARMED,
    Cause.WANDERS: Severity.TOO_SLOW,
    Cause.BREAKS_A_RULE: Severity.QUESTIONABLE,
    Cause.HARMED_UNSENSED: Severity.UNSENSED,
    Cause.PUSHED_TOO_HARD: Severity.UNSENSED,
}


def joined(found: Collection[Cause]) -> dict[Cause, Cause]:
    """Return the cause under which to show each cause that one controller has.

    Args:
        found: All causes of its failures.
    """
    shown = {cause: cause for cause in found}
    for whole, parts in _PARTS.items():
        if all(part in shown for part in parts):
            shown |= dict.fromkeys(parts, whole)
    return shown
