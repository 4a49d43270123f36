"""Failures: a world, and the record of the run that went wrong in it."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from fuzz.cause import CAUSE, Cause
from fuzz.simplicity import Case, FailureOrder, simplicity
from fuzz.violation import Violation
from sim.episode import Episode, simulate
from sim.evidence import Evidence, read_evidence
from sim.options.run import RunOptions, recorded_budget
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.files.grid import dumps, read_world, write_world
from worldgen.plugins.trust import admit_argument
from worldgen.world import Cut, FailureRecord, Value, World

T = TypeVar("T")
K = TypeVar("K")

MOST_SHOWN = 3
"""Failures of one group that campaigns and corpora show; their signatures differ."""

ID_DIGITS = 16
"""Number of hex digits in a failure's id."""


class ShrinkState(StrEnum):
    """How far shrinking got with a failure, as its record says."""

    DONE = "done"
    """It finished, and a separate check found nothing that can still be removed."""
    CUT_SHORT = "cut short"
    """Time ran out, or Ctrl-C came, before it finished."""
    NONE = "none"
    """It was not tried, or could not prove the failure again: the world is as it was found."""


SHRINKING = "shrinking"
"""The detail that names the state; a record without it was never shrunk."""


@dataclass(frozen=True)
class Failure:
    """A world, and what went wrong in it.

    Usually the robot does not arrive although the target can be reached, or an oracle finds a
    violation in its run. A *breach* is the opposite: a cut proves that the target is walled off,
    but the robot goes through a wall (verdict ``tunnel``) and would arrive if walls did not end
    the run.

    Args:
        world: The world, with its certificate and without the record.
        record: What happened, as stored in the file.
    """

    world: World
    record: FailureRecord

    @classmethod
    def of(cls, world: World) -> Failure:
        """Return the failure stored in a world's file.

        Raises:
            InvalidParameter: If the world has no failure.
        """
        found = cls.found_in(world)
        if found is None:
            raise InvalidParameter(
                "no-failure",
                "this world has no failure",
                "run it with worldgen run",
                at_terminal=True,
            )
        return found

    @classmethod
    def found_in(cls, world: World) -> Failure | None:
        """Return the failure stored in a world's file, or ``None`` if there isn't one."""
        return None if world.failure is None else cls(replace(world, failure=None), world.failure)

    @classmethod
    def read(cls, path: Path) -> Failure:
        """Read a failure's file.

        Raises:
            FormatError: If the file cannot be read.
            InvalidParameter: If it has no failure.
        """
        return cls.of(read_world(path))

    def write(self, path: Path, *, force: bool = False) -> None:
        """Write the failure's file.

        Args:
            path: The file; its folder must exist.
            force: Overwrite an existing file.

        Raises:
            OutputError: If it cannot be written, or if it exists and ``force`` is not set.
        """
        write_world(self.stored, path, force=force)

    @property
    def stored(self) -> World:
        """The world with the record, as stored in its file."""
        return replace(self.world, failure=self.record)

    def dumps(self) -> bytes:
        """Return the bytes of the failure's file."""
        return dumps(self.stored)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of its file, in hex.

        The world's digest is not enough: one world may have several failures, for example with
        different seeds.
        """
        return hashlib.sha256(self.dumps()).hexdigest()

    @property
    def id(self) -> str:
        """The first hex digits of its digest."""
        return self.digest[:ID_DIGITS]

    @property
    def signature(self) -> str:
        """What the failure looks like; the verdict if the record does not tell.

        A search collects failures with different signatures. Users group them by cause.
        """
        return str(self.record.details.get("class", self.record.verdict))

    @property
    def group(self) -> str:
        """The name under which failures of one cause are filed: the stem of their files.

        It is the cause, or, for errors of a controller and broken rules, the reason. Files from
        before causes were recorded are filed by what they look like.
        """
        cause = self.recorded_cause
        return self.signature if cause is None or cause.has_reasons else cause.value

    @property
    def recorded_cause(self) -> Cause | None:
        """The cause that the record names; ``None`` if it names none of this version's."""
        recorded = self.record.details.get(CAUSE)
        is_named = isinstance(recorded, str) and recorded in set(Cause)
        return Cause(str(recorded)) if is_named else None

    @property
    def key(self) -> tuple[str, str]:
        """Group and signature: of failures with the same key, a campaign keeps one."""
        return self.group, self.signature

    @cached_property
    def size(self) -> tuple[int, ...]:
        """How complex the failure is, by :data:`fuzz.simplicity.ORDER`; smaller is simpler.

        Raises:
            InvalidParameter: If the record has options that this version does not know.
        """
        return simplicity(Case(self.world, self.scenario))

    @property
    def order(self) -> FailureOrder:
        """The failure's place among others, the simplest first.

        Campaigns, corpora, shrinking and reports keep or show the first failures of each group.

        Raises:
            InvalidParameter: If the record has options that this version does not know.
        """
        return FailureOrder(self.size, self.digest)

    @property
    def verdict(self) -> str:
        """The recorded verdict: one of :class:`sim.verdict.Verdict`, unless the file is foreign."""
        return self.record.verdict

    @property
    def evidence(self) -> Evidence | None:
        """The evidence for the verdict.

        ``None`` if the record lacks the fields that this verdict requires.
        """
        if self.verdict not in set(Verdict):
            return None
        return read_evidence(Verdict(self.verdict), self.record.evidence)

    @property
    def oracle(self) -> str | None:
        """The oracle that found the violation, as ``--oracle`` takes it.

        ``None`` if the verdict itself is the failure.
        """
        named = self.record.evidence.get("oracle")
        return None if named is None else str(named)

    @property
    def violation(self) -> Violation:
        """The violation, as recorded."""
        facts = self.record.evidence.get("objection")
        return Violation(
            self.signature, self.evidence, self.oracle, facts if isinstance(facts, dict) else {}
        )

    @property
    def is_breach(self) -> bool:
        """True if the target is walled off, so that arriving there is the failure."""
        return isinstance(self.world.certificate, Cut)

    @property
    def shrinking(self) -> ShrinkState:
        """How far shrinking got, as recorded."""
        details = self.record.details
        recorded = details.get(SHRINKING)
        if isinstance(recorded, str) and recorded in set(ShrinkState):
            return ShrinkState(recorded)
        # Older files only have the outcome of the check, which is made at the end.
        minimal = details.get("one_minimal")
        if isinstance(minimal, bool):
            return ShrinkState.DONE if minimal else ShrinkState.CUT_SHORT
        return ShrinkState.NONE

    @property
    def original(self) -> str | None:
        """The id of the failure that this one was shrunk from, if recorded."""
        name = self.record.details.get("original")
        return name if isinstance(name, str) and name.isalnum() else None

    @cached_property
    def options(self) -> RunOptions:
        """The options of the run.

        Raises:
            InvalidParameter: If the record has options that this version does not know.
        """
        return RunOptions.of(self.record.motion, self.record.seed, self.record.parameters)

    @property
    def scenario(self) -> Scenario:
        """The controller and its options, with the budget that the record shows."""
        budget = recorded_budget(self.world, self.options)
        return Scenario(self.record.controller, self.options, budget)

    @property
    def label(self) -> str:
        """The controller with its options, as commands take it.

        The motion model, the time step and the seed are not part of it.
        """
        return self.scenario.label(self.record.motion, self.options.time_step)

    @property
    def who(self) -> str:
        """Controller and motion model in words: ``turn-left under swept``."""
        return f"{self.label} under {self.record.motion}"

    def replay_command(self, path: Path, controller: str | None = None) -> str:
        """Return the command that replays the failure.

        Args:
            path: The failure's file.
            controller: A controller to use instead of the recorded one.
        """
        instead = "" if controller is None else f" --controller {shlex.quote(controller)}"
        return f"worldgen replay {shlex.quote(str(path))}{instead}"

    def run(self, *, through_walls: bool = False) -> Episode:
        """Run the failure's controller in its world, recorded.

        Args:
            through_walls: Ignore walls that the robot enters: they neither end the run nor decide
                its verdict.

        Raises:
            WorldgenError: If the controller or one of its options is unknown.
        """
        options = regardless_of_walls(self.options) if through_walls else self.options
        return simulate(self.world, self.record.controller, options, record=True)

    def driven_by(self, controller: str | None) -> Failure:
        """Return the failure with another controller name; unchanged for ``None``."""
        if controller is not None:
            admit_argument(controller)
        return (
            self
            if controller is None
            else replace(self, record=replace(self.record, controller=controller))
        )

    def without(self, *details: str) -> Failure:
        """Return the failure without these details of its record."""
        kept = {name: value for name, value in self.record.details.items() if name not in details}
        return replace(self, record=replace(self.record, details=kept))

    def noting(self, **details: Value) -> Failure:
        """Return the failure with these details added to its record."""
        return replace(
            self, record=replace(self.record, details={**self.record.details, **details})
        )


def few_of_each(
    ordered: Iterable[T], group: Callable[[T], K], signature: Callable[[T], str]
) -> dict[K, list[T]]:
    """Return the failures to show of each group: the first ones that differ in their signature.

    Args:
        ordered: The failures, or what stands for them, the first to show first.
        group: Returns the group of one.
        signature: Returns its signature.
    """
    found: dict[K, dict[str, T]] = {}
    for one in ordered:
        own = found.setdefault(group(one), {})
        if len(own) < MOST_SHOWN:
            own.setdefault(signature(one), one)
    return {key: list(own.values()) for key, own in found.items()}


def stem_of(name: str, number: int, names: Container[str]) -> str:
    """Return the stem of a failure's file: ``CAUSE``, ``CAUSE-2`` and so on.

    Args:
        name: The name of its group.
        number: Its place in the group, from 1.
        names: The names of all groups in the folder. The reason of an error may end in a number,
            too, and then has that stem itself.
    """
    if number == 1:
        return name
    stem = f"{name}-{number}"
    return f"{stem}-more" if stem in names else stem


def regardless_of_walls(options: RunOptions) -> RunOptions:
    """Return options with which walls neither end the run nor decide its verdict."""
    return replace(options, thesis=replace(options.thesis, keep_going=True))
