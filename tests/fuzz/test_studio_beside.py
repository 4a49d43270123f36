"""A process that works for a server ends with it."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

SERVER = """
import sys
from fuzz.studio.workers import start_beside
from tests.fuzz.test_studio_beside import told_and_waiting

if __name__ == "__main__":
    start_beside(told_and_waiting, nice=0).join()
"""


def told_and_waiting():
    """Reports that it has started, and then waits forever."""
    print("there", flush=True)
    while True:
        time.sleep(1)


@pytest.mark.gate
def test_what_runs_beside_a_server_ends_with_it_also_when_that_is_killed(tmp_path):
    (tmp_path / "server.py").write_text(SERVER)
    started = [sys.executable, tmp_path / "server.py"]
    here = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen(started, stdout=subprocess.PIPE, text=True, env=here) as one:
        assert one.stdout.readline() == "there\n"
        one.kill()
        assert (
            one.communicate(timeout=60)[0] == ""
        )  # ends when no process holds the pipe any longer
