"""Families: named, versioned generators of worlds."""

from __future__ import annotations

import functools
import inspect
import math
import re
import textwrap
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any, cast

from worldgen.body_room import FittedRobot, with_spared_path
from worldgen.domain import MAX_ROBOTS
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.lattice import in_cells
from worldgen.parameters import Parameter, check_declared, find_parameter, parameters_of
from worldgen.parameters.bounds import (
    Bounds,
    check_at_least,
    check_between,
    check_choice,
    check_positive,
)
from worldgen.plugins.registry import Registry
from worldgen.random_streams import RandomStream, Seed, seed_of
from worldgen.reach import BLOCKED as SHUT
from worldgen.reach import REACHABLE, Decision, decide
from worldgen.reach.joint.few_robots import FEW_ROBOTS, MOST_TOGETHER
from worldgen.robot_overrides import RobotOverrides, option_flag
from worldgen.shutting import is_shut, shut
from worldgen.support.progress import Work, working
from worldgen.world import JointWitness, Provenance, Value, Witness, World

__all__ = [
    "FAMILIES",
    "MARGIN",
    "MAX_ATTEMPTS",
    "ROBOTS",
    "Bounds",
    "Family",
    "Parameter",
    "check_at_least",
    "check_between",
    "check_choice",
    "check_positive",
    "family",
    "stream_for",
]

Build = Callable[..., World]

MAX_ATTEMPTS = 64  # layouts tried per seed before the parameters are called unsolvable
# Same, for a car: a search for its path that fails takes a second.
MAX_CAR_ATTEMPTS = 16
MAX_PLACEMENTS = 4  # placements of the robots to try in each layout
# Layouts tried for several robots. In the first ones passages are as narrow as for one robot, so
# that robots have to make way for each other; in those after that, two robots can pass.
MAX_NARROW_ATTEMPTS = 3
MAX_FLEET_ATTEMPTS = 12
MAX_CROWD_ATTEMPTS = 6  # same, for more than MOST_TOGETHER, which are redrawn within a layout
# With this many robots, a single layout can take a minute. With fewer, only later ones are
# reported, so that the report does not hide which of many worlds is being made.
_MANY_ROBOTS = 50
# Codes of errors about a layout that is too small for its robots.
_CROWDED = ("too-many-robots", "no-joint-paths")
_PASSAGES = ("width", "passage")  # parameters of families that set the width of passages
ROBOTS = "robots"  # the parameter of every family that says how many robots its worlds have
ROBOTS_PARAMETER = Parameter(
    ROBOTS,
    1,
    (),
    "Number of robots; all have the same size and speed, and start at random places.",
    Bounds(1, MAX_ROBOTS),
)
BLOCKED = "blocked"  # the parameter of families of one robot: the share of blocked worlds
BLOCKED_PARAMETER = Parameter(
    BLOCKED,
    0.0,
    (),
    "Share of the worlds whose target the robot cannot reach, with a proof: gaps in their walls are "
    "closed. 1 for all of them.",
    Bounds(0.0, 1.0),
)
# Provenance of worlds with several robots also names the version of the code that places them and
# plans their witness: the modules in ``reach/joint``. Raise it whenever some
# seed then yields another world of several robots.
PLANNER = "planner"
PLANNER_VERSION = 1
CROWD_PLANNER_VERSION = 2  # same, with more than ``FEW_ROBOTS``
MARGIN = "margin"  # every parameter with this name: seconds by which the witness may start late
# parameters of generate(), and options of every family's command
_TAKEN = (
    "name",
    "seed",
    "count",
    "out",
    "force",
    "json",
    "as_json",
    "help",
    "metrics",
    "where",
    "difficulty",
    "tries",
    "workers",
    PLANNER,
)


@dataclass(frozen=True)
class Family:
    """A generator of worlds.

    Call it with a seed and its own parameters: ``maze(seed=7, size=60)`` is a proved world.
    ``inspect.signature`` shows its parameters with their bounds and units, and ``help`` explains
    them.

    Args:
        name: The noun for its worlds, as on the command line.
        version: Must be raised whenever some seed yields a different world than before.
        build: ``build(rng, **params) -> World``, all parameters keyword-only with defaults.
        changes: True if its worlds change with time, so that no other family can change them.
    """

    name: str
    version: int
    build: Build
    changes: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "__doc__", self._documentation())

    def __call__(self, seed: Seed = 0, **params: Value | None) -> World:
        """Return a world with a witness that its target can be reached.

        With ``blocked`` it may have a cut instead, which proves that the target cannot be reached.

        Args:
            seed: An integer, of which the low 64 bits count, or a NumPy generator. Equal seeds and
                parameters give equal worlds.
            **params: The family's parameters. ``None`` lets the family choose, if it can.

        Raises:
            InvalidParameter: If a parameter is unknown, or a value is out of range.
            GenerationFailed: If no layout in ``MAX_ATTEMPTS`` is solvable for the robot.
        """
        # Check the parameters.
        complete = self.complete(params)
        number = seed_of(seed)
        margin = float(cast("float", complete.get(MARGIN, 0.0)))
        overrides = self.overrides(complete)
        own = {name: value for name, value in complete.items() if name not in overrides.given()}
        fitted = self._fitted(overrides, own)
        own = fitted.laid_out_for(own)
        wanted = SHUT if is_shut(number, cast("float", own.pop(BLOCKED, 0.0))) else REACHABLE
        robots = 1 if self.places_robots else int(cast("int", own.pop(ROBOTS, 1)))
        fleet = int(cast("int", complete.get(ROBOTS, 1)))
        # Try layouts until one is proved to be solvable.
        crowded: InvalidParameter | None = None
        first = 0
        most = MAX_CAR_ATTEMPTS if overrides.drive == "car" else _attempts(fleet)
        for attempt in range(most):
            if attempt < first:
                continue
            rng = stream_for(number, self.name, attempt)
            if robots > 1 and attempt == MAX_NARROW_ATTEMPTS:
                own |= self._wide_passages(own)
            with _placing(fleet, attempt) as work:
                try:
                    world = fitted.put_into(self.build(rng, **own))
                    decision = _decided(world, margin)
                    if decision.result != REACHABLE and overrides.drive == "car" and self.changes:
                        world = with_spared_path(world)
                        decision = _decided(world, margin)
                    if decision.result == REACHABLE and robots > 1:
                        stream = rng.child(ROBOTS)
                        world, decision = self._with_robots(world, stream, robots, margin, work)
                except InvalidParameter as full:
                    # Another layout may have room for more of a crowd.
                    if overrides.footprint is not None:
                        radius = own.get("robot_radius")
                        words = " (a footprint of {body} takes the passages of a disc of {disc} m)"
                        message = full.message.before(words, body=overrides.footprint, disc=radius)
                        raise InvalidParameter.of(message) from full
                    if fleet <= FEW_ROBOTS or not _is_of_crowd(full):
                        raise
                    # Report the most robots that had paths, or else the most
                    # that there was room for.
                    if crowded is None or _how_full(full) > _how_full(crowded):
                        crowded = full
                    # If not even half of them fit, wider passages may help, but no other layout.
                    if 2 * full.facts["placed"] < fleet:
                        is_narrow = attempt < MAX_NARROW_ATTEMPTS and not self.places_robots
                        first = MAX_NARROW_ATTEMPTS if is_narrow else MAX_CROWD_ATTEMPTS
                    continue
            if wanted == SHUT:
                world, decision = shut(world, decision, rng.child(BLOCKED))
            if decision.result == wanted:
                provenance = self.provenance(number, complete)
                return replace(world, certificate=decision.certificate, provenance=provenance)
        if crowded is not None:
            raise crowded
        raise self._no_layout(complete, attempt + 1, number)

    @property
    def robot_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the robot's body, drive and goal that every family of one robot has.

        A family's own parameter of the same name comes first.
        """
        own = {known.name for known in self.parameters}
        declared = () if self.places_robots else RobotOverrides.declared()
        return tuple(known for known in declared if known.name not in own)

    def overrides(self, params: Mapping[str, Value | None]) -> RobotOverrides:
        """Return the robot's body, drive and goal, of all of a world's parameters."""
        names = {known.name for known in self.robot_parameters}
        return RobotOverrides.of({name: params[name] for name in params if name in names})

    def provenance(self, seed: int, complete: Mapping[str, Value]) -> Provenance:
        """Return the origin of a world: with several robots, it names the planner's version too.

        Args:
            seed: Seed of the world.
            complete: All of its parameters, see :meth:`complete`.
        """
        robots = int(cast("int", complete.get(ROBOTS, 1)))
        version = CROWD_PLANNER_VERSION if robots > FEW_ROBOTS else PLANNER_VERSION
        planner = {PLANNER: version} if robots != 1 else {}
        return Provenance(self.name, self.version, seed, {**complete, **planner})

    def _no_layout(self, complete: Mapping[str, Value], layouts: int, seed: int) -> Exception:
        """Return the error for parameters with which this many layouts are not solvable."""
        overrides = self.overrides(complete)
        is_fleet = complete.get(ROBOTS, 1) != 1
        # Say which parameters leave no room.
        shown = [parameter.name for parameter in self.parameters] + list(overrides.given())
        settings = ", ".join(f"{name}={complete[name]}" for name in shown)
        return GenerationFailed(
            "no-layout-found",
            "{family}: none of {layouts} layouts lets "
            + (f"{complete[ROBOTS]} robots" if is_fleet else "the robot")
            + " through"
            + (" and has room for a cut" if BLOCKED in complete else "")
            + " (seed {seed}; {settings})",
            "give it more room: a larger size"
            + (" or cell_size, a smaller footprint" if overrides.changes_body else "")
            + ("" if overrides.changes_body else ", a smaller robot_radius")
            + (", a smaller target_radius" if overrides.target_radius is not None else "")
            + ", or fewer obstacles"
            + (" or robots" if is_fleet else ""),
            family=self.name,
            layouts=layouts,
            seed=seed,
            settings=settings,
        )

    def _with_robots(
        self, world: World, rng: RandomStream, robots: int, margin: float, work: Work
    ) -> tuple[World, Decision]:
        """Return the world with more robots, and whether all of them can arrive."""
        from worldgen.reach.joint.placing import place_robots  # noqa: PLC0415 - few worlds need it

        if robots > FEW_ROBOTS:
            placed = place_robots(world, rng, robots, self.name, margin=margin)
            return placed, _decided(placed, margin)
        for number in range(MAX_PLACEMENTS):
            work.say(f"placement {number + 1} of {MAX_PLACEMENTS}")
            placed = place_robots(world, rng.child(number), robots, self.name)
            decision = decide(placed, margin=margin, cut=False)
            if decision.result == REACHABLE:
                break
        return placed, decision

    def _wide_passages(self, own: Mapping[str, Value]) -> dict[str, Value]:
        """Return widths for passages with no width given, so that two robots can pass."""
        wanted = [known for known in self.parameters if known.name in _PASSAGES]
        radius = own.get("robot_radius")
        cell_size = own.get("cell_size")
        if not isinstance(radius, float) or not isinstance(cell_size, float):
            return {}
        width = math.ceil(4 * in_cells(radius, cell_size))
        return {
            known.name: width
            for known in wanted
            if known.bounds is not None and own[known.name] == known.bounds.chosen
        }

    @functools.cached_property
    def places_robots(self) -> bool:
        """True if the family itself declares ``robots`` and places them."""
        return any(known.name == ROBOTS for known in self.parameters)

    def __repr__(self) -> str:
        return f"<family {self.name}, version {self.version}>"

    def __getattr__(self, name: str) -> Any:
        # On the class, inspect.signature(Family) would find it too; only a family has its own
        # parameters.
        if name == "__signature__":
            return self._signature()
        raise AttributeError(
            f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self
        )

    def _signature(self) -> inspect.Signature:
        seed = inspect.Parameter(
            "seed", inspect.Parameter.POSITIONAL_OR_KEYWORD, default=0, annotation=int
        )
        own = [
            inspect.Parameter(
                known.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=known.python_default,
                annotation=known.annotation,
            )
            for known in self.all_parameters
        ]
        return inspect.Signature([seed, *own], return_annotation=World)

    def _documentation(self) -> str:
        """Return the function's docstring, worded for the family's caller."""
        text = inspect.cleandoc(self.build.__doc__ or "")
        try:
            parameters = self.all_parameters
        except InvalidParameter:  # an error reports that when the family is used
            return text
        notes = [
            "seed: An integer or a NumPy generator. Equal seeds and parameters give equal worlds."
        ]
        notes += [f"{known.name}: {known.note}".rstrip() for known in parameters]
        indented = [
            textwrap.fill(
                note, 100, initial_indent=" " * 4, subsequent_indent=" " * 8, break_on_hyphens=False
            )
            for note in notes
        ]
        arguments = "\n".join(["Args:", *indented, ""])
        before, found, after = text.partition("Args:\n")
        if not found:
            return f"{text}\n\n{arguments}".lstrip()
        rest = re.search(r"^(?=\S)", after, flags=re.MULTILINE)
        return f"{before}{arguments}\n{after[rest.start() :] if rest else ''}".rstrip()

    @functools.cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The family's parameters, in order of declaration.

        Raises:
            InvalidParameter: If an annotation names something that does not exist at run time.
        """
        return parameters_of(self.build, f"family {self.name!r}")

    @property
    def all_parameters(self) -> tuple[Parameter, ...]:
        """Its own parameters, and ``robots`` and ``blocked`` unless it places several robots."""
        if self.places_robots:
            return self.parameters
        return (*self.parameters, ROBOTS_PARAMETER, BLOCKED_PARAMETER)

    @property
    def description(self) -> str:
        """The docstring up to its first section."""
        text = inspect.cleandoc(self.build.__doc__ or "")
        return re.split(r"^(?:Args|Returns|Raises|Source):", text, maxsplit=1, flags=re.MULTILINE)[
            0
        ].strip()

    def defaults(self) -> dict[str, Value]:
        """Return every parameter with its default, in order of declaration."""
        return {parameter.name: parameter.default for parameter in self.parameters}

    def options(self, params: Mapping[str, Value]) -> list[str]:
        """Return the command-line arguments for these parameters.

        Defaults are omitted.
        """
        words: list[str] = []
        for parameter in (*self.all_parameters, *self.robot_parameters):
            value = params.get(parameter.name, parameter.default)
            flag = parameter.name.replace("_", "-")
            if value == parameter.default:
                continue
            if isinstance(value, bool):
                words.append(f"--{flag}" if value else f"--no-{flag}")
            else:
                words += [f"--{flag}", str(value)]
        return words

    def complete(self, params: Mapping[str, Value | None]) -> dict[str, Value]:
        """Return the parameters with defaults filled in, as :attr:`build` expects them.

        Raises:
            InvalidParameter: If a name is unknown, or a value has a different type than the
                default, or is out of bounds; or if they belong to a world whose robots were placed
                by another version.
        """
        if PLANNER in params:
            complete = self.complete({name: params[name] for name in params if name != PLANNER})
            fixed = self.provenance(0, complete).params
            if PLANNER not in fixed:
                find_parameter(PLANNER, self.all_parameters, self.name)
            self._check_planner(cast("Value", params[PLANNER]), fixed[PLANNER])
            return complete
        robot = self.overrides(params)
        if robot.given():
            names = {known.name for known in self.robot_parameters}
            rest = {name: value for name, value in params.items() if name not in names}
            return self.complete(self._suited(robot, rest)) | robot.given()
        known = {parameter.name: parameter for parameter in self.parameters}
        if ROBOTS in params and not self.places_robots:
            robots = ROBOTS_PARAMETER.accept(params[ROBOTS], self.name)
            if robots != 1 and params.get(BLOCKED) not in (None, 0, 0.0):
                raise InvalidParameter(
                    "not-for-fleets",
                    "{option} is for worlds of one robot, and robots={robots}",
                    "omit one of the two",
                    option=option_flag(BLOCKED),
                    robots=robots,
                )
            rest = {name: value for name, value in params.items() if name != ROBOTS}
            # The provenance of a world of one robot stays as it always was.
            return self.complete(rest) | ({ROBOTS: robots} if robots != 1 else {})
        if BLOCKED in params and BLOCKED_PARAMETER in self.all_parameters:
            share = BLOCKED_PARAMETER.accept(params[BLOCKED], self.name)
            rest = {name: value for name, value in params.items() if name != BLOCKED}
            # The provenance of a world that can be solved stays as it always was.
            return self.complete(rest) | ({BLOCKED: share} if share != 0.0 else {})
        others = {known.name for known in self.robot_parameters}
        for name in params:
            if name not in others:
                find_parameter(name, (*self.all_parameters, *self.robot_parameters), self.name)
        return {
            name: parameter.accept(params.get(name, parameter.default), self.name)
            for name, parameter in known.items()
        }

    def _suited(
        self, overrides: RobotOverrides, params: dict[str, Value | None]
    ) -> dict[str, Value | None]:
        """Return the parameters with the sizes that suit a body, unless they are given.

        ``robot_radius`` is that of the disc for which the layout is made.
        """
        robots = params.get(ROBOTS, 1)
        if robots not in (None, 1):
            raise InvalidParameter(
                "not-for-fleets",
                "{option} is for worlds of one robot, and robots={robots}",
                "omit one of the two",
                option=option_flag(next(iter(overrides.given()))),
                robots=robots,
            )
        given = {name: value for name, value in params.items() if value is not None}
        known = {one.name for one in self.parameters}
        suited = self._fitted(overrides, given).suited_sizes()
        return {**{name: size for name, size in suited.items() if name in known}, **given}

    def _fitted(self, overrides: RobotOverrides, params: Mapping[str, Value | None]) -> FittedRobot:
        """Return the robot of a world with these parameters."""
        radius = params.get("robot_radius")
        fitted = FittedRobot(overrides, any_heading=self.changes)
        return replace(fitted, radius=float(radius)) if isinstance(radius, int | float) else fitted

    def _check_planner(self, value: Value, here: Value) -> None:
        if value != here:
            raise InvalidParameter(
                "other-version",
                "{family}: {name} is {value!r}, but here it is {here!r}",
                "this version makes other worlds: use the version that made the world",
                family=self.name,
                name=PLANNER,
                value=str(value)[:60],
                here=str(here),
            )


def _is_of_crowd(error: InvalidParameter) -> bool:
    """Return True if an error says how many robots a layout has room for.

    A family that places its own robots may use the same codes with other facts.
    """
    return error.code in _CROWDED and isinstance(error.facts.get("placed"), int)


def _how_full(error: InvalidParameter) -> tuple[int, int]:
    """Return a sort key for errors of crowded layouts; the highest is the most informative."""
    return _CROWDED.index(error.code), int(error.facts["placed"])


def _attempts(robots: int) -> int:
    """Return the number of layouts that are tried for this many robots."""
    if robots == 1:
        return MAX_ATTEMPTS
    return MAX_FLEET_ATTEMPTS if robots <= MOST_TOGETHER else MAX_CROWD_ATTEMPTS


def _decided(world: World, margin: float) -> Decision:
    """Return whether the robots of a world can arrive.

    A witness that comes with the world counts only if it holds: a family can change a world that
    another one has proved.
    """
    if isinstance(world.certificate, Witness | JointWitness):
        from worldgen.reach import check_certificate  # noqa: PLC0415 - it loads shapely

        if check_certificate(world).valid:
            return Decision(REACHABLE, world.certificate, "proved where the robots were placed")
    return decide(world, margin=margin, cut=False)


def _placing(robots: int, attempt: int) -> AbstractContextManager[Work]:
    """Report the layout that is tried for several robots, once that may take a while."""
    message = f"placing {robots} robots in layout {attempt + 1} of at most {_attempts(robots)}"
    if robots < _MANY_ROBOTS and (robots == 1 or attempt == 0):
        return nullcontext(Work(message))
    return working(message, often=True)


def _check_signature(name: str, build: Build) -> None:
    check_declared(build, f"family {name!r}", _TAKEN)
    for parameter in list(inspect.signature(build).parameters.values())[1:]:
        if parameter.name == MARGIN and type(parameter.default) is not float:
            raise InvalidParameter(
                "reserved-name",
                "family {name!r}: {parameter} is the margin of the witness in seconds",
                "give it a default that is a float, or rename the parameter",
                name=name,
                parameter=MARGIN,
            )


def family(name: str, *, version: int, changes: bool = False) -> Callable[[Build], Family]:
    """Make a family from a function ``(rng, *, size=..., ...) -> World``.

    Register it as an entry point. A parameter called ``margin`` has a special meaning: the robot
    may set out this many seconds late on the world's witness and still arrive.

    Args:
        name: The noun for its worlds.
        version: Version of the worlds that seeds yield.
        changes: True if its worlds change with time.

    Raises:
        InvalidParameter: If a parameter is positional, has no plain default, or is called name or
            seed, or ``margin`` isn't a float.
    """

    def decorate(build: Build) -> Family:
        _check_signature(name, build)
        return Family(name, version, build, changes)

    return decorate


def _accept(name: str, thing: Any) -> Family:
    if not isinstance(thing, Family):
        raise InvalidParameter(
            "wrong-type",
            "family {name!r} is {value!r}, not a Family",
            "decorate its function with @family",
            name=name,
            value=thing,
        )
    return thing


FAMILIES = Registry[Family]("worldgen.families", "family", _accept)


def stream_for(seed: int, family_name: str, attempt: int) -> RandomStream:
    """Return the random stream of one attempt of one family."""
    return RandomStream(seed).child(family_name, attempt)
