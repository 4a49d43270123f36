"""Results of a command, as plain text that is safe in terminals, browsers and parsers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

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
from worldgen.render.overlay import naming
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


_OF_LINES = ("frames", "picture")


@dataclass(frozen=True)
class CiFinding:
    """A failure and its description.

    Args:
        state: The command's description.
        file: The failure's file.
        controller: The recorded controller, without options.
        who: Controller with options, and motion model.
        verdict: Recorded verdict.
        group: See :attr:`fuzz.failure.Failure.group`.
        what: What happened, as a sentence without a full stop.
        size: Size of the world, in words.
        picture: The world as lines of text, with the robot's path if its controller can be run.
        world_id: SHA-256, in hex, of the world without its record.
        seed: Seed of the run.
        replay: The command that replays it.
        cause: Why the robot fails: a name of :class:`fuzz.cause.Cause`.
        sentence: The cause as a sentence, with a full stop; empty if ``what`` says more.
        why: After which single changes it arrives; empty if that was not tried.
        frames: Where the controller crashed, one line per frame; empty if it did not crash.
        shrinking: See :attr:`fuzz.failure.Failure.shrinking`; empty if not known.
    """

    state: FindingState
    file: Path
    controller: str
    who: str
    verdict: str
    group: str
    what: str
    size: str
    picture: str
    world_id: str
    seed: int
    replay: str
    cause: str = ""
    sentence: str = ""
    why: str = ""
    frames: str = ""
    shrinking: str = ""

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
        record = failure.record

        # Run the controller for the picture. If it cannot run, or is too slow, draw the world only.
        try:
            episode, words = run_to_draw(failure)
            trail = naming(trails_of(episode, world), named_cells(cause.changes) if cause else ())
            frames: str = describe_frames(episode.evidence)
        except WorldgenError as error:
            words = f", but it cannot be run here: {error}"
            trail = None
            frames = ""
        except OutOfTime:
            words = ""
            trail = None
            frames = describe_frames(failure.evidence)
        # Collect the facts for the CI's log: the cause, what happened, and a picture that fits.
        diagnosis = diagnosis_of(failure)
        what = reason if state == FindingState.NOT_CONFIRMED else f"{record.verdict}{words}"
        picture = draw_terminal(world, trail=trail, color=False).rstrip("\n")
        if len(picture) > _MOST_PICTURE:
            picture = (
                f"(a map of {world.width} x {world.height} cells is too large for a picture here)"
            )
        return cls(
            state,
            file,
            controller=record.controller,
            who=failure.who,
            verdict=record.verdict,
            group=failure.group,
            what=what,
            frames=frames,
            size=f"{world.width} x {world.height} cells, {world.solid_cells} solid",
            picture=picture,
            world_id=world_digest(failure.stored),
            seed=record.seed,
            replay=replay,
            cause=diagnosis.cause.value,
            sentence="" if diagnosis.cause.is_vague else diagnosis.sentence(world),
            why=cause.why if cause else "",
            shrinking=failure.shrinking.value,
        )

    def __post_init__(self) -> None:
        """Make every text safe for a log, a browser and a parser, whoever made the finding."""
        for one in fields(self):
            text = getattr(self, one.name)
            # The controller's name is looked up, not shown.
            if isinstance(text, str) and one.name not in ("state", "controller"):
                safe = shown_lines(text) if one.name in _OF_LINES else shown(text)
                object.__setattr__(self, one.name, safe)

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
        return f"{self.size}, shrinking {self.shrinking}" if self.shrinking else self.size

    @property
    def text(self) -> str:
        """The complete finding, as lines of text."""
        happened = "" if self.what in self.headline else f"{self.what}\n"
        cause = f"cause {self.cause}, " if self.cause else ""
        about = f"{self.headline}\n{happened}{self.frames}{cause}{self.extent}"
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
