"""Puts the page together: its text, style and script from ``page/``, the player's, and the data as JSON."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from typing import Any

from fuzz.corpus import Entry
from fuzz.player import drawn_run, drawn_world, one_file, sensors_of
from fuzz.report.gather import Seen, Subject, gather, look_at
from fuzz.report.numbers import groups
from fuzz.report.summary import Summary
from fuzz.telling import replay_line
from sim.controllers import CONTROLLERS
from sim.run_options import RunOptions
from worldgen.errors import FormatError
from worldgen.files import check_output, write_bytes
from worldgen.plain_text import counted
from worldgen.world import FailureRecord

__all__ = ["write_report"]

_ID_DIGITS = 12  # hex, of a failure's digest: its address in the page


def write_report(
    paths: Sequence[Path],
    out: Path,
    *,
    title: str = "",
    force: bool = False,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> int:
    """Writes failures and their campaigns as one HTML page; equal files by equal names give equal bytes.

    Runs the controllers that the files name.

    Args:
        paths: Folders, archives and files of failures; of a campaign's folder its summary is shown, too.
        out: The page.
        title: Its heading; without one, who fails under which motion model.
        force: Whether a file that is there is overwritten.
        progress: Called with the number of failures that are done, and of all.

    Returns:
        How many failures the page shows.

    Raises:
        InvalidParameter: If there is nothing to report on, or too much.
        FormatError: If a path or a file cannot be read.
        OutputError: If the page is there already or cannot be written.
    """
    check_output(out, force)
    subject = gather(paths)
    failures = []
    for done, entry in enumerate(subject.entries):
        progress(done, len(subject.entries))
        failures.append(_failure(entry, subject.campaigns))
    heading = title or _heading(subject)
    data = {
        "title": heading,
        "failures": failures,
        "campaigns": [_campaign(summary) for summary in subject.campaigns],
        "others": subject.others,
    }
    write_bytes(out, _page(heading, data), force=force)
    return len(failures)


def _heading(subject: Subject) -> str:
    """``turn-right under stepped``, or how many controllers there are."""
    names = {(entry.facts.controller, entry.facts.motion) for entry in subject.entries}
    names |= {(summary.controller, summary.motion) for summary in subject.campaigns if not subject.entries}
    if len(names) == 1:
        ((controller, motion),) = names
        return f"{controller} under {motion}"
    return f"Failures of {counted(len({controller for controller, _ in names}), 'controller')}"


def _failure(entry: Entry, campaigns: list[Summary]) -> dict[str, Any]:
    """A failure as the page's script wants it."""
    failure = look_at(entry, campaigns)
    seen, facts, record = failure.seen, entry.facts, failure.seen.world.failure
    if record is None:
        raise FormatError(
            "file-changed", "held a failure a moment ago", "do not change it meanwhile", source=str(entry.path)
        )
    met = campaigns[failure.campaign].met.get(facts.kind) if failure.campaign >= 0 else None
    return {
        "id": facts.digest[:_ID_DIGITS],
        "kind": facts.kind,
        "verdict": facts.verdict,
        "controller": facts.controller,
        "motion": facts.motion,
        "solid": facts.solid,
        "size": f"{facts.width} x {facts.height}",
        "cells": facts.width * facts.height,
        "met": met,
        "lane": str(record.details.get("found_by", "")),
        "campaign": failure.campaign,
        "confirmed": seen.replay.confirmed,
        "words": f"{record.verdict}{seen.words}",
        "reason": seen.replay.reason,
        "path": str(entry.path),
        "replay": replay_line(entry.path),
        "groups": groups(failure, record, campaigns),
        "now": _drawn(seen, record),
        "before": None if failure.original is None else _drawn(failure.original, failure.original.world.failure),
    }


def _drawn(seen: Seen, record: FailureRecord | None) -> dict[str, Any]:
    """A world with its run and its file."""
    world = seen.world
    return {
        "name": seen.name,
        "file": base64.b64encode(seen.data).decode("ascii"),
        "size": f"{world.width} x {world.height}",
        "solid": world.solid_cells,
        "events": len(world.timeline),
        "kind": str(record.details.get("class", record.verdict)) if record else "",
        "world": drawn_world(world),
        "run": _run(seen, record),
        "sensors": _sensors(record, world.cell_size) if record and seen.shown is not None else None,
    }


def _run(seen: Seen, record: FailureRecord | None) -> dict[str, Any] | None:
    """The run, with its controller's memory."""
    if seen.shown is None:
        return None
    controller = CONTROLLERS.get(record.controller) if record else None
    return drawn_run(seen.shown, seen.world.cell_size, seen.replay.episode, controller=controller)


def _sensors(record: FailureRecord, side: float) -> dict[str, Any]:
    """What of the robot's sensors is drawn."""
    options = RunOptions.of(record.motion, record.seed, record.parameters)
    return sensors_of(CONTROLLERS.get(record.controller), options, side)


def _campaign(summary: Summary) -> dict[str, Any]:
    """As the page's script wants it: a seed of 64 bits as text, which JavaScript's numbers cannot hold."""
    return asdict(summary) | {"folder": str(summary.folder), "seed": str(summary.seed)}


def _page(title: str, data: dict[str, Any]) -> bytes:
    """The page with the report's own text, style and script."""
    folder = files("fuzz.report") / "page"
    names = sorted(part.name for part in folder.iterdir() if part.name.endswith(".js"))  # start.js comes last
    scripts = "\n".join((folder / name).read_text("utf-8") for name in names)
    body, styles = ((folder / name).read_text("utf-8") for name in ("body.html", "style.css"))
    return one_file(body, title, styles=styles, scripts=scripts, data=data)
