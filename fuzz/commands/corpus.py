"""``worldgen corpus``: inspect folders and archives of failures, and keep them small."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from worldgen.cli.output import (
    PATH,
    check_out,
    emit_json,
    force_option,
    json_option,
    note,
    say,
    skip_bad_file,
)
from worldgen.files.whole import write_bytes
from worldgen.parameters.known_names import nearest
from worldgen.support.plain_text import aligned, counted, shown

if TYPE_CHECKING:
    from fuzz.corpus import Corpus, CorpusEntry

F = TypeVar("F", bound=Callable[..., Any])


class _Only(click.ParamType[tuple[str, str]]):
    """A field of failures and a pattern for it: ``verdict=loop``."""

    name = "FIELD=PATTERN"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str]:
        """Split the text at its first equals sign: a controller's options have others."""
        field, equals, pattern = str(value).partition("=")
        if not equals or field not in FIELDS:
            self.fail(
                f"{value!r} is not {'=..., '.join(FIELDS)}=...; write verdict=loop", param, ctx
            )
        # Verdicts are a closed set, so a mistyped one would select nothing in silence.
        from sim.verdict import Verdict

        if field == "verdict" and not any(fnmatchcase(one, pattern) for one in Verdict):
            near = nearest(pattern, list(Verdict))
            self.fail(
                f"no verdict is {pattern!r}; write verdict={near or Verdict.LOOP}", param, ctx
            )
        return field, pattern


FIELDS = ("verdict", "cause", "controller")


def _filter(command: F) -> F:
    """Add the option ``--only``, which selects failures."""
    return click.option(
        "--only",
        "only",
        multiple=True,
        type=_Only(),
        metavar="FIELD=PATTERN",
        help="Select failures by verdict, cause or controller: verdict=loop, 'cause=circles-*', "
        "'controller=thesis-1*'; may be repeated.",
    )(command)


def _paths(command: F) -> F:
    return click.argument(
        "paths", nargs=-1, required=True, type=PATH, metavar="PATH|DIR|ARCHIVE..."
    )(command)


@click.group()
def corpus() -> None:
    """List, compare, merge and prune folders of failures.

    A corpus is a folder, or an archive, of failures as worldgen fuzz writes them. Two failures
    count as the same if their controller, motion model and cause are the same.
    docs/howto/keep-failures.md describes it.
    """


@corpus.command("list", epilog="\b\n  worldgen corpus list failures/ --only verdict=loop")
@_paths
@_filter
@json_option
def list_(paths: tuple[Path, ...], as_json: bool, only: tuple[tuple[str, str], ...]) -> None:
    """List failures: cause, verdict, controller, motion model, first date, size, shrinking, digest."""
    found = _read(paths, only)
    entries = found.entries
    causes = len({entry.facts.key for entry in entries})
    if as_json:
        emit_json(
            {
                "failures": [_json(entry) for entry in entries],
                "causes": causes,
                "others": found.others,
            }
        )
        return
    if entries:
        rows = [_row(entry) for entry in entries]
        say(
            aligned(
                [
                    [
                        "cause",
                        "verdict",
                        "controller",
                        "motion",
                        "first seen",
                        "size",
                        "shrinking",
                        "digest",
                        "file",
                    ],
                    *rows,
                ]
            )
        )
    say(f"{counted(len(entries), 'failure')} of {counted(causes, 'cause')}")
    if found.others:
        note(f"skipped {counted(found.others, 'world')} without a failure")


@corpus.command(epilog="\b\n  worldgen corpus show failures/ --picture failures.png")
@_paths
@_filter
@click.option("--picture", type=PATH, metavar="OUT.png", help="Draw all on one sheet instead.")
@json_option
@force_option
def show(
    paths: tuple[Path, ...],
    picture: Path | None,
    as_json: bool,
    force: bool,
    only: tuple[tuple[str, str], ...],
) -> None:
    """Show failures in the terminal: picture, evidence and the command that replays each.

    --picture draws all of them on one sheet instead. This runs the controllers that the files name.
    """
    from fuzz.corpus import contact_sheet
    from fuzz.failure import Failure
    from fuzz.overview.describe import describe
    from worldgen.errors import WorldgenError

    # Draw the contact sheet.
    check_out("--picture", picture, ".png", force=force)
    entries = _read(paths, only).entries
    if picture is not None:
        write_bytes(picture, contact_sheet(entries), force=force)
        note(f"wrote {picture}: {counted(len(entries), 'failure')}")
    if as_json:
        emit_json(
            {
                "picture": None if picture is None else str(picture),
                "failures": [_json(entry) for entry in entries],
            }
        )
    if as_json or picture is not None:
        return
    # Describe every failure; a failure that cannot be run gets a single line.
    for entry in entries:
        failure = Failure.read(entry.path)
        try:
            say(describe(failure, entry.path))
        except WorldgenError as error:
            say(f"{entry.path}: {entry.facts.group}, {entry.facts.describe_size()}")
            note(f"  {entry.facts.controller} cannot be run here: {error}")
    if not entries:
        note("no failure fits")


@corpus.command(epilog="\b\n  worldgen corpus merge baseline/ failures/ --out baseline/ --force")
@_paths
@_filter
@click.option("--out", type=PATH, required=True, help="Folder for the failures.")
@json_option
@force_option
def merge(
    paths: tuple[Path, ...],
    out: Path,
    as_json: bool,
    force: bool,
    only: tuple[tuple[str, str], ...],
) -> None:
    """Copy the smallest failures of each cause into a folder, as CONTROLLER/MOTION/CAUSE.grid.

    The order in which you name the corpora makes no difference. A folder that
    holds other worlds is refused without --force, which replaces those of the same name and keeps
    the others.
    """
    from fuzz.corpus import merge as merge_failures

    entries = _read(paths, only).entries
    written = merge_failures(entries, out, force=force)
    if as_json:
        emit_json(
            {
                "read": len(entries),
                "files": {str(path): str(entry.path) for path, entry in written.items()},
            }
        )
        return
    say(f"{counted(len(entries), 'failure')}, {len(written)} kept in {shown(out)}")


@corpus.command(epilog="\b\n  worldgen corpus diff baseline/ failures/")
@click.argument("old", type=PATH, metavar="OLD")
@click.argument("new", type=PATH, metavar="NEW")
@_filter
@json_option
def diff(old: Path, new: Path, as_json: bool, only: tuple[tuple[str, str], ...]) -> None:
    """Report causes of failures that are new, missing, or now in a smaller or larger world.

    Exits with 1 if NEW has a cause that OLD does not have, and with 0 otherwise: known failures do
    not fail a build.
    """
    from fuzz.corpus import differences

    found = differences(_read((old,), only).entries, _read((new,), only).entries)
    count = Counter[str](difference.change for difference in found)
    changes = ("new", "gone", "smaller", "larger", "same")
    if as_json:
        rows = [
            {
                "change": difference.change,
                "old": _json(difference.old) if difference.old else None,
                "new": _json(difference.new) if difference.new else None,
            }
            for difference in found
        ]
        emit_json({**{change: count[change] for change in changes}, "causes": rows})
    else:
        rows_of_text = [
            [
                difference.change,
                *map(shown, difference.entry.facts.key),
                difference.old.facts.describe_size() if difference.old else "-",
                difference.new.facts.describe_size() if difference.new else "-",
                shown(difference.entry.path),
            ]
            for difference in found
            if difference.change != "same"
        ]
        if rows_of_text:
            say(
                aligned(
                    [["", "controller", "motion", "cause", "old", "new", "file"], *rows_of_text]
                )
            )
        say(", ".join(f"{count[change]} {change}" for change in changes))
    if count["new"]:
        raise SystemExit(1)


@corpus.command(epilog="\b\n  worldgen corpus prune failures/ --dry-run")
@click.argument("folder", type=PATH, metavar="DIR")
@_filter
@click.option("--dry-run", is_flag=True, help="Print what would be deleted, but delete nothing.")
@json_option
def prune(folder: Path, dry_run: bool, as_json: bool, only: tuple[tuple[str, str], ...]) -> None:
    """Delete failures that no longer occur, and keep only the smallest of each cause.

    It first runs every failure, with the controllers that the files name, and then deletes without
    asking. --dry-run shows what it would delete. A failure whose controller cannot be run here is
    kept, and the exit code is then 1.
    """
    from fuzz.corpus import judge_all, remove
    from worldgen.errors import OutputError

    # Refuse anything that is not a folder of failures.
    if not folder.is_dir():
        raise OutputError(
            "wrong-kind-of-file",
            "{folder} is not a folder",
            "unpack an archive first, or delete a single file yourself",
            folder=folder,
        )
    # Judge everything before anything is deleted.
    judged = []
    for judgement in judge_all(_read((folder,), only).entries):
        judged.append(judgement)
        if not as_json and judgement.reason:
            word = "keep" if judgement.keep else "would drop" if dry_run else "drop"
            say(f"{word} {judgement.entry.path}: {judgement.reason}")
    dropped = [judgement for judgement in judged if not judgement.keep]
    unsure = [judgement for judgement in judged if not judgement.judged]
    for judgement in () if dry_run else dropped:
        remove(judgement.entry)
    # Print what happened.
    if as_json:
        rows = [
            {"file": str(j.entry.path), "keep": j.keep, "judged": j.judged, "reason": j.reason}
            for j in judged
        ]
        emit_json(
            {
                "kept": len(judged) - len(dropped),
                "dropped": len(dropped),
                "dry_run": dry_run,
                "failures": rows,
            }
        )
    else:
        word = "would be dropped" if dry_run else "dropped"
        say(f"{len(judged) - len(dropped)} kept, {len(dropped)} {word}")
    if unsure:
        raise SystemExit(1)


@corpus.command(epilog="\b\n  worldgen corpus export failures/ --out failures.zip")
@_paths
@_filter
@click.option("--out", type=PATH, required=True, help="A .zip, .csv or .parquet file.")
@json_option
@force_option
def export(
    paths: tuple[Path, ...],
    out: Path,
    as_json: bool,
    force: bool,
    only: tuple[tuple[str, str], ...],
) -> None:
    """Write failures into one file: an archive with pictures and a table, or a table.

    Equal failures give equal archives, byte for byte, and every command reads them like folders.
    The pictures show the robot's path, so the controllers that the files name are run, except for a
    .csv.
    """
    from fuzz.corpus import export as export_failures

    count = export_failures(_read(paths, only).entries, out, force=force)
    if as_json:
        emit_json({"file": str(out), "failures": count})
        return
    say(f"wrote {out}: {counted(count, 'failure')}")


def _read(paths: Sequence[Path], only: Sequence[tuple[str, str]]) -> Corpus:
    from fuzz.corpus import Selection, read_corpus

    return read_corpus(paths, Selection(tuple(only)), skip_bad_file)


def _json(entry: CorpusEntry) -> dict[str, Any]:
    row = entry.as_dict()
    return row | {"first_seen": row["first_seen"] or None, "replay": entry.replay_command}


def _row(entry: CorpusEntry) -> list[str]:
    facts = entry.facts
    words = (
        facts.group,
        facts.verdict,
        facts.controller,
        facts.motion,
        entry.first_seen[:10] or "-",
    )
    size = (facts.describe_size(), facts.shrinking)
    return [*words, *size, facts.digest[:12], str(entry.path)]
