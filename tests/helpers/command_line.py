"""Runs the command line in this process, exit code and all."""

import contextlib
import io
import sys
from dataclasses import dataclass
from unittest import mock

from worldgen.cli.main import main


@dataclass
class Result:
    """What a command left behind."""

    code: int
    out: str
    err: str


def worldgen(*args: object) -> Result:
    """Runs ``worldgen ARGS`` as the console script does."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["worldgen", *map(str, args)]
    with mock.patch.object(sys, "argv", argv), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 1
    return Result(code, out.getvalue(), err.getvalue())
