"""Results of a command, as plain text that is safe in terminals, browsers and parsers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

from fuzz.cause import Diagnosis
from fuzz.failure import Failure
from fuzz.overview.counterfactual import named_cells
from fuzz.overview.describe import run_to_draw
from fuzz.triage.diagnosis import diagnosis_of
from sim.clock.stopping import OutOfTime
from sim.drawing.picture import trails_of
from sim.episode.describe import describe_frames
from worldgen.errors import WorldgenError
from worldgen.files.grid.writer import world_digest
from worldgen.render import draw_terminal
from worldgen.render.overlay import Trail, naming
from worldgen.support.plain_text import counted, shown, shown_lines

if TYPE_CHECKING:
    from fuzz.overview.result import CauseResult


class FindingState(StrEnum):
    """How a command reports a failure.

    A campaign finds new failures, known ones, and hazards that the controller cannot sense; a
    replay confirms a failure or does not.
    """

    NEW = "new"
    KNOWN = "known"
    HAZARD = "hazard"
    CONFIRMED = "confirmed"
    NOT_CONFIRMED = "not confirmed"


_MOST_PICTURE = 20_000  # characters; larger worlds are better viewed from their file

# Texts that a controller or a file decides, and what makes each safe.
_SAFE = {
    "what": shown,
    "why": shown,
    "replay": shown,
    "frames": shown_lines,
    "picture": shown_lines,
}


@dataclass(frozen=True)
class CiFinding:
    """A failure, and what a report for CI says about it.

    Args:
        state: The command's description.
        failure: The failure, with the controller that ran.
        file: Its file.
        replay: The command that replays it.
        what: What happened, as a sentence without a full stop.
        diagnosis: Why the robot fails.
        why: After which single changes it arrives; empty if that was not tried.
        frames: Where the controller crashed, one line per frame; empty if it did not crash.
        picture: The world as lines of text, with the robot's path if its controller can be run.
    """

    state: FindingState
    failure: Failure
    file: Path
    replay: str
    what: str
    diagnosis: Diagnosis
    why: str = ""
    frames: str = ""
    picture: str = ""

    @classmethod
    def of(
        cls,
        failure: Failure,
        file: Path,
        state: FindingState,
        reason: str = "",
        controller: str | None = None,
        cause: CauseResult | None = None,
    ) -> CiFinding:
        """Describe a failure; this runs its controller to draw the path.

        Args:
            failure: The stored failure.
            file: Its file.
            state: See the class.
            reason: Why it is not confirmed.
            controller: A controller to use instead of the recorded one.
            cause: The cause that shows this failure; the picture marks the cells on which it
                depends.
        """
        replay = failure.replay_command(file, controller)
        failure = failure.driven_by(controller)
        world = failure.world

        # Run the controller for the picture. If it cannot run, or is too slow, draw the world only.
        frames = ""
        trails: Sequence[Trail] = ()
        try:
            episode, words = run_to_draw(failure)
            trails = naming(trails_of(episode, world), named_cells(cause.changes) if cause else ())
            frames = describe_frames(episode.evidence)
        except WorldgenError as error:
            words = f", but it cannot be run here: {error}"
        except OutOfTime:
            words = ""
            frames = describe_frames(failure.evidence)
        picture = draw_terminal(world, trail=trails, color=False).rstrip("\n")
        if len(picture) > _MOST_PICTURE:
            picture = (
                f"(a map of {world.width} x {world.height} cells is too large for a picture here)"
            )
        return cls(
            state,
            failure,
            file,
            replay,
            what=reason if state == FindingState.NOT_CONFIRMED else f"{failure.verdict}{words}",
            diagnosis=diagnosis_of(failure),
            why=cause.why if cause else "",
            frames=frames,
            picture=picture,
        )

    def __post_init__(self) -> None:
        """Make texts safe for a log, a browser and a parser, whoever made the finding."""
        for name, safe in _SAFE.items():
            object.__setattr__(self, name, safe(getattr(self, name)))

    @property
    def who(self) -> str:
        """Controller with options, and motion model."""
        return shown(self.failure.who)

    @property
    def verdict(self) -> str:
        """The recorded verdict."""
        return shown(self.failure.verdict)

    @property
    def group(self) -> str:
        """See :attr:`fuzz.failure.Failure.group`."""
        return shown(self.failure.group)

    @property
    def cause(self) -> str:
        """Why the robot fails: a name of :class:`fuzz.cause.Cause`."""
        return self.diagnosis.cause.value

    @property
    def sentence(self) -> str:
        """The cause as a sentence, with a full stop; empty if ``what`` says more."""
        vague = self.diagnosis.cause.is_vague
        return "" if vague else shown(self.diagnosis.sentence(self.failure.world))

    @property
    def world_id(self) -> str:
        """SHA-256, in hex, of the world without its record."""
        return world_digest(self.failure.stored)

    @property
    def fails(self) -> bool:
        """True if this finding makes the command exit with code 1."""
        return self.state in (FindingState.NEW, FindingState.NOT_CONFIRMED)

    @property
    def place(self) -> str:
        """The file's name in a printable form."""
        return shown(self.file)

    @property
    def headline(self) -> str:
        """The controller, and what goes wrong; if that is not known, what happened."""
        return f"{self.who}: {self.explanation or self.what}"

    @property
    def explanation(self) -> str:
        """Why it happens: one or two sentences; empty if nothing is known or confirmed."""
        if self.state == FindingState.NOT_CONFIRMED:
            return ""
        if not self.why:
            return self.sentence
        return f"{self.sentence or f'{self.what}.'} It {self.why}."

    @property
    def extent(self) -> str:
        """The size of the world, and how far shrinking got."""
        return f"{self.size}, shrinking {self.failure.shrinking}"

    @property
    def size(self) -> str:
        """The size of the world, in words."""
        world = self.failure.world
        return f"{world.width} x {world.height} cells, {world.solid_cells} solid"

    @property
    def text(self) -> str:
        """The complete finding, as lines of text."""
        happened = "" if self.what in self.headline else f"{self.what}\n"
        about = f"{self.headline}\n{happened}{self.frames}cause {self.cause}, {self.extent}"
        return f"{about}\n{self.picture}\nworld:  {self.place}\nreplay: {self.replay}"


@dataclass(frozen=True)
class Report:
    """The results of a command.

    Args:
        command: ``fuzz`` or ``replay``.
        findings: In the order in which to show them.
        facts: Named values, such as the seed.
        no_answer: Why a campaign has no answer, as a sentence without a full stop; empty if it has.
        remedy: The next command to type, if it has none.
        is_accepted: True if the user accepts that there is no answer.
    """

    command: str
    findings: tuple[CiFinding, ...]
    facts: Mapping[str, str] = field(default_factory=dict)
    no_answer: str = ""
    remedy: str = ""
    is_accepted: bool = False

    def __post_init__(self) -> None:
        """Make the values of the facts safe, as those of a finding are."""
        safe = {name: shown(value) for name, value in self.facts.items()}
        object.__setattr__(self, "facts", safe)

    @property
    def failing(self) -> int:
        """Number of findings that make the command exit with code 1."""
        return sum(finding.fails for finding in self.findings)

    @property
    def conclusion(self) -> str:
        """The outcome in a few words."""
        if self.no_answer:
            return f"no answer: {self.no_answer}"
        others = len(self.findings) - self.failing
        hazards = sum(finding.state == FindingState.HAZARD for finding in self.findings)
        if self.command == "replay":
            return f"{others} of {len(self.findings)} confirmed"
        found = counted(self.failing, "new failure") if self.failing else "no new failure"
        known = f", {others - hazards} known" if others > hazards else ""
        unsensed = f", {counted(hazards, 'hazard')} that it cannot sense" if hazards else ""
        return f"{found}{known}{unsensed}"
