"""Options that replace a world's robot: its body, its drive, and what counts as arriving.

They are the same on the command line, in a family's parameters and in a campaign, and are stored as
they were written: ``footprint = "0.62x0.9"``.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any, Literal

from worldgen.domain import DECIMAL
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.parameters import Parameter, Written, parameters_of_fields
from worldgen.parameters.bounds import Bounds
from worldgen.parameters.known_names import unknown_name
from worldgen.robot import ARRIVALS, MOST_WAYPOINTS, Corner, Drive, Robot, Target, convex_footprint

if TYPE_CHECKING:
    from worldgen.world import World

_NUMBER = DECIMAL.pattern
_BOX = re.compile(rf"({_NUMBER})\s*[xX*]\s*({_NUMBER})(?:\s*@\s*({_NUMBER}))?")
# Corners as here, as in JSON, and as in Nav2's parameters.
_BETWEEN = re.compile(r"[\s,;()\[\]]+")
_BOX_EXAMPLE = "0.62x0.9"
_PLACES_EXAMPLE = "'1.2,3.4 0.5,2.1'"
_CORNERS_EXAMPLE = "'0.45,0 -0.3,0.3 -0.3,-0.3'"


@dataclass(frozen=True, kw_only=True)
class RobotOverrides:
    """The robot that a user asks about; whatever is omitted stays as the world has it.

    Args:
        footprint: Body of the robot: LENGTHxWIDTH, m, with the axle in its middle; LENGTHxWIDTH@AHEAD
            with its middle that far ahead of the axle; or the corners of a convex polygon,
            "X,Y X,Y X,Y", x ahead and y left of the axle.
        drive: car: it cannot turn on the spot, and stops at walls.
        turning_radius: Smallest radius of the arcs that a car's axle can drive.
        reverse: Whether a car can drive backwards.
        steering_rate: How fast a car can steer, as a share of its largest curvature a second; 0 if
            it steers instantly.
        arrival: What counts as arriving: touch: the path meets the target; step: a step ends in it;
            stop: a step ends in it and the robot stands, at most SPEED m/s and TURN_RATE rad/s fast.
        target_radius: Radius of the target, m, as Nav2's xy_goal_tolerance. Waypoints of the world
            keep theirs.
        target_heading: Heading that the robot must have at the target, rad, and the largest
            difference from it.
        contact: What a wall does to a move into it: slide along the wall, stop there, or fail,
            which ends the run.
        waypoints: Places, "X,Y X,Y", m, that the robot must arrive at before the target, in order;
            each with the target's radius and arrival, or with a radius of its own: X,Y,RADIUS. A
            family, and a campaign, also takes a number of waypoints, and chooses where they are.

    Raises:
        InvalidParameter: If a value is out of range or cannot be read.
        InvalidWorld: If the footprint is not a convex polygon.
    """

    footprint: Annotated[str | None, Written(metavar="LxW[@AHEAD]|CORNERS")] = None
    drive: Literal["car"] | None = None
    turning_radius: Annotated[float | None, Bounds(0.0, unit="m", above=True)] = None
    reverse: bool | None = None
    steering_rate: Annotated[float | None, Bounds(0.0, unit="1/s")] = None
    arrival: Annotated[str | None, Written(metavar="touch|step|stop[:SPEED[:TURN_RATE]]")] = None
    target_radius: Annotated[float | None, Bounds(0.0, unit="m", above=True)] = None
    target_heading: Annotated[str | None, Written(metavar="RAD[:TOLERANCE]")] = None
    contact: Literal["slide", "stop", "fail"] | None = None
    waypoints: Annotated[str | None, Written(metavar="X,Y[,RADIUS]...|N")] = None

    def __post_init__(self) -> None:
        for option in self.declared():
            value = option.accept(getattr(self, option.name), "robot")
            object.__setattr__(self, option.name, value)
        # Read them once, so that a mistake is found before any work begins.
        self._body()
        self._goal()
        self._places()

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """Return the options."""
        # Type checkers do not consider the type of a dataclass hashable.
        fields: Any = cls
        return parameters_of_fields(fields)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> RobotOverrides:
        """Return those among some values, which may be of other options too."""
        names = {option.name for option in cls.declared()}
        return cls(**{name: value for name, value in values.items() if name in names})

    def given(self) -> dict[str, Any]:
        """Return the values that were given, by name."""
        return {
            name: value for name, value in dataclasses.asdict(self).items() if value is not None
        }

    @property
    def changes_body(self) -> bool:
        """True if they are about the body or the drive, not only about the goal."""
        goal = ("arrival", "target_radius", "target_heading", "contact", "waypoints")
        return any(name not in goal for name in self.given())

    @property
    def leaves_axle_outside(self) -> bool:
        """True if they give a footprint that does not cover the axle."""
        body = self._body()
        return body is not None and not covers_axle(body)

    @property
    def waypoint_count(self) -> int:
        """How many waypoints they ask for; 0 if the option is omitted."""
        asked = self._asked()
        return asked if isinstance(asked, int) else len(asked)

    @property
    def chooses_waypoints(self) -> bool:
        """True if they ask for a number of waypoints, not for places."""
        return isinstance(self._asked(), int)

    def moved(self, dx: float, dy: float) -> RobotOverrides:
        """Return these overrides with their places moved, m."""
        places = self._places()
        if places is None or dx == dy == 0.0:
            return self
        words = [
            ",".join(repr(value) for value in (x + dx, y + dy, *([radius] if radius else [])))
            for x, y, radius in places
        ]
        return replace(self, waypoints=" ".join(words))

    def applied_to_robot(self, robot: Robot) -> Robot:
        """Return the robot with these changes.

        Raises:
            InvalidParameter: If an option is a car's, and the robot is not one.
        """
        footprint = self._body()
        target = replace(robot.target, **self._goal())
        return replace(
            robot,
            footprint=robot.footprint if footprint is None else footprint,
            drive=self._drive(robot.drive),
            target=target,
            waypoints=self._waypoints(robot.waypoints, target),
        )

    def applied_to(self, world: World) -> World:
        """Return the world with these changes of its robot.

        It loses what was only true of the other robot: its failure, its provenance unless that is a
        map's, and its certificate if the body, the drive, a waypoint or a goal's heading changes.

        Raises:
            InvalidParameter: If an option is a car's, and the robot is not one; for a fleet; or if they
            ask for a number of waypoints, without places.
            InvalidWorld: If no world can have such a robot.
        """
        if not self.given():
            return world
        if self.chooses_waypoints:
            raise InvalidParameter(
                "no-places",
                "waypoints={name!q} is a number of places to choose, and this world's are not chosen",
                "write the places, such as {near}",
                name=self.waypoints,
                near=f"{world.target.x:.6g},{world.target.y:.6g}",
            )
        if world.is_fleet:
            option = next(iter(self.given()))
            raise InvalidParameter(
                "not-for-fleets",
                "{option} is for worlds of one robot, and this one has {robots}",
                "omit it",
                option=option_flag(option),
                robots=len(world.robots),
            )
        before = world.robots[0]
        after = self.applied_to_robot(before)
        if after == before:
            return world
        is_proved = _proved_of(after) == _proved_of(before)
        made = world.provenance
        return replace(
            world,
            robots=(after,),
            certificate=world.certificate if is_proved else None,
            provenance=made if made is not None and made.is_of_map else None,
            failure=None,
        )

    def _waypoints(self, given: tuple[Target, ...], target: Target) -> tuple[Target, ...]:
        """Return the waypoints of a robot with these ones, whose goal is this target."""
        places = self._places()
        if places is not None:
            return waypoints_at(places, target)
        if self.arrival is None:
            return given
        return tuple(replace(goal, **_arrival(self.arrival)) for goal in given)

    def _places(self) -> list[tuple[float, float, float]] | None:
        asked = self._asked()
        return None if isinstance(asked, int) else asked or None

    def _asked(self) -> int | list[tuple[float, float, float]]:
        """Return the places of the waypoints, or how many there are to be; none if omitted."""
        return [] if self.waypoints is None else parse_waypoints(self.waypoints)

    def _body(self) -> tuple[Corner, ...] | None:
        return None if self.footprint is None else parse_footprint(self.footprint)

    def _drive(self, drive: Drive) -> Drive:
        """Return the drive with these changes.

        Raises:
            InvalidParameter: If an option is a car's, and the robot is not one; or if a car has no
                turning radius.
        """
        changes = {
            name: value
            for name in ("turning_radius", "reverse", "steering_rate")
            if (value := getattr(self, name)) is not None
        }
        is_car = self.drive == "car" or drive.is_car
        lacks_radius = not (drive.is_car or "turning_radius" in changes)
        if changes and not is_car:
            raise InvalidParameter(
                "option-missing",
                "{option} is for a car, and the robot turns on the spot",
                "make it a car with {needs!l}, or omit it",
                option=option_flag(next(iter(changes))),
                needs=["--drive", *(["--turning-radius"] if lacks_radius else [])],
            )
        if is_car and lacks_radius:
            raise InvalidParameter(
                "option-missing",
                "a car needs a turning radius, in m",
                "give it with {needs!l}",
                needs=["--turning-radius"],
            )
        return replace(drive, **changes)

    def _goal(self) -> dict[str, Any]:
        """Return the changes of the goal."""
        changes: dict[str, Any] = {}
        if self.arrival is not None:
            changes |= _arrival(self.arrival)
        if self.target_radius is not None:
            changes["radius"] = self.target_radius
        if self.target_heading is not None:
            changes |= _heading(self.target_heading)
        if self.contact is not None:
            changes["contact"] = self.contact
        return changes


def _proved_of(robot: Robot) -> tuple[object, ...]:
    """Return what a certificate is about, of a robot's body, drive and goals."""
    goals = [(goal.x, goal.y, goal.radius, goal.heading) for goal in robot.goals]
    return robot.footprint, robot.drive, goals


def option_flag(name: str) -> str:
    """Return the spelling of an option on the command line: ``--turning-radius``."""
    return "--" + name.replace("_", "-")


def parse_footprint(text: str) -> tuple[Corner, ...]:
    """Return the corners, m, of a footprint such as ``0.62x0.9@0.1``, or of a list of corners.

    Raises:
        InvalidParameter: If it has another form, a side is not above 0, or the corners do not make
            a convex polygon; ``near`` is what to write instead, if that is known.
    """
    box = _BOX.fullmatch(text.strip())
    corners = _corners(text) if box is None else _rectangle(text, *box.groups())
    try:
        return convex_footprint(corners)
    except InvalidWorld as fault:
        # The hull is what a body with notches, or with corners in another order, can be.
        try:
            near = " ".join(f"{x:g},{y:g}" for x, y in convex_footprint(_hull(corners)))
        except InvalidWorld:
            near = _BOX_EXAMPLE
        message = fault.message.replaced({"name": text, "near": near})
        raise InvalidParameter.of(message) from fault


def waypoints_at(
    places: Iterable[tuple[float, float, float]], target: Target
) -> tuple[Target, ...]:
    """Return waypoints at places, which ask for the arrival that the target asks for.

    Args:
        places: x and y, m, and the radius, m, or 0 for the target's.
        target: The target.
    """
    goal = replace(target, heading=None, contact=None)
    return tuple(replace(goal, x=x, y=y, radius=radius or target.radius) for x, y, radius in places)


def parse_waypoints(text: str) -> int | list[tuple[float, float, float]]:
    """Return x and y, m, and the radius, m, or 0 for the target's, of places such as ``1.2,3.4 5,6``.

    Returns:
        The places; or a number, if that is all that the text is.

    Raises:
        InvalidParameter: If one has another form, a radius is not above 0, or there are too many.
    """
    count = int(text) if re.fullmatch(r"\s*[0-9]{1,9}\s*", text) else None
    places = []
    for word in () if count is not None else filter(None, re.split(r"[\s;()\[\]]+", text)):
        numbers = word.strip(",").split(",")
        if not 2 <= len(numbers) <= 3 or not all(map(DECIMAL.fullmatch, numbers)):
            raise InvalidParameter(
                "wrong-form",
                "waypoint {word!q} is not a place, x and y in m, with or without a radius",
                f"write one such as 1.2,3.4 or 1.2,3.4,0.1, and several as {_PLACES_EXAMPLE}",
                word=word,
                name=text,
                **_near_places(text),
            )
        x, y, *radius = map(float, numbers)
        if radius and not radius[0] > 0.0:
            raise InvalidParameter(
                "not-positive",
                "waypoint {name!q} has a radius that is not above 0 m",
                "write {near} for the target's",
                name=word,
                near=",".join(numbers[:2]),
            )
        places.append((x, y, radius[0] if radius else 0.0))
    asked = len(places) if count is None else count
    if not 1 <= asked <= MOST_WAYPOINTS:
        raise InvalidParameter(
            "too-many-waypoints" if asked else "wrong-form",
            "waypoints: {count} places; there must be 1 to {most}",
            f"write them as {_PLACES_EXAMPLE}",
            count=asked,
            most=MOST_WAYPOINTS,
        )
    return places if count is None else count


def _near_places(text: str) -> dict[str, str]:
    """Return the places that were written in another form, such as ``1.2;3.4``, as a fact ``near``."""
    numbers = re.findall(_NUMBER, text)
    pairs = [",".join(pair) for pair in zip(numbers[::2], numbers[1::2], strict=False)]
    return {"near": " ".join(pairs)} if pairs and len(numbers) % 2 == 0 else {}


def _corners(text: str) -> list[Corner]:
    words = [word for word in _BETWEEN.split(text) if word]
    if not words or len(words) % 2 or not all(map(DECIMAL.fullmatch, words)):
        raise InvalidParameter(
            "wrong-form",
            "footprint {name!q} is neither a length and a width in m, nor the corners of a polygon",
            f"write one such as {_BOX_EXAMPLE}, or {_CORNERS_EXAMPLE}",
            name=text,
            near=_near_box(text),
        )
    return [(float(x), float(y)) for x, y in zip(words[::2], words[1::2], strict=True)]


def _rectangle(text: str, *numbers: str | None) -> list[Corner]:
    length, width, ahead = (Decimal(number or "0") for number in numbers)
    if length <= 0 or width <= 0:
        sides = [f"{abs(side)}" for side in (length, width)]
        raise InvalidParameter(
            "not-positive",
            "footprint {name!q} has a side that is not above 0 m",
            f"write a length and a width, such as {_BOX_EXAMPLE}",
            name=text,
            near="x".join(sides) if length and width else _BOX_EXAMPLE,
        )
    # In decimals, so that half of 0.62 and a shift of 0.1 are 0.41, not a number next to it.
    front = float(ahead + length / 2)
    rear = float(ahead - length / 2)
    left = float(width / 2)
    return [(rear, -left), (front, -left), (front, left), (rear, left)]


def covers_axle(body: Sequence[Corner]) -> bool:
    """Return True if the axle is in a body, or on its edge.

    Args:
        body: Corners of a convex polygon, m, counter-clockwise.
    """
    ends = (*body[1:], body[0])
    return all(ax * by - ay * bx >= 0.0 for (ax, ay), (bx, by) in zip(body, ends, strict=True))


def _near_box(text: str) -> str:
    """Return a length and a width that were written in another form, such as ``0.62 by 0.9 m``."""
    numbers = re.findall(_NUMBER, text)
    is_box = len(numbers) == 2 and all(float(number) > 0 for number in numbers)
    return "x".join(numbers) if is_box else _BOX_EXAMPLE


def _hull(corners: list[Corner]) -> list[Corner]:
    """Return the corners of the convex hull, counter-clockwise.

    Source: Andrew, Another efficient algorithm for convex hulls in two dimensions (1979).
    """
    halves: list[list[Corner]] = []
    for ordered in (sorted(set(corners)), sorted(set(corners), reverse=True)):
        half: list[Corner] = []
        for x, y in ordered:
            while len(half) > 1 and _turns_right(half[-2], half[-1], (x, y)):
                half.pop()
            half.append((x, y))
        halves.append(half[:-1])
    return halves[0] + halves[1]


def _turns_right(a: Corner, b: Corner, c: Corner) -> bool:
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) <= 0


def describe_body(robot: Robot) -> str:
    """Describe what moves: ``disc of 0.25 m``, ``body of 0.62 x 0.9 m``, ``car of ...``."""
    drive = robot.drive
    noun = "car" if drive.is_car else "disc" if robot.is_disc else "body"
    words = f"{noun} of {_size(robot)}"
    if drive.is_car:
        words += f" with a turning radius of {drive.turning_radius:g} m"
        words += " that reverses" if drive.reverse else ""
    return words


def _size(robot: Robot) -> str:
    if robot.is_disc:
        radius = f"{robot.radius:g} m"
        return f"radius {radius}" if robot.drive.is_car else radius
    xs, ys = zip(*robot.footprint, strict=True)
    sides = f"{max(xs) - min(xs):.6g} x {max(ys) - min(ys):.6g} m"
    is_box = len(robot.footprint) == 4 and len(set(xs)) == len(set(ys)) == 2
    return sides if is_box else f"{len(xs)} corners, {sides}"


def _arrival(text: str) -> dict[str, Any]:
    """Return the goal's parts for ``touch``, ``step``, ``stop`` or ``stop:SPEED:TURN_RATE``."""
    word, *limits = text.split(":")
    if word not in ARRIVALS:
        problem = "arrival {name!q} is not one of {known!l}"
        raise InvalidParameter.of(unknown_name(problem, word, ARRIVALS, "use one of them"))
    names = ("arrival_speed", "arrival_turn_rate")
    if limits and (word != "stop" or len(limits) > len(names)):
        raise InvalidParameter(
            "wrong-form",
            "arrival {name!q} has a limit that it does not take",
            "write {near}; only stop takes limits, stop:SPEED:TURN_RATE, in m/s and rad/s",
            name=text,
            # As many limits as it takes stay.
            near=":".join((word, *limits[: len(names)])) if word == "stop" else word,
        )
    parts: dict[str, Any] = {"arrival": word}
    for name, limit in zip(names, limits, strict=False):
        parts[name] = _not_negative("arrival", text, limit)
    return parts


def _heading(text: str) -> dict[str, Any]:
    """Return the goal's parts for ``RAD`` or ``RAD:TOLERANCE``."""
    heading, *tolerances = text.split(":")
    if len(tolerances) > 1 or not DECIMAL.fullmatch(heading.strip()):
        raise InvalidParameter(
            "wrong-form",
            "target_heading {text!q} is not a heading in rad, with or without a tolerance",
            "write one such as 1.5708 or 1.5708:0.1",
            text=text,
        )
    parts: dict[str, Any] = {"heading": float(heading)}
    if tolerances:
        tolerance = _not_negative("target_heading", text, tolerances[0])
        if tolerance >= math.pi:
            raise InvalidParameter(
                "above-maximum",
                "target_heading {text!q}: any heading is within {tolerance:g} rad of another one",
                "leave it out, or use a tolerance below 3.1416",
                text=text,
                tolerance=tolerance,
            )
        parts["heading_tolerance"] = tolerance
    return parts


def _not_negative(option: str, text: str, number: str) -> float:
    value = float(number) if DECIMAL.fullmatch(number.strip()) else -1.0
    if not (math.isfinite(value) and value >= 0.0):
        raise InvalidParameter(
            "below-minimum",
            "{option} {text!q}: {number!q} is not a number of at least 0",
            "use 0 or more",
            option=option,
            text=text,
            number=number,
        )
    return value


def describe_goal(goal: Target) -> str:
    """Return what a goal asks for besides a touch: ``a stop at heading 1.57 rad (+- 0.25)``.

    Empty if that is all.
    """
    words = {"touch": "", "step": "the end of a step", "stop": "a stop"}[goal.arrival]
    if goal.heading is not None and goal.heading_tolerance < math.pi:
        heading = f"heading {goal.heading:.6g} rad (+- {goal.heading_tolerance:.6g})"
        words = f"{words} at {heading}" if words else heading
    contact = {"stop": "no slide along walls", "fail": "no contact with walls"}.get(
        goal.contact or "", ""
    )
    return ", ".join(filter(None, (words, contact)))


def describe_start_in_target(robot: Robot) -> str:
    """Return the sentence about a robot that :attr:`Robot.starts_in_target`."""
    return (
        f"the start is in the target, which has a radius of {robot.target.radius:g} m, so there is no "
        f"way to go; give a smaller one (--target-radius M)"
    )


def describe_waypoint(robot: Robot, number: int) -> str:
    """Return which of a robot's goals one is, and where: ``waypoint 2 of 3, at (1.2, 3.4)``.

    Args:
        robot: The robot.
        number: Number of the goal, from 0.
    """
    goal = robot.goals[number]
    what = "the target"
    if number < len(robot.waypoints):
        what = f"waypoint {number + 1} of {len(robot.waypoints)}"
    return f"{what}, at ({goal.x:.6g}, {goal.y:.6g})"
