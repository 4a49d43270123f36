"""Print notes about options that change nothing."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from worldgen.cli.output import note

if TYPE_CHECKING:
    from sim.scenario import Scenario

__all__ = ["note_survivors", "note_unused"]


def note_survivors(controllers: Iterable[str]) -> None:
    """Report on stderr which state the runs of this process have found to survive ``reset``.

    Args:
        controllers: Names of the controllers that ran.
    """
    from sim.controllers.contract import state_survives_reset
    from sim.runners.controller_time import Effort

    if places := Effort.so_far().survivors:
        note(f"note: {state_survives_reset(', '.join(dict.fromkeys(controllers)), places)}")


def note_unused(scenarios: Iterable[Scenario], *, seeds: Collection[str] = ()) -> None:
    """Report on stderr which options have no effect on these runs, or less than expected.

    Args:
        scenarios: The scenarios that are run.
        seeds: Names of the command's options for seeds; reported as idle if they are given and no
            run draws numbers.
    """
    from sim.options.unused import coarse_forces, random_run, unused_options

    runs = tuple(scenarios)
    sentences = (
        one for scenario in runs for one in (*unused_options(scenario), *coarse_forces(scenario))
    )
    for sentence in dict.fromkeys(sentences):
        note(f"note: {sentence}")
    source = click.get_current_context().get_parameter_source
    typed = [name for name in seeds if source(name) is ParameterSource.COMMANDLINE]
    if typed and not any(map(random_run, runs)):
        note(
            f"note: --{typed[0]} has no effect: nothing in "
            f"{'this run' if len(runs) == 1 else 'these runs'} is random"
        )
