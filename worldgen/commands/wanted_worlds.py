"""``worldgen FAMILY --where ... --difficulty ...``: search for worlds instead of only drawing them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import draw_seed, emit_json, note, say
from worldgen.commands.set_output import make_many
from worldgen.errors import GenerationFailed
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.difficulty.search import Nearest, Search
    from worldgen.family import Family
    from worldgen.world import Value

__all__ = ["CONSTRAINT_OPTIONS", "flag_of", "given_parameters", "make_wanted"]

_TRIES = 500
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
        help="Search for a world whose metrics meet it: 'detour > 3 and bottleneck < 1.2r'. Parameters "
        "not given vary.",
    ),
    click.option(
        "--difficulty",
        type=Difficulty(),
        help="Search for a world of this difficulty, 0 to 1; with a range and --count, spread a "
        "set over the range.",
    ),
    click.option(
        "--tries",
        type=click.IntRange(1, 1_000_000),
        help=f"Maximum number of worlds to try per world found.  [default: {_TRIES}]",
    ),
)


def given_parameters(params: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters that were given, not left at their defaults."""
    source = click.get_current_context().get_parameter_source
    default = click.core.ParameterSource.DEFAULT
    return {name: value for name, value in params.items() if source(name) is not default}


def make_wanted(
    made_by: Family,
    name: str,
    seed: int | None,
    params: Mapping[str, Value],
    *,
    where: str | None,
    difficulty: tuple[float, ...] | None,
    tries: int | None,
    count: int | None,
    out: Path | None,
    metrics: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Search and write the results: one world, or a set.

    Raises:
        Exit: With code 1 if no fitting world was found; those found before are kept.
    """
    from worldgen.difficulty.search import Search, constraint_for, found
    from worldgen.sets import plan_wanted_set

    # A range of difficulty asks for a stratified set, or for one world anywhere in it.
    if difficulty is not None and len(difficulty) == 2:
        if count is not None and out is not None:
            _make_stratified(
                made_by, seed, params, where=where, ends=(difficulty[0], difficulty[1]), tries=tries, count=count,
                out=out, metrics=metrics, force=force, as_json=as_json,
            )  # fmt: skip
            return
        where = _within(difficulty[0], difficulty[1], where)
    constraint = constraint_for(
        where, difficulty[0] if difficulty is not None and len(difficulty) == 1 else None
    )
    search: Search | None = None
    results: list[dict[str, Any]] = []
    # Search for a set, or for one world.
    try:
        with working(f"searching for {constraint.text}") as work:

            def progress(now: Search) -> None:
                nonlocal search
                search = now
                work.say(lambda: _how_near(now))

            if count is not None and out is not None:
                plan = plan_wanted_set(
                    made_by,
                    0,
                    count,
                    params,
                    where=constraint.text,
                    tries=tries or _TRIES,
                    metrics=metrics,
                    tell=progress,
                )
                make_many(plan, seed, out, workers=1, force=force, as_json=as_json)
                return
            search = Search(made_by, constraint, draw_seed(seed), params)
            for one in found(search, 1, tries or _TRIES, progress):
                results.append(
                    _write(
                        one,
                        out,
                        made_by,
                        name,
                        params,
                        metrics=metrics,
                        force=force,
                        as_json=as_json,
                    )
                )
    # Report the nearest world if none fits.
    except GenerationFailed as failure:
        note(f"worldgen: {failure}", always=True)
        if as_json:
            emit_json(
                {
                    "constraint": constraint.text,
                    "tried": search.tried if search else 0,
                    "nearest": _nearest(search),
                }
            )
        raise click.exceptions.Exit(1) from failure
    if as_json:
        emit_json({"constraint": constraint.text, "tried": search.tried, **results[0]})


def _within(low: float, high: float, where: str | None) -> str:
    """Return the constraint for one world anywhere in a range of difficulty."""
    from worldgen.difficulty import parse
    from worldgen.difficulty.strata import check_range

    check_range(low, high)
    if where is not None:
        # Its messages quote only what was written.
        parse(where)
    return f"{low:g} <= difficulty <= {high:g}" + (f" and ({where})" if where else "")


def _make_stratified(
    made_by: Family,
    seed: int | None,
    params: Mapping[str, Value],
    *,
    where: str | None,
    ends: tuple[float, float],
    tries: int | None,
    count: int,
    out: Path,
    metrics: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Make a set spread over a range of difficulty, and print how many worlds each stratum has."""
    from worldgen.sets import manifest_of, plan_stratified_set, strata_of

    plan = plan_stratified_set(
        made_by,
        0,
        count,
        params,
        difficulty=ends,
        where=where,
        tries=tries or _TRIES,
        metrics=metrics,
    )
    try:
        make_many(plan, seed, out, workers=1, force=force, as_json=as_json)
    except GenerationFailed as failure:
        note(f"worldgen: {failure}", always=True)
        if as_json:
            emit_json(
                {
                    "constraint": plan.header.constraint,
                    "count": count,
                    "out": str(out),
                    "error": str(failure),
                }
            )
        raise click.exceptions.Exit(1) from failure
    # Then report each stratum, and why any of its worlds is missing.
    for stratum in strata_of(manifest_of(out)):
        missing = stratum.share - stratum.worlds
        why = (
            f"  {missing} fewer than its share: no more were found, and its neighbours got them"
            if missing > 0
            else ""
        )
        note(f"  difficulty {stratum.low:g} to {stratum.high:g}: {stratum.worlds}{why}")


def _write(
    one: Nearest,
    file: Path | None,
    made_by: Family,
    name: str,
    params: Mapping[str, Value],
    *,
    metrics: bool,
    force: bool,
    as_json: bool,
) -> dict[str, Any]:
    from worldgen.difficulty import with_metrics
    from worldgen.files.grid import dumps, world_digest, write_world

    world = with_metrics(one.world) if metrics else one.world
    if file is not None:
        write_world(world, file, force=force)
    elif not as_json:
        say(dumps(world).decode(), nl=False)
    values = ", ".join(f"{metric} {value:g}" for metric, value in one.metrics.items())
    again = _command(made_by, name, one.seed, {**params, **one.params})
    note(
        (f"{file}: " if file is not None else "")
        + f"fits at try {one.number}: {values}\n  made again by: {again}"
    )
    made = world.provenance
    return {
        "file": None if file is None else str(file),
        "seed": one.seed,
        "params": {} if made is None else made.params,
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
