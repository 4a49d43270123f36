"""What a message of the page asks for, each as one call of the library. This runs in the processes of ``lanes``.

An answer is a table; parts of it that are there earlier are handed to ``part``.
"""

from __future__ import annotations

import base64
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path, PurePosixPath
from typing import Any

from fuzz.player import drawn_run, drawn_world, replay_page, sensors_of
from fuzz.player.streams import numbers
from fuzz.player.worlds import drawn_certificate
from fuzz.report.summary import MEMORY
from fuzz.studio.campaigns import CampaignAnswers
from fuzz.studio.catalogue import catalogue
from fuzz.studio.folder import Folder
from fuzz.studio.messages import field, message_of, restored, world_of
from fuzz.studio.walls import WallAnswers
from fuzz.telling import run_to_draw
from sim.controllers import CONTROLLERS
from sim.controllers.base import Controller
from sim.episode import Episode, simulate
from sim.picture import drive_of, trail_of
from sim.run_options import RunOptions, step_budget
from sim.scenario import Scenario
from sim.thesis_run import signal_in
from sim.words import evidence_in_words
from worldgen.difficulty import METRICS, measure, search_world
from worldgen.errors import FormatError, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files import check_output
from worldgen.generation import generate
from worldgen.grid_file import read_world, write_world
from worldgen.interop import FORMATS, export_world, import_world, readable_formats, write_export
from worldgen.reach import Decision, decide
from worldgen.reach.widest import widest_disc
from worldgen.render import draw_gif, draw_svg
from worldgen.timeline import Timeline
from worldgen.world import Cut, Value, Witness, World
from worldgen.world_files import is_world_file

__all__ = ["MOST_STEPS", "Answers"]

MOST_STEPS = 1_000_000  # of a run that is played: its recording takes 300 MB
_TRIES = 500  # worlds that a search for a wish makes at most, as on the command line
_KEPT_STEPS = 30_000  # of a run, in the page: more than a window has pixels
_MOST_ROBOTS = 6  # at once: more colours cannot be told apart
_PICTURES = ("gif", "svg", "html")
_MOST_FILE = 16 << 20  # bytes of a file that is dropped on the page

Message = Mapping[str, Any]
Part = Callable[[dict[str, Any]], None]


@dataclass(frozen=True)
class Answers(CampaignAnswers, WallAnswers):
    """Everything that can be asked for, by the names of the protocol.

    Args:
        folder: What can be read and written.
        named: Controllers that were named at the start, beside the registered ones.
    """

    folder: Folder
    named: Sequence[str] = ()

    def hello(self, message: Message, part: Part) -> dict[str, Any]:
        """What there is to choose from."""
        return catalogue(self.named)

    def files(self, message: Message, part: Part) -> dict[str, Any]:
        """What in the folder can be opened."""
        endings = tuple({ending for known in readable_formats() for ending in known.suffixes})
        return {"folder": str(self.folder.root), "files": self.folder.files(endings)}

    def open(self, message: Message, part: Part) -> dict[str, Any]:
        """A world of the folder."""
        return _opened(read_world(self.folder.place(field(message, "name", str))))

    def before(self, message: Message, part: Part) -> dict[str, Any]:
        """A failure of the folder as it was found, before shrinking; null where its campaign has not kept that."""
        path = self.folder.place(field(message, "name", str))
        shrunk = read_world(path)
        found = next(filter(None, (_found_in(shrunk, folder, self.folder.root) for folder in path.parents)), None)
        if found is None or found.failure is None:
            return {"before": None}
        who = found.failure.controller
        if who not in self.named and who not in CONTROLLERS.names():  # code of a file that nobody has named
            return {"before": None}
        episode, words = run_to_draw(found)
        options = RunOptions.of(found.failure.motion, found.failure.seed, found.failure.parameters)
        return {
            "before": {
                "words": f"{found.failure.verdict}{words}",
                "world": drawn_world(found),
                "run": drawn_run(episode, found.cell_size, most=_KEPT_STEPS),
                "sensors": sensors_of(CONTROLLERS.get(who), options, found.cell_size),
            }
        }

    def save(self, message: Message, part: Part) -> dict[str, Any]:
        """Writes a world into the folder; with the proof that is decided for it now, or its file's own."""
        place = self.folder.place(field(message, "name", str))
        force = field(message, "overwrite", bool)
        check_output(place, force)
        world = restored(field(message, "world", dict))
        if world.certificate is None:
            world = replace(world, certificate=decide(world).certificate)
        write_world(world, place, force=force)
        return {"name": place.relative_to(self.folder.root).as_posix(), **_opened(world)}

    def decide(self, message: Message, part: Part) -> dict[str, Any]:
        """Whether the target can be reached, with the way or the cut."""
        return _decided(world := world_of(field(message, "world", dict)), decide(world))

    def widest(self, message: Message, part: Part) -> dict[str, Any]:
        """The largest radius that could pass; null in a world that changes."""
        world = world_of(field(message, "world", dict))
        return {"widest": None if world.is_dynamic else widest_disc(world)}

    def signal(self, message: Message, part: Part) -> dict[str, Any]:
        """The signal that the thesis's robot reads, cell by cell; -2 in walls."""
        world = replace(world_of(field(message, "world", dict)), timeline=Timeline())
        return {"signal": numbers(signal_in(world, noise=field(message, "noise", bool)).ravel())}

    def generate(self, message: Message, part: Part) -> dict[str, Any]:
        """A world of a registered family; one that is searched for, if a difficulty or another wish is given."""
        family, seed = field(message, "family", str), field(message, "seed", str)
        if family not in FAMILIES.names():
            raise InvalidParameter(f"family {family[:40]!r} is not registered; choose one of the list")
        if not (seed.isascii() and seed.isdigit() and int(seed[:40]) < 1 << 64):
            raise InvalidParameter(f"seed={seed[:40]!r} is no whole number from 0 to 2**64 - 1; give one")
        parameters: dict[str, Value] = field(message, "parameters", dict)
        hard = None if message.get("difficulty") is None else field(message, "difficulty", float)
        where = None if message.get("where") is None else field(message, "where", str)
        if where is None and hard is None:
            return _opened(generate(family, int(seed), **parameters))
        tried = count(1)
        world = search_world(
            family,
            where,
            difficulty=hard,
            seed=int(seed),
            tries=_TRIES,
            progress=lambda _: part({"tried": next(tried), "of": _TRIES}),
            **parameters,
        )
        return _opened(world)

    def measure(self, message: Message, part: Part) -> dict[str, Any]:
        """How hard a world is, by every metric that has a meaning for it."""
        found = measure(restored(field(message, "world", dict))).as_dict()
        return {
            "metrics": [
                {"name": name, "value": found[name], "unit": metric.unit, "meaning": metric.meaning}
                for name, metric in METRICS.items()
                if name in found
            ]
        }

    def bring(self, message: Message, part: Part) -> dict[str, Any]:
        """A foreign map, of the folder or dropped on the page, with start and target placed where it has none."""
        known = _format_name(message)
        if "data" not in message:
            return _imported(self.folder.place(field(message, "name", str)), known)
        data = base64.b64decode(field(message, "data", str), validate=True)
        if len(data) > _MOST_FILE:
            raise InvalidParameter(
                f"{len(data)} bytes are more than the {_MOST_FILE} of a dropped file; put it into the folder"
            )
        with tempfile.TemporaryDirectory() as there:
            name = PurePosixPath(field(message, "name", str).replace("\\", "/")).name or "map"
            place = Folder(Path(there)).place(name.lstrip("."))
            place.write_bytes(data)
            try:
                plain = is_world_file(place.name) and known is None
                return _opened(read_world(place)) if plain else _imported(place, known)
            except FormatError as error:  # without the folder, which nobody has heard of
                raise FormatError(error.message, line=error.line, source=place.name) from error

    def export(self, message: Message, part: Part) -> dict[str, Any]:
        """A world in another program's format: for the browser to keep, or into the folder."""
        known = _format_name(message)
        if known is None:
            raise InvalidParameter("no format is named; choose one")
        world, place = restored(field(message, "world", dict)), self.folder.place(field(message, "name", str))
        export = export_world(world, known, file=place.name, at=0.0 if world.is_dynamic else None)
        said = {"lost": list(export.lost), "notes": list(export.notes)}
        if field(message, "keep", bool):
            written = write_export(export, place.parent, force=field(message, "overwrite", bool))
            return said | {"written": [path.relative_to(self.folder.root).as_posix() for path in written]}
        return said | {
            "files": [{"name": name, "data": base64.b64encode(data).decode()} for name, data in export.files.items()]
        }

    def run(self, message: Message, part: Part) -> dict[str, Any]:
        """Runs controllers in a world, one after the other; each is a part as soon as it is done."""
        world, labels = _to_run(message)
        part({"world": drawn_world(world)})
        for number, label in enumerate(labels):
            try:
                part({"number": number, **_seen(self._driven(world, label, message))})
            except InvalidParameter as error:
                part({"number": number, "name": str(label), "error": str(error)})
        return {}

    def picture(self, message: Message, part: Part) -> dict[str, Any]:
        """The same runs as a file: an animation of all, a drawing of one, a page that replays all."""
        world, labels = _to_run(message)
        kind, title, looked = field(message, "kind", str), field(message, "title", str), field(message, "looked", int)
        if kind not in _PICTURES or not 0 <= looked < len(labels):
            raise InvalidParameter(f"robot {looked} as {kind[:20]!r}; choose one that drove, as {', '.join(_PICTURES)}")
        drives = []
        for number, label in enumerate(labels):
            try:
                if kind != "svg" or number == looked:
                    drives.append(self._driven(world, label, message))
            except InvalidParameter:  # as the page said already
                if number == looked:
                    raise
        data = _as_file(kind, title, world, drives)
        return {"data": base64.b64encode(data).decode("ascii")}

    def _driven(self, world: World, label: object, message: Message) -> _Driven:
        scenario = self._scenario(label, message)
        steps = message.get("steps")
        budget = step_budget(world, scenario.time_step) if steps is None else field(message, "steps", int)
        options = scenario.options(world, min(max(budget, 1), MOST_STEPS))
        episode = simulate(world, scenario.controller, options, record=True)
        return _Driven(str(label), world, options, episode, CONTROLLERS.get(scenario.controller))

    def _scenario(self, label: object, message: Message) -> Scenario:
        """A controller that the page may run, with the options that it asks for."""
        if label not in self.named and label not in CONTROLLERS.names():
            raise InvalidParameter(
                f"controller {str(label)[:60]!r} was not named when the studio was started; start it with --controller"
            )
        seed = field(message, "seed", int)
        motion, time_step = field(message, "motion", str), field(message, "time_step", float)
        scenario = Scenario.parse(str(label), motion=motion, time_step=time_step, seed=seed)
        asked: dict[str, Value] = field(message, "options", dict)
        changed = scenario.thesis.changed() | scenario.robot.changed() | asked
        parameters: dict[str, Value] = {"time_step": scenario.time_step, **changed}
        return Scenario.of(scenario.controller, RunOptions.of(scenario.motion, seed, parameters))


@dataclass(frozen=True, eq=False)
class _Driven:
    """A run that was asked for."""

    name: str
    world: World
    options: RunOptions
    episode: Episode
    controller: Controller

    @property
    def words(self) -> str:
        return f"{self.episode.verdict}{evidence_in_words(self.episode)}"


def _found_in(shrunk: World, folder: Path, root: Path) -> World | None:
    """The failure that was shrunk, where a campaign of this folder, which must be in the opened one, has it."""
    name = shrunk.failure.details.get("original") if shrunk.failure else None
    if not isinstance(name, str) or not name.isalnum() or not folder.is_relative_to(root):
        return None
    path = Path(os.path.realpath(folder / MEMORY / "failures" / f"{name}.grid"))
    return read_world(path) if path.is_relative_to(root) and path.is_file() else None


def _to_run(message: Message) -> tuple[World, list[Any]]:
    """The world in which robots are to drive, with its proof, and their names."""
    world = restored(field(message, "world", dict))
    if message.get("still") is True:
        world = replace(world, timeline=Timeline(), certificate=None)
    labels = field(message, "controllers", list)
    if not 1 <= len(labels) <= _MOST_ROBOTS:
        raise InvalidParameter(f"{len(labels)} controllers; choose 1 to {_MOST_ROBOTS}")
    if world.certificate is None:
        world = replace(world, certificate=decide(world).certificate)
    return world, labels


def _seen(driven: _Driven) -> dict[str, Any]:
    """A run as the player wants it."""
    episode, side = driven.episode, driven.world.cell_size
    return {
        "name": driven.name,
        "verdict": episode.verdict,
        "words": driven.words,
        "steps": episode.steps,
        "time": episode.time,
        "path": episode.path_length,
        "collisions": episode.collisions,
        "digest": episode.trace_digest,
        "run": drawn_run(episode, side, most=_KEPT_STEPS),
        "sensors": sensors_of(driven.controller, driven.options, side),
    }


def _as_file(kind: str, title: str, world: World, drives: Sequence[_Driven]) -> bytes:
    """Runs as the bytes of a file; of several robots an SVG holds the first."""
    front = drives[0]
    if kind == "html":
        return replay_page(title, drawn_world(world), [_seen(driven) for driven in drives])
    said = f"{title}: {front.name}, {front.options.motion}: {front.words}" if len(drives) == 1 else title
    if kind == "gif":
        return draw_gif(world, [drive_of(driven.episode, world, driven.name) for driven in drives], title=said)
    return draw_svg(world, trail=trail_of(front.episode), title=said).encode()


def _format_name(message: Message) -> str | None:
    """The format that a message names: a registered one, for others are code of files."""
    name = message.get("format")
    if name is None or (isinstance(name, str) and name in FORMATS.names()):
        return name
    raise InvalidParameter(f"format {str(name)[:40]!r} is not registered; choose one of the list")


def _opened(world: World) -> dict[str, Any]:
    """A world with what its file says of it."""
    made, failure = world.provenance, world.failure
    return {
        "world": message_of(world),
        "made": None if made is None else f"{made.family}, version {made.version}, seed {made.seed}",
        "failure": None
        if failure is None
        else {
            "controller": failure.controller,
            "motion": failure.motion,
            "seed": failure.seed,
            "verdict": failure.verdict,
            "digest": failure.trace_digest,
            "parameters": dict(failure.parameters),
        },
    }


def _imported(place: Path, known: str | None) -> dict[str, Any]:
    imported = import_world(place, name=known)
    return _opened(imported.world) | {"notes": [*imported.notes, *imported.warnings]}


def _decided(world: World, decision: Decision) -> dict[str, Any]:
    proof = decision.certificate
    facts: dict[str, Any] = {}
    if isinstance(proof, Witness):
        facts = {"length": proof.length, "duration": proof.duration}
    if isinstance(proof, Witness | Cut):
        facts |= {"clearance": proof.clearance, **drawn_certificate(replace(world, certificate=proof))}
    return {"result": decision.result, "reason": decision.reason, **facts}
