"""Options shared by several of the fuzzer's commands."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

__all__ = ["Duration", "output_options"]

F = TypeVar("F", bound=Callable[..., Any])


def output_options(command: F) -> F:
    """Add ``--junit``, ``--sarif`` and ``--summary``: reports for CI services."""
    for name, what in (
        (
            "--summary",
            "Append a Markdown summary to this file, such as $GITHUB_STEP_SUMMARY.",
        ),
        ("--sarif", "Write a SARIF 2.1.0 report, for code scanning."),
        ("--junit", "Write a JUnit XML report."),
    ):
        command = click.option(name, type=click.Path(path_type=Path), metavar="OUT", help=what)(
            command
        )
    return command


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
