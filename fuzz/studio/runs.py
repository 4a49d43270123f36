"""Answer requests that run robots in the world on the board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY
from fuzz.failure import Failure
from fuzz.overview.describe import run_to_draw
from fuzz.player import drawn_robots, drawn_world, replay_page, sensors_of
from fuzz.studio.driving import HandDriven
from fuzz.studio.requests.folder import Opened, answer
from fuzz.studio.requests.limits import MOST_STEPS
from fuzz.studio.requests.messages import restored
from fuzz.studio.requests.protocol import (
    Before,
    Check,
    Drive,
    DrivenRobot,
    FoundRun,
    Picture,
    RanRobot,
    RobotFault,
    Run,
    RunBegins,
    RunRequest,
    SendPart,
)
from fuzz.studio.requests.running import chart_message, check_record, check_registered, scenario_of
from sim.controllers import CONTROLLERS
from sim.controllers.base import Controller
from sim.controllers.behaviours.arbitration import Arbitration
from sim.drawing.picture import drive_of, drives_of, trails_of
from sim.episode import Episode, simulate
from sim.episode.describe import describe_evidence, describe_unreachable
from sim.evidence import FaultEvidence
from sim.motion import MOTIONS
from sim.options.run import RunOptions, step_budget
from sim.verdict import UNENDED
from worldgen.errors import InvalidParameter
from worldgen.files.grid import read_world
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, decide
from worldgen.render import draw_gif, draw_svg
from worldgen.support.paths import real_path
from worldgen.timeline import Timeline
from worldgen.world import Cut, Value, World

_KEPT_STEPS = 30_000  # steps of a run that the page receives: more than a window has pixels


@answer.register
def _run(request: Run, opened: Opened, part: SendPart[RunBegins | RanRobot | RobotFault]) -> None:
    world, impossible = _to_run(request)
    part(RunBegins(drawn_world(world), impossible))
    for number, label in enumerate(request.controllers):
        try:
            driven = _driven(world, label, request, opened)
            chart = chart_message(driven.arbitration)
            part(RanRobot(number=number, arbitration=chart, **_seen(driven)))
        except InvalidParameter as error:
            part(RobotFault(number, label, opened.folder.refusal(error)))


@answer.register
def _drive(request: Drive, opened: Opened, part: object) -> DrivenRobot:
    world = restored(request.world)
    if world.is_fleet:
        raise InvalidParameter(
            "world-of-several-robots",
            "you can drive only in worlds with one robot; this one has {robots}",
            "open a world of one robot",
            robots=len(world.robots),
        )
    driver = HandDriven.of(request.commands)
    motion = request.motion
    check_registered("motion", motion, MOTIONS.names())
    options: dict[str, Value] = request.options
    # The thesis's model drives only the thesis's robots.
    if not MOTIONS.get(motion).on_lattice:
        motion = "swept"
        options = {}
    parameters = {**options, "time_step": request.time_step, "steps": driver.steps}
    settings = RunOptions.of(motion, request.seed, parameters)
    if request.still:
        world = replace(world, timeline=Timeline(), certificate=None)
    episode = simulate(world, driver, settings, record=True)
    ended = episode.verdict not in UNENDED
    seen = _seen(_Driven("you", world, settings, episode, driver))
    # The user is still driving, so there is no verdict yet.
    if not ended:
        seen |= {"verdict": "still driving", "why": ""}
    return DrivenRobot(motion=motion, ended=ended, **seen)


@answer.register
def _check(request: Check, opened: Opened, part: object) -> None:
    CONTROLLERS.get(scenario_of(request.controller, request, opened).controller)


@answer.register
def _picture(request: Picture, opened: Opened, part: object) -> bytes:
    world, _ = _to_run(request)
    if request.looked >= len(request.controllers):
        raise InvalidParameter(
            "unknown-name",
            "robot {robot} did not run",
            "choose a robot that ran",
            robot=request.looked,
        )
    drives = []
    for number, label in enumerate(request.controllers):
        try:
            if request.kind != "svg" or number == request.looked:
                drives.append(_driven(world, label, request, opened))
        except InvalidParameter:  # the page has already shown this error
            if number == request.looked:
                raise
    return _as_file(request.kind, request.title, world, drives)


@answer.register
def _before(request: Before, opened: Opened, part: object) -> FoundRun | None:
    path = opened.folder.place(request.name)
    shrunk = Failure.found_in(read_world(path))
    found = _original(shrunk, path, opened.folder.root)
    if found is None:
        return None
    # Without permission to run the controller, there is nothing to show.
    try:
        check_record(found.record, opened.named)
    except InvalidParameter:
        return None
    episode, words = run_to_draw(found)
    who = CONTROLLERS.get(found.record.controller)
    side = found.world.cell_size
    drawn = drawn_robots(
        episode, side, motion=found.options.motion_model(), most=_KEPT_STEPS, controller=who
    )
    return FoundRun(
        f"{found.verdict}{words}",
        drawn_world(found.stored),
        sensors_of(who, found.options, side),
        **drawn,
    )


def _original(shrunk: Failure | None, path: Path, root: Path) -> Failure | None:
    """Return the original of a shrunk failure, if a campaign above its file has it.

    The campaign's folder must be inside the opened one.
    """
    if shrunk is None or shrunk.original is None:
        return None
    for folder in path.parents:
        file = real_path(folder / MEMORY / "failures" / f"{shrunk.original}.grid")
        if folder.is_relative_to(root) and file.is_relative_to(root) and file.is_file():
            return Failure.found_in(read_world(file))
    return None


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


def _driven(world: World, label: str, request: RunRequest, opened: Opened) -> _Driven:
    scenario = scenario_of(label, request, opened)
    budget = step_budget(world, scenario.run) if request.steps is None else request.steps
    options = scenario.options(world, min(max(budget, 1), MOST_STEPS))
    episode = simulate(world, scenario.controller, options, record=True, lean=True)
    controller = CONTROLLERS.get(scenario.controller)
    return _Driven(label, world, options, episode, controller, scenario.arbitration)


def _to_run(request: Run | Picture) -> tuple[World, str]:
    """Return the world to run robots in, with its proof.

    The second is a sentence if it is impossible or undecided that all robots arrive, else empty.
    """
    world = restored(request.world)
    if request.still:
        world = replace(world, timeline=Timeline(), certificate=None)
    result = BLOCKED if isinstance(world.certificate, Cut) else REACHABLE
    proof = "cut"
    if world.certificate is None:
        decision = decide(world)
        world = replace(world, certificate=decision.certificate)
        result = decision.result
        proof = "cut" if decision.swap is None else "swap"
    if result == REACHABLE:
        return world, ""
    return world, describe_unreachable(world, undecided=result == UNDECIDED, proof=proof)


def _seen(driven: _Driven) -> dict[str, Any]:
    """Return the fields of a run's ``RobotMessage``."""
    episode = driven.episode
    side = driven.world.cell_size
    drawn = drawn_robots(
        episode,
        side,
        motion=driven.options.motion_model(),
        most=_KEPT_STEPS,
        controller=driven.controller,
    )
    evidence = episode.evidence
    frames = evidence.frames if isinstance(evidence, FaultEvidence) else None
    return {
        "name": driven.name,
        "verdict": episode.verdict,
        "why": driven.reason,
        "frames": [dict(frame) for frame in frames or ()],
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
    """Return runs as the bytes of a file, which names every robot and its verdict."""
    front = drives[0]
    if kind == "html":
        return replay_page(title, drawn_world(world), [_seen(driven) for driven in drives])
    ending = f"{front.episode.verdict} {front.reason}".rstrip()
    said = f"{title}: {front.name}, {front.options.motion}: {ending}" if len(drives) == 1 else title
    # The robots of one world are all driven by one controller, and each has its own verdict.
    if world.is_fleet:
        if kind == "gif":
            return draw_gif(world, drives_of(front.episode, world), title=said)
        return draw_svg(world, trail=trails_of(front.episode, world), title=said).encode()
    names = [f"{driven.name}: {driven.episode.verdict}" for driven in drives]
    if kind == "gif":
        shown = zip(drives, names, strict=True)
        driven = [drive_of(one.episode, world, name) for one, name in shown]
        return draw_gif(world, driven, title=said)
    trails = [
        replace(trail, name=name)
        for one, name in zip(drives, names, strict=True)
        for trail in trails_of(one.episode, world)
    ]
    return draw_svg(world, trail=trails, title=said).encode()
