"""``worldgen fuzz``: a campaign on the command line."""

from __future__ import annotations

from pathlib import Path

import click

from fuzz.commands._options import Duration, output_options
from worldgen.cli.output import CONTROLLER_HELP, draw_seed, force_option, json_option, seed_option

__all__ = ["fuzz"]

EXAMPLES = (
    "\b\n  worldgen fuzz --controller turn-right --motion stepped --budget 30s --seed 1 --out failures/\n"
    "  worldgen fuzz --controller ./mine.py:Robot --family trap --units 20 --out failures/\n"
    "  worldgen fuzz --controller turn-left --world map.grid --budget 1m --out failures/\n"
    "  worldgen fuzz --controller bug1 --vary sensor_noise=0,0.1 --vary robot_speed=1,2 --out failures/\n"
    "  worldgen fuzz --controller bug1 --detour 5 --oracle turn --budget 30s --out failures/"
)


@click.command(epilog=EXAMPLES)
@click.option("--controller", required=True, help=CONTROLLER_HELP)
@click.option("--motion", default="swept", show_default=True, help="Motion model.")
@click.option("--family", "families", multiple=True, help="Draw worlds from this family; may be repeated.")
@click.option("--world", type=click.Path(path_type=Path), help="Keep this map; vary start, target and radius.")
@click.option("--budget", type=Duration(), metavar="TIME", help="Search this long: 30s, 5m, 1h [default: 30s].")
@click.option("--units", type=click.IntRange(1), help="Do this much work; the result depends on the seed alone.")
@click.option("--workers", type=click.IntRange(1, 256), help="Processes [default: one a core].")
@click.option("--time-step", type=float, help="Duration of a step, s [default: the motion model's].")
@click.option(
    "--vary",
    multiple=True,
    metavar="NAME=VALUE,...",
    help="Draw robot_radius, robot_speed, time_step or an option of the motion model from these values, "
    "the simplest first; may be repeated.",
)
@click.option("--examples", type=click.IntRange(1, 100_000), default=400, show_default=True, help="Draws a unit.")
@click.option(
    "--detour",
    type=click.FloatRange(1.0),
    metavar="RATIO",
    help="Arriving by a longer way than RATIO times the witness's is a failure too; the same as --oracle detour=RATIO.",
)
@click.option(
    "--oracle",
    "oracles",
    multiple=True,
    metavar="NAME[=NUMBER]",
    help="Ask this oracle about each run: "
    "detour, repeat, turn, shift, scale, mirror, finer, wall, block, or ./file.py:name; may be repeated.",
)
@click.option("--shrink/--no-shrink", default=None, help="Shrink failures [default: yes, but not with --world].")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for the failures.")
@output_options
@seed_option
@json_option
@force_option
def fuzz(
    controller: str,
    motion: str,
    families: tuple[str, ...],
    world: Path | None,
    budget: float | None,
    units: int | None,
    workers: int | None,
    time_step: float | None,
    vary: tuple[str, ...],
    examples: int,
    detour: float | None,
    oracles: tuple[str, ...],
    shrink: bool | None,
    out: Path,
    seed: int | None,
    as_json: bool,
    force: bool,
    **outputs: Path | None,
) -> None:
    """Search for worlds in which a controller fails; prove, shrink and save what is found.

    Writes one .grid file for each class of failure, the smallest world of it. Exit code 1 if there is any,
    0 if not. Ctrl-C keeps what was found.
    """
    import os

    from fuzz.ci import Outputs
    from fuzz.session import CampaignSession, configure
    from worldgen.grid_file import read_world

    if budget is not None and units is not None:
        raise click.UsageError("give --budget or --units, not both")
    if world is not None and families:
        raise click.UsageError("give --world or --family, not both: on a map only the poses vary")
    reports = Outputs(**outputs, force=force)
    reports.check()
    config = configure(
        controller=controller,
        motion=motion,
        families=families,
        fixed_map=None if world is None else read_world(world),
        time_step=time_step,
        vary=vary,
        examples=examples,
        shrink=shrink,
        oracles=oracles if detour is None else (f"detour={detour!r}".removesuffix(".0"), *oracles),
        seed=draw_seed(seed),
    )
    session = CampaignSession(
        config,
        out,
        units=units,
        seconds=None if units else budget or 30.0,
        workers=workers or os.cpu_count() or 1,
        force=force,
        quiet=as_json,
        outputs=reports,
    )
    raise SystemExit(session.run())
