"""``worldgen FAMILY --where ... --difficulty ...``: search for worlds instead of drawing them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import draw_seed, emit_data, emit_json, note
from worldgen.cli.robot_options import warn_of_start_in_target
from worldgen.cli.set_output import Output, make_many
from worldgen.errors import GenerationFailed
from worldgen.robot_overrides import RobotOverrides
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.difficulty.search import Nearest, Search
    from worldgen.family import Family
    from worldgen.world import Value

_ROBOT = {"robot_radius": "radius", "robot_speed": "speed"}


class Difficulty(click.ParamType[tuple[float, ...]]):
    """A difficulty, ``0.8``, or a range of difficulty, ``0.1..0.9``."""

    name = "D or D..D"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Parse one number, or the two ends of a range."""
        if isinstance(value, tuple):
            return value
        try:
            numbers = tuple(float(word) for word in str(value).split(".."))
        except ValueError:
            numbers = ()
        if len(numbers) not in (1, 2):
            self.fail(
                f"{value!r} is neither a difficulty, such as 0.8, nor a range of it, such as "
                f"0.1..0.9",
                param,
                ctx,
            )
        return numbers


CONSTRAINT_OPTIONS = (
    click.option(
        "--where",
        metavar="CONDITION",
        help=(
            "Search for a world whose metrics meet it: 'detour > 3 and bottleneck < 1.2r'. "
            "Parameters that you do not set vary."
        ),
    ),
    click.option(
        "--difficulty",
        type=Difficulty(),
        help="Search for a world of this difficulty, 0 to 1; with a range and --count, spread a "
        "set over the range.",
    ),
)


def given_parameters(params: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters that were given, not left at their defaults."""
    source = click.get_current_context().get_parameter_source
    default = click.core.ParameterSource.DEFAULT
    return {name: value for name, value in params.items() if source(name) is not default}


@dataclass(frozen=True)
class WorldQuery:
    """Which worlds to search for.

    Args:
        where: A constraint on their metrics.
        difficulty: Their difficulty, or the two ends of its range.
    """

    where: str | None
    difficulty: tuple[float, ...] | None


def make_wanted(
    made_by: Family,
    name: str,
    seed: int | None,
    params: Mapping[str, Value],
    query: WorldQuery,
    to: Output,
) -> None:
    """Search and write the results: one world, or a set.

    Raises:
        Exit: With code 1 if no fitting world was found; those found before are kept.
    """
    from worldgen.difficulty.search import TRIES, Search, constraint_for
    from worldgen.sets import plan_wanted_set

    # A range of difficulty requests worlds that are spread over it, or one world anywhere in it.
    low, *more = query.difficulty or (None,)
    difficulty = (low, more[0]) if low is not None and more else low
    constraint = constraint_for(query.where, difficulty)
    search: Search | None = None
    results: list[dict[str, Any]] = []
    # Search for a set, or for one world.
    try:
        with working(f"searching for {constraint.text}") as work:

            def progress(now: Search) -> None:
                nonlocal search
                search = now
                work.say(lambda: _how_near(now))

            if to.count is not None and to.path is not None:
                plan = plan_wanted_set(
                    made_by,
                    0,
                    to.count,
                    params,
                    where=query.where,
                    difficulty=difficulty,
                    metrics=to.metrics is not False,
                    tell=progress,
                )
                make_many(plan, seed, to.path, force=to.force, as_json=to.as_json)
                _note_strata(to.path)
                return
            search = Search(made_by, constraint, draw_seed(seed), params)
            for one in search.found(1, TRIES, progress):
                again = _command(made_by, name, one.seed, {**params, **one.params})
                results.append(_write(one, again, to))
    # Report the nearest world if none fits.
    except GenerationFailed as failure:
        note(f"worldgen: {failure}", always=True)
        if to.as_json:
            emit_json(
                {
                    "constraint": constraint.text,
                    "tried": search.tried if search else 0,
                    "nearest": _nearest(search),
                }
            )
        raise click.exceptions.Exit(1) from failure
    if to.as_json:
        emit_json({"constraint": constraint.text, "tried": search.tried, **results[0]})


def _note_strata(out: Path) -> None:
    """Print how many worlds each stratum of a set has, and why any of its worlds is missing."""
    from worldgen.sets import manifest_of, strata_of

    for stratum in strata_of(manifest_of(out)):
        missing = stratum.share - stratum.worlds
        why = (
            f"  {missing} fewer than its share: no more were found, so its neighbours have more"
            if missing > 0
            else ""
        )
        note(f"  difficulty {stratum.low:g} to {stratum.high:g}: {stratum.worlds}{why}")


def _write(one: Nearest, again: str, to: Output) -> dict[str, Any]:
    """Write a world that was found, with the command that makes it again; return its facts."""
    from worldgen.difficulty import with_metrics
    from worldgen.files.grid import dumps, world_digest, write_world

    file = to.path
    metrics = to.metrics is not False
    world = with_metrics(one.world) if metrics else one.world
    if file is not None:
        write_world(world, file, force=to.force)
    elif not to.as_json:
        emit_data(dumps(world).decode())
    values = ", ".join(f"{metric} {value:g}" for metric, value in one.metrics.items())
    place = f"{file}: " if file is not None else ""
    note(f"{place}fits at try {one.number}: {values}")
    note(f"  to make it again: {again}")
    made = world.provenance
    params = {} if made is None else made.params
    warn_of_start_in_target(RobotOverrides.of(params), world, place)
    return {
        "file": None if file is None else str(file),
        "seed": one.seed,
        "params": params,
        "metrics": one.metrics if made is None or not metrics else made.metrics,
        "digest": world_digest(world),
        "try": one.number,
    }


def flag_of(parameter: str, made_by: Family) -> str:
    """Return the name of a parameter's option, without the dashes.

    The robot's options have the same names as in every other command.
    """
    short = _ROBOT.get(parameter)
    own = {one.name for one in made_by.parameters}
    return parameter.replace("_", "-") if short is None or short in own else short


def _command(made_by: Family, name: str, seed: int, params: Mapping[str, Value]) -> str:
    words = ["worldgen", name, "--seed", str(seed)]
    for key, value in params.items():
        flag = flag_of(key, made_by)
        words += (
            [f"--{flag}" if value else f"--no-{flag}"]
            if isinstance(value, bool)
            else [f"--{flag}", str(value)]
        )
    return shlex.join(words)


def _nearest(search: Search | None) -> dict[str, Any] | None:
    near = None if search is None else search.nearest
    return (
        None
        if near is None
        else {"seed": near.seed, "params": near.params, "metrics": near.metrics}
    )


def _how_near(search: Search) -> str:
    near = search.nearest
    values = (
        ""
        if near is None
        else "; nearest: " + ", ".join(f"{name} {value:g}" for name, value in near.metrics.items())
    )
    return f"{search.tried:,} worlds tried{values}"
