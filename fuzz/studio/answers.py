"""Answer the page's messages, each by one call of the library.

This runs in the processes of ``workers``. An answer is a table; parts of it that are ready earlier
are passed to ``part``.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY
from fuzz.failure import Failure
from fuzz.overview.describe import run_to_draw
from fuzz.player import drawn_robots, drawn_world, replay_page, sensors_of
from fuzz.player.streams import numbers
from fuzz.player.worlds import drawn_certificate, drawn_others
from fuzz.studio.campaigns.answers import CampaignAnswers
from fuzz.studio.catalogue import catalogue
from fuzz.studio.comparing import CompareAnswers
from fuzz.studio.driving import HandDriven
from fuzz.studio.exchange import ExchangeAnswers
from fuzz.studio.gallery import WallAnswers
from fuzz.studio.requests.folder import digest_of
from fuzz.studio.requests.limits import MOST_ROBOTS, MOST_STEPS
from fuzz.studio.requests.messages import (
    Request,
    SendPart,
    field,
    message_of,
    opened_message,
    restored,
    seed_of,
    world_of,
)
from fuzz.studio.requests.running import chart_message, check_record, check_registered, scenario_of
from sim.controllers import CONTROLLERS
from sim.controllers.base import Controller
from sim.controllers.behaviours.arbitration import Arbitration
from sim.drawing.picture import drive_of, trails_of
from sim.episode import Episode, simulate
from sim.episode.describe import describe_evidence, describe_unreachable
from sim.evidence import FaultEvidence
from sim.motion import MOTIONS, THESIS
from sim.options.run import RunOptions, step_budget
from sim.thesis.run import signal_in
from sim.verdict import UNENDED
from worldgen.difficulty import METRICS, measure, search_world
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.errors import InvalidParameter, OutputError
from worldgen.families.builtin.shift import shifted
from worldgen.family import FAMILIES
from worldgen.files.grid import read_world, write_world
from worldgen.files.whole import check_output
from worldgen.files.worlds import is_world_file, read_whole_world
from worldgen.generation import generate
from worldgen.interop import readable_formats
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, Decision, check_certificate, decide
from worldgen.render import draw_gif, draw_svg
from worldgen.timeline import Timeline
from worldgen.world import Cut, JointWitness, Value, Witness, World

_TRIES = 500  # most worlds that a search generates, as on the command line
_KEPT_STEPS = 30_000  # steps of a run that the page receives: more than a window has pixels
_PREVIEW_SIDE = 24  # cells per side in a preview of a family: enough to recognise it
_PREVIEW_SEED = 1
_PICTURES = ("gif", "svg", "html")


@dataclass(frozen=True)
class Answers(CampaignAnswers, CompareAnswers, ExchangeAnswers, WallAnswers):
    """All answers, by the names of the protocol."""

    def hello(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return everything that the page offers as a choice."""
        return catalogue(self.named, part)

    def files(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the files in the folder that can be opened."""
        endings = tuple({ending for known in readable_formats() for ending in known.suffixes})
        return {"folder": str(self.folder.root), "files": self.folder.files(endings)}

    def open(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return a world of the folder."""
        place = self.folder.place(field(message, "name", str))
        world = read_whole_world(place)  # first, because it reports any fault in the file
        return {"file": digest_of(place) if place.is_file() else None, **opened_message(world)}

    def before(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the original of a failure in the folder, before shrinking.

        Null if its campaign has not kept it.
        """
        path = self.folder.place(field(message, "name", str))
        shrunk = Failure.found_in(read_world(path))
        # The original is in the campaign store of a folder above it.
        places = () if shrunk is None or shrunk.original is None else path.parents
        found = next(
            filter(None, (_found_in(shrunk, folder, self.folder.root) for folder in places)), None
        )
        if found is None:
            return {"before": None}
        # Without permission to run the controller, there is nothing to show.
        try:
            check_record(found.record, self.named)
        except InvalidParameter:
            return {"before": None}
        episode, words = run_to_draw(found)
        who = CONTROLLERS.get(found.record.controller)
        side = found.world.cell_size
        return {
            "before": {
                "words": f"{found.verdict}{words}",
                "world": drawn_world(found.stored),
                **drawn_robots(
                    episode,
                    side,
                    motion=found.options.motion_model(),
                    most=_KEPT_STEPS,
                    controller=who,
                ),
                "sensors": sensors_of(who, found.options, side),
            }
        }

    def save(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Write a world to the folder, with its file's proof or else a new one."""
        place = self.folder.place(field(message, "name", str))
        if not is_world_file(place.name):
            raise InvalidParameter(
                "wrong-suffix",
                "{name!r} is not the name of a world",
                "choose a name that ends in .grid",
                name=place.name,
            )
        force = field(message, "overwrite", bool)
        # A file may be replaced without asking if it has not changed since it was opened.
        replaces = message.get("replaces")
        if not force and isinstance(replaces, str) and place.is_file():
            if digest_of(place) != replaces:
                raise OutputError(
                    "file-changed",
                    "{name} has changed since it was opened",
                    "overwrite it, or choose another name",
                    name=place.name,
                )
            force = True
        check_output(place, force)
        self.folder.check_replaceable(place)
        world = restored(field(message, "world", dict))
        if world.certificate is None:
            world = replace(world, certificate=decide(world).certificate)
        write_world(world, place, force=force)
        name = place.relative_to(self.folder.root).as_posix()
        return {"name": name, "file": digest_of(place), **opened_message(world)}

    def decide(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Decide if the target can be reached, and return the witness or the cut."""
        world = restored(field(message, "world", dict))
        return _decided(world, _decision(world))

    def widest(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the largest radius that fits through; null in a world with events."""
        world = world_of(field(message, "world", dict))
        return {"widest": None if world.is_dynamic else bottleneck(world, world.walls)}

    def signal(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the signal that the thesis's robot reads, cell by cell; -2 in walls."""
        world = replace(world_of(field(message, "world", dict)), timeline=Timeline())
        return {"signal": numbers(signal_in(world, noise=field(message, "noise", bool)).ravel())}

    def generate(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return a world of a registered family.

        If a difficulty or a condition is given, search for a world that meets it.
        """
        family = field(message, "family", str)
        seed = seed_of(message)
        check_registered("family", family, FAMILIES.names())
        parameters: dict[str, Value] = {
            name: self.folder.file_in_option(value, FAMILIES.names())
            if isinstance(value, str)
            else value
            for name, value in field(message, "parameters", dict).items()
        }
        # Refuse anything else, because the search would treat it as an argument.
        FAMILIES.get(family).complete(parameters)
        hard = None if message.get("difficulty") is None else field(message, "difficulty", float)
        where = None if message.get("where") is None else field(message, "where", str)
        if where is None and hard is None:
            return opened_message(generate(family, seed, **parameters))
        tried = count(1)
        world = search_world(
            family,
            where,
            difficulty=hard,
            seed=seed,
            tries=_TRIES,
            progress=lambda _: part({"tried": next(tried), "of": _TRIES}),
            **parameters,
        )
        return opened_message(world)

    def preview(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return a small world of a registered family, as an example of its worlds."""
        family = field(message, "family", str)
        check_registered("family", family, FAMILIES.names())
        known = {parameter.name for parameter in FAMILIES.get(family).parameters}
        small: dict[str, Value] = {"size": _PREVIEW_SIDE} if "size" in known else {}
        return {"world": drawn_world(generate(family, _PREVIEW_SEED, **small))}

    def shift(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the world with walls that move from time to time, as in the thesis's simulator."""
        return {
            "world": message_of(shifted(world_of(field(message, "world", dict)), seed_of(message)))
        }

    def measure(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the difficulty of a world by every applicable metric."""
        found = measure(restored(field(message, "world", dict))).as_dict()
        return {
            "metrics": [
                {"name": name, "value": found[name], "unit": metric.unit, "meaning": metric.meaning}
                for name, metric in METRICS.items()
                if name in found
            ]
        }

    def run(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Run controllers in a world, one after another; each result is a part."""
        world, labels, impossible = _to_run(message)
        part({"world": drawn_world(world), "impossible": impossible})
        for number, label in enumerate(labels):
            try:
                driven = self._driven(world, label, message)
                chart = chart_message(driven.arbitration)
                part({"number": number, **_seen(driven), "arbitration": chart})
            except InvalidParameter as error:
                part({"number": number, "name": str(label), "error": self.folder.refusal(error)})
        return {}

    def drive(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Run a robot by the user's commands from the start; ``ended`` if the world ended the run.

        The page asks again with more commands, several times a second. That is simple, and the run
        is as exact and as repeatable as any other.
        """
        world = restored(field(message, "world", dict))
        if world.is_fleet:
            raise InvalidParameter(
                "world-of-several-robots",
                "you can drive only in worlds with one robot; this one has {robots}",
                "open a world of one robot",
                robots=len(world.robots),
            )
        driver = HandDriven.of(field(message, "commands", list))
        motion = field(message, "motion", str)
        check_registered("motion", motion, MOTIONS.names())
        changed: dict[str, Value] = field(message, "options", dict)
        # The thesis's model drives only the thesis's robots.
        if MOTIONS.get(motion).kernel == THESIS:
            motion = "swept"
            changed = {}
        time_step = field(message, "time_step", float)
        parameters: dict[str, Value] = {**changed, "time_step": time_step, "steps": driver.steps}
        options = RunOptions.of(motion, field(message, "seed", int), parameters)
        if message.get("still") is True:
            world = replace(world, timeline=Timeline(), certificate=None)
        episode = simulate(world, driver, options, record=True)
        ended = episode.verdict not in UNENDED
        seen = _seen(_Driven("you", world, options, episode, driver))
        # The user is still driving, so there is no verdict yet.
        if not ended:
            seen |= {"verdict": "still driving", "why": ""}
        return {**seen, "motion": motion, "ended": ended}

    def check(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Check that a controller may run under this name with its options."""
        CONTROLLERS.get(scenario_of(field(message, "controller", str), message, self).controller)
        return {}

    def picture(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Return the same runs as a file: an animation, a drawing of one, or a replay page."""
        world, labels, _ = _to_run(message)
        kind = field(message, "kind", str)
        title = field(message, "title", str)
        looked = field(message, "looked", int)
        if kind not in _PICTURES or not 0 <= looked < len(labels):
            raise InvalidParameter(
                "unknown-name",
                "robot {robot} as {kind!r}",
                "choose a robot that ran, and one of {known!l}",
                robot=looked,
                kind=kind[:20],
                known=list(_PICTURES),
            )
        drives = []
        for number, label in enumerate(labels):
            try:
                if kind != "svg" or number == looked:
                    drives.append(self._driven(world, label, message))
            except InvalidParameter:  # the page has already shown this error
                if number == looked:
                    raise
        data = _as_file(kind, title, world, drives)
        return {"data": base64.b64encode(data).decode("ascii")}

    def _driven(self, world: World, label: object, message: Request) -> _Driven:
        scenario = scenario_of(label, message, self)
        steps = message.get("steps")
        budget = step_budget(world, scenario.run) if steps is None else field(message, "steps", int)
        options = scenario.options(world, min(max(budget, 1), MOST_STEPS))
        episode = simulate(world, scenario.controller, options, record=True, lean=True)
        controller = CONTROLLERS.get(scenario.controller)
        return _Driven(str(label), world, options, episode, controller, scenario.arbitration)


@dataclass(frozen=True, eq=False)
class _Driven:
    """A run that the page requested."""

    name: str
    world: World
    options: RunOptions
    episode: Episode
    controller: Controller
    arbitration: Arbitration | None = None

    @property
    def reason(self) -> str:
        """The evidence for the verdict, in words; empty if the robot arrived."""
        return describe_evidence(self.episode).strip()

    @property
    def frames(self) -> list[dict[str, Any]]:
        """The place where the controller crashed; empty if it did not."""
        evidence = self.episode.evidence
        found = evidence.frames if isinstance(evidence, FaultEvidence) else None
        return [dict(frame) for frame in found or ()]


def _found_in(shrunk: Failure | None, folder: Path, root: Path) -> Failure | None:
    """Return the original of a shrunk failure, if a campaign in this folder has it.

    The folder must be inside the opened one.
    """
    if shrunk is None or not folder.is_relative_to(root):
        return None
    path = Path(os.path.realpath(folder / MEMORY / "failures" / f"{shrunk.original}.grid"))
    return (
        Failure.found_in(read_world(path)) if path.is_relative_to(root) and path.is_file() else None
    )


def _decision(world: World) -> Decision:
    """Decide a world, unless it has several robots and its file has a valid proof."""
    proof = world.certificate
    # Deciding for many robots takes long; checking their paths does not.
    if not world.is_fleet or proof is None:
        return decide(world)
    report = check_certificate(world)
    if not report.valid:
        return decide(world)
    return Decision(BLOCKED if isinstance(proof, Cut) else REACHABLE, proof, report.reason)


def _to_run(message: Request) -> tuple[World, list[Any], str]:
    """Return the world to run robots in, with its proof, and their names.

    The last is a sentence if it is impossible or undecided that all robots arrive, else empty.
    """
    world = restored(field(message, "world", dict))
    if message.get("still") is True:
        world = replace(world, timeline=Timeline(), certificate=None)
    labels = field(message, "controllers", list)
    if not 1 <= len(labels) <= MOST_ROBOTS:
        raise InvalidParameter(
            "out-of-range",
            "{count} controllers",
            "choose 1 to {most}",
            count=len(labels),
            most=MOST_ROBOTS,
        )
    result = BLOCKED if isinstance(world.certificate, Cut) else REACHABLE
    proof = "cut"
    if world.certificate is None:
        decision = decide(world)
        world = replace(world, certificate=decision.certificate)
        result = decision.result
        proof = "cut" if decision.swap is None else "swap"
    if result == REACHABLE:
        return world, labels, ""
    undecided = result == UNDECIDED
    return world, labels, describe_unreachable(world, undecided=undecided, proof=proof)


def _seen(driven: _Driven) -> dict[str, Any]:
    """Return a run in the form that the player takes."""
    episode = driven.episode
    side = driven.world.cell_size
    drawn = drawn_robots(
        episode,
        side,
        motion=driven.options.motion_model(),
        most=_KEPT_STEPS,
        controller=driven.controller,
    )
    return {
        "name": driven.name,
        "verdict": episode.verdict,
        "why": driven.reason,
        "frames": driven.frames,
        "steps": episode.steps,
        "time": episode.time,
        "path": episode.path_length,
        "collisions": episode.collisions,
        "digest": episode.trace_digest,
        "run": drawn["run"],
        "others": drawn.get("others", []),
        "sensors": sensors_of(driven.controller, driven.options, side),
    }


def _as_file(kind: str, title: str, world: World, drives: Sequence[_Driven]) -> bytes:
    """Return runs as the bytes of a file; an SVG shows only the first robot."""
    front = drives[0]
    if kind == "html":
        return replay_page(title, drawn_world(world), [_seen(driven) for driven in drives])
    ending = f"{front.episode.verdict} {front.reason}".rstrip()
    said = f"{title}: {front.name}, {front.options.motion}: {ending}" if len(drives) == 1 else title
    if kind == "gif":
        return draw_gif(
            world, [drive_of(driven.episode, world, driven.name) for driven in drives], title=said
        )
    return draw_svg(world, trail=trails_of(front.episode, world), title=said).encode()


def _decided(world: World, decision: Decision) -> dict[str, Any]:
    proof = decision.certificate
    facts: dict[str, Any] = {}
    if isinstance(proof, Witness | JointWitness):
        facts = {"length": proof.length, "duration": proof.duration}
    if proof is not None:
        facts |= {
            "clearance": proof.clearance,
            **drawn_certificate(replace(world, certificate=proof)),
        }
    if isinstance(proof, JointWitness):
        facts["others"] = drawn_others(replace(world, certificate=proof))
    # With several robots, the reason names the one that the ring stops.
    if isinstance(proof, Cut) and not world.is_fleet and len(proof.cells) > 1:
        facts["ring"] = len(proof.cells)
    return {"result": decision.result, "reason": decision.reason, **facts}
