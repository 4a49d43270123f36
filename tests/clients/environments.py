"""The real programs that must accept what ``export`` writes, each in an environment of its own.

A client from the package registry lives in a virtual environment under ``$WORLDGEN_CLIENTS``
(``build/clients`` where it is not set), made by ``python -m tests.clients.install [NAME ...]``; a
program of the system is looked for on the path. Where one is missing its tests are skipped and say
how to get it.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.clients.install import FOLDER, PROGRAMS

SCRIPTS = Path(__file__).parent / "scripts"


@dataclass(frozen=True)
class Client:
    """An interpreter that has one client installed.

    Args:
        name: Of the client.
        python: The interpreter.
    """

    name: str
    python: Path

    def ask(
        self, script: str, *args: object, timeout: float = 120.0, cwd: Path | None = None
    ) -> dict:
        """What ``scripts/SCRIPT`` prints, as one JSON object in its last line.

        Args:
            script: Name of the file.
            args: Its arguments.
            timeout: s.
            cwd: Where it runs.
        """
        words = [self.python, "-W", "ignore", SCRIPTS / script, *args]
        quiet = {"MPLBACKEND": "Agg", "PYTHONPATH": "", "SDL_VIDEODRIVER": "dummy"}
        done = subprocess.run(
            [str(word) for word in words],
            capture_output=True, text=True, timeout=timeout, cwd=cwd, env={**os.environ, **quiet}, check=False,
        )  # fmt: skip
        assert done.returncode == 0, (
            f"{self.name}: {script} ended with {done.returncode}:\n{done.stderr[-4000:]}"
        )
        return json.loads(done.stdout.splitlines()[-1])


def client(name: str) -> Client:
    """The client of that name; the test is skipped, with the reason, where it is not installed."""
    for place in ("bin/python", "Scripts/python.exe"):
        python = FOLDER / name / place
        if python.exists():
            return Client(name, python)
    pytest.skip(
        f"{name} is not here, so it did not judge what export writes; python -m "
        f"tests.clients.install {name}"
    )


def program(name: str) -> str:
    """The path of a program; the test is skipped, with the reason, where there is none."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(
            f"{name} is not here, so it did not judge what export writes; apt-get install "
            f"{PROGRAMS[name]}"
        )
    return found
