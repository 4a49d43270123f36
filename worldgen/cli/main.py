"""Entry point of ``worldgen``: find commands, and turn errors into one line and an exit code."""

from __future__ import annotations

import contextlib
import errno
import os
import shlex
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import click

from worldgen.cli.ctrl_c import no_ctrl_c_lost
from worldgen.cli.every_command import QUIET_AND_VERBOSE, equip, watch_parser
from worldgen.cli.output import note
from worldgen.cli.overview import COMMANDS, describe_versions
from worldgen.cli.usage import UnknownCommand
from worldgen.errors import NotAGrid, WorldgenError
from worldgen.plugins.entry_points import points_of
from worldgen.plugins.own_packages import check_hidden, prefer_own_packages
from worldgen.support.progress import display_on_stderr

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

EPILOG = (
    "\b\n  worldgen maze --size 60 --out w.grid\n  worldgen run w.grid --controller turn-right "
    "--picture run.png\n"
    "  worldgen fuzz --controller turn-right --budget 30s --out failures/\n  worldgen replay "
    "failures/\n\n"
    "Every command has --help. Exit codes: 0 success, 1 a failure was found, 2 bad input, 3 "
    "internal error (please report it), 130 interrupted."
)


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

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the requested command, and add what every command has."""
        command = self._found(cmd_name)
        return None if command is None else equip(command)

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
        if (
            cmd_name in self._points("worldgen.families")
            or ":" in cmd_name
            or cmd_name.endswith(".toml")
        ):
            # Such as ./mine.py:my_family or ./recipe.toml.
            from worldgen.commands.family_command import family_command

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
        click.echo(Path(__file__).parents[2] / "sim" / "include")
        ctx.exit()


def _print_versions(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Print the versions of the program and of the libraries it uses."""
    if wanted:
        click.echo(describe_versions())
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
    note(
        f"it looks like a map of another program; make a world of it first:\n  {command}",
        always=True,
    )


_CORES = ("worldgen._core", "sim._core", "fuzz._core")


def main() -> NoReturn:
    """Run the command line and end the process with the documented exit code."""
    # Our own packages come first, even if the user has a folder called sim.
    prefer_own_packages()
    if "_WORLDGEN_COMPLETE" in os.environ:
        from worldgen.cli.completion import offer_completion

        offer_completion()
    # Every error becomes one line and the documented exit code.
    try:
        with no_ctrl_c_lost(), display_on_stderr():
            code = cli.main(prog_name="worldgen", standalone_mode=False)
            sys.stdout.flush()
    except click.exceptions.Exit as stop:
        code = stop.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        code = 2
    except click.UsageError as error:
        from worldgen.cli.corrections import answer

        note(answer(error, cli, sys.argv[1:]), always=True)
        code = 2
    except click.ClickException as error:
        note(f"worldgen: {error.format_message()}", always=True)
        code = 2
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        code = 130
    except WorldgenError as error:
        note(f"worldgen: {error}", always=True)
        from worldgen.cli.corrections import answer_named

        if isinstance(error, NotAGrid):
            _say_how_to_import(error)
        elif suggested := answer_named(error, cli, sys.argv[1:]):
            note(f"  {suggested}", always=True)
        code = 2
    # The reader of the pipe has closed it, so writing to it again would also fail.
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    except OSError as error:
        if error.errno is None or error.errno in (errno.EFAULT, errno.EBADF):
            code = _our_fault(error)
        else:
            where = f"{error.filename}: " if error.filename else ""
            note(f"worldgen: {where}{error.strerror or error}", always=True)
            code = 2
    except MemoryError:
        click.echo("worldgen: out of memory; use a smaller world", err=True)
        code = 2
    except Exception as error:  # noqa: BLE001 - the last net: no traceback reaches a user unasked
        code = _our_fault(error)
    sys.exit(code if isinstance(code, int) else 0)


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

        traceback.print_exception(error)
    click.echo(
        f"worldgen: a bug in worldgen, not an error in your input: {type(error).__name__}: "
        f"{error}\n"
        "Set WORLDGEN_DEBUG=1 and run it again to get the details to report.",
        err=True,
    )
    return 3
