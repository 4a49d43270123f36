"""A robot of a world: its start, its goal, its body, and how it may drive.

The robot's frame has x ahead and y to the left, in metres; its origin is the axle, about which the
robot turns. A body is a disc around the axle, or a convex polygon.
"""

from __future__ import annotations

import math
import typing
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Literal, TypeAlias

from worldgen.domain import radius_fault
from worldgen.errors import InvalidWorld

Arrival = Literal["touch", "step", "stop"]
ARRIVALS: Final[tuple[Arrival, ...]] = typing.get_args(Arrival)
Contact = Literal["slide", "stop", "fail"]
CONTACTS: Final[tuple[Contact, ...]] = typing.get_args(Contact)

Corner: TypeAlias = tuple[float, float]
MOST_CORNERS: Final = 16
# Cells from the axle to the farthest corner of a footprint, so that exact tests fit into 128 bits.
MOST_OF_A_FOOTPRINT = 256
# Goals that a robot must arrive at before its target.
MOST_WAYPOINTS: Final = 64
# Slowest steering of a car, 1/s: eleven days to full lock.
SLOWEST_STEERING = 1e-6

# The thesis's robot: 10 px cells, a 14 px disc at 0.2 px/ms, at 10 px = 0.1 m.
# Radius, m.
DEFAULT_ROBOT_RADIUS: Final = 0.07
# Speed, m/s.
DEFAULT_ROBOT_SPEED: Final = 2.0
# rad; Nav2's goal checkers have the same.
DEFAULT_HEADING_TOLERANCE: Final = 0.25
# m/s and rad/s below which a robot stands.
DEFAULT_ARRIVAL_SPEED: Final = 0.01
DEFAULT_ARRIVAL_TURN_RATE: Final = 0.01


@dataclass(frozen=True, slots=True)
class Pose:
    """A pose of the robot: x and y in m, heading in rad, counter-clockwise from +x."""

    x: float
    y: float
    heading: float = 0.0


@dataclass(frozen=True, slots=True)
class Target:
    """The goal: a disc for the robot's centre or axle, and what counts as arriving there.

    Args:
        x: The disc's centre, m.
        y: The same.
        radius: Its radius, m.
        heading: Heading that the robot must have there, rad; None for any.
        heading_tolerance: Largest difference from it, rad.
        arrival: ``touch``: the robot's path meets the disc. ``step``: a step ends in it. ``stop``:
            a step ends in it, and the robot stands.
        arrival_speed: Speed up to which a robot stands, m/s.
        arrival_turn_rate: The same for its turn rate, rad/s.
        contact: What a wall does to a move into it. ``slide``: the robot slides along the wall.
            ``stop``: it stops there until its next step. ``fail``: it stops, and the run has
            failed. None: as the robot drives, ``stop`` for a car and ``slide`` otherwise.
    """

    x: float
    y: float
    radius: float
    heading: float | None = None
    heading_tolerance: float = DEFAULT_HEADING_TOLERANCE
    arrival: Arrival = "touch"
    arrival_speed: float = DEFAULT_ARRIVAL_SPEED
    arrival_turn_rate: float = DEFAULT_ARRIVAL_TURN_RATE
    contact: Contact | None = None

    @property
    def is_plain(self) -> bool:
        """True if touching the disc is all that counts, in any way."""
        return self.heading is None and self.arrival == "touch" and self.contact is None


@dataclass(frozen=True, slots=True)
class Drive:
    """How a robot may move. By default it turns on the spot and drives both ways.

    Args:
        turning_radius: Smallest radius, m, of the arcs that a car's axle drives; 0 if the robot
            turns on the spot.
        reverse: Whether a car may drive backwards.
        steering_rate: Largest change of a car's curvature, as a share of the largest curvature a
            second, 1/s; 0 if it steers instantly.
    """

    turning_radius: float = 0.0
    reverse: bool = False
    steering_rate: float = 0.0

    @property
    def is_car(self) -> bool:
        """True if the robot cannot turn on the spot."""
        return self.turning_radius > 0.0


@dataclass(frozen=True, slots=True)
class Robot:
    """One robot of a world.

    Args:
        start: Pose at the start.
        target: The goal.
        radius: Radius of the robot's disc, m. For a robot with a footprint, it is the radius of the
            smallest disc about the axle that holds it, rounded up, whatever is given.
        speed: Top speed, m/s.
        footprint: Corners of a convex polygon, m, in the robot's frame; none for a disc. They are
            kept counter-clockwise, without those on a straight side.
        drive: How it may move.
        waypoints: Goals that it must arrive at before the target, in order.

    Raises:
        InvalidWorld: If the footprint is not a convex polygon of 3 to 16 corners.
    """

    start: Pose
    target: Target
    radius: float = DEFAULT_ROBOT_RADIUS
    speed: float = DEFAULT_ROBOT_SPEED
    footprint: tuple[Corner, ...] = ()
    drive: Drive = Drive()
    waypoints: tuple[Target, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "waypoints", tuple(self.waypoints))
        # An empty list would compare unequal to no footprint.
        footprint = convex_footprint(self.footprint) if len(self.footprint) else ()
        object.__setattr__(self, "footprint", footprint)
        if footprint:
            radius = max(math.hypot(x, y) for x, y in footprint)
            object.__setattr__(self, "radius", math.nextafter(radius, math.inf))

    @property
    def is_disc(self) -> bool:
        """True if the body is a disc."""
        return not self.footprint

    @property
    def is_round(self) -> bool:
        """True for a disc that turns on the spot, so that its heading does not matter."""
        return self.is_disc and not self.drive.is_car

    @property
    def is_plain(self) -> bool:
        """True for a disc that turns on the spot and only has to touch its target."""
        return (
            self.is_disc and self.drive == Drive() and self.target.is_plain and not self.waypoints
        )

    @property
    def goals(self) -> tuple[Target, ...]:
        """All goals in the order in which the robot must arrive at them; the last is the target."""
        return (*self.waypoints, self.target)

    @property
    def places(self) -> tuple[Corner, ...]:
        """X and y, m, of the start and of all goals, in order."""
        return ((self.start.x, self.start.y), *((goal.x, goal.y) for goal in self.goals))

    @property
    def starts_in_target(self) -> bool:
        """True if the start is in all goals, but not the target's centre, and no heading is asked for."""
        start = (self.start.x, self.start.y)
        is_inside = all(math.dist(start, (goal.x, goal.y)) <= goal.radius for goal in self.goals)
        is_centre = start == (self.target.x, self.target.y)
        return is_inside and not is_centre and self.target.heading is None

    @property
    def inner_radius(self) -> float:
        """Radius, m, of the largest disc about the axle in the body; 0 if the axle is outside."""
        if self.is_disc:
            return self.radius
        # Rounded down, so that the disc is inside.
        ends = (*self.footprint[1:], self.footprint[0])
        return max(0.0, math.nextafter(min(map(_side_distance, self.footprint, ends)), 0.0))

    @property
    def contact(self) -> Contact:
        """What a wall does to a move into it."""
        return self.target.contact or ("stop" if self.drive.is_car else "slide")


def convex_footprint(corners: Iterable[Sequence[float]]) -> tuple[Corner, ...]:
    """Return the corners of a convex polygon counter-clockwise, without those on a straight side.

    Args:
        corners: Three to 16 corners, m, in order; clockwise ones are turned around.

    Raises:
        InvalidWorld: If there are too few or too many, one is not a pair of finite numbers, or the
            polygon has no area or is not convex.
    """
    given = [_corner(corner) for corner in corners]
    if not 3 <= len(given) <= MOST_CORNERS:
        raise InvalidWorld(
            "wrong-footprint",
            "footprint with {count} corners; it must have 3 to {most}",
            "a rectangle of 0.62 x 0.9 m has the corners [0.31, 0.45], [-0.31, 0.45], "
            "[-0.31, -0.45], [0.31, -0.45]",
            count=len(given),
            most=MOST_CORNERS,
        )
    # Corners on a straight side, and repeated ones, say nothing.
    kept = given
    while bends := [_bend(kept, k) for k in range(len(kept))]:
        if all(bends):
            break
        kept = [corner for corner, bend in zip(kept, bends, strict=True) if bend]
    if not kept:
        raise InvalidWorld(
            "wrong-footprint",
            "footprint without area: its corners are on one line",
            "give three corners that are not on one line",
        )
    # A convex polygon bends the same way everywhere, and turns around once.
    if max(bends) < 0:
        kept = [kept[0], *reversed(kept[1:])]
    ups = [(y, x) > (v, u) for (x, y), (u, v) in zip(kept, [kept[-1], *kept[:-1]], strict=True)]
    turns = sum(up and not before for up, before in zip(ups, [ups[-1], *ups[:-1]], strict=True))
    if min(bends) < 0 < max(bends) or turns != 1:
        raise InvalidWorld(
            "wrong-footprint",
            "footprint is not convex, or its sides cross",
            "give the corners in order around the body; if it has notches, those of its convex hull",
        )
    return tuple(kept)


def _bend(corners: Sequence[Corner], k: int) -> int:
    """Return 1, -1 or 0: the way in which a polygon bends at a corner, counter-clockwise is 1."""
    # Decimals are exact here: 0.1, 0.2 and 0.3 are on one line.
    (ax, ay), (bx, by), (cx, cy) = (
        [Fraction(repr(value)) for value in corners[n % len(corners)]] for n in (k - 1, k, k + 1)
    )
    area = (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
    return (area > 0) - (area < 0)


def _side_distance(begin: Corner, end: Corner) -> float:
    """Return the distance of the axle from the line through a side; negative if it is outside."""
    along = (end[0] - begin[0], end[1] - begin[1])
    return (begin[0] * along[1] - begin[1] * along[0]) / math.hypot(*along)


def _corner(corner: Sequence[float]) -> Corner:
    try:
        x, y = (float(value) + 0.0 for value in corner)
    except (TypeError, ValueError) as error:
        raise InvalidWorld(
            "wrong-footprint",
            "footprint: {corner!r} is not a corner",
            "write each corner as [x, y], m",
            corner=corner,
        ) from error
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InvalidWorld(
            "not-finite", "footprint: corner ({x}, {y}) must have finite numbers", x=x, y=y
        )
    return x, y


def check_goals(robot: Robot, prefix: str) -> None:
    """Reject what goals cannot be; ``prefix`` precedes names in messages.

    Raises:
        InvalidWorld: If a word is unknown, a number is not finite or below 0, or there are too many
            waypoints.
    """
    if len(robot.waypoints) > MOST_WAYPOINTS:
        raise InvalidWorld(
            "too-many-waypoints",
            "{count} {name}; a robot has at most {most}",
            "leave some out",
            name=f"{prefix}waypoints",
            count=len(robot.waypoints),
            most=MOST_WAYPOINTS,
        )
    for number, waypoint in enumerate(robot.waypoints, start=1):
        if waypoint.contact is not None:
            raise InvalidWorld(
                "contact-of-waypoint",
                "{name} {number} has contact={contact!q}; the contact is the whole run's",
                "give it to the target alone",
                name=f"{prefix}waypoint",
                number=number,
                contact=waypoint.contact,
            )
        _check_goal(waypoint, f"{prefix}waypoint {number} ")
    _check_word(f"{prefix}contact", robot.contact, CONTACTS)
    _check_goal(robot.target, prefix)


def _check_word(name: str, value: str, known: Sequence[str]) -> None:
    if value not in known:
        raise InvalidWorld(
            "unknown-name",
            "{name}={value!q} is not one of {known!l}",
            "use one of them",
            name=name,
            value=value,
            known=list(known),
        )


def _check_goal(goal: Target, prefix: str) -> None:
    _check_word(f"{prefix}arrival", goal.arrival, ARRIVALS)
    if goal.heading is not None and not math.isfinite(goal.heading):
        raise InvalidWorld(
            "not-finite",
            "{name}={heading}: must be a finite number of radians",
            name=f"{prefix}target_heading",
            heading=goal.heading,
        )
    for name in ("heading_tolerance", "arrival_speed", "arrival_turn_rate"):
        _check_not_negative(f"{prefix}{name}", getattr(goal, name))
    if goal.heading is not None and goal.heading_tolerance >= math.pi:
        raise InvalidWorld(
            "above-maximum",
            "{name}={tolerance:g}: any heading is within that of another one",
            "leave out target_heading, or use a tolerance below 3.1416",
            name=f"{prefix}heading_tolerance",
            tolerance=goal.heading_tolerance,
        )


def check_body(robot: Robot, cell_size: float, prefix: str) -> None:
    """Reject a body or a drive that no robot can have in a grid with cells of this side, m.

    Raises:
        InvalidWorld: If the footprint is too large, or the drive has parts that do not go together.
    """
    widest = MOST_OF_A_FOOTPRINT * cell_size
    if not robot.is_disc and robot.radius > widest:
        raise InvalidWorld(
            "out-of-range",
            "{name}: a corner is {radius:.6g} m from the axle, more than {most} cells of "
            "{cell_size:g} m",
            "use a smaller footprint or larger cells",
            name=f"{prefix}footprint",
            radius=robot.radius,
            most=MOST_OF_A_FOOTPRINT,
            cell_size=cell_size,
        )
    drive = robot.drive
    for name in ("turning_radius", "steering_rate"):
        _check_not_negative(f"{prefix}{name}", getattr(drive, name))
    if 0.0 < drive.steering_rate < SLOWEST_STEERING:
        raise InvalidWorld(
            "below-minimum",
            "{name}={value} 1/s is below {low:g} 1/s",
            "use 0 for a car that steers instantly",
            name=f"{prefix}steering_rate",
            value=drive.steering_rate,
            low=SLOWEST_STEERING,
        )
    if drive.is_car:
        fault = radius_fault(f"{prefix}turning_radius", drive.turning_radius, cell_size)
        if fault is not None:
            raise InvalidWorld.of(fault)
    elif drive != Drive():
        name = "reverse" if drive.reverse else "steering_rate"
        raise InvalidWorld(
            "not-a-car",
            "{name} without a turning radius",
            "give turning_radius, or leave {name} out: a robot that turns on the spot drives "
            "both ways, and does not steer",
            name=f"{prefix}{name}",
        )
    if drive.is_car and robot.contact == "slide":
        raise InvalidWorld(
            "car-slides",
            "{name}=slide: a car cannot slide along a wall",
            "use stop, which is a car's default, or fail",
            name=f"{prefix}contact",
        )


def _check_not_negative(name: str, value: float) -> None:
    if not (math.isfinite(value) and value >= 0.0):
        raise InvalidWorld(
            "below-minimum",
            "{name}={value}: must be a finite number, 0 or more",
            name=name,
            value=value,
        )
