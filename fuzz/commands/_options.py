"""Options shared by several of the fuzzer's commands."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, TypeVar

import click

from worldgen.cli.output import PATH
from worldgen.cli.usage import Instead

# Budget of a search if none is given.
_USUAL_SECONDS = 30.0

F = TypeVar("F", bound=Callable[..., Any])


def output_options(command: F) -> F:
    """Add ``--junit``, ``--sarif`` and ``--summary``: reports for CI services."""
    for name, what in (
        ("--summary", "Append a Markdown summary to this file, such as $GITHUB_STEP_SUMMARY."),
        ("--sarif", "Write a SARIF 2.1.0 report, for code scanning."),
        ("--junit", "Write a JUnit XML report."),
    ):
        command = click.option(name, type=PATH, metavar="OUT", help=what)(command)
    return command


code_option: Callable[[F], F] = click.option(
    "--no-code",
    is_flag=True,
    help="Leave out the lines of a Python controller that run when it fails, and its state.",
)


class Duration(click.ParamType[float]):
    """A time like 30s, 5m, 1.5h, or plain seconds."""

    name = "duration"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read the time, s."""
        match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*(s|m|h)?", str(value).strip())
        if not match or float(match[1]) <= 0:
            self.fail(f"{value!r} is not a duration; write 30s, 5m or 1h", param, ctx)
        return float(match[1]) * {"s": 1, "m": 60, "h": 3600, None: 1}[match[2]]


def _refuse_both(context: click.Context, option: click.Parameter, value: Any) -> Any:
    other = "budget" if option.name == "units" else "units"
    if value is not None and context.params.get(other) is not None:
        raise Instead("use --budget or --units, not both", "--budget", context=context)
    return value


def budget_options(purpose: str) -> Callable[[F], F]:
    """Add ``--budget`` and ``--units``, of which at most one can be given.

    Args:
        purpose: What the time is for: ``to search``.
    """

    def decorated(command: F) -> F:
        for option in (
            click.option(
                "--units",
                type=click.IntRange(1),
                callback=_refuse_both,
                help="Run this many units of work instead; the result then depends only on the "
                "seed.",
            ),
            click.option(
                "--budget",
                type=Duration(),
                metavar="TIME",
                callback=_refuse_both,
                help=f"Time {purpose}, such as 30s, 5m or 1h.  [default: 30s]",
            ),
        ):
            command = option(command)
        return command

    return decorated


def seconds_of(budget: float | None, units: int | None) -> float | None:
    """Return the time that ``--budget`` and ``--units`` give, s; ``None`` for a number of units."""
    return None if units is not None else budget or _USUAL_SECONDS
