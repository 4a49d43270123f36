"""``worldgen find``: search for a world in which given controllers have given outcomes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fuzz.commands._options import budget_options, seconds_of
from fuzz.unit.options import CampaignOptions
from sim.verdict import OUT_OF_BUDGET, Verdict
from worldgen.cli.declared_options import declared_options
from worldgen.cli.output import (
    PATH,
    draw_seed,
    emit_json,
    force_option,
    json_option,
    motion_option,
    note,
    say,
    seed_option,
    time_step_option,
    workers_option,
)

if TYPE_CHECKING:
    from fuzz.find import FindConfig, OutcomeSearch, OutcomeTarget, Result
    from worldgen.world import Pose, Value

EXAMPLES = (
    '\b\n  worldgen find --outcome "./mine.py:Robot=loop, turn-left=reached" --budget 1m --out '
    "w.grid\n"
    '  worldgen find --outcome "thesis-1=reached@330, thesis-2=loop" --motion stepped --family '
    "trap --out w.grid\n"
    '  worldgen find --outcome "thesis-1=stuck, thesis-3=reached" --motion stepped --from '
    "sketch.grid --out w.grid"
)


@click.command(epilog=EXAMPLES)
@click.option(
    "--outcome",
    "outcomes",
    required=True,
    multiple=True,
    help="CONTROLLER=OUTCOME, ...; see above.",
)
@declared_options([CampaignOptions.named("families")])
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Fix a parameter of the family."
)
@click.option("--from", "begin", type=PATH, help="Start from this world and edit it.")
@click.option("--start", metavar="X,Y,HEADING", help="Start pose of every world, m and rad.")
@click.option("--keep-target", is_flag=True, help="Do not move the target.")
@click.option(
    "--leash",
    type=click.IntRange(0),
    metavar="CELLS",
    help="Move walls and target at most this far, and add no walls.",
)
@click.option("--no-edit", is_flag=True, help="Do not edit worlds; use them as generated.")
@motion_option
@time_step_option
@budget_options("to search")
@workers_option
@click.option("--out", type=PATH, required=True, help="File to write the nearest world to.")
@seed_option
@json_option
@force_option
def find(
    outcomes: tuple[str, ...],
    families: tuple[str, ...],
    settings: tuple[str, ...],
    begin: Path | None,
    start: str | None,
    keep_target: bool,
    leash: int | None,
    no_edit: bool,
    motion: str,
    time_step: float | None,
    budget: float | None,
    units: int | None,
    workers: int | None,
    out: Path,
    seed: int | None,
    as_json: bool,
    force: bool,
) -> None:
    r"""Search for a world with the outcomes that you name.

    An outcome is a verdict (reached, loop, stalled, timeout, tunnel, overlap, contact, burned,
    crash, hang, invalid-command), stuck (loop or stalled; for random controllers also timeout), or fails
    (anything but reached). Add steps to reached, or the period to loop: reached@330,
    reached@300..400, reached@<400, reached@4.95s, loop@104. For a random controller, at least 19 of
    20 seeds must have that outcome; for a time, the median counts.

    The target of the written world can be reached. Exits with 0 if every outcome is as requested,
    with 1 otherwise. Ctrl-C writes the closest match so far and exits with 130.
    """
    import os

    from fuzz.find import FindConfig, OutcomeSearch, parse_targets
    from sim.options.run import RunOptions
    from worldgen.files.whole import check_output
    from worldgen.files.worlds import read_whole_world
    from worldgen.support.progress import working

    # Refuse contradicting options before any work.
    seconds = seconds_of(budget, units)
    for contradiction, reason in (
        (begin is not None and bool(families), "use --from or --family, not both"),
        (
            no_edit and not families,
            "--no-edit uses worlds as a family makes them; name a family with --family",
        ),
    ):
        if contradiction:
            raise click.UsageError(reason)
    # Define the search, and try its controllers.
    step = RunOptions(time_step=RunOptions.time_step if time_step is None else time_step).time_step
    targets = parse_targets(",".join(outcomes), motion=motion, time_step=step)
    config = FindConfig(
        targets=targets,
        seed=draw_seed(seed),
        families=families,
        params=tuple(_parameters(families, settings).items()),
        begin=None if begin is None else read_whole_world(begin),
        start=None if start is None else _pose(start),
        fixed_target=keep_target,
        leash=leash,
        edit=not no_edit,
    )
    with working("trying the controllers"):
        _try_out(config)
    check_output(out, force)
    search = OutcomeSearch(
        config, units=units, seconds=seconds, workers=workers or os.cpu_count() or 1
    )
    stopped = _watch(search, out, force)
    _report(search, targets, out, as_json)
    raise SystemExit(
        130 if stopped else 0 if search.best is not None and search.best.distance == 0.0 else 1
    )


def _watch(search: OutcomeSearch, out: Path, force: bool) -> bool:
    """Search, and write the nearest world in any case; return True if Ctrl-C ended the search."""
    from fuzz.campaign.executors import WorkersLost
    from worldgen.errors import OutputError
    from worldgen.files.grid import write_world
    from worldgen.support.plain_text import counted
    from worldgen.support.progress import working

    # Search, and record how the search ended.
    stopped = False
    broken = None
    try:
        with working("searching") as work:
            work.say(lambda: f"{counted(search.done, 'unit')}, {counted(search.tried, 'world')}")
            for found in search.run():
                off = f"off by {found.distance:.4g}" if found.distance else "as wanted"
                note(f"unit {found.unit}: {off}")
    except KeyboardInterrupt:
        stopped = True
    except WorkersLost as error:
        broken = error
    # Write the nearest world, no matter how the search ended.
    if search.best is not None:
        write_world(search.best.world, out, force=force)
    if broken is not None:
        kept = (
            f"the closest match so far is in {out}"
            if search.best
            else "no world was found before that"
        )
        raise OutputError(
            "worker-died",
            "a worker process died, perhaps killed by a controller or for lack of memory; {kept}",
            "try --workers 1",
            at_terminal=True,
            kept=kept,
        ) from broken
    return stopped


def _parameters(families: tuple[str, ...], settings: tuple[str, ...]) -> dict[str, Value]:
    """Return the parameters that ``--set`` fixes, with the types that the families declare."""
    from worldgen.errors import InvalidParameter
    from worldgen.family import FAMILIES
    from worldgen.parameters import parse_options

    words: dict[str, str | None] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not equals:
            raise InvalidParameter(
                "no-value",
                "{setting!q} sets no value",
                "write --set NAME=VALUE",
                at_terminal=True,
                setting=setting,
            )
        words[name.strip().replace("-", "_")] = text.strip()
    known = [parameter for name in families for parameter in FAMILIES.get(name).parameters]
    return parse_options(
        words, known, f"--family {', '.join(families)}" if families else "--set without --family"
    )


def _pose(text: str) -> Pose:
    from worldgen.errors import InvalidParameter
    from worldgen.world import Pose

    try:
        x, y, heading = (float(word) for word in text.split(","))
    except ValueError:
        raise InvalidParameter(
            "not-a-pose",
            "start={text!r} is not X,Y,HEADING",
            "write numbers, as in 0.35,2.65,-1.36",
            text=text,
        ) from None
    return Pose(x, y, heading)


def _try_out(config: FindConfig) -> None:
    """Draw a world and take two steps, so that mismatches show before the search."""
    from fuzz.find import draw
    from sim.episode.try_out import EMPTY_ARENA, try_out

    drawn = draw(config)
    for target in config.targets:
        try_out(target.scenario, EMPTY_ARENA if config.begin is None else drawn)


def _report(
    search: OutcomeSearch, targets: tuple[OutcomeTarget, ...], out: Path, as_json: bool
) -> None:
    from worldgen.support.plain_text import counted

    best = search.best
    if best is None:
        note(
            "no world with a reachable target was found; allow more time, or use another --family"
            if search.ended
            else "no run ended before the search did; allow more time with --budget, or fewer steps, "
            "as in reached@<400"
        )
    if as_json:
        emit_json(
            {
                "file": str(out) if best else None,
                "exact": best is not None and best.distance == 0.0,
                "distance": best.distance if best else None,
                "seed": search.config.seed,
                "units": search.done,
                "worlds": search.tried,
                "outcomes": [
                    {
                        "controller": target.scenario.label(),
                        "wanted": target.text,
                        "budget": target.steps,
                        "verdict": result.verdict,
                        "steps": result.steps,
                        "reached": result.share,
                        "seeds": result.seeds,
                        "distance": result.distance,
                    }
                    for target, result in zip(
                        targets, best.results if best else (), strict=best is not None
                    )
                ],
            }
        )
        return
    if best is None:
        return
    for target, result in zip(targets, best.results, strict=True):
        off = "as wanted" if result.distance == 0.0 else f"off by {result.distance:.4g}"
        say(f"{target.scenario.label()}: wanted {target.text}, got {_got(target, result)}: {off}")
    say(f"{counted(search.tried, 'world')} in {counted(search.done, 'unit')}; wrote {out}")
    first = targets[0].scenario
    note(
        f"run it: worldgen run {out} --controller '{first.label()}' --motion {first.run.motion} "
        f"--steps {targets[0].steps}"
    )


def _got(target: OutcomeTarget, result: Result) -> str:
    """Describe an outcome: ``reached@330``, ``stalled in 20000 steps`` or a share of seeds."""
    if result.seeds > 1:
        words = (
            f"{result.verdict}@{result.steps:g}"
            if result.verdict == Verdict.REACHED
            else result.verdict
        )
        return f"{words}, {result.share:.0%} of {result.seeds} seeds arrive"
    if result.verdict in (Verdict.REACHED, Verdict.LOOP):
        return f"{result.verdict}@{result.steps:g}"
    return (
        f"{result.verdict} in {target.steps} steps"
        if result.verdict in OUT_OF_BUDGET
        else result.verdict
    )
