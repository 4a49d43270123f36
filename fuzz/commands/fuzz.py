"""``worldgen fuzz``: run a campaign from the command line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzz.commands._options import budget_options, code_option, output_options, seconds_of
from fuzz.unit.options import BASELINE_HELP, CampaignOptions
from worldgen.cli.declared_options import declared_options
from worldgen.cli.output import (
    CONTROLLER_HELP,
    PATH,
    draw_seed,
    force_option,
    json_option,
    note,
    seed_option,
    typed,
    workers_option,
)
from worldgen.cli.robot_options import warn_of_start_in_target
from worldgen.cli.usage import ConditionalCommand

if TYPE_CHECKING:
    from fuzz.campaign.store import Budget, CampaignRun
    from fuzz.corpus import Baseline
    from fuzz.overview import NaturalResult

EXAMPLES = (
    "\b\n  worldgen fuzz --controller turn-right --motion stepped --budget 30s --seed 1 --out "
    "failures/\n"
    "  worldgen fuzz --controller ./mine.py:Robot --family trap --units 20 --out failures/\n"
    "  worldgen fuzz --controller turn-left --world map.grid --budget 1m --out failures/\n"
    "  worldgen fuzz --controller bug1 --vary sensor_noise=0,0.1 --vary robot_speed=1,2 --out "
    "failures/\n"
    "  worldgen fuzz --controller bug1 --oracle detour=5 --oracle turn --budget 30s --out failures/\n"
    "  worldgen fuzz --resume failures/"
)

_DECLARED = CampaignOptions.declared()
_BEGUN = {option.name for option in _DECLARED} | {"out", "seed"}
"""Parameters that define a campaign rather than its extent."""

_HELP = {
    "controller": CONTROLLER_HELP,
    "oracles": f"{CampaignOptions.named('oracles').help} ./file.py:name is an oracle of your own.",
}


def _unless_resumed(given: Mapping[str, Any]) -> str:
    return "" if given.get("resume") else "it is needed unless --resume continues a campaign"


@click.command(
    cls=ConditionalCommand,
    needs={"controller": _unless_resumed, "out": _unless_resumed},
    epilog=EXAMPLES,
)
@declared_options(_DECLARED, _HELP)
@budget_options("to search and shrink")
@workers_option
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Run on the workers of a Dask cluster, such as tcp://host:8786.",
)
@click.option("--out", type=PATH, help="Folder to write the failures to.")
@click.option(
    "--resume",
    type=PATH,
    metavar="FOLDER",
    help="Continue the campaign in FOLDER until it is complete, or for the given --units or "
    "--budget.",
)
@click.option("--report", type=PATH, metavar="PAGE", help="Write an HTML report of the failures.")
@click.option("--baseline", multiple=True, type=PATH, metavar="DIR|ARCHIVE", help=BASELINE_HELP)
@click.option(
    "--count-hazards",
    is_flag=True,
    help="Also count as failures hazards that the controller cannot sense, and disturbances that "
    "no controller is certain to withstand.",
)
@click.option(
    "--accept-no-answer",
    is_flag=True,
    help="Exit with 0 even if too little was tried to say whether the controller fails.",
)
@click.option(
    "--strict",
    is_flag=True,
    help="Also count as new failures of a known cause that look different from the known ones.",
)
@code_option
@output_options
@seed_option
@json_option
@force_option
def fuzz(
    budget: float | None,
    units: int | None,
    workers: int | None,
    scheduler: str | None,
    resume: Path | None,
    report: Path | None,
    baseline: tuple[Path, ...],
    count_hazards: bool,
    accept_no_answer: bool,
    strict: bool,
    no_code: bool,
    as_json: bool,
    junit: Path | None,
    sarif: Path | None,
    summary: Path | None,
    force: bool,
    **begun: Any,
) -> None:
    """Search for worlds in which a controller fails.

    Up to three small worlds of each cause are written to .grid files. Exits with 1 if it finds a
    cause that is in no --baseline, with 4 if it tried too little to say whether there is one, and
    with 0 otherwise. Hazards that the controller cannot sense
    or withstand are listed separately. Ctrl-C keeps the failures found so far; run the same command
    again, or --resume FOLDER, to continue.
    """
    import os
    import time

    began = time.monotonic()
    from fuzz.campaign import store
    from fuzz.campaign.executors import cluster_executor, local_executor
    from fuzz.campaign.schedule import Beginning
    from fuzz.ci import Outputs
    from fuzz.commands._session import CampaignSession
    from fuzz.corpus import Baseline, read_corpus
    from fuzz.overview.building import Conclusion
    from fuzz.report import write_report
    from sim.clock.controller_time import Effort
    from worldgen.support.plain_text import counted

    # Refuse contradicting options before any work.
    loaded = Effort.so_far()
    seconds = seconds_of(budget, units)
    if scheduler is not None and workers is not None:
        raise click.UsageError(
            "use --scheduler or --workers, not both: a cluster has its own workers"
        )
    # Begin or continue the campaign.
    with store.errors_recorded(resume or begun["out"], begins=resume is None):
        outputs = Outputs(junit=junit, sarif=sarif, summary=summary, force=force)
        outputs.check(report, made=begun["out"])
        known = read_corpus(baseline).entries
        run_budget = store.Budget(units, seconds)
        if resume is None:
            campaign_run = _begin(run_budget, force=force, **begun)
        else:
            _refuse_beside_resume()
            campaign_run = store.resume(
                resume, None if units is None and budget is None else run_budget
            )
    with store.errors_recorded(campaign_run.store.out):
        if campaign_run.done:
            note(
                f"continues the campaign in {campaign_run.store.out}: seed "
                f"{campaign_run.config.seed}, {counted(campaign_run.done, 'unit')} done"
            )
        # Choose the baseline and the workers.
        was_known = Baseline.of(known, campaign_run.config.scenario, note, strict=strict)
        # The last campaign's failures here serve for comparison; a baseline replaces them.
        replaces = force and resume is None and not known
        last = _last_failures(campaign_run) if replaces else Baseline()
        before = _natural_before([*baseline, *([campaign_run.store.out] if replaces else ())])
        if scheduler:
            executor = cluster_executor(scheduler, campaign_run.config)
        else:
            executor = local_executor(workers or os.cpu_count() or 1)
        session = CampaignSession(
            campaign_run,
            executor,
            quiet=as_json,
            outputs=outputs,
            conclusion=Conclusion(was_known, last, before, with_code=not no_code),
            accepts_no_answer=accept_no_answer,
            count_hazards=count_hazards,
            began=Beginning(began, loaded.since().own),
        )
        # Search, then write the report.
        code = session.run()
        if report is not None:
            from fuzz.report import write_report

            write_report([campaign_run.store.out], report, force=force, with_code=not no_code)
            note(f"wrote {report}")
    raise SystemExit(code)


def _begin(
    run_budget: Budget, *, out: Path, seed: int | None, force: bool, **said: Any
) -> CampaignRun:
    """Return a new campaign, or the same one again in its folder."""
    from fuzz.campaign.configure import configure, unstated_pace
    from fuzz.campaign.store import begin, stored_seed, with_stored_pace
    from sim.scenario.unused import ineffective

    options = CampaignOptions(**{name: value for name, value in said.items() if value is not None})
    if options.world is not None and (options.families or options.strategies):
        raise click.UsageError(
            "use --world, or --family and --strategy, not both: all worlds come from the map"
        )
    drawn = draw_seed(stored_seed(out) if seed is None and not force else seed)
    config = configure(options, drawn, run_budget.seconds)
    if options.pace is None and not force:
        config = with_stored_pace(config, out)
    if run_budget.seconds is None and (pace := unstated_pace(config)) is not None:
        note(
            f"note: a step of {config.scenario.controller} takes about {1e3 * pace.step:.2g} ms, and "
            f"without a budget a unit counts on a quick class: --pace {1e3 * pace.step:.2g} sizes "
            "it for that, and brings the first result far sooner"
        )
    for sentence in ineffective([config.scenario]):
        note(f"note: {sentence}")
    if config.fixed_map is not None:
        warn_of_start_in_target(options.robot, config.fixed_map)
    return begin(config, out, run_budget, force=force)


def _last_failures(campaign_run: CampaignRun) -> Baseline:
    """Return the failures that an earlier campaign left in the folder, after running them again.

    Unreadable files are about to be overwritten, so they are not reported.
    """
    import contextlib

    from fuzz.corpus import Baseline, read_corpus
    from worldgen.errors import WorldgenError

    with contextlib.suppress(WorldgenError):
        entries = read_corpus([campaign_run.store.out], skip=lambda _: None).entries
        if entries:
            return Baseline.of(entries, campaign_run.config.scenario, lambda _: None)
    return Baseline()


def _natural_before(folders: Iterable[Path]) -> NaturalResult | None:
    """Return how often the robot arrived in natural worlds, from the first campaign that tells."""
    import contextlib

    from fuzz.overview import read_overview
    from worldgen.errors import WorldgenError

    for folder in folders:
        with contextlib.suppress(WorldgenError):
            overview = read_overview(folder)
            if overview is not None and overview.natural is not None:
                return overview.natural
    return None


def _refuse_beside_resume() -> None:
    for option in click.get_current_context().command.params:
        if option.name in _BEGUN and typed(option.name):
            raise click.UsageError(
                f"{option.opts[0]} cannot change in a resumed campaign; omit it, or omit --resume"
            )
