"""``worldgen report``: show failures in one HTML page."""

from __future__ import annotations

from pathlib import Path

import click

from fuzz.commands._options import code_option
from worldgen.cli.output import PATH, emit_json, force_option, json_option, note, skip_bad_file


@click.command(epilog="\b\n  worldgen report failures/ --out report.html")
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR|ARCHIVE...")
@click.option("--out", type=PATH, required=True, help="File to write the page to, .html.")
@click.option(
    "--title", default="", help="Heading of the page.  [default: controller and motion model]"
)
@code_option
@json_option
@force_option
def report(
    paths: tuple[Path, ...], out: Path, title: str, no_code: bool, as_json: bool, force: bool
) -> None:
    """Show failures and their campaign in one HTML page.

    The page needs no network and no other file. Each failure is run again for the page, so this
    runs the controllers that the files name. For a controller in Python, the page contains the
    lines of its file that run when it fails. docs/howto/why-it-fails.md describes it.
    """
    from fuzz.report import write_report
    from worldgen.support.plain_text import counted
    from worldgen.support.progress import working

    with working(f"writing {out}") as work:
        count = write_report(
            paths,
            out,
            title=title,
            force=force,
            with_code=not no_code,
            skip=skip_bad_file,
            progress=lambda done, of: work.count(done, of, "failures"),
        )
    note(f"wrote {out}: {counted(count, 'failure')}")
    if as_json:
        emit_json({"file": str(out), "failures": count})
