"""Other people's controllers in their own environment.

They drive, and the stored failures are confirmed.
"""

import json
import os
import subprocess
from importlib.metadata import distribution
from pathlib import Path

import pytest

from tests.clients.environments import SCRIPTS, client
from worldgen import read_world

REPOSITORY = Path(__file__).parents[2]
FAILURES = REPOSITORY / "examples" / "third-party" / "failures"


@pytest.fixture(scope="module")
def ask(tmp_path_factory):
    """Runs Python with the third-party packages and this checkout's worldgen."""
    python = client("third-party").python
    folder = tmp_path_factory.mktemp("site")
    info = folder / "worldgen-0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: worldgen\nVersion: 0\n")
    (info / "entry_points.txt").write_text(
        distribution("worldgen").read_text("entry_points.txt") or ""
    )
    env = {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{REPOSITORY}", "MPLBACKEND": "Agg"}

    def run(*words):
        text = [str(word) for word in (python, "-W", "ignore", *words)]
        return subprocess.run(
            text, cwd=REPOSITORY, env=env, capture_output=True, text=True, timeout=300, check=False
        )

    return run


def controllers():
    found = {read_world(path).failure.controller for path in FAILURES.glob("*/*.grid")}
    return sorted(found)


def test_each_controller_arrives_where_nothing_is_in_its_way(ask):
    names = [*controllers(), "./examples/third-party/dynamic_window.py:PlannedWindow"]
    done = ask(SCRIPTS / "third_party_room.py", *names)
    assert done.returncode == 0, done.stderr[-2000:]
    assert json.loads(done.stdout.splitlines()[-1]) == dict.fromkeys(names, "reached")


def test_their_stored_failures_are_confirmed(ask):
    files = list(FAILURES.glob("*/*.grid"))
    done = ask("-c", "from worldgen.cli.main import main; main()", "replay", FAILURES)
    assert f"{len(files)} of {len(files)} confirmed" in done.stdout, (
        done.stdout + done.stderr[-2000:]
    )
