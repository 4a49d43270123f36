"""What the first runs need is compiled while the page is looked at, once for each installation."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fuzz.studio import Folder, Gate, Studio, serving
from fuzz.studio.preparing import _RUNS, prepare_beside
from sim.motion import MOTIONS


@pytest.mark.gate
def test_it_is_done_once_and_in_a_process_that_ends(tmp_path):
    done = tmp_path / "done"
    process = prepare_beside(done)
    process.join(300)
    assert process.exitcode == 0 and done.exists()
    assert prepare_beside(done) is None


def test_both_simulators_are_prepared():
    assert {MOTIONS.get(motion).kernel for _, motion in _RUNS} == {MOTIONS.get(name).kernel for name in MOTIONS.names()}


def test_it_begins_when_the_studio_does(monkeypatch, tmp_path):
    did = []
    monkeypatch.setattr(serving, "prepare_beside", lambda: did.append("prepared"))
    monkeypatch.setattr(serving.uvicorn.Server, "run", lambda server, sockets: did.append("served"))
    studio = Studio(Folder(tmp_path), Gate("127.0.0.1", 1))
    serving.serve(studio, None, browse=False, said=lambda words: None)
    assert did == ["prepared", "served"]


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


@pytest.mark.gate
def test_what_runs_beside_a_server_ends_with_it_also_when_that_is_killed(tmp_path):
    (tmp_path / "server.py").write_text(SERVER)
    started = [sys.executable, tmp_path / "server.py"]
    here = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen(started, stdout=subprocess.PIPE, text=True, env=here) as one:
        assert one.stdout.readline() == "there\n"
        one.kill()
        assert one.communicate(timeout=60)[0] == ""  # ends when nobody holds the pipe any more
