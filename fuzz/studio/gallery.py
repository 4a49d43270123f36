"""The gallery of the campaign page: pictures of failures, with commands and tests for each."""

from __future__ import annotations

import functools
from dataclasses import asdict, replace
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
from fuzz.studio.requests.folder import KNOWN, MOST_FAILURES, Opened, answer
from fuzz.studio.requests.protocol import (
    FailureList,
    Failures,
    Know,
    Look,
    LookMessage,
    Progress,
    Refusal,
    SendPart,
    Snippet,
    WallFailure,
)
from fuzz.studio.requests.running import check_record, check_registered, from_anywhere
from fuzz.triage.diagnosis import diagnosis_of, diagnosis_of_run
from fuzz.triage.repeated_moves import describe_period
from sim.controllers import CONTROLLERS
from sim.episode import simulate
from sim.episode.describe import describe_evidence
from sim.motion import MOTIONS
from worldgen.errors import FormatError, InvalidParameter, Message, WorldgenError
from worldgen.files.archives import is_archive, members
from worldgen.files.grid import read_world
from worldgen.files.grid.disk import unpack_world
from worldgen.files.json_file import converted
from worldgen.files.whole import refused_writes, write_bytes
from worldgen.files.worlds import is_world_file
from worldgen.world import World

_MOST_STEPS = 200_000  # longest run drawn in a picture; the Play page shows longer ones

_EVERY = 500  # files between progress reports


@answer.register
def _failures(request: Failures, opened: Opened, part: SendPart[Progress]) -> FailureList:
    folder = opened.folder
    known = (
        {entry.facts.key for entry in _entries(opened, KNOWN, [], part)}
        if folder.place(KNOWN).is_dir()
        else set()
    )
    faults: list[Refusal] = []
    place = folder.place(request.folder) if request.folder else folder.root
    if is_archive(place) and place.is_file():
        found = _packed(opened, place, faults, part)
    else:
        found = _entries(opened, request.folder, faults, part)
    place_of = places(entry for entry in found)
    rank_of = ranks((entry.facts.cause for entry in found), {entry.path.parent for entry in found})
    failures = [
        converted(
            asdict(entry.facts)
            | {
                "name": entry.path.relative_to(folder.root).as_posix(),
                "place": place_of[entry.facts.order],
                "rank": rank_of[entry.facts.cause],
                "seen": entry.seen or 0,
                "known": entry.facts.key in known,
            },
            WallFailure,
        )
        for entry in found
    ]
    return FailureList(failures, faults)


@answer.register
def _look(request: Look, opened: Opened, part: object) -> LookMessage:
    path = opened.folder.place(request.name)
    world = read_world(path)
    failure = Failure.of(world)
    diagnosis = None if failure.recorded_cause is None else diagnosis_of(failure)
    example = example_in(path)
    answered: dict[str, Any] = {
        "world": drawn_world(world),
        "why": "" if example is None else example.why,
        "named": [] if example is None else named_cells(example.changes, world),
        "replay": from_anywhere(
            failure.replay_command(path), failure.record.controller, CONTROLLERS.names()
        ),
        "notes": [*filter(None, (describe_seeds(failure), describe_boundaries(failure)))],
        **_texts(diagnosis, world),
    }
    try:
        return LookMessage(**(answered | _seen(failure, diagnosis, opened)))
    except WorldgenError as error:
        return LookMessage(**answered, error=opened.folder.refusal(error))


@answer.register
def _snippet(request: Snippet, opened: Opened, part: object) -> str:
    failure = Failure.read(opened.folder.place(request.name))
    check_registered("motion", failure.record.motion, MOTIONS.names())
    return snippet(failure)


@answer.register
def _know(request: Know, opened: Opened, part: object) -> None:
    path = opened.folder.place(request.name)
    failure = Failure.found_in(read_world(path))
    if failure is None:
        raise InvalidParameter(
            "no-failure", "{name} has no failure", "mark a file that has one", name=path.name
        )
    facts = Facts.of(failure, path.name)
    # The copy keeps the failure known even if a campaign replaces the original.
    if request.known:
        copy = opened.folder.place(f"{KNOWN}/{name_of(facts)}.grid")
        with refused_writes(copy):
            copy.parent.mkdir(parents=True, exist_ok=True)
        opened.folder.check_replaceable(copy)
        write_bytes(copy, failure.dumps(), force=True)
    else:
        for entry in _entries(opened, KNOWN, []):
            if entry.facts.key == facts.key:
                entry.path.unlink()


def _seen(failure: Failure, recorded: Diagnosis | None, opened: Opened) -> dict[str, Any]:
    """Return the run of a failure, cut off at the length that a picture can show."""
    check_record(failure.record, opened.named)
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
        judged.trace_digest == failure.record.trace_digest or options.steps < failure.options.steps
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
    opened: Opened, below: str, faults: list[Refusal], part: SendPart[Progress] | None = None
) -> list[CorpusEntry]:
    """Return the failures in a folder's files, each read only once; links are ignored."""
    files = [file for file in opened.folder.files(below=below, most=MOST_FAILURES) if file.world]
    if len(files) == MOST_FAILURES:
        faults.append(opened.folder.refusal(_too_many("choose a folder below")))
    found = []
    for number, file in enumerate(files, start=1):
        if part is not None and number % _EVERY == 0:
            part(Progress(number, len(files)))
        path = opened.folder.root / file.name
        try:
            facts = path.stat()
            entry = _entry(path, facts.st_mtime_ns, facts.st_size)
        except FileNotFoundError:  # deleted a moment ago
            continue
        except WorldgenError as error:
            faults.append(opened.folder.refusal(error))
            continue
        if entry is not None:
            found.append(entry)
    return found


@functools.lru_cache(2 * MOST_FAILURES)
def _entry(path: Path, mtime_ns: int, size: int) -> CorpusEntry | None:
    """Return a file's failure; ``mtime_ns`` and ``size`` say of which contents."""
    return next(iter(read_corpus([path]).entries), None)


def _packed(
    opened: Opened, archive: Path, faults: list[Refusal], part: SendPart[Progress]
) -> list[CorpusEntry]:
    """Return the failures in an archive, under its name followed by their own.

    Invalid names are reported.
    """
    # Only world files count, except hidden ones.
    found: list[CorpusEntry] = []
    there = archive.relative_to(opened.folder.root).as_posix()
    packed = (
        one for one in members(archive) if is_world_file(one.name) and not _is_hidden(one.name)
    )
    # Read the members, and report faults without giving up on the rest.
    try:
        for number, member in enumerate(islice(packed, MOST_FAILURES + 1), start=1):
            if number > MOST_FAILURES:
                faults.append(opened.folder.refusal(_too_many("unpack it", archive.name)))
                break
            if number % _EVERY == 0:
                part(Progress(number, None))
            try:
                # The name may be any text, and may even begin with a slash.
                name = PurePosixPath(member.name).as_posix()
                place = opened.folder.place(f"{there}/{name}")
                facts = Facts.in_world(unpack_world(member, str(place)), str(place))
            except WorldgenError as error:
                faults.append(opened.folder.refusal(error))
                continue
            if facts is not None:
                found.append(CorpusEntry(place, facts))
    # the archive is damaged, but the entries read so far are sound
    except FormatError as error:
        faults.append(opened.folder.refusal(error))
    return found


def _texts(diagnosis: Diagnosis | None, world: World) -> dict[str, str]:
    """Return the sentence and the advice of a diagnosis; without one, both are empty."""
    if diagnosis is None:
        return {"sentence": "", "advice": ""}
    return {"sentence": diagnosis.sentence(world), "advice": diagnosis.advice}


def _too_many(remedy: str, archive: str = "") -> Message:
    of = " of {archive}" if archive else ""
    problem = f"only the first {{most}} files{of} are shown"
    return Message("too-many", problem, remedy, most=MOST_FAILURES, archive=archive)


def _is_hidden(name: str) -> bool:
    """Return True if a file is not one of the user's own.

    Such a file is in a campaign store, or was added to an archive by macOS.
    """
    return any(part.startswith(".") and part != ".." for part in PurePosixPath(name).parts)
