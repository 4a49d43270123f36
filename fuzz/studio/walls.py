"""Failures as the campaign page shows them: a wall of small pictures, with the lines and tests that show them again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fuzz.asked import objection_in_words
from fuzz.boundary import boundaries_in_words
from fuzz.corpus import read_corpus
from fuzz.corpus.entry import Entry, Facts
from fuzz.corpus.names import name_of
from fuzz.failure import regardless_of_walls, scenario_of
from fuzz.player import drawn_run, drawn_world, sensors_of
from fuzz.shrink.snippet import snippet
from fuzz.studio.campaigns import KNOWN
from fuzz.studio.folder import Folder
from fuzz.studio.messages import field as part_of
from fuzz.studio.running import may_run
from fuzz.telling import replay_line, seeds_in_words
from sim.controllers import CONTROLLERS
from sim.episode import simulate
from sim.words import evidence_in_words
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.files import write_bytes
from worldgen.grid_file import dumps, read_world
from worldgen.world import Cut, World

__all__ = ["WallAnswers"]

_MOST_STEPS = 200_000  # of a run for a picture; a longer one is played on the page Play

Message = Mapping[str, Any]


@dataclass(frozen=True)
class WallAnswers:
    """What the campaign page asks for, as far as failures are concerned.

    Args:
        folder: What can be read and written.
        named: Controllers that were named at the start, beside the registered ones.
    """

    folder: Folder
    named: Sequence[str] = ()
    _read: dict[tuple[str, int, int], Entry | None] = field(default_factory=dict, init=False, repr=False, compare=False)

    def failures(self, message: Message, part: object) -> dict[str, Any]:
        """The failures in a folder and below; what cannot be read is told, not raised."""
        below = part_of(message, "folder", str)
        known = {entry.facts.key for entry in self._entries(KNOWN, [])} if self.folder.place(KNOWN).is_dir() else set()
        faults: list[str] = []
        entries = self._entries(below, faults)
        return {
            "failures": [
                {
                    "name": entry.path.relative_to(self.folder.root).as_posix(),
                    "class": entry.facts.kind,
                    "verdict": entry.facts.verdict,
                    "controller": entry.facts.controller,
                    "motion": entry.facts.motion,
                    "width": entry.facts.width,
                    "height": entry.facts.height,
                    "solid": entry.facts.solid,
                    "events": entry.facts.events,
                    "seen": entry.seen or 0,
                    "digest": entry.facts.digest,
                    "known": entry.facts.key in known,
                }
                for entry in entries
            ],
            "faults": faults,
        }

    def look(self, message: Message, part: object) -> dict[str, Any]:
        """A failure's world and its run, to be drawn, and what happened in words."""
        path = self.folder.place(part_of(message, "name", str))
        world = read_world(path)
        told: dict[str, Any] = {"world": drawn_world(world), "run": None, "sensors": None}
        told |= {
            "replay": replay_line(path),
            "notes": [*filter(None, (seeds_in_words(world), boundaries_in_words(world)))],
        }
        try:
            return told | self._seen(world)
        except WorldgenError as error:
            return told | {"words": str(error)}

    def snippet(self, message: Message, part: object) -> dict[str, Any]:
        """A failure as the text of a test."""
        return {"text": snippet(read_world(self.folder.place(part_of(message, "name", str))))}

    def know(self, message: Message, part: object) -> dict[str, Any]:
        """Marks a failure's class as known, by a copy in the folder of known ones, or takes that back."""
        path = self.folder.place(part_of(message, "name", str))
        world = read_world(path)
        facts = Facts.of(world, path.name)
        if facts is None:
            raise InvalidParameter(f"{path.name} holds no failure; mark one that does")
        if part_of(message, "known", bool):
            copy = self.folder.place(f"{KNOWN}/{name_of(facts)}.grid")
            copy.parent.mkdir(parents=True, exist_ok=True)
            write_bytes(copy, dumps(world), force=True)
        else:
            for entry in self._entries(KNOWN, []):
                if entry.facts.key == facts.key:
                    entry.path.unlink()
        return {}

    def _seen(self, world: World) -> dict[str, Any]:
        """The run of a failure, as long as a picture has use for."""
        record, options = scenario_of(world)
        if not may_run(record.controller, self.named):
            raise InvalidParameter(
                f"{record.verdict}; {record.controller[:60]} is not run here: it was not named when the studio started"
            )
        options = replace(options, steps=min(options.steps, _MOST_STEPS))
        judged = shown = simulate(world, record.controller, options, record=True)
        words = f"{judged.verdict}{evidence_in_words(judged)}"
        if isinstance(world.certificate, Cut):
            shown = simulate(world, record.controller, regardless_of_walls(options), record=True)
            words += f": reached a walled-off target in step {shown.steps}"
        return {
            "run": drawn_run(shown, world.cell_size, judged),
            "sensors": sensors_of(CONTROLLERS.get(record.controller), options, world.cell_size),
            "words": words + objection_in_words(record.evidence),
        }

    def _entries(self, below: str, faults: list[str]) -> list[Entry]:
        """The failures of a folder's files, read once; links are passed over."""
        found = []
        for file in self.folder.files(below=below):
            if not file["world"]:
                continue
            path = self.folder.root / file["name"]
            try:
                entry = self._entry(path)
            except WorldgenError as error:
                faults.append(str(error))
                continue
            if entry is not None:
                found.append(entry)
        return found

    def _entry(self, path: Path) -> Entry | None:
        facts = path.stat()
        key = (str(path), facts.st_mtime_ns, facts.st_size)
        if key not in self._read:
            entries = read_corpus([path]).entries
            self._read[key] = entries[0] if entries else None
        return self._read[key]
