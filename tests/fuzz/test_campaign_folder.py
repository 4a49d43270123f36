"""A campaign's folder: whenever and however a campaign is interrupted, it ends with the same
corpus, byte for byte.
"""

import contextlib
import json
import random
import re
import signal
import subprocess
import sys
import time
from collections import deque
from concurrent.futures import Future
from dataclasses import replace
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest

import fuzz.campaign.store.folder
from fuzz.campaign.executors import InlineExecutor, WorkersLost
from fuzz.campaign.run import Campaign
from fuzz.campaign.store import (
    Budget,
    FolderStore,
    Status,
    begin,
    fingerprint_of,
    read_error,
    resume,
    stored_seed,
)
from fuzz.campaign.summary import describe_units, summary_of
from fuzz.campaign.unit import run_unit
from fuzz.commands._session import CampaignSession
from fuzz.search.native import Pace
from fuzz.shrink.queue import Shrinking
from fuzz.unit.config import CampaignConfig
from fuzz.unit.deadline import Deadline
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from tests.helpers.tiers import some
from worldgen.errors import FormatError, OutputError

CONFIG = CampaignConfig(Scenario("turn-right"), seed=5, families=("features",), examples=4, epoch=1)
UNITS = 3
FUZZ = (
    "fuzz", "--controller", "turn-right", "--family", "features", "--seed", 5, "--examples", 4, "--epoch", 1,
    "--workers", 1,
)  # fmt: skip


class Killed(BaseException):
    """Ends a campaign between two files, as kill -9 would."""


def run(campaign_run):
    return CampaignSession(campaign_run, InlineExecutor(), quiet=True).run()


def left_in(out):
    """Everything that a campaign wrote, except times."""
    text = (out / ".campaign" / "summary.json").read_text()
    summary = re.sub(r'"seconds": [0-9.]+|"times": {[^}]*}', "", text)
    return {file.name: file.read_bytes() for file in out.glob("*.grid")}, summary


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("whole") / "failures"
    assert run(begin(CONFIG, out, Budget(units=UNITS))) == 1
    return out


@pytest.fixture
def copied(whole, tmp_path):
    """A folder with the finished campaign."""
    for file in whole.rglob("*"):
        if file.is_file():
            target = tmp_path / "copy" / file.relative_to(whole)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(file.read_bytes())
    return tmp_path / "copy"


@pytest.mark.gate
@pytest.mark.parametrize("seed", some(range(4)))
def test_a_campaign_killed_between_any_two_files_goes_on_to_the_same_corpus(
    seed, whole, tmp_path, monkeypatch
):
    chance, write = random.Random(seed), fuzz.campaign.store.folder.write_bytes
    left, killed, done = 0, 0, False

    def write_or_die(path, data, *, force):
        nonlocal left
        left -= 1
        if left < 0:
            raise Killed
        write(path, data, force=force)

    monkeypatch.setattr(fuzz.campaign.store.folder, "write_bytes", write_or_die)
    while not done:
        left = chance.randrange(1, 14)
        try:
            done = run(begin(CONFIG, tmp_path / "out", Budget(units=UNITS))) == 1
        except Killed:
            killed += 1
    assert killed and left_in(tmp_path / "out") == left_in(whole)


@pytest.mark.gate
@pytest.mark.parametrize("workers", [pytest.param(1, marks=pytest.mark.nightly), 2])
def test_a_campaign_killed_with_signal_9_goes_on_to_the_same_corpus(workers, whole, tmp_path):
    out = tmp_path / "out"
    process = start(*FUZZ[:-1], workers, "--units", UNITS, "--out", out)
    units = out / ".campaign" / "units"
    wait_for(lambda: units.is_dir() and any(units.iterdir()))
    process.kill()
    process.communicate()
    assert run(resume(out)) == 1
    assert left_in(out) == left_in(whole)


def start(*args):
    command = [sys.executable, "-c", "from worldgen.cli.main import main; main()", *map(str, args)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(condition):
    deadline = time.monotonic() + 120
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert condition()


@pytest.mark.gate
def test_ctrl_c_leaves_a_campaign_that_goes_on_to_the_same_corpus(whole, tmp_path):
    out = tmp_path / "out"
    process = start(*FUZZ, "--units", UNITS, "--out", out)
    wait_for(lambda: any(out.glob("*.grid")))
    process.send_signal(signal.SIGINT)
    err = process.communicate(timeout=180)[1]
    assert process.returncode == 130 and f"worldgen fuzz --resume {out} continues" in err
    assert worldgen("fuzz", "--resume", out, "--workers", 1, "--json").code == 1
    assert left_in(out) == left_in(whole)


@pytest.mark.gate
def test_a_finished_campaign_goes_on_to_more_units_as_if_it_had_never_stopped(copied, tmp_path):
    run(begin(CONFIG, tmp_path / "all", Budget(units=UNITS + 1)))
    result = worldgen("fuzz", "--resume", copied, "--units", UNITS + 1, "--workers", 1, "--json")
    assert result.code == 1 and json.loads(result.out)["units"] == UNITS + 1
    assert left_in(copied) == left_in(tmp_path / "all")


@pytest.mark.gate
def test_the_whole_plan_goes_on_from_its_memory_as_if_it_had_never_stopped(tmp_path):
    config = replace(CONFIG, families=(), examples=10, epoch=2, shrink=False)

    def search(name, units):
        campaign_run = begin(config, tmp_path / name, Budget(units=units))
        campaign = Campaign(config, units=units, store=campaign_run.store)
        with contextlib.closing(campaign_run.store):
            deque(campaign.run(), maxlen=0)
        return campaign.state

    whole = search("whole", 10)
    parts = [search("parts", units) for units in (3, 7, 10)][-1]
    assert {"native", "archive"} <= whole.memory.strategies.keys() and whole.memory.elites
    assert list(parts.memory.elites.items()) == list(whole.memory.elites.items())
    assert (parts.memory.strategies, list(parts.best), parts.met) == (
        whole.memory.strategies,
        list(whole.best),
        whole.met,
    )


def test_the_same_command_again_does_nothing_again_and_says_the_same(copied):
    before = {file: file.stat().st_mtime_ns for file in copied.glob("*.grid")}
    result = worldgen(*FUZZ, "--units", UNITS, "--out", copied, "--json")
    assert (
        result.code == 1
        and f"continues the campaign in {copied}: seed 5, 3 units done" in result.err
    )
    assert {file: file.stat().st_mtime_ns for file in copied.glob("*.grid")} == before


def test_a_campaign_whose_seed_was_drawn_is_found_again_by_the_same_command(copied):
    without_seed = [word for word in FUZZ if word not in ("--seed", 5)]
    assert worldgen(*without_seed, "--units", UNITS, "--out", copied, "--json").code == 1


def ticking(patch, start=0):
    """A clock that advances by a second whenever it is read."""
    clock = count(start).__next__
    patch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=clock))
    patch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=clock))


def test_a_time_counts_anew(copied, monkeypatch, capsys):
    ticking(monkeypatch, start=10_000)
    run(resume(copied, Budget(seconds=100.0)))
    said = json.loads(capsys.readouterr().out)
    assert said["units"] + said["units_cut"] > UNITS


def test_what_is_not_shrunk_when_the_time_is_over_is_kept_as_found_and_shrunk_later(
    whole, tmp_path, monkeypatch, capsys
):
    at = SimpleNamespace(now=0.0)

    def unit_of_15_s(*given):
        result = run_unit(*given)
        at.now += 15.0
        return result

    def endless_shrinking(failure, *_, **__):
        at.now = 1_000.0
        return Shrinking(failure, complete=False)

    with monkeypatch.context() as patch:
        patch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
        patch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=lambda: at.now))
        patch.setattr("fuzz.campaign.run.run_unit", unit_of_15_s)
        patch.setattr("fuzz.campaign.run.shrunk_or_same", endless_shrinking)
        run(begin(CONFIG, tmp_path / "out", Budget(seconds=40.0)))
    assert at.now == 1_000.0
    said = capsys.readouterr()
    failures = json.loads(said.out)["failures"]
    assert failures and {one["shrinking"] for one in failures} <= {"none", "cut short"}
    assert "not fully shrunk, because time ran out" in said.err and re.search(
        "--units [1-3] finishes it", said.err
    )
    run(resume(tmp_path / "out", Budget(units=UNITS)))
    assert left_in(tmp_path / "out") == left_in(whole)


@pytest.mark.gate
def test_a_unit_that_the_time_cuts_short_keeps_what_it_met_and_is_done_whole_later(
    whole, tmp_path, monkeypatch, capsys
):
    out = tmp_path / "out"
    entries = tmp_path / "out" / ".campaign" / "units"
    at = SimpleNamespace(now=0.0)

    def cut_where_it_failed(config, unit, known, _):
        result = run_unit(config, unit, known)
        if result.failures:
            at.now = 1_000.0
        return replace(result, cut=bool(result.failures))

    with monkeypatch.context() as at_once:
        at_once.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
        at_once.setattr("fuzz.campaign.run.run_unit", cut_where_it_failed)
        assert run(begin(CONFIG, out, Budget(seconds=60.0))) == 1
    said = json.loads(capsys.readouterr().out)
    assert said["units_cut"] == 1 and said["failures"] and list(out.glob("*.grid"))
    assert [file.name for file in entries.glob("*.cut.json")] == [f"{said['units']:06}.cut.json"]
    run(resume(out, Budget(units=UNITS)))
    assert left_in(out) == left_in(whole) and not list(entries.glob("*.cut.json"))


@pytest.mark.gate
def test_whole_units_after_a_cut_one_are_those_of_a_campaign_that_nobody_stopped(
    tmp_path, monkeypatch
):
    config = replace(CONFIG, families=("archive",), examples=4, shrink=False)
    for strategy in ("archive", "native"):
        monkeypatch.setattr(
            f"fuzz.search.{strategy}.pace_of", lambda _: Pace(generation=50, proved=6)
        )

    def left(name):
        campaign_run = begin(config, tmp_path / name, Budget(units=4))
        campaign = Campaign(config, units=4, store=campaign_run.store)
        with contextlib.closing(campaign_run.store):
            deque(campaign.run(), maxlen=0)
        entries = sorted((tmp_path / name / ".campaign" / "units").iterdir())
        return campaign.state, {file.name: without_seconds(file.read_text()) for file in entries}

    def cut_in_the_second(config, unit, known, deadline):
        return run_unit(config, unit, known, Deadline(begin=1.0) if unit == 1 else deadline)

    with monkeypatch.context() as once:
        once.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=count().__next__))
        once.setattr("fuzz.campaign.run.run_unit", cut_in_the_second)
        cut, entries = left("stopped")
    # Unit 3 knows what unit 1 found.
    whole, again = ["000000.json", "000002.json"], [f"00000{unit}.cut.json" for unit in (1, 3)]
    assert sorted(entries) == sorted(whole + again) and (cut.units, cut.cut, cut.too_early) == (
        2,
        2,
        1,
    )
    assert describe_units(summary_of(config, cut, Status.STOPPED)) == (
        "2 whole units and 1 cut short and 1 that learned too little from them"
    )
    (stopped, _) = left("stopped")
    (state, _) = left("never")
    assert (stopped.worlds, stopped.met, stopped.cut) == (state.worlds, state.met, 0)
    assert stopped.memory.elites == state.memory.elites and dumped(stopped.best) == dumped(
        state.best
    )


def dumped(worlds):
    return {kind: found.dumps() for kind, found in worlds.items()}


class StuckInTheFirst(InlineExecutor):
    """Two workers, one of which never returns from its first unit until the time is up."""

    room = 2

    def __init__(self, at):
        super().__init__()
        self.at = at

    def submit(self, work, /, *args, **kwargs):
        return (
            Future() if work is run_unit and args[1] == 0 else super().submit(work, *args, **kwargs)
        )

    def listen(self):
        self.at.now = 1_000.0


@pytest.fixture
def stuck(monkeypatch):
    at = SimpleNamespace(now=0.0)
    monkeypatch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
    monkeypatch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=lambda: at.now))
    monkeypatch.setattr("fuzz.campaign.scheduler.LISTEN", 0.0)
    return StuckInTheFirst(at)


@pytest.mark.gate
def test_units_that_are_done_behind_one_that_is_stuck_are_kept(stuck, whole, tmp_path):
    out = tmp_path / "out"
    CampaignSession(begin(CONFIG, out, Budget(seconds=60.0)), stuck, quiet=True).run()
    assert [file.name for file in (out / ".campaign" / "units").iterdir()] == ["000001.json"]
    run(resume(out, Budget(units=UNITS)))
    assert left_in(out) == left_in(whole)


def test_a_worker_beside_one_that_is_stuck_goes_on(stuck):
    campaign = Campaign(
        replace(CONFIG, examples=1, epoch=5, shrink=False), seconds=60.0, executor=stuck
    )
    deque(campaign.run(), maxlen=0)
    assert (
        campaign.state.units == 9
    )  # all units of two epochs except the first; more would depend on what that one found


@pytest.mark.gate
def test_what_a_cut_unit_met_beyond_the_units_that_are_wanted_later_goes_but_no_file_of_somebody_else(
    whole, tmp_path, monkeypatch
):
    out = tmp_path / "out"
    run(begin(CONFIG, out, Budget(units=UNITS)))
    known = next(iter(sorted(out.glob("*.grid"))))
    with contextlib.closing(FolderStore(out)) as folder:
        folder.write_failure("beyond.grid", known.read_bytes())
        folder.write_failure("changed.grid", known.read_bytes())
    (out / "changed.grid").write_bytes(b"mine")
    (out / "mine.grid").write_bytes(known.read_bytes())
    run(resume(out))
    assert {file.name for file in out.glob("*.grid")} == {
        *left_in(whole)[0],
        "changed.grid",
        "mine.grid",
    }


@pytest.mark.gate
def test_the_seconds_of_all_runs_are_added_up(copied):
    file = copied / ".campaign" / "summary.json"
    before = json.loads(file.read_text())["seconds"]
    run(resume(copied, Budget(units=UNITS + 1)))
    assert json.loads(file.read_text())["seconds"] > before


def spoil_text(file):
    file.write_text(file.read_text()[: file.stat().st_size // 2])


def spoil_number(file):
    file.write_text(file.read_text().replace('"worlds": ', '"worlds": 1'))


def spoil_type(file):
    file.write_text("[" * 100_000)


def spoil_path(file):
    file.write_text(
        json.dumps({**json.loads(file.read_text()), "failures": {"loop": "../../../etc/passwd"}})
    )


@pytest.mark.parametrize("spoil", [Path.unlink, spoil_text, spoil_number, spoil_type, spoil_path])
def test_a_unit_whose_entry_is_not_whole_is_done_again(spoil, copied, whole):
    entry = copied / ".campaign" / "units" / "000001.json"
    before = entry.read_text()
    spoil(entry)
    assert run(resume(copied)) == 1 and left_in(copied) == left_in(whole)
    assert without_seconds(entry.read_text()) == without_seconds(before)


def without_seconds(text):
    entry = json.loads(text)
    entry["first_met"] = [(worlds, steps) for worlds, steps, _ in entry["first_met"]]
    return {name: entry[name] for name in entry if name not in ("seconds", "digest")}


@pytest.mark.gate
@pytest.mark.parametrize("part", ["failures", "shrunk"])
@pytest.mark.parametrize("spoil", [Path.unlink, spoil_text])
def test_a_failure_that_is_not_whole_is_found_and_shrunk_again(part, spoil, copied, whole):
    for file in (copied / ".campaign" / part).iterdir():
        spoil(file)
    assert run(resume(copied)) == 1 and left_in(copied) == left_in(whole)


@pytest.mark.parametrize(
    ("change", "differences"),
    [
        ({"seed": 6}, ["seed is 5, not 6"]),
        (
            {"scenario": Scenario("turn-left")},
            ["scenario controller is 'turn-right', not 'turn-left'"],
        ),
        ({"scenario": Scenario.parse("turn-right+beams=36")}, ["scenario beams is None, not 36"]),
        ({"examples": 13, "epoch": 2}, ["epoch is 1, not 2", "examples is 4, not 13"]),
    ],
)
def test_another_campaign_is_refused_with_what_differs(change, differences, copied):
    with raises(OutputError, "another-campaign", out=str(copied)) as caught:
        begin(replace(CONFIG, **change), copied, Budget(units=UNITS))
    found = caught.value.facts["differences"]
    assert len(found) == len(differences) and all(map(re.fullmatch, differences, found))


def test_a_controller_that_was_changed_is_noticed(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("class Sits:\n def reset(self): return ()\n def act(self, o, m): return None\n")
    config = replace(CONFIG, scenario=Scenario(f"{file}:Sits"), examples=2)
    run(begin(config, tmp_path / "out", Budget(units=1)))
    file.write_text(file.read_text() + "# changed\n")
    with raises(OutputError, "another-campaign") as caught:
        resume(tmp_path / "out")
    (difference,) = caught.value.facts["differences"]
    assert re.fullmatch(
        r"controller .*mine.py:Sits was [0-9a-f]{16} and is now [0-9a-f]{16}", difference
    )


def test_a_campaign_that_did_nothing_makes_room_for_another(tmp_path):
    begin(CONFIG, tmp_path, Budget(units=UNITS)).store.close()
    other = replace(CONFIG, seed=6)
    begin(other, tmp_path, Budget(units=UNITS)).store.close()
    stored = FolderStore.stored_in(tmp_path)
    assert stored is not None and stored[0] == fingerprint_of(other)


def test_force_begins_anew(copied, tmp_path):
    run(begin(replace(CONFIG, seed=6), copied, Budget(units=1), force=True))
    run(begin(replace(CONFIG, seed=6), tmp_path / "fresh", Budget(units=1)))
    assert left_in(copied)[1] == left_in(tmp_path / "fresh")[1]


def test_fewer_units_than_are_done_are_refused(copied):
    result = worldgen("fuzz", "--resume", copied, "--units", 2)
    assert result.code == 2 and result.error_code == "campaign-is-further"


def test_a_folder_without_a_campaign_is_not_resumed(tmp_path):
    result = worldgen("fuzz", "--resume", tmp_path)
    assert result.code == 2 and result.error_code == "no-campaign" and not list(tmp_path.iterdir())


def test_what_a_campaign_is_cannot_be_changed_when_it_is_resumed(copied):
    result = worldgen("fuzz", "--resume", copied, "--seed", 7)
    assert result.code == 2 and "--seed cannot change in a resumed campaign" in result.err


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"version": 3}', '{"version": 2, "configuration": 5}', "[" * 100_000]
)
def test_a_configuration_that_cannot_be_read_is_refused_in_one_sentence(text, copied):
    (copied / ".campaign" / "campaign.json").write_text(text)
    with raises(FormatError, "invalid-campaign"):
        resume(copied)


@pytest.mark.parametrize(
    ("here", "strange", "said"),
    [
        ('"examples": 4', '"examples": "many"', "examples is 'many'"),
        ('"seed": ', '"seed": 1e999, "was": ', "Number out of range"),
    ],
)
def test_a_configuration_with_a_strange_value_is_refused_in_one_sentence(
    here, strange, said, copied
):
    file = copied / ".campaign" / "campaign.json"
    file.write_text(file.read_text().replace(here, strange))
    with raises(FormatError, "invalid-campaign") as caught:
        resume(copied)
    assert said in caught.value.facts["reason"]
    stored_seed(copied)  # without an error


def test_a_second_writer_is_refused(copied):
    folder = FolderStore(copied)
    result = worldgen("fuzz", "--resume", copied)
    folder.close()
    assert result.code == 2 and result.error_code == "campaign-is-running"


@pytest.mark.gate
def test_a_folder_is_free_again_when_its_writer_is_killed(copied):
    script = (
        "import time; from pathlib import Path; from fuzz.campaign.store import FolderStore\n"
        f"held = FolderStore(Path({str(copied)!r}))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", f"{script}; print(flush=True); time.sleep(600)"], stdout=-1
    )
    process.stdout.readline()
    with raises(OutputError, "campaign-is-running", out=str(copied)):
        FolderStore(copied)
    process.kill()
    process.communicate()
    FolderStore(copied).close()


class Lost(InlineExecutor):
    """Workers that die at their first request."""

    def submit(self, work, /, *args, **kwargs):
        raise WorkersLost("worker-died", "a worker process died")


def test_a_campaign_says_in_its_folder_whether_it_was_done_or_failed(copied):
    def status():
        return json.loads((copied / ".campaign/summary.json").read_text())["status"]

    CampaignSession(begin(CONFIG, copied, Budget(units=UNITS)), InlineExecutor(), quiet=True).run()
    assert status() == "done"
    with raises(OutputError, "broken-off"):
        CampaignSession(resume(copied, Budget(units=UNITS + 1)), Lost(), quiet=True).run()
    assert status() == "failed"


@pytest.mark.gate
def test_a_full_disk_stops_a_campaign_in_one_sentence_and_with_room_it_goes_on(
    whole, tmp_path, monkeypatch
):
    write, left = fuzz.campaign.store.folder.write_bytes, 9

    def full(path, data, *, force):
        nonlocal left
        left -= 1
        if left < 0:
            raise OutputError(
                "unwritable", "{path}: cannot be written: No space left on device", path=path
            )
        write(path, data, force=force)

    monkeypatch.setattr(fuzz.campaign.store.folder, "write_bytes", full)
    result = worldgen(*FUZZ, "--units", UNITS, "--out", tmp_path)
    assert result.code == 2 and result.error_code == "broken-off"
    assert read_error(tmp_path).code == "broken-off"
    monkeypatch.undo()
    assert worldgen("fuzz", "--resume", tmp_path, "--workers", 1, "--json").code == 1
    assert left_in(tmp_path) == left_in(whole)
