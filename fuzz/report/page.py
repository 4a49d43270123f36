"""Assemble the page from ``page/``, the player's scripts and style, and the data as JSON."""

from __future__ import annotations

import base64
import contextlib
import gzip
import json
import math
import shlex
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import msgspec

from fuzz.corpus import Corpus, places
from fuzz.failure import Failure
from fuzz.layouts.variation import changes_on_map
from fuzz.overview.counterfactual import Change, named_cells
from fuzz.overview.result import CauseResult
from fuzz.player import drawn_robots, drawn_world, one_file, sensors_of
from fuzz.player.live import has_live_proof, live_question
from fuzz.player.one_file import modules
from fuzz.report.answers import answers_for
from fuzz.report.gather import ReplayedFailure, ReportedCampaign, gather, look_at
from fuzz.report.numbers import groups
from fuzz.shrink.snippet import snippet
from fuzz.triage.diagnosis import diagnosis_of
from fuzz.triage.reactions import Reactions
from fuzz.triage.run_facts import RunFacts, run_facts
from sim.controllers import CONTROLLERS
from sim.options.run import RunOptions
from worldgen.errors import WorldgenError
from worldgen.files.grid import dumps
from worldgen.files.json_file import plain
from worldgen.files.whole import check_output, write_bytes
from worldgen.files.worlds import Skip
from worldgen.support.plain_text import counted
from worldgen.world import World

_MOST_TRIES = 6
_ID_DIGITS = 12  # hex digits of a failure's digest, used as its address in the page


def write_report(
    paths: Sequence[Path],
    out: Path,
    *,
    title: str = "",
    force: bool = False,
    with_code: bool = True,
    progress: Callable[[int, int], None] = lambda done, of: None,
    skip: Skip | None = None,
) -> int:
    """Write failures and their campaigns as one HTML page.

    Equal files with equal names give equal bytes. The controllers named in the files are run.

    Args:
        paths: Folders, archives and files of failures; a campaign's folder also adds its summary.
        out: The page.
        title: Heading; if empty, the controller and motion model, or the number of controllers.
        force: Overwrite an existing file.
        with_code: False to leave out the source lines and the state of Python controllers.
        progress: Called with the number of failures done and the total.
        skip: See :func:`worldgen.files.worlds.walk`.

    Returns:
        The number of failures on the page.

    Raises:
        InvalidParameter: If there is nothing to report on, or too much.
        FormatError: If a path or a file cannot be read.
        OutputError: If the page exists or cannot be written.
    """
    # Refuse before the work rather than after it: replaying a corpus may take minutes.
    check_output(out, force)
    corpus, campaigns = gather(paths, skip)
    answers = answers_for(corpus.entries, campaigns)
    causes = {cause.file: cause for answer in answers for cause in answer.result.causes}
    failures = []
    reactions: defaultdict[tuple[str, str], Reactions] = defaultdict(Reactions)
    place = places(corpus.entries)
    index = {None: -1} | {campaign: number for number, campaign in enumerate(campaigns)}

    def shown_failure(seen: ReplayedFailure) -> dict[str, Any]:
        table = _failure(seen, causes.get(str(seen.path)), with_code=with_code)
        return table | {"campaign": index[seen.campaign]}

    # Replay each entry, because the corpus stores no trajectories.
    for done, entry in enumerate(corpus.entries):
        progress(done, len(corpus.entries))
        seen = look_at(entry.path, campaigns)
        _add_reactions(seen, reactions[entry.facts.controller, entry.facts.motion])
        failures.append(shown_failure(seen) | {"place": place[entry.facts.order]})
    # A cause's clearest world may be an original before shrinking, which is not among the failures.
    shown = {failure["path"] for failure in failures}
    others = [Path(name) for name in causes if name and name not in shown]
    extras = [shown_failure(look_at(path, campaigns)) for path in others if _is_readable(path)]
    heading = title or _heading(corpus, campaigns)
    data = {
        "title": heading,
        "answers": [
            answer.table()
            | {
                "campaign": index[answer.campaign],
                "reactions": reactions[answer.controller, answer.motion].rows(),
            }
            for answer in answers
        ],
        "failures": failures,
        "extras": extras,
        "campaigns": list(map(_campaign, campaigns)),
        "others": corpus.others,
    }
    write_bytes(out, _page(heading, data), force=force)
    return len(failures)


def _is_readable(path: Path) -> bool:
    """Return True if a file has a failure that this version can run."""
    with contextlib.suppress(WorldgenError):
        return bool(Failure.read(path).label)
    return False


def _heading(corpus: Corpus, campaigns: Sequence[ReportedCampaign]) -> str:
    """Return ``turn-right under stepped``, or the number of controllers if there are several."""
    names = {(entry.facts.controller, entry.facts.motion) for entry in corpus.entries}
    names = names or {(one.summary.controller, one.summary.motion) for one in campaigns}
    if len(names) == 1:
        ((controller, motion),) = names
        return f"{controller} under {motion}"
    return f"Failures of {counted(len({controller for controller, _ in names}), 'controller')}"


def _failure(
    seen: ReplayedFailure, example: CauseResult | None, *, with_code: bool
) -> dict[str, Any]:
    """Return a failure as the page's script expects it.

    Args:
        seen: The failure, run again.
        example: The cause whose example it is.
        with_code: False to leave out what runs inside its controller.
    """
    failure = seen.failure
    world = failure.world
    record = failure.record
    diagnosis = diagnosis_of(failure)
    cause = diagnosis.cause
    campaign = seen.campaign
    is_same_robot = campaign is not None and campaign.summary.controller == record.controller
    return {
        "id": failure.digest[:_ID_DIGITS],
        "group": failure.group,
        "verdict": record.verdict,
        "controller": failure.label,
        "motion": record.motion,
        "solid": world.solid_cells,
        "size": f"{world.width} x {world.height}",
        "met": None if campaign is None else campaign.summary.met.get(failure.group),
        "strategy": str(record.details.get("found_by", "")),
        "confirmed": seen.replay.confirmed,
        "words": f"{record.verdict}{seen.words}",
        "reason": seen.replay.reason,
        "path": str(seen.path),
        "replay": failure.replay_command(seen.path),
        "explain": f"worldgen explain {shlex.quote(str(seen.path))}",
        "cause": cause.value,
        "sentence": "" if cause.is_vague else diagnosis.sentence(world),
        "advice": diagnosis.advice,
        "example": example is not None,
        "why": "" if example is None else example.why,
        **plain(_shown(seen, with_code=with_code)),
        "onMap": changes_on_map(world),
        "shrinking": failure.shrinking.value,
        "changed": campaign.change if campaign is not None and is_same_robot else "",
        "test": snippet(failure),
        "live": _live(seen),
        "tries": [] if example is None else _tries(example.changes, world),
        "groups": groups(seen),
        "now": _drawn(seen)
        | {"named": [] if example is None else named_cells(example.changes, world)},
        "before": None if seen.original is None else _drawn(seen.original),
    }


def _live(seen: ReplayedFailure) -> str | None:
    """Return what the page needs to judge changes of the world; ``None`` if it can judge nothing.

    That is the question for the core, the text of the file that an edited world is based on, and
    the controller's name for a test, as gzip of JSON in base64.
    """
    failure = seen.failure
    world = failure.world
    controller = None if seen.shown is None else CONTROLLERS.get(failure.record.controller)
    question = live_question(world, controller, None if controller is None else failure.options)
    if question["run"] is None and not has_live_proof(world):
        return None
    record = replace(failure.record, details={})
    source = replace(failure.stored, provenance=None, certificate=None, failure=record)
    label = failure.scenario.label(RunOptions.motion, RunOptions.time_step)
    table = {"question": question, "source": dumps(source).decode("utf-8"), "label": label}
    packed = gzip.compress(json.dumps(table, separators=(",", ":")).encode("utf-8"), mtime=0)
    return base64.b64encode(packed).decode("ascii")


def _tries(changes: Sequence[Change], world: World) -> list[tuple[str, dict[str, Any]]]:
    """Return the changes that the page's editor can make: in words, and with their values."""
    found: list[tuple[str, dict[str, Any]]] = []
    cells = named_cells(changes, world)
    for change in changes:
        match change:
            case Change("cell", [int(ix), int(iy)]) if (ix, iy) in cells:
                found.append((change.describe(), {"cell": [ix, iy]}))
            case Change("heading", int() | float()):
                found.append((change.describe(), {"heading": math.radians(change.value)}))
            case Change("radius", int() | float()):
                found.append((change.describe(), {"radius": change.value}))
    return found[:_MOST_TRIES]


def _add_reactions(reported: ReplayedFailure, to: Reactions) -> None:
    """Add a failure's runs, also as it was found, where the robot has more around it."""
    for seen in filter(None, (reported, reported.original)):
        world = seen.failure.world
        if seen.shown is not None and seen.shown.trace is not None and not world.is_fleet:
            to.add(world, seen.shown.trace)


def _shown(seen: ReplayedFailure, *, with_code: bool) -> RunFacts:
    if seen.shown is None:
        return RunFacts()
    return run_facts(seen.failure, seen.shown, with_code=with_code)


def _drawn(seen: ReplayedFailure) -> dict[str, Any]:
    """Return a world with its run and its file."""
    failure = seen.failure
    world = seen.failure.world
    run: dict[str, Any] = {"run": None}
    sensors = None
    if seen.shown is not None:
        controller = CONTROLLERS.get(failure.record.controller)
        run = drawn_robots(
            seen.shown,
            world.cell_size,
            seen.replay.episode,
            motion=failure.options.motion_model(),
            controller=controller,
        )
        sensors = sensors_of(controller, failure.options, world.cell_size)
    return {
        "name": seen.path.name,
        "file": base64.b64encode(seen.data).decode("ascii"),
        "size": f"{world.width} x {world.height}",
        "solid": world.solid_cells,
        "events": len(world.timeline),
        "world": drawn_world(failure.stored),
        **run,
        "sensors": sensors,
    }


def _campaign(campaign: ReportedCampaign) -> dict[str, Any]:
    """Return a campaign as the page's script expects it.

    A 64-bit seed becomes text, because JavaScript's numbers cannot hold it.
    """
    summary = campaign.summary
    return plain(summary) | {
        "folder": str(campaign.folder),
        "changed": campaign.change,
        "seed": str(summary.seed),
        "found": list(map(msgspec.structs.asdict, summary.found)),
        "archive": None if summary.archive is None else summary.archive.table(),
    }


def _page(title: str, data: dict[str, Any]) -> bytes:
    """Return the page with the report's text, style and scripts."""
    folder = files("fuzz.report") / "page"
    body = (folder / "body.html").read_text("utf-8")
    styles = (folder / "style.css").read_text("utf-8")
    scripts = modules(folder, "#report/")
    return one_file(
        body, title, styles=styles, scripts=scripts, start="#report/start.js", data=data, live=True
    )
