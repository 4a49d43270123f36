"""``worldgen init``: set up a project's CI, with a first corpus of known failures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from worldgen.cli.output import (
    CONTROLLER_HELP,
    PATH,
    emit_json,
    force_option,
    json_option,
    motion_option,
    note,
    say,
)

if TYPE_CHECKING:
    from fuzz.ci.project import Project

EXAMPLES = (
    "\b\n  worldgen init --controller ./robot.py:Robot\n"
    "  worldgen init --controller 'cmd:./robot --fast' --ci gitlab\n"
    "  worldgen init --controller my_robot.core:Robot --family maze --family rooms --units 20"
)


@click.command(epilog=EXAMPLES)
@click.argument("folder", type=PATH, default=Path())
@click.option("--controller", required=True, help=CONTROLLER_HELP)
@motion_option
@click.option(
    "--family",
    "families",
    multiple=True,
    help="Family to test pull requests with; may be repeated.",
)
@click.option(
    "--ci",
    type=click.Choice(("github", "gitlab", "none")),
    help="CI service.  [default: the one that FOLDER uses]",
)
@click.option(
    "--units",
    type=click.IntRange(1),
    default=6,
    show_default=True,
    help="Amount of work for each search; a fixed amount, so that no pull request fails by chance.",
)
@json_option
@force_option
def init(
    folder: Path,
    controller: str,
    motion: str,
    families: tuple[str, ...],
    ci: str | None,
    units: int,
    as_json: bool,
    force: bool,
) -> None:
    """Set up a project whose CI searches for failures.

    It runs the search that pull requests will run and stores the findings as known failures; writes
    a CI job that fails when a pull request adds another one; and adds your controller to
    pyproject.toml, so that `worldgen fuzz --out failures/` needs no more options. Then it shrinks
    the known failures, which takes longer; you can keep working in the meantime, or press Ctrl-C.
    """
    import contextlib
    import io
    import os
    import tempfile

    from fuzz.campaign import store
    from fuzz.campaign.configure import configure
    from fuzz.campaign.executors import local_executor
    from fuzz.ci.project import SEED, Project
    from fuzz.commands._session import NO_ANSWER, CampaignSession
    from fuzz.unit.options import CampaignOptions
    from worldgen.files.whole import write_bytes
    from worldgen.support.results import results_to

    # Before the search, refuse anything that the project cannot have.
    project = Project(folder, controller, motion, families, units, ci or _service_of(folder))
    project.check(force=force)
    # The controller's path is relative to the project, whose folder CI starts in.
    with contextlib.chdir(folder), tempfile.TemporaryDirectory() as scratch:
        config = configure(
            CampaignOptions(controller=controller, motion=motion, families=families, shrink=False),
            SEED,
        )
        # Search for today's failures in a temporary folder.
        note(
            f"searching for the current failures of {controller}, as CI will "
            f"(--units {max(1, units // 3)} takes less time)"
        )
        campaign_run = store.begin(config, Path(scratch) / "found", store.Budget(units=units))
        with results_to(io.StringIO()):
            code = CampaignSession(
                campaign_run, local_executor(os.cpu_count() or 1), lasts=False
            ).run()
        if code not in (0, 1, NO_ANSWER):
            raise SystemExit(code)
        if code == NO_ANSWER:
            note(
                f"{controller} has no answer yet, so CI will fail: see why with worldgen fuzz, use "
                "more --units, or set accept-no-answer = true in pyproject.toml"
            )
        failures = {
            found.name: found.read_bytes()
            for found in sorted((Path(scratch) / "found").glob("*.grid"))
        }
    # Write the project's files, and store the failures as known ones.
    written = project.write(force=force)
    known = [project.known / name for name in failures]
    for path, text in zip(known, failures.values(), strict=True):
        write_bytes(path, text, force=True)
    # The project is complete now; smaller worlds only make the failures easier to understand.
    if as_json:
        names = [str(path) for path in known]
        emit_json({"seed": SEED, "known": names, "written": [str(path) for path in written]})
    else:
        _report(project, len(failures), written)
    _shrink([path.resolve() for path in known], folder)


def _shrink(known: list[Path], folder: Path) -> None:
    """Shrink the known failures in place, the smallest first; Ctrl-C stops early.

    Args:
        known: Their files.
        folder: The project's root, to which the controller's path is relative.
    """
    import contextlib
    import os
    from concurrent.futures import FIRST_COMPLETED, Future, wait

    from fuzz.campaign.executors import local_executor
    from fuzz.failure import Failure
    from fuzz.shrink.queue import Shrinking, shrunk_or_same
    from worldgen.plugins.workers import LISTEN
    from worldgen.support.plain_text import counted
    from worldgen.support.progress import working

    # Small failures shrink fastest, so begin with these.
    waiting = sorted(((Failure.read(path), path) for path in known), key=lambda one: one[0].order)
    busy: dict[Future[Shrinking], Path] = {}
    done = 0
    try:
        with (
            contextlib.chdir(folder),
            working("shrinking the known failures") as work,
            local_executor(os.cpu_count() or 1) as executor,
        ):
            work.say(lambda: f"{done} of {len(known)}; Ctrl-C leaves the others as found")
            while waiting or busy:
                while waiting and len(busy) < executor.room:
                    failure, path = waiting.pop(0)
                    busy[executor.submit(shrunk_or_same, failure)] = path
                # Write each result immediately, so that Ctrl-C loses none.
                for future in wait(busy, LISTEN, FIRST_COMPLETED).done:
                    future.result().failure.write(busy.pop(future), force=True)
                    done += 1
                executor.listen()
    # Every file holds a whole failure, shrunk or not.
    except KeyboardInterrupt:
        left = len(known) - done
        note(
            f"interrupted; the project is complete, and {counted(left, 'known failure')} "
            f"{'is' if left == 1 else 'are'} not shrunk; worldgen shrink FILE does that"
        )
        raise SystemExit(130) from None


def _service_of(folder: Path) -> str:
    """Return the CI service that a project seems to use, GitHub's by default."""
    if (folder / ".github").is_dir():
        return "github"
    return (
        "gitlab"
        if (folder / ".gitlab-ci.yml").is_file() or (folder / ".gitlab").is_dir()
        else "github"
    )


def _report(project: Project, failures: int, written: list[Path]) -> None:
    """Print what was written, and what the user still has to do."""
    from fuzz.ci.project import FIXED, KNOWN
    from worldgen.support.plain_text import counted

    say(f"{KNOWN}: {counted(failures, 'known failure')}")
    for path in written:
        say(f"wrote {path}")
    if missing := project.must_be_told_where_worldgen_is:
        say(f"fill in {missing}; CI installs worldgen from there")
    if project.ci == "gitlab" and (project.folder / ".gitlab-ci.yml") not in written:
        say("add to .gitlab-ci.yml: include: [{local: .gitlab/worldgen.yml}]")
    if not project.runs_fixed_failures:
        say(f'add to your pytest settings: worldgen_corpus = ["{FIXED}"]')
    say("next: commit these files; worldgen fuzz --out failures/ searches as CI does")
