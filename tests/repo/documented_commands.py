"""Run the commands in README.md and in the pages of docs/, and compare their output with the page.

Every fenced block of kind ``console`` is run: a line that begins with ``$ `` is a command, the
lines below it are its output, on stdout and stderr together. The blocks of a page share one
temporary folder and run in order. The folder holds ``corpora`` and ``examples``, and every fenced
block of the page whose first line names a file (``# mine.py``).

- A command without output on the page only has to work.
- ``...`` stands for any text within a line and, alone on a line, for any number of lines. More dots
in a row are literal: free cells of a map.
- How long a command took, as in ``in 12.9 s``, is not compared.
- A search with ``--budget`` runs with ``--units 1`` instead: what a budget of seconds finds depends
  on the machine.

Five comments, each alone on a line above the block that it is for, change how it is run:

- ``<!-- first: COMMAND -->`` runs a hidden command in the page's folder;
  ``$ROOT`` is the project's own folder.
- ``<!-- not run: REASON -->`` skips a block.
- ``<!-- file: NAME -->`` says that the next block is the contents of that file.
- ``<!-- new folder -->`` runs the blocks below in a new folder, as if they were another page.
- ``<!-- needs: PROGRAM -->`` skips a block if that program is not installed.

``python -m tests.repo.documented_commands PAGE...`` prints the differences; ``--update`` writes the
current output into the pages.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from unittest import mock

from worldgen.cli.main import main as command_line

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GENERATED = DOCS / "reference" / "generated"  # written when the site is built
NOTES = DOCS / "notes"  # for the authors; not on the site
SITE = sorted(
    page
    for page in DOCS.rglob("*.md")
    if not (page.is_relative_to(GENERATED) or page.is_relative_to(NOTES))
)
PAGES = [ROOT / "README.md", *SITE]

_FENCE = re.compile(r"( *)```(\w*|\{[\w-]+\}.*?)\s*")  # in braces: a directive of the site
_FILE = re.compile(r"(?:# |// |\"\"\")([\w./-]+\.(?:py|toml|c|json))\b.*")
_NOT_RUN = re.compile(r"<!-- not run: (.+) -->")
_FIRST = re.compile(r"<!-- first: (.+) -->")
_NAMED = re.compile(r"<!-- file: (\S+) -->")
_NEEDS = re.compile(r"<!-- needs: (\S+) -->")
_NEW_FOLDER = "<!-- new folder -->"
_SECONDS = re.compile(
    r"\bin \d+(?:\.\d+)? s\b"
)  # this also hides a witness's time, but not its digest
_SKIPPED = re.compile(r"(?<!\.)\.{3}(?!\.)")  # more dots in a row are cells of a map
_BUDGET = re.compile(r"(worldgen (?:fuzz|find)\b.*)--budget[ =]\S+")
_WENT_WRONG = (
    2  # the exit code of a command that could not do its work; 1 means that a check failed
)


@dataclass
class Command:
    """A command on a page, and its output there.

    Args:
        text: The command, as a shell would get it.
        line: Number of its line in the page, from 1.
        first: Number of the first line below it that is not part of the command.
        shown: The lines that the page shows as its output.
        hidden: True if the reader does not see it.
    """

    text: str
    line: int
    first: int
    shown: list[str] = field(default_factory=list)
    hidden: bool = False


@dataclass
class Block:
    """A block of commands.

    Args:
        commands: Its visible commands, after the hidden ones.
        not_run: Why it is skipped, if it is.
        needs: Programs without which it is skipped.
    """

    commands: list[Command]
    not_run: str | None = None
    needs: list[str] = field(default_factory=list)

    @property
    def runs_here(self) -> bool:
        """Return whether the block should be run and can be."""
        return self.not_run is None and all(map(shutil.which, self.needs))


@dataclass
class Page:
    """A page's blocks of commands, and the files in its other blocks."""

    path: Path
    blocks: list[Block]
    files: dict[str, str]


@dataclass
class Done:
    """A command that was run: its exit code and output."""

    command: Command
    code: int
    printed: list[str]

    @property
    def fault(self) -> str | None:
        """Return what is wrong, in words; None if the page is right."""
        command = self.command
        if self.code > _WENT_WRONG or (self.code == _WENT_WRONG and not command.shown):
            return f"{command.text}: exit code {self.code}\n" + "\n".join(self.printed)
        if not command.shown or matches(command.shown, self.printed):
            return None
        shown = "\n".join(command.shown)
        printed = "\n".join(self.printed)
        return f"$ {command.text}\n--- the page shows\n{shown}\n--- it prints\n{printed}"


def read_page(path: Path) -> Page:
    """Return a page's commands and files."""
    return parse_page(path.read_text(encoding="utf-8"), path)


def read_parts(path: Path) -> list[Page]:
    """Return the parts of a page that run in separate folders; line numbers are the page's."""
    parts = path.read_text(encoding="utf-8").split(_NEW_FOLDER)
    # Empty lines in place of the text above keep line numbers right.
    above = [sum(part.count("\n") for part in parts[:at]) for at in range(len(parts))]
    return [parse_page("\n" * count + part, path) for count, part in zip(above, parts, strict=True)]


def part_with(path: Path, heading: str) -> str:
    """Return the text of the part of a page that has this heading."""
    parts = path.read_text(encoding="utf-8").split(_NEW_FOLDER)
    [part] = [part for part in parts if re.search(rf"^#+ {re.escape(heading)}$", part, re.M)]
    return part


def parse_page(text: str, path: Path) -> Page:
    """Return the commands and files of a page with this text.

    Raises:
        ValueError: If a block of commands begins with something else, or shows the result of a
            budget in seconds.
    """
    page = Page(path, [], {})
    first: list[Command] = []
    needs: list[str] = []
    not_run: str | None = None
    named: str | None = None
    for kind, start, lines in _parts(text):
        if kind is None:
            if found := _NOT_RUN.fullmatch(lines[0].strip()):
                not_run = found[1]
            elif found := _NAMED.fullmatch(lines[0].strip()):
                named = found[1]
            elif found := _NEEDS.fullmatch(lines[0].strip()):
                needs.append(found[1])
            elif found := _FIRST.fullmatch(lines[0].strip()):
                first.append(Command(found[1], start, start, hidden=True))
        elif kind == "console":
            block = Block([*first, *_commands(lines, start, path)], not_run, needs)
            _check_budgets(block, path)
            page.blocks.append(block)
            first, needs, not_run = [], [], None
        elif name := named or _name_in(lines):
            page.files.setdefault(name, "\n".join(lines) + "\n")
            named = None
    return page


def _name_in(lines: list[str]) -> str | None:
    """Return the name of the file in a block's first line."""
    found = _FILE.fullmatch(lines[0]) if lines else None
    return found[1] if found else None


def _parts(text: str) -> Iterator[tuple[str | None, int, list[str]]]:
    """Fenced blocks and single lines: kind (None for a line), number of the first line, lines
    without indentation.
    """
    lines = text.splitlines()
    at = 0
    while at < len(lines):
        fence = _FENCE.fullmatch(lines[at])
        if fence is None:
            yield None, at + 1, [lines[at]]
            at += 1
            continue
        indent = len(fence[1])
        end = next(k for k in range(at + 1, len(lines)) if lines[k].strip() == "```")
        yield fence[2] or "plain", at + 2, [line[indent:] for line in lines[at + 1 : end]]
        at = end + 1


def _commands(lines: list[str], start: int, path: Path) -> list[Command]:
    commands: list[Command] = []
    goes_on = False
    for number, line in enumerate(lines, start):
        if goes_on:
            command = commands[-1]
            command.text = command.text.removesuffix("\\") + line.strip()
            command.first = number + 1
            goes_on = line.endswith("\\")
        elif line.startswith("$ "):
            commands.append(Command(line.removeprefix("$ "), number, number + 1))
            goes_on = line.endswith("\\")
        elif not commands:
            raise ValueError(
                f"{path.name}, line {number}: a block of commands begins with a line that starts "
                f"with '$ '"
            )
        else:
            commands[-1].shown.append(line)
    return commands


def _check_budgets(block: Block, path: Path) -> None:
    for command in block.commands:
        if block.not_run is None and command.shown and _BUDGET.search(command.text):
            raise ValueError(
                f"{path.name}, line {command.line}: the page shows what a budget of seconds found; "
                f"give it --units"
            )


def matches(shown: list[str], printed: list[str]) -> bool:
    """Return True if the output matches the page, apart from ``...`` and from durations."""
    lines = [_SECONDS.sub("in 0 s", line.rstrip()) for line in printed]
    # Numbers of printed lines that the lines shown so far may match; a single pattern would take
    # forever.
    reached = {0}
    for line in shown:
        if line.strip() == "...":
            reached = set(range(min(reached, default=len(lines) + 1), len(lines) + 1))
        else:
            parts = _SKIPPED.split(_SECONDS.sub("in ... s", line.rstrip()))
            pattern = re.compile(".*?".join(map(re.escape, parts)))
            reached = {k + 1 for k in reached if k < len(lines) and pattern.fullmatch(lines[k])}
    return len(lines) in reached


def run_page(page: Page, folder: Path) -> Iterator[Done]:
    """Run a page's commands in a folder, in order, and return their output."""
    for name in ("corpora", "examples"):
        shutil.copytree(ROOT / name, folder / name)
    for name, text in page.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = {"PATH": path, "ROOT": str(ROOT), "COLUMNS": "200", "WORLDGEN_PROGRESS": "off"}
    environment["XDG_STATE_HOME"] = str(Path(folder).resolve() / ".state")
    with contextlib.chdir(folder), mock.patch.dict(os.environ, environment):
        for block in page.blocks:
            if block.runs_here:
                # This process keeps the modules that it has imported, so it would miss an edit.
                edited = any(one.hidden and "sed -i" in one.text for one in block.commands)
                for command in block.commands:
                    yield run(command, in_this_process=not edited)


def run_parts(path: Path, folder: Path) -> Iterator[Done]:
    """Run a page's commands, each part in its own folder."""
    for number, part in enumerate(read_parts(path)):
        own = folder / str(number)
        own.mkdir()
        yield from run_page(part, own)


def run(command: Command, in_this_process: bool = True) -> Done:
    """Run one command in the current folder.

    ``worldgen`` runs in this process, which is quicker; everything else runs as a program.
    """
    text = os.path.expandvars(command.text) if command.hidden else command.text
    words = shlex.split(_BUDGET.sub(r"\1--units 1", text), comments=True)
    if words[0] == "worldgen" and in_this_process and "|" not in words and ">" not in words:
        code, printed = _run_here(words)
    else:
        done = subprocess.run(
            text, shell=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
        )
        code, printed = done.returncode, done.stdout.decode("utf-8", "replace")
    return Done(command, code, printed.splitlines())


def _run_here(argv: list[str]) -> tuple[int, str]:
    both = io.StringIO()
    with (
        mock.patch.object(sys, "argv", argv),
        contextlib.redirect_stdout(both),
        contextlib.redirect_stderr(both),
    ):
        try:
            command_line()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    return code, both.getvalue()


def faults(path: Path, folder: Path) -> list[str]:
    """Return what is wrong with a page, a text for each command whose output differs."""
    return [fault for done in run_parts(path, folder) if (fault := done.fault)]


def updated(text: str, done: list[Done]) -> str:
    """Return a page's text with the output that its commands print today.

    Lines that a page elides with ``...`` stay elided: as many lines as it shows above and below are
    kept.
    """
    lines = text.splitlines()
    for one in reversed(done):
        command = one.command
        if command.hidden or not command.shown or matches(command.shown, one.printed):
            continue
        if one.code >= _WENT_WRONG:  # the page's command is wrong, not its output
            continue
        printed = one.printed
        skips = [k for k, line in enumerate(command.shown) if line.strip() == "..."]
        if skips:
            above = skips[0]
            below = len(command.shown) - skips[-1] - 1
            if above + below < len(printed):
                printed = [*printed[:above], "...", *printed[len(printed) - below :]]
        at = command.first - 1
        indent = lines[command.line - 1].partition("$")[0]
        lines[at : at + len(command.shown)] = [(indent + line).rstrip() for line in printed]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Compare pages with the output of their commands, or update them."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.repo.documented_commands", description=__doc__
    )
    parser.add_argument(
        "pages", nargs="*", type=Path, default=PAGES, metavar="PAGE", help="all by default"
    )
    parser.add_argument(
        "--update", action="store_true", help="write what the commands print into the pages"
    )
    options = parser.parse_args()
    wrong = 0
    for path in map(Path.absolute, options.pages):
        with tempfile.TemporaryDirectory() as folder:
            done = []
            for one in run_parts(path, Path(folder)):
                done.append(one)
                sys.stderr.write(f"{path.name}: {one.command.text}\n")
        found = [fault for one in done if (fault := one.fault)]
        if options.update and found:
            path.write_text(updated(path.read_text(encoding="utf-8"), done), encoding="utf-8")
        wrong += len(found)
        sys.stdout.write(f"{path.name}: {len(done)} commands, {len(found)} not as shown\n")
        sys.stdout.writelines(f"{fault}\n\n" for fault in found)
    return 1 if wrong and not options.update else 0


if __name__ == "__main__":
    sys.exit(main())
