"""Failures: a world, and the record of a run in it that went wrong."""

from __future__ import annotations

import hashlib
import shlex
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from fuzz.simplicity import Case, simplicity
from fuzz.violation import Violation
from sim.episode import Episode, simulate
from sim.evidence import Evidence, read_evidence
from sim.options.run import RunOptions
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.files.grid import dumps, read_world, write_world
from worldgen.world import Cut, FailureRecord, Value, World

__all__ = ["ID_DIGITS", "Failure", "regardless_of_walls"]

ID_DIGITS = 16
"""Hex digits of a failure's id."""


@dataclass(frozen=True)
class Failure:
    """A world, and what went wrong in it.

    Its robot does not arrive, though the target can be reached; or an oracle objects to its run. A
    *breach* is the other way around: the target is walled off, as a cut proves, the robot goes
        through a wall (verdict ``tunnel``) and,
    where walls end nothing, it arrives.

    Args:
        world: Where, with its certificate; the record is not in it.
        record: What happened, as the file holds it.
    """

    world: World
    record: FailureRecord

    @classmethod
    def of(cls, world: World) -> Failure:
        """Return the failure that a world's file holds.

        Raises:
            InvalidParameter: If it holds none.
        """
        found = cls.found_in(world)
        if found is None:
            raise InvalidParameter(
                "no-failure",
                "this world holds no failure",
                "worldgen run simulates it",
                at_terminal=True,
            )
        return found

    @classmethod
    def found_in(cls, world: World) -> Failure | None:
        """Return the failure that a world's file holds, if it holds one."""
        return None if world.failure is None else cls(replace(world, failure=None), world.failure)

    @classmethod
    def read(cls, path: Path) -> Failure:
        """Read a failure's file.

        Raises:
            FormatError: If the file cannot be read.
            InvalidParameter: If it holds no failure.
        """
        return cls.of(read_world(path))

    def write(self, path: Path, *, force: bool = False) -> None:
        """Write the failure's file.

        Raises:
            OutputError: If it cannot be written, or is there already and ``force`` is not set.
        """
        write_world(self.stored, path, force=force)

    @property
    def stored(self) -> World:
        """The world as its file holds it, with the record."""
        return replace(self.world, failure=self.record)

    def dumps(self) -> bytes:
        """Return the bytes of the failure's file."""
        return dumps(self.stored)

    @cached_property
    def id(self) -> str:
        """The first hex digits of the SHA-256 of its file.

        The world's id would not do: one world may hold several failures, of other seeds for
        example.
        """
        return hashlib.sha256(self.dumps()).hexdigest()[:ID_DIGITS]

    @property
    def bucket(self) -> str:
        """The name of failures of its form; the verdict if the record does not say."""
        return str(self.record.details.get("class", self.record.verdict))

    @cached_property
    def size(self) -> tuple[int, ...]:
        """How large it is, by :data:`fuzz.simplicity.ORDER`.

        Campaigns, corpora and shrinking keep the smallest.

        Raises:
            InvalidParameter: If the record names options that are unknown here.
        """
        return simplicity(Case(self.world, self.scenario))

    @property
    def verdict(self) -> str:
        """As the record has it: one of :class:`sim.verdict.Verdict`, unless a stranger wrote it."""
        return self.record.verdict

    @property
    def evidence(self) -> Evidence | None:
        """What the verdict rests on.

        ``None`` if the record does not hold what such a verdict needs.
        """
        if self.verdict not in set(Verdict):
            return None
        return read_evidence(Verdict(self.verdict), self.record.evidence)

    @property
    def oracle(self) -> str | None:
        """The oracle that objects to the run, as ``--oracle`` takes it.

        ``None`` of a failure by its verdict.
        """
        named = self.record.evidence.get("oracle")
        return None if named is None else str(named)

    @property
    def violation(self) -> Violation:
        """What is wrong with the run, as the record has it."""
        facts = self.record.evidence.get("objection")
        return Violation(
            self.bucket, self.evidence, self.oracle, facts if isinstance(facts, dict) else {}
        )

    @property
    def is_breach(self) -> bool:
        """Whether the target is walled off, so that it is a failure to get there."""
        return isinstance(self.world.certificate, Cut)

    @property
    def is_shrunk(self) -> bool:
        """Whether it was shrunk, and not only found."""
        return "shrunk_from" in self.record.details

    @property
    def original(self) -> str | None:
        """The id of the failure from which it was shrunk, if the record names one."""
        name = self.record.details.get("original")
        return name if isinstance(name, str) and name.isalnum() else None

    @cached_property
    def options(self) -> RunOptions:
        """How the controller ran.

        Raises:
            InvalidParameter: If the record names options that are unknown here.
        """
        return RunOptions.of(self.record.motion, self.record.seed, self.record.parameters)

    @property
    def scenario(self) -> Scenario:
        """What ran, without its budget."""
        return Scenario.of(self.record.controller, self.options)

    @property
    def label(self) -> str:
        """The controller with its options, as commands take it.

        Without motion model, time step and seed.
        """
        return self.scenario.label(self.record.motion, self.options.time_step)

    @property
    def who(self) -> str:
        """``turn-left under swept``, with the options that vary the run."""
        return f"{self.label} under {self.record.motion}"

    def replay_command(self, path: Path, controller: str | None = None) -> str:
        """Return the command that shows the failure again.

        Args:
            path: The failure's file.
            controller: Instead of the one that the file names.
        """
        instead = "" if controller is None else f" --controller {shlex.quote(controller)}"
        return f"worldgen replay {shlex.quote(str(path))}{instead}"

    def run(self, *, through_walls: bool = False) -> Episode:
        """Run the failure's controller in its world, recorded.

        Args:
            through_walls: Whether walls that the robot enters neither end the run nor decide its
                verdict.

        Raises:
            WorldgenError: If the controller or an option is unknown here.
        """
        options = regardless_of_walls(self.options) if through_walls else self.options
        return simulate(self.world, self.record.controller, options, record=True)

    def driven_by(self, controller: str | None) -> Failure:
        """Return the failure with another name for its controller; itself for ``None``."""
        return (
            self
            if controller is None
            else replace(self, record=replace(self.record, controller=controller))
        )

    def noting(self, **details: Value) -> Failure:
        """Return the failure with more details in its record."""
        return replace(
            self, record=replace(self.record, details={**self.record.details, **details})
        )


def regardless_of_walls(options: RunOptions) -> RunOptions:
    """Return the same run, where walls that the robot enters neither end it nor decide its verdict."""
    return replace(options, thesis=replace(options.thesis, keep_going=True))
