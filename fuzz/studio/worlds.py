"""Answer requests about the world on the board, and about files of worlds."""

from __future__ import annotations

from dataclasses import replace
from itertools import count

from fuzz.player import drawn_world
from fuzz.player.streams import numbers
from fuzz.player.worlds import drawn_certificate, drawn_others
from fuzz.studio.requests.folder import Opened, answer, digest_of
from fuzz.studio.requests.messages import message_of, opened_message, restored, world_of
from fuzz.studio.requests.protocol import (
    Decide,
    DrawnWorld,
    Files,
    Generate,
    Goal,
    ListedFile,
    Measure,
    Metric,
    Open,
    OpenedMessage,
    Preview,
    Progress,
    ProofMessage,
    Save,
    SendPart,
    Shift,
    Signal,
    Widest,
    WorldMessage,
)
from fuzz.studio.requests.running import check_registered
from sim.thesis.run import signal_in
from worldgen.difficulty import METRICS, measure, search_world
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.errors import InvalidParameter, OutputError
from worldgen.families.builtin.shift import shifted
from worldgen.family import FAMILIES
from worldgen.files.grid import write_world
from worldgen.files.whole import check_output
from worldgen.files.worlds import is_world_file, read_whole_world
from worldgen.generation import generate
from worldgen.interop import readable_formats
from worldgen.reach import BLOCKED, REACHABLE, Decision, check_certificate, decide
from worldgen.robot import DEFAULT_ROBOT_RADIUS
from worldgen.robot_overrides import RobotOverrides
from worldgen.timeline import Timeline
from worldgen.world import Cut, JointWitness, Target, Value, World

_TRIES = 500  # most worlds that a search generates, as on the command line
_PREVIEW_SIDE = 24  # cells per side in a preview of a family: enough to recognise it
_PREVIEW_SEED = 1


@answer.register
def _files(request: Files, opened: Opened, part: object) -> list[ListedFile]:
    endings = tuple({ending for known in readable_formats() for ending in known.suffixes})
    return opened.folder.files(endings)


@answer.register
def _open_world(request: Open, opened: Opened, part: object) -> OpenedMessage:
    place = opened.folder.place(request.name)
    world = read_whole_world(place)  # first, because it reports any fault in the file
    return opened_message(world, file=digest_of(place) if place.is_file() else None)


@answer.register
def _save(request: Save, opened: Opened, part: object) -> OpenedMessage:
    place = opened.folder.place(request.name)
    if not is_world_file(place.name):
        raise InvalidParameter(
            "wrong-suffix",
            "{name!r} is not the name of a world",
            "choose a name that ends in .grid",
            name=place.name,
        )
    # A file may be replaced without asking if it has not changed since it was opened.
    force = request.overwrite
    if not force and request.replaces is not None and place.is_file():
        if digest_of(place) != request.replaces:
            raise OutputError(
                "file-changed",
                "{name} has changed since it was opened",
                "overwrite it, or choose another name",
                name=place.name,
            )
        force = True
    check_output(place, force)
    opened.folder.check_replaceable(place)
    world = restored(request.world)
    if world.certificate is None:
        world = replace(world, certificate=decide(world).certificate)
    write_world(world, place, force=force)
    name = place.relative_to(opened.folder.root).as_posix()
    return opened_message(world, name=name, file=digest_of(place))


@answer.register
def _decided(request: Decide, opened: Opened, part: object) -> ProofMessage:
    world = restored(request.world)
    decision = _decision(world)
    proof = decision.certificate
    if proof is None:
        return ProofMessage(result=decision.result, reason=decision.reason)
    proved = replace(world, certificate=proof)
    # With several robots, the reason names the one that the ring stops.
    ring = len(proof.cells) if isinstance(proof, Cut) and not world.is_fleet else 0
    return ProofMessage(
        result=decision.result,
        reason=decision.reason,
        length=0.0 if isinstance(proof, Cut) else proof.length,
        duration=0.0 if isinstance(proof, Cut) else proof.duration,
        clearance=proof.clearance,
        ring=ring if ring > 1 else None,
        others=drawn_others(proved) if isinstance(proof, JointWitness) else [],
        **drawn_certificate(proved),
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


@answer.register
def _widest(request: Widest, opened: Opened, part: object) -> float | None:
    world = world_of(request.world)
    return None if world.is_dynamic else bottleneck(world, world.walls)


@answer.register
def _with_goal(request: Goal, opened: Opened, part: object) -> WorldMessage:
    world = restored(request.world).bare
    robot = world.robots[0]
    overrides = RobotOverrides(
        footprint=request.footprint or None,
        target_heading=request.heading or None,
        arrival=request.arrival or None,
        waypoints=request.waypoints or None,
    )
    if not world.is_fleet:
        goal = Target(robot.target.x, robot.target.y, robot.target.radius)
        # The radius of a body follows from it, and says nothing about a disc.
        radius = robot.radius if robot.is_disc else DEFAULT_ROBOT_RADIUS
        plain = replace(robot, footprint=(), waypoints=(), target=goal, radius=radius)
        world = replace(world, robots=(plain,))
    return message_of(overrides.applied_to(world))


@answer.register
def _signal(request: Signal, opened: Opened, part: object) -> str:
    world = replace(world_of(request.world), timeline=Timeline())
    return numbers(signal_in(world, noise=request.noise).ravel())


@answer.register
def _generated(request: Generate, opened: Opened, part: SendPart[Progress]) -> OpenedMessage:
    check_registered("family", request.family, FAMILIES.names())
    parameters: dict[str, Value] = {
        name: opened.folder.file_in_option(value, FAMILIES.names())
        if isinstance(value, str)
        else value
        for name, value in request.parameters.items()
    }
    # Refuse anything else, because the search would treat it as an argument.
    FAMILIES.get(request.family).complete(parameters)
    seed = int(request.seed)
    if request.where is None and request.difficulty is None:
        return opened_message(generate(request.family, seed, **parameters))
    tried = count(1)
    world = search_world(
        request.family,
        request.where,
        difficulty=request.difficulty,
        seed=seed,
        tries=_TRIES,
        progress=lambda _: part(Progress(next(tried), _TRIES)),
        **parameters,
    )
    return opened_message(world)


@answer.register
def _preview(request: Preview, opened: Opened, part: object) -> DrawnWorld:
    check_registered("family", request.family, FAMILIES.names())
    known = {parameter.name for parameter in FAMILIES.get(request.family).parameters}
    small: dict[str, Value] = {"size": _PREVIEW_SIDE} if "size" in known else {}
    return drawn_world(generate(request.family, _PREVIEW_SEED, **small))


@answer.register
def _shift(request: Shift, opened: Opened, part: object) -> WorldMessage:
    return message_of(shifted(restored(request.world).alone(1), int(request.seed)))


@answer.register
def _measured(request: Measure, opened: Opened, part: object) -> list[Metric]:
    found = measure(restored(request.world)).as_dict()
    return [
        Metric(name, found[name], metric.unit, metric.meaning)
        for name, metric in METRICS.items()
        if name in found
    ]
