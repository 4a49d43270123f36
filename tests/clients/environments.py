"""The real programs that must accept the output of ``export``, each in its own environment.

A client from the package registry lives in a virtual environment under ``$WORLDGEN_CLIENTS``
(``build/clients`` if it is not set), made by ``python -m tests.clients.install [NAME ...]``; a
system program is looked up on PATH. If one is missing, its tests are skipped with a message that
explains how to get it.
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
        name: Name of the client.
        python: The interpreter.
    """

    name: str
    python: Path

    def ask(
        self, script: str, *args: object, timeout: float = 120.0, cwd: Path | None = None
    ) -> dict:
        """Return the output of ``scripts/SCRIPT``, one JSON object on its last line.

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
    """Return the client with this name; skip the test, with the reason, if it is not installed."""
    for place in ("bin/python", "Scripts/python.exe"):
        python = FOLDER / name / place
        if python.exists():
            return Client(name, python)
    pytest.skip(
        f"{name} is not here, so it did not judge what export writes; python -m "
        f"tests.clients.install {name}"
    )


def program(name: str) -> str:
    """Return the path of a program; skip the test, with the reason, if there is none."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(
            f"{name} is not here, so it did not judge what export writes; apt-get install "
            f"{PROGRAMS[name]}"
        )
    return found
