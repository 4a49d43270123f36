"""A campaign's folder: what continues it, what it keeps, and what it refuses.

That interruptions do not change its corpus is tested in ``test_campaign_interrupted.py``.
"""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections import deque
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import pytest

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
from fuzz.campaign.store.journal import Journal, ShownRecord, ShrunkRecord, append_line
from fuzz.campaign.summary import describe_units, summary_of
from fuzz.campaign.unit import run_unit
from fuzz.commands._session import CampaignSession
from fuzz.layouts.layout_bytes import SCENE_BYTES
from fuzz.shrink.queue import Shrinking
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import UnitResult
from sim.scenario import Scenario
from tests.fuzz.test_campaign_interrupted import StuckInTheFirst, left_in, stopped_clock, writes_end
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import FormatError, OutputError

CONFIG = CampaignConfig(Scenario("turn-right"), seed=5, families=("features",), examples=4, epoch=1)
UNITS = 3
FUZZ = (
    "fuzz", "--controller", "turn-right", "--family", "features", "--seed", 5, "--examples", 4, "--epoch", 1,
    "--workers", 1,
)  # fmt: skip


def run(campaign_run):
    return CampaignSession(campaign_run, InlineExecutor(), quiet=True).run()


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
def test_two_processes_killed_with_signal_9_go_on_to_the_corpus_of_one(whole, tmp_path):
    out = tmp_path / "out"
    process = start(*FUZZ[:-1], 2, "--units", UNITS, "--out", out)
    wait_for((out / ".campaign" / "journal.txt").is_file)
    process.kill()
    process.communicate()
    assert worldgen("fuzz", "--resume", out, "--workers", 2, "--json").code == 1
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


def test_a_campaign_whose_seed_was_drawn_is_found_again_by_the_same_command(copied):
    without_seed = [word for word in FUZZ if word not in ("--seed", 5)]
    result = worldgen(*without_seed, "--units", UNITS, "--out", copied, "--json")
    assert result.code == 1
    assert f"continues the campaign in {copied}: seed 5, 3 units done" in result.err


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


def test_what_is_not_shrunk_when_the_time_is_over_is_kept_as_found(tmp_path, monkeypatch, capsys):
    at = SimpleNamespace(now=0.0)

    def unit_of_15_s(*given):
        result = run_unit(*given)
        at.now += 15.0
        return result

    def endless_shrinking(failure, *_, **__):
        at.now = 1_000.0
        return Shrinking(failure, complete=False)

    monkeypatch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
    monkeypatch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=lambda: at.now))
    monkeypatch.setattr("fuzz.campaign.run.run_unit", unit_of_15_s)
    monkeypatch.setattr("fuzz.campaign.run.shrunk_or_same", endless_shrinking)
    run(begin(CONFIG, tmp_path / "out", Budget(seconds=40.0)))
    assert at.now == 1_000.0
    said = capsys.readouterr()
    failures = json.loads(said.out)["failures"]
    assert failures and {one["shrinking"] for one in failures} <= {"none", "cut short"}
    assert "not fully shrunk, because time ran out" in said.err and re.search(
        "--units [1-3] finishes it", said.err
    )


@pytest.mark.gate
def test_a_unit_that_the_time_cuts_short_keeps_what_it_met(tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    at = SimpleNamespace(now=0.0)

    def cut_where_it_failed(config, unit, known, *_):
        result = run_unit(config, unit, known)
        if result.failures:
            at.now = 1_000.0
        return replace(result, cut=bool(result.failures))

    monkeypatch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
    monkeypatch.setattr("fuzz.campaign.run.run_unit", cut_where_it_failed)
    assert run(begin(CONFIG, out, Budget(seconds=60.0))) == 1
    said = json.loads(capsys.readouterr().out)
    assert said["units_cut"] == 1 and said["failures"] and list(out.glob("*.grid"))
    with contextlib.closing(resume(out).store) as store:
        assert store.units_cut() == [said["units"]]


def test_units_that_lack_the_findings_of_a_cut_one_are_counted_apart(monkeypatch):
    def cut_the_second(config, unit, known, *_):
        return replace(run_unit(config, unit, known), cut=unit == 1)

    monkeypatch.setattr("fuzz.campaign.run.run_unit", cut_the_second)
    campaign = Campaign(replace(CONFIG, examples=1, shrink=False), units=4)
    deque(campaign.run(), maxlen=0)
    # Unit 3 knows what unit 1 found.
    state = campaign.state
    assert (state.units, state.cut, state.too_early) == (2, 2, 1)
    assert describe_units(summary_of(campaign.config, state, Status.STOPPED)) == (
        "2 whole units, 1 cut short and 1 to do again after it"
    )


def test_a_worker_beside_one_that_is_stuck_goes_on(monkeypatch):
    monkeypatch.setattr("fuzz.campaign.scheduler.LISTEN", 0.0)
    campaign = Campaign(
        replace(CONFIG, examples=1, epoch=5, shrink=False),
        seconds=60.0,
        executor=StuckInTheFirst(stopped_clock(monkeypatch)),
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
    with contextlib.closing(resume(out).store) as folder:
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


SHRUNK = ShrunkRecord("0" * 16, "1" * 16)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda line: line[: len(line) // 2],
        lambda line: line.replace(b"1111", b"1112"),
        lambda line: b"",
        lambda line: b"\0" * len(line),
        lambda line: line + line,
    ],
)
def test_a_record_that_is_torn_or_changed_is_as_if_it_were_not_there(spoil, tmp_path):
    journal = Journal(tmp_path / "journal.txt", "fingerprint")
    other = ShownRecord("loop.grid", "2" * 16)
    journal.append(other)
    end = (tmp_path / "journal.txt").stat().st_size
    journal.append(SHRUNK)
    data = (tmp_path / "journal.txt").read_bytes()
    (tmp_path / "journal.txt").write_bytes(data[:end] + spoil(data[end:].rstrip()))
    offset = journal.append(other)
    assert [record for _, record in journal] == [other, other]
    assert journal.at(offset) == other


@pytest.mark.parametrize(
    "text",
    [
        b"[" * 100_000,
        b'{"type":"shrunk","found":"../../../etc/passwd","shrunk":"0000000000000000"}',
        b'{"type":"unit"}',
    ],
)
def test_a_sealed_record_that_is_none_is_passed_over(text, tmp_path):
    journal = Journal(tmp_path / "journal.txt", "fingerprint")
    append_line(tmp_path / "journal.txt", journal._seal(text) + b" " + text)
    journal.append(SHRUNK)
    assert [record for _, record in journal] == [SHRUNK]


UNIT = {
    "type": "unit", "unit": 0, "cut": False, "seconds": 1.0, "strategy": "archive", "worlds": 1, "steps": 1,
    "verdicts": {"loop": 1}, "judged": 1, "met": [["loop", "loop", 1]], "failures": ["0" * 16],
    "first_met": [[1, 1, 0.5]], "elites": [[[1, 2], "00" * SCENE_BYTES, -3.0, "loop"]],
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("unit", -1),
        ("unit", 1 << 63),
        ("seconds", 1e300),
        ("strategy", ""),
        ("strategy", "a" * 20_000),
        ("worlds", 1 << 64),
        ("steps", -1),
        ("verdicts", {"loop": -1}),
        ("verdicts", {"": 1}),
        ("judged", 10**30),
        ("met", [["loop", "loop", 1 << 62]]),
        ("first_met", [[-1, 1, 0.5]]),
        ("elites", [[[1], "00" * SCENE_BYTES, -3.0, "loop"]]),
        ("elites", [[[-1, 2], "00" * SCENE_BYTES, -3.0, "loop"]]),
        ("elites", [[[1, 2], "00", -3.0, "loop"]]),
    ],
)
def test_a_sealed_unit_with_numbers_that_no_unit_has_is_passed_over(name, value, tmp_path):
    journal = Journal(tmp_path / "journal.txt", "fingerprint")
    for unit in (UNIT, {**UNIT, name: value}):
        text = json.dumps(unit).encode()
        append_line(tmp_path / "journal.txt", journal._seal(text) + b" " + text)
    ((_, record),) = journal
    assert record.unit == 0 and record.strategy == "archive"


def test_a_journal_that_cannot_be_read_is_said_in_one_sentence(tmp_path, monkeypatch):
    journal = Journal(tmp_path / "journal.txt", "fingerprint")
    offset = journal.append(SHRUNK)

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.open", refuse)
    for read in (lambda: [*journal], lambda: journal.at(offset)):
        with raises(FormatError, "unreadable", reason="Permission denied"):
            read()


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="this system follows links")
@pytest.mark.parametrize("name", ["journal.txt", "lock"])
def test_a_link_in_the_store_is_not_written(name, tmp_path):
    memory = tmp_path / "out" / ".campaign"
    memory.mkdir(parents=True)
    target = tmp_path / "target"
    target.write_text("mine")
    (memory / name).symlink_to(target)
    with (
        raises(OutputError, "is-a-link") as caught,
        contextlib.closing(FolderStore(tmp_path / "out")) as store,
    ):
        store.begin(fingerprint_of(CONFIG), Budget(units=1))
        store.save_unit(0, UnitResult(strategy="features"), 1.0)
    assert "remove it" in str(caught.value) and target.read_text() == "mine"


def test_records_of_another_campaign_do_not_count(tmp_path):
    Journal(tmp_path / "journal.txt", "fingerprint").append(SHRUNK)
    assert not [*Journal(tmp_path / "journal.txt", "other")]


def test_each_failure_is_stored_once_and_the_folder_shows_some_of_them(whole):
    stored = {file.read_bytes() for file in (whole / ".campaign/failures").iterdir()}
    assert len(stored) == len([*(whole / ".campaign/failures").iterdir()])
    assert {file.read_bytes() for file in whole.glob("*.grid")} <= stored


def of_an_earlier_version(out):
    """Make a campaign's store one of another version."""
    memory = out / ".campaign"
    said = json.loads((memory / "campaign.json").read_text())
    said["code"]["worldgen"] = "earlier"
    (memory / "campaign.json").write_text(json.dumps(said))


def test_a_campaign_of_an_earlier_version_is_refused_and_kept(copied):
    of_an_earlier_version(copied)
    before = {file: file.read_bytes() for file in copied.rglob("*") if file.is_file()}
    for again in (("--resume", copied), (*FUZZ[1:], "--out", copied)):
        result = worldgen("fuzz", *again, "--units", UNITS)
        assert result.code == 2 and result.error_code == "another-campaign"
        assert "worldgen was earlier and is now" in result.err and "--force" in result.err
    after = {file: file.read_bytes() for file in copied.rglob("*") if file.is_file()}
    names = ("lock", "error.json")
    assert before == {file: data for file, data in after.items() if file.name not in names} | {
        file: before[file] for file in before if file.name in names
    }


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


def with_windows_lines(copied):
    file = copied / ".campaign" / "journal.txt"
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))


def with_another_digest(copied):
    file = copied / ".campaign" / "campaign.json"
    text = file.read_text()
    file.write_text(text.replace('"worldgen": "', '"worldgen": "edited '))
    assert file.read_text() != text


def without_journal(copied):
    (copied / ".campaign" / "journal.txt").unlink()


@pytest.mark.parametrize("spoil", [with_windows_lines, with_another_digest, without_journal])
def test_findings_whose_records_do_not_count_are_kept(spoil, copied):
    spoil(copied)
    before = {file: file.read_bytes() for file in (copied / ".campaign/failures").iterdir()}
    assert before
    with raises(OutputError, "another-campaign"):
        begin(replace(CONFIG, seed=6), copied, Budget(units=UNITS))
    with contextlib.suppress(OutputError):
        begin(CONFIG, copied, Budget(units=UNITS)).store.close()
    assert {file: file.read_bytes() for file in before} == before


def test_a_campaign_that_only_cut_units_goes_on_and_refuses_another(tmp_path):
    begun = begin(CONFIG, tmp_path, Budget(units=UNITS))
    begun.store.save_unit(0, UnitResult(strategy="features", worlds=3, cut=True), 1.0)
    begun.store.close()
    with raises(OutputError, "another-campaign"):
        begin(replace(CONFIG, seed=6), tmp_path, Budget(units=UNITS))
    again = begin(CONFIG, tmp_path, Budget(units=UNITS))
    again.store.close()
    assert again.done == 0 and again.store.units_cut() == [0]
    assert again.store.cut_unit(0).worlds == 3


def stored_after(spoil, out):
    begun = begin(CONFIG, out, Budget(units=UNITS))
    begun.store.save_unit(0, UnitResult(strategy="features"), 1.0)
    begun.store.close()
    spoil(out)


@pytest.mark.parametrize(
    ("spoil", "change", "is_offered"),
    [
        (lambda _: None, {"seed": 6}, True),
        (with_another_digest, {"seed": 6}, False),
        (with_another_digest, {}, False),
    ],
)
def test_resuming_is_offered_only_where_it_would_be_accepted(spoil, change, is_offered, tmp_path):
    stored_after(spoil, tmp_path)
    with raises(OutputError, "another-campaign") as caught:
        begin(replace(CONFIG, **change), tmp_path, Budget(units=UNITS))
    assert ("--resume" in str(caught.value)) == is_offered
    with contextlib.nullcontext() if is_offered else raises(OutputError, "another-campaign"):
        resume(tmp_path).store.close()


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


def test_a_full_disk_stops_a_campaign_in_one_sentence(tmp_path, monkeypatch):
    full = OutputError(
        "unwritable", "{path}: No space left on device", "choose another place", path=tmp_path
    )
    writes_end(monkeypatch, 4, full)
    result = worldgen(*FUZZ, "--units", UNITS, "--out", tmp_path)
    assert result.code == 2 and result.error_code == "broken-off"
    assert "free some space" in result.err and "choose another place" not in result.err
    assert read_error(tmp_path).code == "broken-off"
