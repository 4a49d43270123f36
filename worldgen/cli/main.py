"""Entry point of ``worldgen``: finds commands, turns errors into one line and an exit code."""

from __future__ import annotations

import contextlib
import errno
import os
import shlex
import sys
from importlib.metadata import EntryPoint, version
from pathlib import Path
from typing import NoReturn

import click

from worldgen.cli.ctrl_c import no_ctrl_c_lost
from worldgen.cli.every_command import QUIET_AND_VERBOSE, equip
from worldgen.cli.output import note
from worldgen.errors import NotAGrid, WorldgenError
from worldgen.plugins.entry_points import points_of
from worldgen.plugins.own_packages import check_hidden, prefer_own_packages
from worldgen.support.progress import display_on_stderr

__all__ = ["cli", "main"]

EPILOG = (
    "\b\n  worldgen maze --size 60 --out w.grid\n  worldgen run w.grid --controller turn-right "
    "--trail run.png\n"
    "  worldgen fuzz --controller turn-right --budget 30s --out failures/\n  worldgen replay "
    "failures/\n\n"
    "Every command has --help. Exit codes: 0 fine, 1 a failure was found, 2 bad input, 3 our "
    "fault, 130 interrupted."
)


class LazyGroup(click.Group):
    """A group whose commands live in entry points and are imported when used."""

    def _points(self, group: str) -> dict[str, EntryPoint]:
        return {point.name: point for point in points_of(group)}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Families first, then the commands of every installed package."""
        return [
            *sorted(self._points("worldgen.families")),
            *sorted(self._points("worldgen.commands")),
        ]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the one command that is asked for, and give it what every command has."""
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
                    f"command {cmd_name!r} ({point.value}) is no click command"
                )
            return command
        if (
            cmd_name in self._points("worldgen.families")
            or ":" in cmd_name
            or cmd_name.endswith(".toml")
        ):
            # ./mine.py:my_family, ./recipe.toml
            from worldgen.commands.family_command import family_command

            return family_command(cmd_name)
        return None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Suggests the nearest command for a misspelt one."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            import difflib

            names = self.list_commands(ctx)
            close = difflib.get_close_matches(name, names, n=1)
            hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(names)}"
            ctx.fail(f"no command is called {name!r}; {hint}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Lists names by kind without importing a single command."""
        with formatter.section("Families (worldgen FAMILY --out w.grid)"):
            formatter.write_text(", ".join(sorted(self._points("worldgen.families"))))
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, _SUMMARY.get(name, ""))
                    for name in sorted(self._points("worldgen.commands"))
                ]
            )


# One line per command of our own, so that --help need not import them; tests hold it against the
# commands.
_SUMMARY = {
    "audit": "Say whether a trajectory, recorded in any simulator, was possible in a world.",
    "boundary": "Say at which values of one number a controller arrives and at which it fails.",
    "census": "Count in how many foreign maps a disc can reach its target, and where only a grid "
    "says so.",
    "compare": "Run controllers in many worlds and print one table of times, failures, best and "
    "worst.",
    "chance": "Say whether a random controller arrives with probability one, never, or in part.",
    "check-family": "Check what every family promises, over a family of your own.",
    "check-scenarios": "Check that MovingAI problems have the shortest path that their file says.",
    "compose": "Make worlds of parts, by a recipe: a trap in a maze, a fire in one wing.",
    "corpus": "Look at saved failures, compare and merge folders of them, and keep them small.",
    "demo": "Make a world, run a robot in it, find and draw the smallest worlds in which it fails.",
    "find": "Find a world in which given controllers have given outcomes, or come as near as the "
    "budget allows.",
    "explain": "Say what a failure depends on: the least changes after which the robot arrives.",
    "export": "Write a world in another program's format.",
    "formats": "List the formats that import reads and export writes; of one, its options.",
    "fuzz": "Search for worlds in which a controller fails; prove, shrink and save what is found.",
    "init": "Set up FOLDER so that its CI looks for worlds in which your controller fails.",
    "import": "Read a foreign map and place start and target.",
    "measure": "Say how hard worlds are: by their ways, their narrow places, what draws a robot "
    "astray.",
    "new-controller": "Write a working, commented controller to begin from.",
    "regenerate": "Make a set of worlds again from its manifest, byte for byte, or check it.",
    "report": "Show failures in one HTML page: pictures, replays, numbers, and how their campaign "
    "went.",
    "replay": "Run saved failures again: does each still fail, how, or does the robot arrive now.",
    "run": "Run a controller in a world and say how it ends.",
    "show": "Draw a world in the terminal, or as PNG, SVG or HTML.",
    "studio": "Draw worlds, run robots in them and watch, in the browser.",
    "shrink": "Make a failure's world as small as it can be, keeping verdict and certificate.",
    "verify": "Check a world's proof, or decide a map afresh.",
}


def _print_include(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Print where the header for controllers in C is."""
    if wanted:
        click.echo(Path(__file__).parents[2] / "sim" / "include")
        ctx.exit()


@click.group(
    cls=LazyGroup,
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"]},
    params=[*QUIET_AND_VERBOSE],
)
@click.version_option(version("worldgen"), prog_name="worldgen")
@click.option(
    "--include",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_include,
    help="Print the folder of worldgen_controller.h, for cc -I, and exit.",
)
def cli() -> None:
    """Make worlds for mobile robots, run controllers in them, and find the worlds where they fail."""


def _say_how_to_import(error: NotAGrid) -> None:
    """Print the command that makes a world of another program's map, if the file is one."""
    from worldgen.interop.recognising import find_format, looks_like_a_map

    path = Path(error.source or "")
    if not path.is_file() or not looks_like_a_map(path):
        return
    with contextlib.suppress(WorldgenError):  # of several formats: import says so
        if find_format(path).name == "grid":  # by its name alone: import would say the same again
            return
    out = f"{path.stem}{'-imported' if path.suffix == '.grid' else ''}.grid"
    command = shlex.join(["worldgen", "import", str(path), "--out", out])
    note(
        f"it looks like a map of another program; make a world of it first:\n  {command}",
        always=True,
    )


def main() -> NoReturn:
    """Runs the command line and ends the process with the documented exit code."""
    prefer_own_packages()
    try:
        with no_ctrl_c_lost(), display_on_stderr():
            code = cli.main(standalone_mode=False)
            sys.stdout.flush()
    except click.exceptions.Exit as stop:
        code = stop.exit_code
    except click.ClickException as error:
        error.show()
        code = 2
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        code = 130
    except WorldgenError as error:
        note(f"worldgen: {error}", always=True)
        if isinstance(error, NotAGrid):
            _say_how_to_import(error)
        code = 2
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
    except WorldgenError as hidden:  # then what went wrong is no fault of ours
        note(f"worldgen: {hidden}", always=True)
        return 2
    if os.environ.get("WORLDGEN_DEBUG"):
        import traceback

        traceback.print_exception(error)
    click.echo(
        f"worldgen: a fault of our own, not of your input: {type(error).__name__}: {error}\n"
        "Set WORLDGEN_DEBUG=1 and run it again for the details to report.",
        err=True,
    )
    return 3
