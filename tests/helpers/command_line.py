"""Run the command line in this process, including the exit code."""

import contextlib
import io
import sys
from dataclasses import dataclass
from typing import Any
from unittest import mock

from worldgen.cli.main import cli, main
from worldgen.errors import WorldgenError


@dataclass
class Result:
    """The outcome of a command; ``error`` is the error that refused its input, if one ended it."""

    code: int
    out: str
    err: str
    error: WorldgenError | None = None

    @property
    def error_code(self) -> str:
        """The rule that was broken; empty if no such error ended the command."""
        return "" if self.error is None else self.error.code


def worldgen(*args: object) -> Result:
    """Run ``worldgen ARGS`` as the console script does."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["worldgen", *map(str, args)]
    ended_by: list[WorldgenError] = []
    without_record = cli.main

    def recording(**settings: Any) -> Any:
        try:
            return without_record(**settings)
        except WorldgenError as error:
            ended_by.append(error)
            raise

    with (
        mock.patch.object(sys, "argv", argv),
        mock.patch.object(cli, "main", recording),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 1
    return Result(code, out.getvalue(), err.getvalue(), ended_by[0] if ended_by else None)
