"""The gallery of the campaign page: pictures of failures, with commands and tests for each."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Any

from fuzz.boundary import describe_boundaries
from fuzz.cause import Diagnosis
from fuzz.corpus import places, read_corpus
from fuzz.corpus.entry import CorpusEntry, Facts, name_of
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.failure import Failure, regardless_of_walls
from fuzz.overview.counterfactual import named_cells
from fuzz.overview.describe import describe_seeds
from fuzz.player import drawn_robots, drawn_world, sensors_of
from fuzz.shrink.snippet import snippet
from fuzz.studio.campaigns.overviews import example_in, ranks
from fuzz.studio.requests.folder import KNOWN, MOST_FAILURES, Opened
from fuzz.studio.requests.messages import Request, SendPart
from fuzz.studio.requests.messages import field as part_of
from fuzz.studio.requests.running import check_record, check_registered, from_anywhere
from fuzz.triage.diagnosis import diagnosis_of, diagnosis_of_run
from fuzz.triage.repeated_moves import describe_period
from sim.controllers import CONTROLLERS
from sim.episode import simulate
from sim.episode.describe import describe_evidence
from sim.motion import MOTIONS
from worldgen import errors
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.archives import is_archive, members
from worldgen.files.grid import read_world
from worldgen.files.grid.disk import unpack_world
from worldgen.files.whole import refused_writes, write_bytes
from worldgen.files.worlds import is_world_file
from worldgen.world import World

_MOST_STEPS = 200_000  # longest run drawn in a picture; the Play page shows longer ones

_TOLD = 500  # files between progress reports


@dataclass(frozen=True)
class WallAnswers(Opened):
    """Answers of the campaign page that concern failures."""

    _read: dict[tuple[str, int, int], CorpusEntry | None] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def failures(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the failures in and below a folder; unreadable ones are reported, not raised."""
        below = part_of(message, "folder", str)
        known = (
            {entry.facts.key for entry in self._entries(KNOWN, [], part)}
            if self.folder.place(KNOWN).is_dir()
            else set()
        )
        faults: list[dict[str, Any]] = []
        place = self.folder.place(below) if below else self.folder.root
        packed = is_archive(place) and place.is_file()
        entries = (
            self._packed(place, faults, part) if packed else self._entries(below, faults, part)
        )
        place_of = places(entries)
        rank_of = ranks(
            (entry.facts.cause for entry in entries), {entry.path.parent for entry in entries}
        )
        return {
            "failures": [
                {
                    "name": entry.path.relative_to(self.folder.root).as_posix(),
                    "group": entry.facts.group,
                    "shrinking": entry.facts.shrinking,
                    "verdict": entry.facts.verdict,
                    "controller": entry.facts.controller,
                    "motion": entry.facts.motion,
                    "width": entry.facts.width,
                    "height": entry.facts.height,
                    "solid": entry.facts.solid,
                    "events": entry.facts.events,
                    "place": place_of[entry.facts.order],
                    "rank": rank_of[entry.facts.cause],
                    "seen": entry.seen or 0,
                    "digest": entry.facts.digest,
                    "known": entry.facts.key in known,
                }
                for entry in entries
            ],
            "faults": faults,
        }

    def look(self, message: Request, part: object) -> dict[str, Any]:
        """Return a failure's world and run, to be drawn, and a description of what happened."""
        path = self.folder.place(part_of(message, "name", str))
        world = read_world(path)
        failure = Failure.of(world)
        answer: dict[str, Any] = {
            "world": drawn_world(world),
            "run": None,
            "sensors": None,
            "error": None,
        }
        diagnosis = diagnosis_of(failure) if failure.recorded_cause else None
        example = example_in(path)
        answer |= {
            "why": "" if example is None else example.why,
            "named": [] if example is None else named_cells(example.changes, world),
            "replay": from_anywhere(
                failure.replay_command(path), failure.record.controller, CONTROLLERS.names()
            ),
            "notes": [*filter(None, (describe_seeds(failure), describe_boundaries(failure)))],
            **_texts(diagnosis, world),
        }
        try:
            return answer | self._seen(failure, diagnosis)
        except WorldgenError as error:
            return answer | {"words": "", "error": self.folder.refusal(error)}

    def snippet(self, message: Request, part: object) -> dict[str, Any]:
        """Return a failure as the source of a test."""
        failure = Failure.read(self.folder.place(part_of(message, "name", str)))
        check_registered("motion", failure.record.motion, MOTIONS.names())
        return {"text": snippet(failure)}

    def know(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Mark a failure's cause as known, by a copy in the folder for known ones, or unmark it."""
        path = self.folder.place(part_of(message, "name", str))
        failure = Failure.found_in(read_world(path))
        if failure is None:
            raise InvalidParameter(
                "no-failure", "{name} has no failure", "mark a file that has one", name=path.name
            )
        facts = Facts.of(failure, path.name)
        # The copy keeps the failure known even if a campaign replaces the original.
        if part_of(message, "known", bool):
            copy = self.folder.place(f"{KNOWN}/{name_of(facts)}.grid")
            with refused_writes(copy):
                copy.parent.mkdir(parents=True, exist_ok=True)
            self.folder.check_replaceable(copy)
            write_bytes(copy, failure.dumps(), force=True)
        else:
            for entry in self._entries(KNOWN, [], part):
                if entry.facts.key == facts.key:
                    entry.path.unlink()
        return {}

    def _seen(self, failure: Failure, recorded: Diagnosis | None) -> dict[str, Any]:
        """Return the run of a failure, cut off at the length that a picture can show."""
        check_record(failure.record, self.named)
        world = failure.world
        who = failure.record.controller
        options = replace(failure.options, steps=min(failure.options.steps, _MOST_STEPS))
        judged = shown = simulate(world, who, options, record=True)
        controller = CONTROLLERS.get(who)
        words = f"{judged.verdict}{describe_evidence(judged)}"
        # Draw a breach up to its target; the evidence comes from the run that ends at the wall.
        if failure.is_breach:
            shown = simulate(world, who, regardless_of_walls(options), record=True)
            words += f": reached a walled-off target in step {shown.steps}"
        is_same = (
            judged.trace_digest == failure.record.trace_digest
            or options.steps < failure.options.steps
        )
        # The record describes the run that was found.
        diagnosis = recorded
        if diagnosis is None or not is_same:
            diagnosis = diagnosis_of_run(world, judged, OtherWorlds(who, options))
        return {
            **drawn_robots(
                shown, world.cell_size, judged, motion=options.motion_model(), controller=controller
            ),
            "sensors": sensors_of(controller, options, world.cell_size),
            "words": words + failure.violation.in_words,
            **_texts(diagnosis, world),
            "repeats": "" if failure.oracle else describe_period(world, judged),
            "same": is_same,
        }

    def _entries(
        self, below: str, faults: list[dict[str, Any]], part: SendPart
    ) -> list[CorpusEntry]:
        """Return the failures in a folder's files, each read only once; links are ignored."""
        files = [
            file for file in self.folder.files(below=below, most=MOST_FAILURES) if file["world"]
        ]
        if len(files) == MOST_FAILURES:
            faults.append(self.folder.refusal(_too_many("choose a folder below")))
        found = []
        for number, file in enumerate(files):
            if number % _TOLD == _TOLD - 1:
                part({"read": number + 1, "of": len(files)})
            try:
                entry = self._entry(self.folder.root / file["name"])
            except FileNotFoundError:  # deleted a moment ago
                continue
            except WorldgenError as error:
                faults.append(self.folder.refusal(error))
                continue
            if entry is not None:
                found.append(entry)
        return found

    def _packed(
        self, archive: Path, faults: list[dict[str, Any]], part: SendPart
    ) -> list[CorpusEntry]:
        """Return the failures in an archive, under its name followed by their own.

        Invalid names are reported.
        """
        # Only world files count, except hidden ones.
        found: list[CorpusEntry] = []
        there = archive.relative_to(self.folder.root).as_posix()
        packed = (
            one for one in members(archive) if is_world_file(one.name) and not _is_hidden(one.name)
        )
        # Read the members, and report faults without giving up on the rest.
        try:
            for number, member in enumerate(islice(packed, MOST_FAILURES + 1)):
                if number == MOST_FAILURES:
                    faults.append(self.folder.refusal(_too_many("unpack it", archive.name)))
                    break
                if number % _TOLD == _TOLD - 1:
                    part({"read": number + 1, "of": None})
                try:
                    # The name may be any text, and may even begin with a slash.
                    name = PurePosixPath(member.name).as_posix()
                    place = self.folder.place(f"{there}/{name}")
                    facts = Facts.in_world(unpack_world(member, str(place)), str(place))
                except WorldgenError as error:
                    faults.append(self.folder.refusal(error))
                    continue
                if facts is not None:
                    found.append(CorpusEntry(place, facts))
        # the archive is damaged, but the entries read so far are sound
        except FormatError as error:
            faults.append(self.folder.refusal(error))
        return found

    def _entry(self, path: Path) -> CorpusEntry | None:
        facts = path.stat()
        key = (str(path), facts.st_mtime_ns, facts.st_size)
        if key not in self._read:
            entries = read_corpus([path]).entries
            self._read[key] = entries[0] if entries else None
        return self._read[key]


def _texts(diagnosis: Diagnosis | None, world: World) -> dict[str, str]:
    """Return the sentence and the advice of a diagnosis; without one, both are empty."""
    if diagnosis is None:
        return {"sentence": "", "advice": ""}
    return {"sentence": diagnosis.sentence(world), "advice": diagnosis.advice}


def _too_many(remedy: str, archive: str = "") -> errors.Message:
    of = " of {archive}" if archive else ""
    problem = f"only the first {{most}} files{of} are shown"
    return errors.Message("too-many", problem, remedy, most=MOST_FAILURES, archive=archive)


def _is_hidden(name: str) -> bool:
    """Return True if a file is not one of the user's own.

    Such a file is in a campaign store, or was added to an archive by macOS.
    """
    return any(part.startswith(".") and part != ".." for part in PurePosixPath(name).parts)
