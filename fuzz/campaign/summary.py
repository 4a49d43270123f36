"""Summarise a campaign in numbers, for reports and ``--json``."""

from __future__ import annotations

from msgspec import UNSET, structs

from fuzz.campaign.state import CampaignState
from fuzz.campaign.store import Archive, Status, Summary
from fuzz.facts.unrun import unrun_lines
from fuzz.search.archive import archive_table
from fuzz.unit.answer import AnswerNumbers, answer_of
from fuzz.unit.config import CampaignConfig
from fuzz.unit.live import LiveState
from sim.controllers import CONTROLLERS, CompiledController, ProcessController
from worldgen.files.json_file import converted
from worldgen.support.plain_text import aligned, counted, lasting

# Places of lines that never ran that are named.
_MOST_UNRUN = 8
# Seconds of a world from which its cost is shown.
_WORTH_SAYING = 0.01


def summary_of(
    config: CampaignConfig,
    state: CampaignState,
    status: Status,
    numbers: AnswerNumbers | None = None,
) -> Summary:
    """Return the summary of a campaign's current state.

    Args:
        config: Definition of the campaign.
        state: Its state.
        status: Its progress.
        numbers: The numbers that decide its answer; ``None`` while it runs.
    """
    answer, reason = (UNSET, UNSET) if numbers is None else answer_of(numbers)
    share = controller_share(config, state)
    return Summary(
        controller=config.scenario.label(),
        motion=config.scenario.run.motion,
        seed=config.seed,
        units=state.units,
        worlds=state.worlds,
        steps=state.steps,
        seconds=round(state.seconds, 3),
        status=status,
        answer=answer,
        answer_reason=reason,
        answer_numbers=numbers or UNSET,
        verdicts=dict(state.verdicts),
        tried=dict(state.tried),
        met=dict(state.met_by_group),
        known=dict(state.known),
        strategies=list(state.memory.strategies.values()),
        found=[find for find, _ in state.finds],
        archive=_archive_of(state),
        units_cut=state.cut - state.too_early,
        units_too_early=state.too_early,
        times={name: round(seconds, 3) for name, seconds in state.times.items()},
        controller_share=UNSET if share is None else round(share, 3),
        survives_reset=sorted(state.effort.survivors) or UNSET,
        differs_by=sorted(state.effort.differences) or UNSET,
        unrun_lines=unrun_lines(config.scenario.controller, state.memory.lines | state.effort.lines)
        or UNSET,
    )


def _archive_of(state: CampaignState) -> Archive | None:
    table = archive_table(state.memory.elites)
    return None if table is None else converted(table, Archive)


def controller_share(config: CampaignConfig, state: CampaignState) -> float | None:
    """Return the share of this run's work spent in the controller's own code.

    It is ``None`` for a compiled controller, which runs inside the kernels, and for a run without
    work.
    """
    if (
        isinstance(CONTROLLERS.get(config.scenario.controller), CompiledController)
        or not state.effort.seconds
    ):
        return None
    return state.effort.share


def describe_strategies(summary: Summary) -> str:
    """Return a table of the strategies, with their shares and yields."""
    rows = [["strategy", "units", "worlds", "steps", "failures", "new variants"]]
    for one in sorted(summary.strategies, key=lambda one: one.strategy):
        rows.append(list(map(str, structs.astuple(one))))
    return aligned(rows, right=range(1, 6))


def describe_units(summary: Summary) -> str:
    """Describe the units by result.

    For example ``9 whole units, 2 cut short and 1 to do again after these``.
    """
    cut = summary.units_cut
    parts = [counted(summary.units, "whole unit" if cut else "unit")]
    if cut:
        parts.append(f"{cut} cut short")
    if summary.units_too_early:
        parts.append(f"{summary.units_too_early} to do again after {'it' if cut == 1 else 'these'}")
    *first, last = parts
    return f"{', '.join(first)} and {last}" if first else last


def describe_time(summary: Summary) -> str:
    """Describe how long this run took: ``30.0 s: start-up 2.0 s, search 21.9 s, shrinking 6.1 s``.

    A run without work reports the total time of earlier runs, whose parts are unknown.
    """
    whole = sum(summary.times.values())
    if not whole:
        return f"{summary.seconds:.1f} s"
    parts = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in summary.times.items())
    return f"{whole:.1f} s: {parts}"


def describe_speed(live: LiveState) -> str:
    """Describe a running search's speed, to follow its counts; empty until a unit is done.

    For example ``; 190 worlds a minute, 0.31 s each (95 % your controller), about 40 s left``.
    """
    if not live.cost:
        return ""
    parts = [f"{live.rate:,.0f} worlds a minute"]
    # A compiled controller's share is not measured, and its worlds cost no time worth mentioning.
    if live.cost >= _WORTH_SAYING:
        parts.append(f"{live.cost:.2g} s each")
        if live.own:
            parts[-1] += f" ({100 * live.own:.0f} % your controller)"
    if live.left:
        parts.append(f"about {lasting(live.left)} left")
    return f"; {', '.join(parts)}"


def describe_unrun(summary: Summary) -> str:
    """Describe the lines that never ran.

    For example ``lines of your controller that never ran in any world: 41-44 (recover), 60 (act)``.
    """
    lines = [] if summary.unrun_lines is UNSET else summary.unrun_lines
    more = f", and {len(lines) - _MOST_UNRUN} more" if len(lines) > _MOST_UNRUN else ""
    places = ", ".join(lines[:_MOST_UNRUN])
    return f"lines of your controller that never ran in any world: {places}{more}"


def describe_share(summary: Summary, controller: str) -> str | None:
    """Describe the controller's share: ``40 % of the work was your controller's own code``.

    ``None`` if unknown.
    """
    share = summary.controller_share
    if share is UNSET:
        return None
    is_program = isinstance(CONTROLLERS.get(controller), ProcessController)
    what = "waiting for your program" if is_program else "your controller's own code"
    return f"{100 * share:.0f} % of the work was {what}"
