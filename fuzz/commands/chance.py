"""``worldgen chance``: decide what a random controller can do, whatever it draws."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import CONTROLLER_HELP, PATH, emit_json, json_option, say, time_step_option
from worldgen.cli.usage import missing
from worldgen.support.progress import working

EXAMPLES = (
    "\b\n  worldgen chance w.grid --controller turn-random+coin=4+lattice=16\n"
    "  worldgen chance failures/stalled-nook-near.grid --most 1000000"
)


@click.command(epilog=EXAMPLES)
@click.argument("path", type=PATH)
@click.option("--controller", help=f"{CONTROLLER_HELP} A failure names its own.")
@time_step_option
@click.option(
    "--most",
    type=click.IntRange(1, 10_000_000),
    help="Number of states to explore.  [default: 100000]",
)
@click.option(
    "--seeds",
    type=click.IntRange(1, 100_000),
    default=40,
    show_default=True,
    help="Number of seeds to run if undecided.",
)
@json_option
def chance(
    path: Path,
    controller: str | None,
    time_step: float | None,
    most: int | None,
    seeds: int,
    as_json: bool,
) -> None:
    """Decide whether a random controller always, never or sometimes arrives.

    Explores every state that random numbers can lead to; if there are too many, counts the seeds
    with which the robot fails to arrive. Exits with 0 if the robot arrives with probability one, or
    with every seed, and with 1 otherwise.
    """
    from fuzz.chance import MOST_STATES, chance_of, in_words, share_that_fails
    from fuzz.failure import Failure
    from sim.options.run import RunOptions
    from sim.scenario import Scenario
    from worldgen.files.grid import read_world

    # Take the scenario from the options or from the failure.
    world = read_world(path)
    if controller is not None:
        scenario = Scenario.parse(
            controller, time_step=RunOptions.time_step if time_step is None else time_step
        )
    elif time_step is not None:
        raise click.UsageError(
            "--time-step needs --controller; a failure's file names its own step"
        )
    elif (failure := Failure.found_in(world)) is not None:
        scenario = failure.scenario
    else:
        raise missing("controller", "only the file of a failure names its own")
    # Explore all states, or fall back to counting seeds.
    with working(f"exploring every draw of {scenario.label()}") as work:
        found = chance_of(
            world, scenario.controller, scenario.options(world), most=most or MOST_STATES
        )
        if not found.states:
            work.say(f"too many states; running {seeds} seeds")
        counted = {} if found.states else share_that_fails(world, scenario, seeds)
    # Print the answer.
    if as_json:
        emit_json(found.as_dict() | counted)
    else:
        say(f"{scenario.label()}: {in_words(found, counted)}")
    raise SystemExit(
        int(counted["failing_seeds"] != [0, seeds] if counted else found.chance != "sure")
    )
