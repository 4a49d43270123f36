"""Turn a foreign map into a world with a proof: add a robot, a start and a target, and decide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from worldgen.domain import DECIMAL
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld, Message, WorldgenError
from worldgen.family import check_between
from worldgen.interop.format import ROBOT_FACTS, robot_kinds
from worldgen.interop.format.foreign_map import IMPORTED, ForeignMap, ForeignRobot
from worldgen.interop.formats.movingai import SCENARIO_RADIUS, read_scenario, scenario_contents
from worldgen.interop.largest_disc import largest_disc
from worldgen.interop.place import Placement, heading_towards, is_clear, place
from worldgen.interop.recognising import read_map_alone
from worldgen.interop.sidecar import Sidecar, with_sidecar
from worldgen.lattice import UNIT, exact
from worldgen.reach import REACHABLE, Decision, decide
from worldgen.robot_overrides import RobotOverrides, describe_body, describe_start_in_target
from worldgen.support.paths import real_path
from worldgen.support.plain_text import alternatives
from worldgen.timeline import Timeline
from worldgen.world import DEFAULT_ROBOT_SPEED, Pose, Provenance, Robot, Target, Value, World

# Raise this whenever some file becomes a different world than before.
VERSION = 5


@dataclass(frozen=True)
class ImportedRobot:
    """Settings that the map does not contain.

    Args:
        start: x and y, m, and optionally the heading, rad; chosen if omitted.
        target: x and y, m, and optionally the radius, m; chosen if omitted.
        radius: Radius of the robot's disc, m; if omitted, the file's, or the radius of the robot
            that such maps are drawn for.
        speed: Top speed, m/s.
        scenario: A MovingAI scenario file with start and target.
        row: Number of the scenario's problem, from 1.
        seed: Seed of the search for distant places. Without it, a ``.grid`` keeps its own places,
            and a thesis map its program's start.
        ignore_unread: True to judge the map without what could not be read.
        robots: Number of the scenario's problems, starting at ``row``, that become robots of one
            world. If omitted, one, or all robots from ``row`` of a map that was exported with several.
        in_file_frame: True if start and target are in the file's coordinates, such as ROS's ``map``
            frame, instead of measured from the grid's lower-left corner.
        overrides: Body, drive and goal that replace the file's.
        near: x and y, m, to which the start is placed as near as possible, or the target if the
            start is given. A ``.grid`` then loses its own places, as with a seed.
        clearance: Least distance, m, to the nearest wall of a place that is chosen. Same here.
    """

    start: tuple[float, ...] | None = None
    target: tuple[float, ...] | None = None
    radius: float | None = None
    speed: float | None = None
    scenario: Path | None = None
    row: int = 1
    seed: int | None = None
    ignore_unread: bool = False
    robots: int | None = None
    in_file_frame: bool = False
    overrides: RobotOverrides = field(default_factory=RobotOverrides)
    near: tuple[float, ...] | None = None
    clearance: float | None = None

    @property
    def is_placed_again(self) -> bool:
        """True if the file's own places do not count."""
        return (self.seed, self.near, self.clearance) != (None,) * 3


@dataclass(frozen=True)
class Imported:
    """A world, and the answer to whether its target can be reached.

    Args:
        world: The world with its certificate and provenance.
        decision: Result, proof, and a sentence. It is ``undecided`` if something of the file was
            not read.
        notes: Sentences worth knowing.
        warnings: Sentences about likely mistakes.
        radius_from: Where the robot's radius comes from.
        unread: Elements of the file that the world lacks.
        withheld: True if the world has no proof because of them.
        origin: The grid's lower-left corner, m, in the file's own coordinates.
        in_file_frame: True if people are told places in these coordinates.
        placement: Where start and target come from, in a sentence.
    """

    world: World
    decision: Decision
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    radius_from: str = ""
    unread: tuple[str, ...] = ()
    withheld: bool = False
    origin: tuple[float, float] = (0.0, 0.0)
    in_file_frame: bool = False
    placement: str = ""


def parse_point(name: str, text: str, third: str = "") -> tuple[float, ...]:
    """Parse two or three numbers separated by commas, as ``--start`` and ``--target`` take them.

    Args:
        name: The option, for messages.
        text: The numbers.
        third: What the third number is; empty if there are only two.

    Raises:
        InvalidParameter: If there are too few or too many, or one isn't a number.
    """
    words = [word.strip() for word in text.split(",")]
    most = 3 if third else 2
    if not 2 <= len(words) <= most or not all(DECIMAL.fullmatch(word) for word in words):
        raise InvalidParameter(
            "wrong-form",
            "{name}={text!r} is not X,Y" + (" or X,Y,{third}" if third else ""),
            "write numbers, as in 1.5,0.35",
            name=name,
            text=text[:60],
            third=third,
        )
    return tuple(float(word) for word in words)


def import_world(
    path: Path,
    robot: ImportedRobot | None = None,
    *,
    name: str | None = None,
    options: Mapping[str, Value | None] | None = None,
) -> Imported:
    """Read a map, add a robot, a start and a target, and decide whether the target is reachable.

    Args:
        path: A file of any known format.
        robot: Robot, start and target.
        name: The format, optionally with ``+option=value``; recognised if omitted.
        options: Settings that the file leaves open.

    Raises:
        FormatError: If the file breaks its format's rules.
        InvalidParameter: If an option is out of range or contradicts another one.
        InvalidWorld: If the start is not clear, or there is no room for the robot.
    """
    found, sidecar = read_map_alone(path, name, options)
    robot = robot or ImportedRobot()
    try:
        return _with_robot(path, found, sidecar, robot)
    except WorldgenError as error:
        lacks_room = error.code == "no-room" and "radius" in error.facts
        if lacks_room and found.params.get("unknown") == "solid":
            error.message = _with_unknown_free(error.message, path, name, options, robot)
        # What the reader noticed often explains why the robot has no room.
        lost = [f"not read: {'; '.join(found.unread)}"] if found.unread else []
        warnings = [f"warning: {sentence}" for sentence in (*found.warnings, *lost)]
        error.notes = (*found.notes, *warnings)
        raise


def _with_unknown_free(
    message: Message,
    path: Path,
    name: str | None,
    options: Mapping[str, Value | None] | None,
    robot: ImportedRobot,
) -> Message:
    """Add to a message about too little room how much there is where unknown cells are free."""
    found = read_map_alone(path, name, {**(options or {}), "unknown": "free"})[0]
    fit = largest_disc(found.walls, found.cell_size)
    if fit is None or fit.radius <= message.facts.get("fits", 0.0):
        return message
    left, low = found.origin if robot.in_file_frame else (0.0, 0.0)
    return message.before(
        "; with unknown cells free (--from {format}+unknown=free) a radius of up to {freed:g} m "
        "fits, at {at[0]:.6g},{at[1]:.6g}",
        format=found.params["format"],
        freed=fit.radius,
        at=[fit.centre[0] + left, fit.centre[1] + low],
    )


def _with_robot(
    path: Path, found: ForeignMap, sidecar: Sidecar | None, robot: ImportedRobot
) -> Imported:
    """Add a robot, a start and a target to a map, and decide whether the target is reachable."""
    # Complete the robot.
    asked = robot
    if sidecar is not None:
        robot = _with_exported_robots(robot, found, sidecar, path)
    if robot.scenario is not None or robot.robots not in (None, len(found.robots)):
        found = _with_scenario(robot, found)
    if sidecar is not None:
        found = with_sidecar(found, _fitting(sidecar, path, robot))
    if robot.in_file_frame:
        robot = replace(
            robot,
            start=_from_corner(robot.start, found.origin),
            target=_from_corner(robot.target, found.origin),
            near=_from_corner(robot.near, found.origin),
            overrides=robot.overrides.moved(-found.origin[0], -found.origin[1]),
        )
    found = _as_given(robot, found)
    params = dict(found.params)
    if found.origin != (0.0, 0.0):
        params["origin"] = list(found.origin)
    radius_from = _radius_from(robot, found)
    if robot.scenario is not None:
        robot = replace(robot, start=found.robot.start, target=found.robot.target)
    robot, notes = _at_programs_start(_complete(robot, found), found)
    try:
        world, placement = _place(robot, found)
    except InvalidWorld as error:
        if not robot.in_file_frame:
            raise
        raise _in_file_frame(error, found) from error

    # Record the world's origin, and what it lacks, before it is decided.
    warnings = [*placement.warnings, *_arrivals_at_once(world)]
    if found.unread:
        params["unread"] = list(found.unread)
        params |= {"ignore_unread": True} if robot.ignore_unread else {}
        warnings.append(f"not read, and not in this world: {'; '.join(found.unread)}")
    world = replace(world, provenance=Provenance(IMPORTED, VERSION, robot.seed or 0, params))
    decision = decide(world)
    if found.is_resampled:
        decision = replace(decision, reason=decision.reason + _on_file(decision, found))
    world = replace(world, certificate=decision.certificate)
    return Imported(
        world,
        decision,
        (*found.notes, *notes),
        (*found.warnings, *warnings),
        radius_from,
        found.unread,
        bool(world.unread),
        found.origin,
        robot.in_file_frame,
        _placement(asked, robot, placement),
    )


def _placement(asked: ImportedRobot, used: ImportedRobot, placed: Placement) -> str:
    """Return where start and target come from.

    Args:
        asked: The robot with the places that the user gives.
        used: The robot with the file's places, too.
        placed: The places.
    """
    file = "scenario" if used.scenario is not None else "file"
    sources = {
        name: "as given" if getattr(asked, name) is not None else f"from the {file}"
        for name in ("start", "target")
        if getattr(used, name) is not None
    }
    if len(set(sources.values())) == 1:
        sources = {" and ".join(sources): sources.popitem()[1]}
    given = [f"{name} {source}" for name, source in sources.items()]
    return "; ".join(filter(None, (*given, placed.why)))


def _arrivals_at_once(world: World) -> list[str]:
    """Return a warning if a robot starts in its target and has nothing else to do."""
    return [describe_start_in_target(robot) for robot in world.robots if robot.starts_in_target][:1]


def _on_file(decision: Decision, found: ForeignMap) -> str:
    """Return what a decision about resampled cells means for the file itself."""
    if decision.result == REACHABLE:
        return ". This holds for the file too, whose walls reach into these cells but not beyond"
    return (
        ". This holds for these cells, into which the file's walls reach, and not for the file: "
        "its gaps may be up to two cells wider"
        + ("; --frame picture judges the picture's own cells" if "yaw" in found.params else "")
    )


def _from_corner(
    place: tuple[float, ...] | None, origin: tuple[float, float]
) -> tuple[float, ...] | None:
    """Return a place of the file's frame as seen from the grid's lower-left corner."""
    if place is None:
        return None
    return (place[0] - origin[0], place[1] - origin[1], *place[2:])


def _in_file_frame(error: InvalidWorld, found: ForeignMap) -> InvalidWorld:
    """Return an error about a place with all its places in the file's frame."""
    height, width = found.walls.shape
    left, low = found.origin
    size = found.cell_size
    facts = dict(error.facts)
    for name, origin in (("x", left), ("y", low)):
        if name in facts:
            facts[name] += origin
    if facts.get("clear"):
        # The sums have rounding errors; twelve digits lead to the same point of the pose lattice.
        facts["clear"] = [
            float(f"{a + b:.12g}") for a, b in zip(facts["clear"], found.origin, strict=True)
        ]
    message = error.message.replaced(facts)
    if error.code == "outside-grid":
        message = message.with_remedy(
            "use x from {left:g} to {right:g} and y from {low:g} to {high:g}, in the file's "
            "coordinates",
            left=left,
            right=left + width * size,
            low=low,
            high=low + height * size,
        )
    return InvalidWorld.of(message)


def _radius_from(robot: ImportedRobot, found: ForeignMap) -> str:
    """Return where the radius chosen by ``_complete`` comes from."""
    if robot.radius is not None:
        return "as given"
    if robot.scenario is not None and found.robot.radius == _scenario_radius(found):
        return "0.4 cells, like a scenario's agent"
    if found.world is not None or found.robot.radius is not None:
        return "from the file"
    return found.usual_robot.source


def _scenario_radius(found: ForeignMap) -> float:
    return float(SCENARIO_RADIUS * exact(found.cell_size))


def _with_exported_robots(
    robot: ImportedRobot, found: ForeignMap, sidecar: Sidecar, path: Path
) -> ImportedRobot:
    """Name the scenario file of a map that was exported with several robots, unless places are given.

    The sidecar says how many robots there were, and the scenario file has a problem for each.
    """
    own = path.with_name(f"{path.name}.scen")
    count = 1 + len(sidecar.others)
    chosen = (robot.scenario, robot.start, robot.target, robot.seed)
    if found.params.get("format") != "movingai" or chosen != (None,) * 4:
        return robot
    try:
        if count == 1 or not own.is_file() or scenario_contents(own)[1] != count:
            return robot
    except (FormatError, OSError):
        # The sidecar's warning says that the robots are missing.
        return robot
    return replace(robot, scenario=own, robots=robot.robots or max(count - robot.row + 1, 1))


def _with_scenario(robot: ImportedRobot, found: ForeignMap) -> ForeignMap:
    """Return the map with a robot for each of the chosen problems of the scenario."""
    # Check that the options belong together.
    if robot.scenario is None:
        raise InvalidParameter(
            "conflict",
            "robots={robots}: the number of robots can be chosen only with a scenario file",
            "name it with --scen, or use the map's own robots",
            at_terminal=True,
            robots=robot.robots,
        )
    if found.params.get("format") != "movingai":
        raise InvalidParameter(
            "conflict", "scen is for MovingAI maps", "use start and target instead"
        )
    if robot.start is not None or robot.target is not None:
        raise InvalidParameter(
            "conflict",
            "scen already gives start and target",
            "omit either start and target, or scen",
        )

    # Read the problems.
    height, width = found.walls.shape
    count = robot.robots or 1
    rows = range(robot.row, robot.row + count)
    problems = [read_scenario(robot.scenario, row, width, height, found.cell_size) for row in rows]
    robots = [ForeignRobot(problem.start, problem.goal) for problem in problems]
    robots[0] = robots[0]._replace(radius=_scenario_radius(found))
    params = {**found.params, "scenario": robot.scenario.name, "row": robot.row}
    if count > 1:
        params["robots"] = count
    return replace(
        found,
        robots=tuple(robots),
        numbers=tuple(rows),
        params=params | {"optimal": problems[0].optimal},
        # The problem next to the map, which they describe, does not count.
        notes=(),
        warnings=(),
    )


def _fitting(sidecar: Sidecar, path: Path, robot: ImportedRobot) -> Sidecar:
    """Return a sidecar without its robots if the user names a scenario of other robots."""
    own = path.with_name(f"{path.name}.scen")
    if robot.scenario is None or real_path(robot.scenario) == real_path(own):
        return sidecar
    of_map = {name: value for name, value in sidecar.values.items() if name not in ROBOT_FACTS}
    return replace(sidecar, values=of_map, others=())


def _as_given(robot: ImportedRobot, found: ForeignMap) -> ForeignMap:
    """Return the map with the values that the user gives for all robots."""
    given = {"radius": robot.radius, "speed": robot.speed}
    parts: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    # A radius asks for a disc.
    parts |= {} if robot.radius is None else {"footprint": ()}
    old = found.world
    robots = found.robots if old is None else tuple(map(_as_foreign, old.robots))
    return replace(found, robots=tuple(one._replace(**parts) for one in robots))


def _as_foreign(robot: Robot) -> ForeignRobot:
    """Return body, drive and goal of a robot of our own file."""
    return ForeignRobot(**robot_kinds(robot))


def _complete(robot: ImportedRobot, found: ForeignMap) -> ImportedRobot:
    """Fill in the options from a world of ours, or from the default robot."""
    old = found.world
    start = robot.start
    target = robot.target
    # A seed, a place to be near and a clearance request new places.
    if old is not None and not robot.is_placed_again:
        start = start or (old.start.x, old.start.y, old.start.heading)
        target = target or (old.target.x, old.target.y, old.target.radius)
    target = target or found.robot.target
    usual = found.usual_robot.radius(found.cell_size)
    radius = _first(robot.radius, old.robot_radius if old else found.robot.radius, usual)
    speed = _first(robot.speed, old.robot_speed if old else found.robot.speed, DEFAULT_ROBOT_SPEED)
    check_between("radius", radius, 1e-9, 1e9, "m")
    check_between("speed", speed, 1e-6, 1e6, "m/s")
    return replace(robot, start=start, target=target, radius=radius, speed=speed)


def _at_programs_start(
    robot: ImportedRobot, found: ForeignMap
) -> tuple[ImportedRobot, tuple[str, ...]]:
    """Fill in the start that the format implies, if none is given and the robot fits there.

    If it does not fit, return the reason.
    """
    if robot.start is not None or robot.is_placed_again or found.robot.start is None:
        return robot, ()
    x, y = found.robot.start[:2]
    # _complete has already set the radius.
    if is_clear(found.walls, found.cell_size, robot.radius or 0.0, (x, y)):
        return replace(robot, start=found.robot.start), ()
    return robot, (
        f"the map's own start ({x:g}, {y:g}) m has no room for the robot, so another one was "
        "chosen",
    )


def _first(*values: float | None) -> float:
    return next(value for value in values if value is not None)


def _place(robot: ImportedRobot, found: ForeignMap) -> tuple[World, Placement]:
    """Return the map with start and target, as given or chosen."""
    # _complete has already set them.
    radius = robot.radius or 0.0
    speed = robot.speed or 0.0
    given = [
        None if point is None else (point[0], point[1])
        for point in (robot.start, robot.target, robot.near)
    ]
    check_between("clearance", robot.clearance or 0.0, 0.0, 1e9, "m")
    origin = (-found.origin[0], -found.origin[1]) if found.is_picture else None
    body = _with_kind(Robot(Pose(0.0, 0.0), Target(0.0, 0.0, radius), radius, speed), robot, found)

    def placed(disc: float, where: str) -> Placement:
        return place(
            found.walls, found.cell_size, disc, robot.seed or 0, start=given[0], target=given[1],
            origin=origin, near=given[2], clearance=robot.clearance or 0.0,
            body="" if body.is_disc else f"{where} the {describe_body(body)}",
        )  # fmt: skip

    # A body has room to turn where its outer disc is clear; elsewhere, its inner one must be.
    try:
        placement = placed(body.radius, "around")
    except InvalidWorld:
        if body.is_disc:
            raise
        try:
            placement = placed(body.inner_radius or found.cell_size / UNIT, "in")
        except InvalidWorld as error:
            raise _for_body(error, body, found) from None
    radius = body.radius
    at = placement.start
    to = placement.target
    headed = robot.start or ()
    sized = robot.target or ()
    start = Pose(*at, headed[2] if len(headed) > 2 else heading_towards(at, to))
    goal = found.robot.goal
    # Nav2's parameters have a goal's size, but not its place.
    size = radius if goal is None else goal.radius
    target = Target(*to, sized[2] if len(sized) > 2 else size)
    timeline = found.world.timeline if found.world else Timeline()
    first = _with_kind(Robot(start, target, radius, speed), robot, found)
    robots = (first, *_other_robots(robot, found, radius, speed))
    world = World(found.walls, cell_size=found.cell_size, timeline=timeline, robots=robots)
    return world, placement


def _for_body(error: InvalidWorld, body: Robot, found: ForeignMap) -> InvalidWorld:
    """Return the error about the disc inside a body in the words of the body."""
    facts = error.facts
    # One about the neighbourhood of a place, or about a start, names what the user gave.
    if error.code != "no-room" or "x" in facts:
        return error
    remedies = ["a smaller footprint"]
    if found.is_resampled:
        remedies.insert(
            0, f"smaller cells, --cell {found.cell_size / 2:g}, which are more accurate"
        )
    return InvalidWorld(
        "no-room",
        "the {body} does not fit anywhere in the map: not even the disc of {radius:g} m inside it "
        "has room",
        f"use {alternatives(remedies)}"
        + (
            "; a disc of up to {fits:g} m fits, at {clear[0]!r},{clear[1]!r}"
            if "fits" in facts
            else ""
        ),
        **{**facts, "body": describe_body(body)},
    )


def _with_kind(robot: Robot, given: ImportedRobot, found: ForeignMap) -> Robot:
    """Return a robot with the body, the drive and the goal that the user or the file gives."""
    return given.overrides.applied_to_robot(found.robot.applied_to(robot))


def _other_robots(
    robot: ImportedRobot, found: ForeignMap, radius: float, speed: float
) -> tuple[Robot, ...]:
    """Return the robots after the first: the file's, unless the user asked for other places."""
    if robot.is_placed_again:
        return ()
    if found.world is not None:
        return found.world.robots[1:]
    robots = []
    for other in found.robots[1:]:
        start = other.start or ()
        target = other.target or ()
        at = (start[0], start[1])
        to = (target[0], target[1])
        headed = start[2] if len(start) > 2 else heading_towards(at, to)
        size = _first(other.radius, radius)
        sized = target[2] if len(target) > 2 else size
        speed_of = _first(other.speed, speed)
        robots.append(
            other.applied_to(Robot(Pose(*at, headed), Target(*to, sized), size, speed_of))
        )
    return tuple(robots)


def as_json(file: str | None, imported: Imported) -> Mapping[str, object]:
    """Return what ``import --json`` prints."""
    world = imported.world
    decision = imported.decision
    corners = [list(corner) for corner in world.robots[0].footprint]
    footprint = {"footprint": corners} if corners else {}
    return {
        "file": file,
        "result": decision.result,
        "reason": decision.reason,
        "clearance": decision.certificate.clearance if decision.certificate else None,
        "radius": world.robot_radius,
        "radius_from": imported.radius_from,
        **footprint,
        "unread": list(imported.unread),
        "width": world.width,
        "height": world.height,
        "cell_size": world.cell_size,
        "start": [world.start.x, world.start.y, world.start.heading],
        "target": [world.target.x, world.target.y, world.target.radius],
        "origin": list(imported.origin),
        "placement": imported.placement,
        "notes": list(imported.notes),
        "warnings": list(imported.warnings),
    }


def describe(file: str | None, imported: Imported) -> list[str]:
    """Return what ``import`` prints for people."""
    world = imported.world
    decision = imported.decision
    start = world.start
    target = world.target
    left, low = imported.origin if imported.in_file_frame else (0.0, 0.0)
    frame = " in the file's coordinates" if (left, low) != (0.0, 0.0) else ""
    robot = world.robots[0]
    body = f"robot radius {world.robot_radius:g} m ({imported.radius_from})"
    if not robot.is_disc or robot.drive.is_car:
        body = f"robot: {describe_body(robot)}"
    headed = "" if target.heading is None else f", heading {target.heading:.4g} rad"
    return [
        (f"{file}: " if file is not None else "")
        + f"{world.width} x {world.height} cells of {world.cell_size:g} m, {body}",
        f"start ({start.x + left:g}, {start.y + low:g}) m, heading {start.heading:.4g} rad; "
        f"target ({target.x + left:g}, {target.y + low:g}) m{frame}, radius {target.radius:g} m{headed}",
        f"placed: {imported.placement}",
        f"{decision.result}: {decision.reason}",
    ]
