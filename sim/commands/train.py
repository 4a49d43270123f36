"""``worldgen train``: train a learning controller in worlds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import (
    PATH,
    SEED,
    check_out,
    emit_json,
    force_option,
    json_option,
    note,
    say,
    skip_bad_file,
    write_out,
)
from worldgen.files.whole import write_bytes
from worldgen.support.progress import working

if TYPE_CHECKING:
    from sim.controllers.learning import Learned

EXAMPLES = (
    "\b\n  worldgen train failures/ --controller q-learner --out taught.json\n"
    "  worldgen run w.grid --controller learned:taught.json\n"
    "  worldgen train w.grid --controller learned:taught.json --episodes 500 --out more.json"
)


@click.command(epilog=EXAMPLES)
@click.argument("paths", nargs=-1, required=True, type=PATH)
@click.option(
    "--controller",
    default="q-learner",
    show_default=True,
    help=(
        "A learning controller: q-learner, behaviours+by=learning:..., ./mine.py:Mine, or "
        "learned:FILE to continue."
    ),
)
@click.option("--episodes", default=200, show_default=True, help="Number of runs to learn from.")
@click.option("--steps", default=2000, show_default=True, help="Budget of each run, in steps.")
@click.option(
    "--explore",
    default=300,
    show_default=True,
    help="Random decisions at first, in thousandths; the rate falls to zero.",
)
@click.option("--seed", type=SEED, default=0, help="Seed of all random choices.")
@click.option("--out", required=True, type=PATH, help="Output file.")
@click.option("--curve", type=PATH, metavar="OUT", help="Draw the learning curve (.svg).")
@json_option
@force_option
def train(
    paths: tuple[Path, ...],
    controller: str,
    episodes: int,
    steps: int,
    explore: int,
    seed: int,
    out: Path,
    curve: Path | None,
    as_json: bool,
    force: bool,
) -> None:
    """Train a learning controller in worlds, and store what it learned.

    PATHS are worlds, or folders of them, such as the failures of a campaign.
    """
    from sim.controllers.catalogue import CONTROLLERS
    from sim.controllers.learning import learned_text
    from sim.controllers.taught import learning_of
    from sim.drawing.curve import curve_svg
    from sim.runners.training import TrainingOptions
    from sim.runners.training import train as train_in
    from sim.scenario import Scenario
    from worldgen.files.worlds import read_worlds

    # Refuse bad output and input before the work begins.
    check_out("--out", out, force=force)
    check_out("--curve", curve, ".svg", force=force)
    scenario = Scenario.parse(controller)
    found = CONTROLLERS.get(scenario.controller)
    learning_of(found, scenario.controller)
    worlds = [world for _, world in read_worlds(paths, skip_bad_file)]
    # Train, with the number of the episode in the progress line.
    options = TrainingOptions(episodes, steps, explore, seed)
    done = [0]
    with working(f"training {scenario.label()}") as work:
        work.say(lambda: f"episode {done[0]} of {episodes}")
        learned = train_in(
            worlds, scenario, found, options, lambda count: done.__setitem__(0, count)
        )
    # Write what was learned, and the curve.
    learned = learned._replace(controller=_first_name(scenario.controller))
    write_bytes(out, learned_text(learned).encode(), force=force)
    if as_json:
        emit_json(
            {
                "controller": learned.controller,
                "numbers": len(learned.numbers),
                "curve": [point._asdict() for point in learned.curve],
                "out": str(out),
            }
        )
    else:
        _say(learned)
    note(f"wrote {out}")
    if curve is not None:
        write_out(curve, curve_svg(learned.curve, scenario.label()).encode(), force=force)


def _first_name(name: str) -> str:
    """Return the name of the controller that first learned, if this one continues from a file."""
    from sim.controllers.catalogue import own_words
    from sim.controllers.learning import LEARNED, is_learned_name, learned_file, read_learned
    from worldgen.parameters import with_options

    if is_learned_name(name):
        return read_learned(learned_file(name)).controller
    base, words = own_words(name)
    return with_options(base, {key: value for key, value in words.items() if key != LEARNED})


def _say(learned: Learned) -> None:
    for point in learned.curve:
        say(
            f"after {point.episodes} episodes: reaches {point.reached} of {point.worlds}, "
            f"{point.steps} steps"
        )
    best = min(learned.curve, key=lambda point: (-point.reached, point.steps))
    say(f"kept the numbers after {best.episodes} episodes: {len(learned.numbers)} numbers")
