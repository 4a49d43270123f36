"""Run the scripts in ``benchmarks/peers``, each in the interpreter in which its peer is installed."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any


def add_peer_options(parser: argparse.ArgumentParser, peers: Iterable[str]) -> None:
    """Add an option for each peer's interpreter."""
    for peer in peers:
        parser.add_argument(
            f"--{peer}",
            default=sys.executable,
            metavar="PYTHON",
            help=f"interpreter that has {peer}",
        )


def run_peer(script: str, name: str, python: str, given: str | None = None) -> Any:
    """Return what a peer's script prints as JSON; None if the peer is not installed.

    Args:
        script: Name of the script.
        name: Name of the peer.
        python: Its interpreter.
        given: Input of the script.
    """
    path = Path(__file__).parent / "peers" / script
    done = subprocess.run(
        [python, str(path), name], check=False, capture_output=True, text=True, input=given
    )
    if done.returncode != 0:
        if any(error in done.stderr for error in ("ModuleNotFoundError", "PackageNotFoundError")):
            return None
        raise RuntimeError(f"{name} failed in {python}:\n{done.stderr[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])
