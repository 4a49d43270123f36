"""Entry point of ``worldgen``: find commands, and turn errors into one line and an exit code."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import os
import shlex
import sys
import warnings
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from worldgen.cli.ctrl_c import no_ctrl_c_lost
from worldgen.cli.every_command import QUIET_AND_VERBOSE, equip, watch_parser
from worldgen.cli.output import ask_user, is_at_terminal, note, say
from worldgen.cli.overview import COMMANDS, describe_versions
from worldgen.cli.usage import UnknownCommand
from worldgen.errors import NotAGrid, WorldgenError
from worldgen.plugins.entry_points import points_of
from worldgen.plugins.own_packages import check_hidden, prefer_own_packages
from worldgen.plugins.trust import admit_typed, command_rule, unsaid
from worldgen.support.plain_text import joined, shown_lines
from worldgen.support.progress import display_on_stderr
from worldgen.support.results import claim_stdout, only_results_on_stdout, release_stdout

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

EPILOG = (
    "\b\n  worldgen maze --size 60 --out w.grid\n  worldgen run w.grid --controller turn-right "
    "--picture run.png\n"
    "  worldgen fuzz --controller turn-right --budget 30s --out failures/\n  worldgen replay "
    "failures/\n\n"
    "Every command has --help. Exit codes: 0 success, 1 a failure was found, 2 bad input, 3 "
    "internal error (please report it), 4 no answer (too little was tried), 130 interrupted."
)


_OUR_PACKAGES = ("worldgen", "sim", "fuzz")


class LazyGroup(click.Group):
    """A group whose commands live in entry points and are imported when used."""

    def _points(self, group: str) -> dict[str, EntryPoint]:
        return {point.name: point for point in points_of(group)}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return families first, then the commands of every installed package."""
        return [
            *sorted(self._points("worldgen.families")),
            *sorted(self._points("worldgen.commands")),
        ]

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command, in which no file can choose code to run.

        A command that refused some code has not answered, whatever it printed.
        """
        with command_rule(ask_user if is_at_terminal() else None) as refused:
            answer: Any = None
            ended: click.exceptions.Exit | SystemExit | None = None
            try:
                answer = super().invoke(ctx)
            except (click.exceptions.Exit, SystemExit) as stop:
                ended = stop
            code = ended.code if isinstance(ended, SystemExit) else getattr(ended, "exit_code", 0)
            if refused and code in (None, 0, 1):
                for sentence in unsaid():
                    note(f"worldgen: {sentence}", always=True)
                raise click.exceptions.Exit(2)
            if ended is not None:
                raise ended
            return answer

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the requested command, and add what every command has."""
        # A family in a user's file, or another package's command, may print when it is imported.
        with only_results_on_stdout():
            command = self._found(cmd_name)
        point = self._points("worldgen.commands").get(cmd_name)
        is_ours = point is None or point.value.partition(".")[0] in _OUR_PACKAGES
        return None if command is None else equip(command, is_ours=is_ours)

    def _found(self, cmd_name: str) -> click.Command | None:
        point = self._points("worldgen.commands").get(cmd_name)
        if point is not None:
            if not point.value.startswith("worldgen."):
                check_hidden()
            command: object = point.load()
            if not isinstance(command, click.Command):
                raise click.ClickException(
                    f"command {cmd_name!r} ({point.value}) is not a click command"
                )
            return command
        if cmd_name in self._points("worldgen.families") or ":" in cmd_name:
            # Such as ./mine.py:my_family.
            admit_typed([cmd_name], "")
            from worldgen.cli.family_command import family_command

            return family_command(cmd_name)
        return None

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem[str]]:
        """Complete a command's name without importing any command."""
        from click.shell_completion import CompletionItem

        if incomplete.startswith("-"):
            return click.Command.shell_complete(self, ctx, incomplete)
        summaries = {name: text for job in COMMANDS.values() for name, text in job.items()}
        names = (name for name in self.list_commands(ctx) if name.startswith(incomplete))
        return [CompletionItem(name, help=summaries.get(name)) for name in names]

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Suggest the nearest command for a misspelt one."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            raise UnknownCommand(name, self.list_commands(ctx), ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands by job, without importing any of them."""
        installed = dict.fromkeys(sorted(self._points("worldgen.commands")), "")
        families = ", ".join(sorted(self._points("worldgen.families")))
        # List only installed commands, in the order of the jobs they do.
        rows = {"Make worlds": [("FAMILY", f"Make a world of a family: {families}.")]}
        for job, summaries in COMMANDS.items():
            known = [(name, text) for name, text in summaries.items() if name in installed]
            with formatter.section(job):
                formatter.write_dl(rows.get(job, []) + known)
            for name, _ in known:
                del installed[name]
        if installed:
            with formatter.section("From other packages"):
                formatter.write_dl(list(installed.items()))


def _print_include(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Print the include folder for controllers in C."""
    if wanted:
        say(str(Path(__file__).parents[2] / "sim" / "include"))
        ctx.exit()


def _print_versions(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Print the versions of the program and of the libraries it uses."""
    if wanted:
        say(joined(describe_versions()))
        ctx.exit()


@click.group(
    cls=LazyGroup,
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"]},
    params=[*QUIET_AND_VERBOSE],
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_versions,
    help="Show the versions that a bug report needs, and exit.",
)
@click.option(
    "--include",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_include,
    help="Print the include folder with worldgen_controller.h, for cc -I, and exit.",
)
def cli() -> None:
    """Make worlds for mobile robots, run controllers in them, and find worlds where they fail."""


watch_parser(cli)


def _say_how_to_import(error: NotAGrid) -> None:
    """Print the command that makes a world of another program's map, if the file is one."""
    from worldgen.interop.recognising import find_format, looks_like_a_map

    path = Path(error.source or "")
    if not path.is_file() or not looks_like_a_map(path):
        return
    # Several formats match, and import reports that.
    with contextlib.suppress(WorldgenError):
        # Only its name matches: import would report the same again.
        if find_format(path).name == "grid":
            return
    out = f"{path.stem}{'-imported' if path.suffix == '.grid' else ''}.grid"
    command = shlex.join(["worldgen", "import", str(path), "--out", out])
    note("it looks like a map of another program; make a world of it first:", always=True)
    note(f"  {command}", always=True)


_CORES = ("worldgen._core", "sim._core", "fuzz._core")


def main() -> NoReturn:
    """Run the command line and end the process with the documented exit code."""
    # Our own packages come first, even if the user has a folder called sim.
    prefer_own_packages()
    if "_WORLDGEN_COMPLETE" in os.environ:
        from worldgen.cli.completion import offer_completion

        offer_completion()
    claim_stdout()
    _print_safely_what_libraries_say()
    # Every error becomes one line and the documented exit code.
    try:
        with no_ctrl_c_lost(), display_on_stderr():
            code = cli.main(prog_name="worldgen", standalone_mode=False)
            # Write what another package's command printed, to end well if nobody reads it.
            say("", nl=False)
    except click.exceptions.Exit as stop:
        code = stop.exit_code
    except click.ClickException as error:
        code = _answer_wrong_command(error)
    except (click.Abort, KeyboardInterrupt):
        note("interrupted", always=True)
        code = 130
    except WorldgenError as error:
        code = _answer_error(error)
    except OSError as error:
        if error.errno is None or error.errno in (errno.EFAULT, errno.EBADF):
            code = _our_fault(error)
        else:
            where = f"{error.filename}: " if error.filename else ""
            note(f"worldgen: {where}{error.strerror or error}", always=True)
            code = 2
    except MemoryError:
        note("worldgen: out of memory; use a smaller world", always=True)
        code = 2
    except Exception as error:  # noqa: BLE001 - the last net: no traceback reaches a user unasked
        code = _our_fault(error)
    finally:
        release_stdout()
    sys.exit(code if isinstance(code, int) else 0)


def _answer_wrong_command(error: click.ClickException) -> int:
    """Print what is wrong with a command and the corrected one; return the exit code."""
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        help_text = io.StringIO()
        error.show(file=help_text)
        note(joined(help_text.getvalue().rstrip("\n")), always=True)
    elif isinstance(error, click.UsageError):
        from worldgen.cli.corrections import answer

        # A correction looks for files of the words' names, which may be too long for any.
        try:
            note(answer(error, cli, sys.argv[1:]), always=True)
        except OSError:
            note(f"worldgen: {error.format_message()}", always=True)
    else:
        note(f"worldgen: {error.format_message()}", always=True)
    return 2


def _answer_error(error: WorldgenError) -> int:
    """Print an error, after what was noticed before it, and the corrected command if one is known.

    Return the exit code.
    """
    from worldgen.cli.corrections import answer_named

    for sentence in error.notes:
        note(sentence)
    note(joined(f"worldgen: {error}"), always=True)
    # What helps looks for files of the words' names, which may be too long for any.
    with contextlib.suppress(OSError):
        if isinstance(error, NotAGrid):
            _say_how_to_import(error)
        elif suggested := answer_named(error, cli, sys.argv[1:]):
            note(f"  {suggested}", always=True)
    return 2


class _SafeLog(logging.Formatter):
    """Formats a library's log line without control characters of the file that it is about."""

    def format(self, record: logging.LogRecord) -> str:
        return shown_lines(super().format(record))


_usual_warning = warnings.formatwarning


def _safe_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    line: str | None = None,
) -> str:
    return shown_lines(_usual_warning(message, category, filename, lineno, line))


def _print_safely_what_libraries_say() -> None:
    """Pass warnings and log lines of other libraries, which may quote a file, through our door."""
    warnings.formatwarning = _safe_warning
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(_SafeLog())


def _our_fault(error: BaseException) -> int:
    try:
        check_hidden()
    # In that case the error is not our fault.
    except WorldgenError as hidden:
        note(f"worldgen: {hidden}", always=True)
        return 2
    # A source checkout that is not installed: the message says so.
    if isinstance(error, ModuleNotFoundError) and error.name in _CORES:
        note(f"worldgen: {error}", always=True)
        return 2
    if os.environ.get("WORLDGEN_DEBUG"):
        import traceback

        note(joined("".join(traceback.format_exception(error)).rstrip("\n")), always=True)
    note(
        f"worldgen: a bug in worldgen, not an error in your input: {type(error).__name__}: {error}",
        always=True,
    )
    note("Set WORLDGEN_DEBUG=1 and run it again to get the details to report.", always=True)
    return 3
