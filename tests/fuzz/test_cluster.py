"""A real Dask scheduler and real workers in separate processes.

One is killed in mid-campaign.
"""

import itertools
import json
import random
import re
import subprocess
import sys
import time
import warnings
from importlib.util import find_spec

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzz.campaign.executors import WorkersLost, cluster_executor
from fuzz.campaign.executors.remote import RemoteJob, give_dask_its_own_random
from fuzz.campaign.run import Campaign
from fuzz.campaign.state import UnitDone
from fuzz.unit.config import CampaignConfig
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.plugins.installation import pip_install

pytestmark = [
    pytest.mark.gate,
    pytest.mark.skipif(find_spec("distributed") is None, reason="the extra [dask]"),
]

CONFIG = CampaignConfig(Scenario("turn-right"), seed=5, families=("features",), examples=4, epoch=4)
UNITS = 5

MINE = """
class Mine:
    \"\"\"Stands still.\"\"\"
    def reset(self): return ()
    def act(self, observation, memory):
        from sim import Command
        return Command(), memory
"""


class Dask:
    """A scheduler and its workers, in their own folder without any of the test's files."""

    def __init__(self, folder):
        self.folder, self.file, self.processes = folder, folder / "scheduler.json", []
        self.start("scheduler", "--port", "0", "--no-show", "--no-dashboard")
        wait_for(self.file.is_file)
        self.address = json.loads(self.file.read_text())["address"]

    def start(self, role, *options):
        command = [
            sys.executable,
            "-m",
            "dask",
            role,
            "--host",
            "127.0.0.1",
            "--scheduler-file",
            self.file,
            *options,
        ]
        with (self.folder / f"{role}.log").open("ab") as log:
            process = subprocess.Popen(
                [*map(str, command)], cwd=self.folder, stdout=log, stderr=log
            )
        self.processes.append(process)
        return process

    def worker(self):
        return self.start("worker", "--nthreads", "1", "--no-nanny", "--no-dashboard")

    def end(self):
        for process in self.processes:
            process.kill()
            process.wait()


def wait_for(condition):
    deadline = time.monotonic() + 120
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert condition()


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    running = Dask(tmp_path_factory.mktemp("dask"))
    running.worker()
    yield running
    running.end()


def corpus(campaign, each=lambda event: None):
    for event in campaign.run():
        each(event)
    return {
        kind: found.dumps() for kind, found in campaign.state.best.items()
    }, campaign.state.finds[-1][0].steps


@pytest.mark.nightly
def test_a_cluster_one_of_whose_workers_is_killed_finds_the_same_as_one_process(dask):
    doomed = dask.worker()
    from distributed import (
        Client,
    )  # this takes three seconds in each process that collects these tests

    with Client(dask.address) as client:
        client.wait_for_workers(2)

    def kill_one(event):
        if isinstance(event, UnitDone) and event.unit == 0:
            doomed.kill()

    found = corpus(
        Campaign(CONFIG, units=UNITS, executor=cluster_executor(dask.address, CONFIG)), kill_one
    )
    assert doomed.wait() == -9 and found == corpus(Campaign(CONFIG, units=UNITS))


def test_a_controller_in_a_file_of_ones_own_goes_along_to_the_workers(dask, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(MINE)
    options = (
        "--controller",
        "./mine.py:Mine",
        "--family",
        "corridor",
        "--seed",
        1,
        "--units",
        1,
        "--examples",
        4,
    )
    result = worldgen(
        "fuzz", *options, "--scheduler", dask.address, "--out", tmp_path / "there", "--json"
    )
    assert result.code == 1, result.err
    worldgen("fuzz", *options, "--workers", 1, "--out", tmp_path / "here", "--json")
    there, here = (
        {file.name: file.read_bytes() for file in (tmp_path / way).glob("*.grid")}
        for way in ["there", "here"]
    )
    assert there == here and there


def test_draws_of_dasks_threads_are_not_those_of_a_controller():
    from distributed.protocol import compression
    from tornado import ioloop

    before = random.getstate()
    give_dask_its_own_random()
    give_dask_its_own_random()  # once per job
    assert 0 <= compression.randint(0, 9) <= 9 and 0.0 <= ioloop.random.random() < 1.0
    assert random.getstate() == before


def test_a_worker_whose_code_is_another_refuses_the_work_and_says_what_differs(dask):
    executor = cluster_executor(dask.address, CONFIG)
    job = RemoteJob.of(CONFIG)
    job.fingerprint.code["hypothesis"] = "1.0"
    executor._job = job
    with raises(InvalidParameter, "other-code") as caught:
        corpus(Campaign(CONFIG, units=1, executor=executor))
    (difference,) = caught.value.facts["differences"]
    assert difference.startswith("hypothesis was 1.0 and is ")


def test_work_on_a_worker_hears_no_warning_of_hypothesis_about_dasks_own_threads():
    seeds = itertools.count()

    @settings(database=None, max_examples=2)
    @given(st.integers().map(lambda _: random.seed(next(seeds))))
    def draws_while_dask_draws(_):
        pass

    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        RemoteJob.of(CONFIG).run(draws_while_dask_draws, (), {})
    assert not heard


def test_a_scheduler_that_is_killed_ends_the_campaign_in_one_sentence(tmp_path):
    running = Dask(tmp_path)
    campaign = Campaign(CONFIG, units=UNITS, executor=cluster_executor(running.address, CONFIG))
    running.worker()

    def kill(event):
        running.end()

    with raises(WorkersLost, "scheduler-lost"):
        corpus(campaign, kill)


def test_a_scheduler_that_is_not_there_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr("fuzz.campaign.executors.dask._TO_CONNECT", 0.5)
    options = ("--controller", "turn-right", "--units", 1, "--seed", 1)
    result = worldgen(
        "fuzz", *options, "--scheduler", "tcp://127.0.0.1:1", "--out", tmp_path / "out"
    )
    assert result.code == 2 and result.error_code == "no-scheduler"


@pytest.mark.parametrize(
    "address", ["nonsense", "tcp://host", "http://host:8786/status", "host:port"]
)
def test_what_is_no_address_is_refused_before_anything_is_asked(address):
    with raises(InvalidParameter, "not-an-address", address=address):
        cluster_executor(address, CampaignConfig(Scenario("turn-right")))


def test_without_dask_the_way_to_install_it_is_said(monkeypatch):
    monkeypatch.delitem(sys.modules, "fuzz.campaign.executors.dask", raising=False)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InvalidParameter, match=re.escape(pip_install("dask"))):
        cluster_executor("tcp://127.0.0.1:1", CONFIG)
