"""Draw failures, each with the robot's path if its controller can be run."""

from __future__ import annotations

from collections.abc import Sequence

from fuzz.corpus.entry import CorpusEntry
from fuzz.failure import Failure
from fuzz.triage.diagnosis import diagnosis_of
from sim.controllers.programs.process import is_process_name
from sim.drawing.picture import trails_of
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.render import draw_png
from worldgen.render.overlay import Trail
from worldgen.render.sheet import Panel, draw_sheet

_PIXELS = 480  # longer side of a map; at 900 a picture takes 250 kB
_MOST = 200  # panels: a sheet of five columns is then 16,000 px high


def draw_failure(entry: CorpusEntry, failure: Failure) -> bytes:
    """Return a picture of a failure as the bytes of a PNG file."""
    facts = entry.facts
    title = f"{facts.controller}, {facts.motion}: {facts.group}"
    return draw_png(failure.stored, trail=_trails(failure), title=title, pixels=_PIXELS)


def contact_sheet(entries: Sequence[CorpusEntry]) -> bytes:
    """Return a picture of several failures side by side, as the bytes of a PNG file.

    Raises:
        InvalidParameter: If there are none, or more than fit on a sheet.
        FormatError: If a file can no longer be read.
    """
    if not entries:
        raise InvalidParameter(
            "nothing-given", "there is no failure to draw", "check the path and the filters"
        )
    if len(entries) > _MOST:
        raise InvalidParameter(
            "too-many",
            "{count} failures are more than the {most} that fit on a sheet",
            "select some with --only cause=...",
            at_terminal=True,
            count=len(entries),
            most=_MOST,
        )
    return draw_sheet([_panel(entry) for entry in entries], ())


def _panel(entry: CorpusEntry) -> Panel:
    failure = Failure.read(entry.path)
    facts = entry.facts
    name = (
        facts.controller
        if is_process_name(facts.controller)
        else facts.controller.rpartition("/")[2]
    )
    trails = tuple(_trails(failure))
    diagnosis = diagnosis_of(failure)
    return Panel(
        failure.stored,
        facts.group,
        trails,
        (f"{name}, {facts.motion}",),
        "" if diagnosis.cause.is_vague else diagnosis.sentence(failure.world),
    )


def _trails(failure: Failure) -> list[Trail]:
    """Return the robots' current paths; none if their controller cannot be run."""
    try:
        return trails_of(failure.run(through_walls=failure.is_breach), failure.world)
    except WorldgenError:
        return []
