"""What the first runs need is compiled while the page is looked at, once for each installation."""

import os
import subprocess
import sys
import time
from pathlib import Path

from fuzz.studio.preparing import _done, prepare_beside


def test_it_is_done_once_and_in_a_process_that_ends():
    _done().unlink(missing_ok=True)
    process = prepare_beside()
    process.join(300)
    assert process.exitcode == 0 and _done().exists()
    assert prepare_beside() is None


SERVER = """
import sys
from fuzz.studio.beside import start_beside
from tests.fuzz.test_studio_preparing import told_and_waiting

if __name__ == "__main__":
    start_beside(told_and_waiting, nice=0).join()
"""


def told_and_waiting():
    """Says that it is there, and would wait for ever."""
    print("there", flush=True)
    while True:
        time.sleep(1)


def test_what_runs_beside_a_server_ends_with_it_also_when_that_is_killed(tmp_path):
    (tmp_path / "server.py").write_text(SERVER)
    started = [sys.executable, tmp_path / "server.py"]
    here = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen(started, stdout=subprocess.PIPE, text=True, env=here) as one:
        assert one.stdout.readline() == "there\n"
        one.kill()
        assert one.stdout.read() == ""  # ends when nobody holds the pipe any more
