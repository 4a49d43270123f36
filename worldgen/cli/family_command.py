"""``worldgen FAMILY``: a command made from a family's own parameters."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from worldgen.cli.declared_options import declared_options
from worldgen.cli.output import (
    PATH,
    draw_seed,
    emit_data,
    emit_json,
    force_option,
    json_option,
    named_also,
    note,
    seed_option,
)
from worldgen.cli.robot_options import note_axle, warn_of_start_in_target
from worldgen.cli.set_output import Output, make_many
from worldgen.cli.usage import ConditionalCommand, missing
from worldgen.cli.wanted_worlds import (
    CONSTRAINT_OPTIONS,
    WorldQuery,
    flag_of,
    given_parameters,
    make_wanted,
)
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.family import Family, Parameter
    from worldgen.support.progress import Work
    from worldgen.world import Cut, JointWitness, Value, Witness, World

_EXAMPLES = (
    "\b\n  worldgen {name} --seed 7 --out w.grid\n  worldgen {name} --count 20 --out worlds/\n"
    "  worldgen {name} --where 'detour > 2' --out w.grid"
)


@functools.cache
def family_command(name: str) -> click.Command:
    """Return the command that generates worlds of one family.

    Raises:
        InvalidParameter: If no family has that name.
    """
    from worldgen.family import FAMILIES

    return command_of(FAMILIES.get(name), name)


def command_of(made_by: Family, name: str) -> click.Command:
    """Return the command that generates worlds of this family."""

    def command(
        seed: int | None,
        count: int | None,
        out: Path | None,
        metrics: bool | None,
        where: str | None,
        difficulty: tuple[float, ...] | None,
        force: bool,
        as_json: bool,
        **params: Any,
    ) -> None:
        # A body decides the sizes that are not given.
        params = given_parameters(params)
        note_axle(made_by.overrides(params))
        # Search for a world with the requested properties, or make one, or a set of them.
        place = _set_place(count, out)
        to = Output(out, None if place is None else count, metrics, force, as_json)
        if where is not None or difficulty is not None:
            query = WorldQuery(where, difficulty)
            make_wanted(made_by, name, seed, params, query, to)
        elif place is None:
            _make_one(made_by, draw_seed(seed), params, to)
        else:
            from worldgen.sets import plan_set

            plan = plan_set(name, 0, count or 1, params, metrics=metrics is not False)
            make_many(plan, seed, place, force=force, as_json=as_json)

    command.__doc__ = made_by.description
    # The last decorator applied is the first option in the help.
    for decorate in (
        json_option,
        force_option,
        *reversed((*_SET_OPTIONS, *CONSTRAINT_OPTIONS)),
        seed_option,
    ):
        command = decorate(command)
    command = declared_options(made_by.robot_parameters)(command)
    for parameter in reversed(made_by.all_parameters):
        command = _option(parameter, made_by)(command)
    epilog = _EXAMPLES.format(name=name)
    needs = {"out": _needs_folder}
    return click.command(name, cls=ConditionalCommand, needs=needs, epilog=epilog)(command)


def _needs_folder(given: Mapping[str, Any]) -> str:
    count = given.get("count") or 1
    return f"--count {count} writes {count} files, into a folder" if count > 1 else ""


def _set_place(count: int | None, out: Path | None) -> Path | None:
    """Return the place for a set, or None if a single file is wanted.

    Raises:
        UsageError: If there is no place for it, or the output's name is for the other kind.
    """
    from worldgen.files.archives import is_archive
    from worldgen.files.worlds import is_world_file

    if count is None and out is not None and is_archive(out):
        raise click.UsageError(f"{out} names an archive; set the number of worlds with --count")
    if count is None or (count == 1 and (out is None or is_world_file(out.name))):
        return None
    if out is None:
        raise missing("out", _needs_folder({"count": count}))
    if count > 1 and is_world_file(out.name):
        raise click.UsageError(
            f"{out} names the file of one world; for {count} worlds, choose a folder or an archive"
        )
    return out


_count_option = click.option(
    "--count",
    type=click.IntRange(1),
    help="Make a set of this many worlds, with consecutive seeds and a manifest.",
)
_out_option = click.option(
    "--out",
    type=PATH,
    help="File to write, .grid or .grid.gz; with --count a folder or a .zip. Without it, the world "
    "goes to stdout.",
)
_metrics_option = click.option(
    "--metrics/--no-metrics",
    default=None,
    help="Measure each world, and store the result in its file's header.  [default: a single world "
    "up to 2000 x 2000 cells, and sets]",
)
_SET_OPTIONS = (_count_option, _out_option, _metrics_option)


# Cells of the largest world measured by default; larger ones would take over 15 seconds.
_MEASURED = 4_000_000


def _option(parameter: Parameter, made_by: Family) -> Any:
    from worldgen.family import BLOCKED

    words = flag_of(parameter.name, made_by)
    flags = f"--{words}/--no-{words}" if isinstance(parameter.default, bool) else f"--{words}"
    earlier = parameter.name.replace("_", "-")
    option = (
        click.option if words == earlier else functools.partial(named_also, also=f"--{earlier}")
    )
    kind = click.Choice(parameter.choices) if parameter.choices else type(parameter.default)
    default = parameter.python_default
    if parameter.name == BLOCKED:
        # Alone, it means all worlds.
        option = functools.partial(option, is_flag=False, flag_value=1.0, metavar="[SHARE]")
    return option(
        flags, parameter.name, type=kind, default=default, show_default=True, help=parameter.note
    )


def _make_one(made_by: Family, seed: int, params: dict[str, Value], to: Output) -> None:
    from worldgen.files.grid import dumps, write_world

    out = to.path
    with working(f"making a world of {made_by.name}") as work:
        world = _made(made_by, seed, params, work, metrics=to.metrics)
        if out is not None:
            work.say(f"writing {out}")
            write_world(world, out, force=to.force)
        text = "" if to.as_json or out is not None else dumps(world).decode()
        result = _result(world, out)
    emit_data(text)
    warn_of_start_in_target(made_by.overrides(params), world)
    note(
        (f"{out}: " if out is not None else "")
        + f"{made_by.name} {world.width} x {world.height} cells{_for_robot(world)}, "
        + (f"{len(world.robots)} robots, joint " if world.is_fleet else "")
        + _proof(world, result)
        + f", seed {seed}"
    )
    if to.as_json:
        emit_json({**_identity(made_by, seed, params), **result})


def _proof(world: World, result: Mapping[str, Any]) -> str:
    """Return the proof in words."""
    from worldgen.world import Cut

    cut = world.certificate
    if isinstance(cut, Cut):
        return "blocked: a cut proves that the target cannot be reached"
    return f"witness {result['witness_length']:.4g} m in {result['witness_time']:.4g} s"


def _for_robot(world: World) -> str:
    """Return the size of the cells and the robot, if they were chosen to suit its body."""
    from worldgen.robot_overrides import describe_body

    robot = world.robots[0]
    if robot.is_round:
        return ""
    return f" of {world.cell_size:g} m for a {describe_body(robot)}"


def _identity(made_by: Family, seed: int, params: dict[str, Value]) -> dict[str, Any]:
    return {
        "family": made_by.name,
        "version": made_by.version,
        "seed": seed,
        "params": made_by.provenance(seed, made_by.complete(params)).params,
    }


def _made(
    made_by: Family, seed: int, params: dict[str, Value], work: Work, *, metrics: bool | None
) -> World:
    from worldgen.generation import generate

    work.say("drawing it and proving that its target can be reached")
    world = generate(made_by, seed, **params)
    if metrics is None and world.walls.size > _MEASURED:
        note(
            f"{world.width} x {world.height} cells are not measured by default; --metrics "
            f"measures them"
        )
        return world
    if metrics is False:
        return world
    from worldgen.difficulty import with_metrics

    work.say("measuring it; --no-metrics skips this")
    return with_metrics(world)


def _result(world: World, file: Path | None) -> dict[str, Any]:
    from worldgen.files.grid import world_digest
    from worldgen.world import Cut

    # generate() never returns a world without a proof.
    proof = cast("Witness | JointWitness | Cut", world.certificate)
    witness = None if isinstance(proof, Cut) else proof
    return {
        "file": None if file is None else str(file),
        "digest": world_digest(world),
        "result": "blocked" if witness is None else "reachable",
        "witness_length": None if witness is None else witness.length,
        "witness_time": None if witness is None else witness.duration,
    }
