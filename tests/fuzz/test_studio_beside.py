"""A process that works for a server ends with it."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
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


PAIR = """
import os
import sys
from pathlib import Path
from fuzz.studio.workers import start_beside
from tests.fuzz.test_studio_beside import note

if __name__ == "__main__":
    for k in range(2):
        os.environ["WHICH"] = f"number {k}"
        one = start_beside(note, Path(sys.argv[1]), nice=0)
        one.join()
        assert one.exitcode == 0, one.exitcode
"""


def note(file):
    """Adds a line with what a process should not share with others."""
    words = (os.environ["WHICH"], os.environ.get("PYTHONSAFEPATH"), np.random.random())
    with file.open("a") as lines:
        print(*words, file=lines)


@pytest.mark.gate
@pytest.mark.parametrize("depth", [0, 120])
def test_processes_have_the_environment_of_now_and_random_numbers_of_their_own(tmp_path, depth):
    temporary = tmp_path / ("long" * depth)[:120]  # a socket's path must be shorter
    temporary.mkdir(exist_ok=True)
    (tmp_path / "server.py").write_text(PAIR)
    here = {"PYTHONPATH": str(Path(__file__).parents[2]), "TMPDIR": str(temporary)}
    subprocess.run(
        [sys.executable, tmp_path / "server.py", tmp_path / "noted"],
        env=os.environ | here, check=True, timeout=300,
    )  # fmt: skip
    first, second = (
        line.rsplit(maxsplit=1) for line in (tmp_path / "noted").read_text().split("\n")[:2]
    )
    assert (first[0], second[0]) == ("number 0 None", "number 1 None")
    assert first[1] != second[1]
    assert not list(temporary.glob("pymp-*"))
