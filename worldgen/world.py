"""The world: solid cells, a start, a target, a round robot, and changes over time.

Frame: metres, x right, y up, headings counter-clockwise from +x in radians (ROS REP-103).
``walls[iy, ix]`` covers [ix, ix+1) x [iy, iy+1) times ``cell_size``; row 0 is the lowest y.
Everything outside the grid is solid.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.domain import (
    CELL_SIZES,
    MAX_ROBOTS,
    MAX_SIDE,
    number_fault,
    radius_fault,
    speed_fault,
)
from worldgen.domain.robot_pairs import pair_fault
from worldgen.errors import InvalidWorld
from worldgen.robot import (
    DEFAULT_ROBOT_RADIUS,
    DEFAULT_ROBOT_SPEED,
    Drive,
    Pose,
    Robot,
    Target,
    check_body,
    check_goals,
)
from worldgen.support.arrays import Bools, Bytes, Floats, Ints
from worldgen.support.frozen import HoldsFrozen, frozen
from worldgen.support.world_methods import world_methods
from worldgen.timeline import CellState, Timeline

__all__ = [
    "DEFAULT_CELL_SIZE",
    "DEFAULT_ROBOT_RADIUS",
    "DEFAULT_ROBOT_SPEED",
    "Certificate",
    "Cut",
    "Drive",
    "FailureRecord",
    "JointWitness",
    "Pose",
    "Provenance",
    "Robot",
    "Target",
    "Value",
    "Witness",
    "World",
]

# Side of a cell, m; 10 px of the thesis.
DEFAULT_CELL_SIZE = 0.1

_NO_CHANGES = Timeline()

Value: TypeAlias = "bool | int | float | str | list[Value] | dict[str, Value]"
"""A value that a TOML header can hold."""


@dataclass(frozen=True, slots=True)
class Provenance:
    """The origin of a world.

    Worlds with equal family, version, seed and params are equal, byte for byte.

    Args:
        family: Name of the generator.
        version: Version of the family.
        seed: Seed of all randomness.
        params: The family's parameters.
        metrics: Metrics of the world, as :func:`worldgen.difficulty.measure` returns them; empty if
            it was not measured. A change of a world's cells, start, target or witness drops its
            provenance, and the metrics with it.
    """

    family: str
    version: int
    seed: int
    params: Mapping[str, Value] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)

    @property
    def unread(self) -> tuple[str, ...]:
        """Elements of an imported file that the world lacks, such as ``"1 shape of <mesh>"``.

        It is empty if the user chose to ignore them. Before version 3, only such imports, and those
        that are blocked in any case, became a world.
        """
        unread = self.params.get("unread")
        is_open = self.family == "import" and self.version >= 3
        if not is_open or not isinstance(unread, list) or self.params.get("ignore_unread") is True:
            return ()
        return tuple(str(what) for what in unread)

    @property
    def changed(self) -> tuple[str, ...]:
        """What was changed on the map from which the world was made, and which part of it it is.

        Such as ``"box of 0.5 x 0.3 m at (3.4, 2) m"``; empty for all other worlds.
        """
        changed = self.params.get("changed")
        return tuple(map(str, changed)) if self.is_of_map and isinstance(changed, list) else ()

    @property
    def is_of_map(self) -> bool:
        """True if it is about the cells alone: those of a foreign map, or of one with changes.

        It then holds for any robot and any start. A family's is about the whole world.
        """
        return self.family in ("import", "map")

    @property
    def origin(self) -> tuple[float, float]:
        """X and y, m, of the grid's lower-left corner in the frame of the map that it is from, or 0."""
        origin = self.params.get("origin")
        if (
            self.family in ("import", "export", "map")
            and isinstance(origin, list)
            and len(origin) == 2
            # An integer may be beyond the range of a float64.
            and all(
                isinstance(value, int | float) and abs(value) <= sys.float_info.max
                for value in origin
            )
        ):
            x, y = (float(value) for value in origin if isinstance(value, int | float))
            return x, y
        return 0.0, 0.0

    @property
    def map_pose(self) -> tuple[float, float, float]:
        """X and y, m, and yaw, rad, of the grid's lower-left corner in the frame of its map, or 0.

        Only the cells of a turned picture have a yaw; then ``origin`` is in the picture's frame.
        """
        left, low = self.origin
        picture = self.params.get("picture")
        if not (isinstance(picture, list) and len(picture) == 3 and self.is_of_map):
            return left, low, 0.0
        x, y, yaw = (float(part) for part in picture if isinstance(part, int | float))
        c, s = math.cos(yaw), math.sin(yaw)
        return x + c * left - s * low, y + s * left + c * low, yaw


@dataclass(frozen=True, slots=True)
class FailureRecord:
    """A failure in this world, with everything needed to reproduce it.

    Args:
        controller: Name of the controller, as on the command line.
        motion: Name of the motion model.
        seed: Seed of the controller's randomness.
        verdict: Verdict of the run.
        trace_digest: 16 hex digits over every state of the run.
        parameters: Options of the run (steps, time step, ...).
        evidence: Facts for a checker (for ``loop``: entry, period, state digest; ...).
        details: Useful facts that prove nothing (class, campaign, shrinking).
    """

    controller: str
    motion: str
    seed: int
    verdict: str
    trace_digest: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    evidence: Mapping[str, Value] = field(default_factory=dict)
    details: Mapping[str, Value] = field(default_factory=dict)

    @property
    def who(self) -> str:
        """Controller, motion model and options in words: ``vfh under swept with beams=36``."""
        given = [
            name if value is True else f"{name}={value}"
            for name, value in self.parameters.items()
            if name not in ("steps", "time_step")
        ]
        options = f" with {', '.join(given)}" if given else ""
        return f"{self.controller} under {self.motion}{options}"

    @property
    def outcome(self) -> str:
        """The verdict; if an oracle found the violation, its name too."""
        return self.verdict + (
            f", oracle {self.evidence['oracle']} objects" if "oracle" in self.evidence else ""
        )


def _frozen_array(
    values: npt.ArrayLike, dtype: npt.DTypeLike, what: str, shape: tuple[int | None, ...]
) -> npt.NDArray[np.generic]:
    array = frozen(values, dtype)
    if array.ndim != len(shape) or any(
        n is not None and n != m for n, m in zip(shape, array.shape, strict=True)
    ):
        raise InvalidWorld(
            "wrong-shape",
            "{what}: shape {shape} does not fit {expected}",
            what=what,
            shape=array.shape,
            expected=shape,
        )
    return array


@dataclass(frozen=True, eq=False)
class Witness(HoldsFrozen):
    """A timed path that the robot could drive; it proves that the target can be reached.

    If the robot has waypoints, a point of the path is in each of them, in order.

    Args:
        times: (n,) float64, s, ascending; the first is 0.
        x: (n,) float64, m; straight lines between the points.
        y: (n,) float64, m.
        clearance: Largest radius, m, of a disc that can follow this path; for a robot with a
            footprint, the distance by which the footprint could be padded all around.
        headings: (n,) float64, rad; None if the heading does not matter, as for a disc that turns
            on the spot. From point to point, a robot either keeps its heading or turns on the spot,
            the shorter way; only a car turns while it drives.
    """

    times: Floats
    x: Floats
    y: Floats
    clearance: float
    headings: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "times", _frozen_array(self.times, np.float64, "witness times", (None,))
        )
        for name in ("x", "y") if self.headings is None else ("x", "y", "headings"):
            object.__setattr__(
                self,
                name,
                _frozen_array(
                    getattr(self, name), np.float64, f"witness {name}", (len(self.times),)
                ),
            )

    @property
    def length(self) -> float:
        """Length of the path, m."""
        return float(np.sum(np.hypot(np.diff(self.x), np.diff(self.y))))

    @property
    def duration(self) -> float:
        """Time of arrival, s."""
        return float(self.times[-1]) if len(self.times) else 0.0

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Witness):
            return NotImplemented
        return self.clearance == other.clearance and all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("times", "x", "y", "headings")
        )

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True)
class JointWitness:
    """One timed path for each robot; it proves that all of them can reach their targets.

    All robots drive at the same time. Their discs stay clear of the walls and of each other. A
    robot waits where its path ends, which is in its target, and the others have to avoid it there.

    Args:
        paths: A path for each robot of the world, in order, each with at least one point. The
            clearance of a path is about the walls alone: the largest radius, m, of a disc that
            could follow it if there were no other robot.
    """

    paths: tuple[Witness, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "paths", tuple(self.paths))
        for number, path in enumerate(self.paths, start=1):
            if not len(path.times):
                raise InvalidWorld(
                    "empty",
                    "the path of robot {number} has no points",
                    "begin it at the robot's start",
                    number=number,
                )

    @property
    def clearance(self) -> float:
        """Smallest clearance of a path, m."""
        return min((path.clearance for path in self.paths), default=0.0)

    @property
    def length(self) -> float:
        """Length of all paths together, m."""
        return sum(path.length for path in self.paths)

    @property
    def duration(self) -> float:
        """Time at which the last robot arrives, s."""
        return max((path.duration for path in self.paths), default=0.0)

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True, eq=False)
class Cut(HoldsFrozen):
    """What the robot cannot pass between start and target.

    For a disc, it is a closed chain of solid cells with gaps narrower than the disc; it also stops
    every body that holds the disc. For a footprint, it can be poses in which the body overlaps a
    wall, and without which no path leads from the start to a pose in the target.

    Args:
        cells: (n, 2) int64, rows (ix, iy) in chain order; the last is linked to the first. Cells
            just outside the grid (index -1 or the grid's side) count as solid, like everything
            outside. Empty for poses.
        clearance: Half the widest gap of the chain, m: the cut stops every disc with a larger
            radius. For poses, the distance by which the footprint could be shrunk all around and
            still be stopped; 0 if it is not known.
        robot: Number of the robot that it stops, from 1.
        boxes: (n, 6) int64, rows (heading, span, side, y, x_begin, x_end), each a run of poses in
            which the body overlaps a wall: headings from ``heading`` to ``heading + span``, 1/65536
            turn; y from ``y`` to ``y + side`` and x from ``x_begin`` to ``x_end``, 1/1024 cell; all
            bounds included. None for a chain.
        waypoint: Number, from 1, of the robot's waypoint that it separates from the start; 0 for the
            target.
    """

    cells: Ints
    clearance: float
    robot: int = 1
    boxes: Ints | None = None
    waypoint: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "cells", _frozen_array(self.cells, np.int64, "cut cells", (None, 2))
        )
        if self.boxes is not None:
            boxes = _frozen_array(self.boxes, np.int64, "cut boxes", (None, 6))
            object.__setattr__(self, "boxes", boxes)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Cut):
            return NotImplemented
        ours = (self.clearance, self.robot, self.waypoint)
        return ours == (other.clearance, other.robot, other.waypoint) and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in ("cells", "boxes")
        )

    __hash__ = None  # type: ignore[assignment]


Certificate: TypeAlias = Witness | JointWitness | Cut


def _with_first(
    robots: tuple[Robot, ...],
    start: Pose | None,
    target: Target | None,
    radius: float | None,
    speed: float | None,
) -> tuple[Robot, ...]:
    """Return the robots with these parts of the first one, which is made if there is none."""
    parts = {"start": start, "target": target, "radius": radius, "speed": speed}
    given: dict[str, Any] = {name: part for name, part in parts.items() if part is not None}
    if not given and robots:
        return robots
    if robots:
        return (replace(robots[0], **given), *robots[1:])
    if start is None or target is None:
        absent = [name for name in ("start", "target") if parts[name] is None]
        raise InvalidWorld(
            "no-robots",
            "a world needs at least one robot, and {came}",
            "give start and target, or robots=[Robot(start, target)]",
            came=f"there are no robots and no {' and no '.join(absent)}",
        )
    return (Robot(**given),)


def _robots_of(given: object) -> tuple[Robot, ...]:
    """Return the robots that a caller gives as a tuple."""
    robots = tuple(given) if isinstance(given, Iterable) else None
    if robots is not None and all(isinstance(robot, Robot) for robot in robots):
        return robots
    came = f"robots is {_article(type(given).__name__)}"
    if robots is not None:
        number, strange = next(
            (number, robot)
            for number, robot in enumerate(robots, start=1)
            if not isinstance(robot, Robot)
        )
        came = f"robot {number} is {_article(type(strange).__name__)}"
    raise InvalidWorld(
        "not-robots",
        "{came}; robots must be a list of Robot",
        "write robots=[Robot(start, target)], or leave robots out for a world of one robot",
        came=came,
    )


def _article(name: str) -> str:
    return "None" if name == "NoneType" else f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"


@dataclass(frozen=True, eq=False, init=False)
class World(HoldsFrozen):
    """Everything about the surroundings that a scenario fixes.

    Worlds are immutable; use ``dataclasses.replace``.

    A world of one robot is given by its ``start`` and ``target``, one of several by ``robots``. Of
    a given fleet, ``start``, ``target``, ``robot_radius`` and ``robot_speed`` replace what the first
    robot has; so ``replace(world, start=...)`` moves the first robot.

    Args:
        walls: (height, width) bool, True is solid; row 0 is the lowest y.
        start: Start pose of the first robot.
        target: Target of the first robot.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the first robot's disc, m.
        robot_speed: Top speed of the first robot, m/s.
        timeline: Changes of cells over time.
        certificate: Proof that the target can, or cannot, be reached.
        provenance: How the world was made.
        failure: Failure recorded in it, if it is a failure's world.
        robots: All robots, in order.

    Raises:
        InvalidWorld: If there is no robot, or ``robots`` has something else; if a number is outside
            its limits (`worldgen.domain`), or a point is outside the grid; if robots overlap at the
            start, or their targets exclude each other; or if the certificate is not for this number
            of robots, or is about a map that was not read whole.
    """

    walls: Bools
    robots: tuple[Robot, ...]
    cell_size: float
    timeline: Timeline
    certificate: Certificate | None
    provenance: Provenance | None
    failure: FailureRecord | None

    if TYPE_CHECKING:
        # Type checkers see fields here, so that they accept `replace(world, start=...)`.
        start: Pose
        target: Target
        robot_radius: float
        robot_speed: float
    else:
        start = property(lambda self: self.robots[0].start, doc="Start pose of the first robot.")
        target = property(lambda self: self.robots[0].target, doc="Target of the first robot.")
        robot_radius = property(
            lambda self: self.robots[0].radius, doc="Radius of the first robot's disc, m."
        )
        robot_speed = property(
            lambda self: self.robots[0].speed, doc="Top speed of the first robot, m/s."
        )

    def __init__(  # noqa: PLR0913 - a world has these parts
        self,
        walls: npt.ArrayLike,
        start: Pose | None = None,
        target: Target | None = None,
        cell_size: float = DEFAULT_CELL_SIZE,
        robot_radius: float | None = None,
        robot_speed: float | None = None,
        timeline: Timeline = _NO_CHANGES,
        certificate: Certificate | None = None,
        provenance: Provenance | None = None,
        failure: FailureRecord | None = None,
        *,
        robots: Iterable[Robot] = (),
    ) -> None:
        # Freeze the arrays, so that a certificate can't become wrong afterwards.
        fields = {
            "walls": _frozen_array(walls, np.bool_, "walls", (None, None)),
            "robots": _with_first(_robots_of(robots), start, target, robot_radius, robot_speed),
            "cell_size": cell_size,
            "timeline": timeline,
            "certificate": certificate,
            "provenance": provenance,
            "failure": failure,
        }
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        self._check()

    def _check(self) -> None:
        """Reject a world that the domain excludes, or whose parts do not fit together."""
        if 0 in self.walls.shape or max(self.walls.shape) > MAX_SIDE:
            raise InvalidWorld(
                "wrong-size",
                "walls: {width} x {height} cells; a side has 1 to {max_side} cells",
                width=self.width,
                height=self.height,
                max_side=MAX_SIDE,
            )
        fault = number_fault("cell_size", self.cell_size, CELL_SIZES, "m")
        if fault is not None:
            raise InvalidWorld.of(fault)
        # Start, target and radius of each robot must suit the grid.
        for number, robot in enumerate(self.robots, start=1):
            self._check_robot(robot, f"robot {number} " if self.is_fleet else "")
        self._check_fleet()
        self._check_certificate()
        if not self.timeline.is_within(self.width, self.height):
            raise InvalidWorld(
                "outside-grid",
                "timeline: every cell must be in the grid of {width} x {height} cells",
                width=self.width,
                height=self.height,
            )

    def _check_fleet(self) -> None:
        """Reject robots that cannot be in one world."""
        if len(self.robots) > MAX_ROBOTS:
            raise InvalidWorld(
                "too-many-robots",
                "{count} robots; a world has at most {most}",
                "leave some out",
                count=len(self.robots),
                most=MAX_ROBOTS,
            )
        fault = pair_fault(self.robots, self.cell_size) if self.is_fleet else None
        if fault is not None:
            raise InvalidWorld.of(fault)

    def _check_certificate(self) -> None:
        """Reject a certificate for another number of robots, or one of a map read in part."""
        proof = self.certificate
        if proof is not None and self.unread:
            raise InvalidWorld(
                "part-not-read",
                "a certificate in a world of whose map something was not read: {unread!l}",
                "drop it; import the map with ignore_unread if that cannot block the robot",
                unread=list(self.unread),
            )
        count = len(self.robots)
        # A cut proves something about one robot; a joint witness needs a path for each.
        if isinstance(proof, Cut):
            fits = 1 <= proof.robot <= count
            kind = f"a cut for robot {proof.robot}"
            if fits and not 0 <= proof.waypoint <= len(self.robots[proof.robot - 1].waypoints):
                fits = False
                kind = f"a cut for waypoint {proof.waypoint}"
            # Poses in which a body overlaps a wall say nothing about discs and fleets.
            if proof.boxes is not None:
                fits = count == 1 and not self.robots[0].is_disc
                kind = "a cut for a footprint"
        elif isinstance(proof, JointWitness):
            fits = len(proof.paths) == count and count > 1
            kind = f"a joint witness of {len(proof.paths)} paths"
        else:
            fits = proof is None or count == 1
            kind = "a witness for one robot"
            # Only version 2 of a file has headings.
            if proof is not None and proof.headings is not None:
                fits = count == 1 and not self.robots[0].is_plain
                kind = "a witness with headings"
        if not fits:
            raise InvalidWorld(
                "wrong-certificate",
                "{kind} in a world of {count} robots",
                "drop it, or prove the world again",
                kind=kind,
                count=count,
            )

    def _check_robot(self, robot: Robot, prefix: str) -> None:
        """Reject a robot outside the domain or the grid; ``prefix`` precedes names in messages."""
        for fault in (
            radius_fault(f"{prefix or 'robot_'}radius", robot.radius, self.cell_size),
            speed_fault(f"{prefix or 'robot_'}speed", robot.speed, self.cell_size),
            radius_fault(f"{prefix}target radius", robot.target.radius, self.cell_size),
            *(
                radius_fault(f"{prefix}waypoint {number} radius", goal.radius, self.cell_size)
                for number, goal in enumerate(robot.waypoints, start=1)
            ),
        ):
            if fault is not None:
                raise InvalidWorld.of(fault)
        if not math.isfinite(robot.start.heading):
            raise InvalidWorld(
                "not-finite",
                "{name} heading {heading}: must be a finite number of radians",
                name=f"{prefix}start",
                heading=robot.start.heading,
            )
        check_goals(robot, prefix)
        check_body(robot, self.cell_size, prefix)
        self._check_inside(f"{prefix}start", robot.start.x, robot.start.y)
        self._check_inside(f"{prefix}target", robot.target.x, robot.target.y)
        for number, goal in enumerate(robot.waypoints, start=1):
            self._check_inside(f"{prefix}waypoint {number}", goal.x, goal.y)

    def _check_inside(self, name: str, x: float, y: float) -> None:
        width = self.width * self.cell_size
        height = self.height * self.cell_size
        # Also true for NaN.
        if not (0.0 <= x <= width and 0.0 <= y <= height):
            raise InvalidWorld(
                "outside-grid",
                "{name} ({x}, {y}) m is outside the grid of {width:g} x {height:g} m",
                "move it inside",
                name=name,
                x=x,
                y=y,
                width=width,
                height=height,
            )

    @property
    def height(self) -> int:
        """Number of cells in y."""
        return int(self.walls.shape[0])

    @property
    def width(self) -> int:
        """Number of cells in x."""
        return int(self.walls.shape[1])

    @property
    def is_fleet(self) -> bool:
        """True if there are several robots."""
        return len(self.robots) > 1

    def alone(self, number: int) -> World:
        """Return this world with only one of its robots.

        Facts about all robots are dropped: certificate, provenance and failure.

        Args:
            number: The robot's number, from 1.
        """
        return replace(self.bare, robots=(self.robots[number - 1],))

    def for_goal(self, number: int) -> World:
        """Return this world with one of its only robot's goals as the target, without waypoints.

        Args:
            number: The goal's number, from 0; the last one is the target.
        """
        robot = self.robots[0]
        if not robot.waypoints:
            return self
        goal = replace(robot.goals[number], contact=robot.target.contact)
        # A cut may be about another goal.
        proof = None if isinstance(self.certificate, Cut) else self.certificate
        robots = (replace(robot, target=goal, waypoints=()),)
        return replace(self, robots=robots, certificate=proof)

    @property
    def unread(self) -> tuple[str, ...]:
        """Elements of the imported map that are not in this world; nothing about it is proved."""
        return () if self.provenance is None else self.provenance.unread

    @property
    def is_dynamic(self) -> bool:
        """True if any cell changes with time."""
        return len(self.timeline) > 0

    @property
    def solid_cells(self) -> int:
        """Number of solid cells at time 0."""
        return int(np.count_nonzero(self.walls))

    @property
    def bare(self) -> World:
        """The world without certificate, provenance and failure."""
        return replace(self, certificate=None, provenance=None, failure=None)

    @property
    def changing_cells(self) -> Bools:
        """Cells with an event, (height, width) bool."""
        return self.timeline.cells_that_become(shape=self.walls.shape)

    @property
    def still_walls(self) -> Bools:
        """Cells that are always solid, (height, width) bool."""
        still: Bools = self.walls & ~self.changing_cells
        return still

    def cells_at(self, time: float) -> Bytes:
        """Return the state of every cell at a time, s.

        The result has shape (height, width), uint8, with values of :class:`CellState`.
        """
        line = self.timeline
        past = np.s_[: line.count_until(time)]
        cells = np.where(self.walls, np.uint8(CellState.SOLID), np.uint8(CellState.FREE))
        # The last of a cell's events wins.
        cells[line.iy[past], line.ix[past]] = line.states[past]
        return cells

    @property
    def digest(self) -> str:
        """SHA-256 of the world's canonical file without provenance and failure: the world's id."""
        digest: str = world_methods["digest"](self)
        return digest

    def __repr__(self) -> str:
        made = self.provenance
        name = "" if made is None else f" {made.family} seed {made.seed}"
        proof = self.certificate
        if proof is None:
            proved = "no certificate"
        elif isinstance(proof, Witness | JointWitness):
            proved = f"witness of {proof.length:.4g} m"
        else:
            proved = f"cut of {len(proof.cells)} cells"
        fleet = f", {len(self.robots)} robots" if self.is_fleet else ""
        changes = f", {len(self.timeline)} changes" if self.is_dynamic else ""
        failed = f", failure {self.failure.outcome}" if self.failure is not None else ""
        return (
            f"<World{name}: {self.width} x {self.height} cells of {self.cell_size:g} "
            f"m{changes}{fleet}, start ({self.start.x:g}, {self.start.y:g}), target "
            f"({self.target.x:g}, {self.target.y:g}), {proved}{failed}>"
        )

    def _repr_png_(self) -> bytes:
        """Return the picture shown in a notebook."""
        picture: bytes = world_methods["picture"](self)
        return picture

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, World):
            return NotImplemented
        return np.array_equal(self.walls, other.walls) and all(
            getattr(self, name) == getattr(other, name)
            for name in (
                "robots", "cell_size", "timeline", "certificate", "provenance", "failure",
            )
        )  # fmt: skip

    __hash__ = None  # type: ignore[assignment]
