"""However a campaign is interrupted, it ends with the corpus of one that was not, byte for byte.

Each test does a few random steps with one campaign: it runs part of it with one worker or several,
kills it, lets its time or its disk run out, and damages its store. Then it completes the campaign.

Hypothesis's state machines cannot do this, because the campaigns draw with Hypothesis themselves.
"""

import contextlib
import functools
import json
import random
import re
from concurrent.futures import Future
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import pytest

import fuzz.campaign.store.folder
import fuzz.campaign.store.journal
from fuzz.campaign.executors import InlineExecutor
from fuzz.campaign.store import Budget, FolderStore, begin
from fuzz.campaign.unit import run_unit
from fuzz.commands._session import CampaignSession
from fuzz.search.native import UnitSize
from fuzz.shrink.queue import Shrinking
from fuzz.unit.config import CampaignConfig
from fuzz.unit.deadline import Deadline
from sim.scenario import Scenario
from tests.helpers.tiers import some
from worldgen.errors import OutputError

# Two strategies, one of which learns from the archive of earlier units.
CONFIG = CampaignConfig(
    Scenario("turn-right"), seed=5, families=("features", "archive"), examples=4, epoch=1
)
UNITS = 3


class Killed(BaseException):
    """Ends a campaign at a write, as kill -9 would."""


class Several(InlineExecutor):
    """Several workers that finish their work in any order, in one process."""

    room = 3

    def __init__(self, seed):
        super().__init__()
        self.chance, self.waiting = random.Random(seed), []

    def submit(self, work, /, *args, **kwargs):
        future = Future()
        self.waiting.append((future, functools.partial(work, *args, **kwargs)))
        return future

    def listen(self):
        if self.waiting:
            future, work = self.waiting.pop(self.chance.randrange(len(self.waiting)))
            future.set_result(super().submit(work).result())
        super().listen()


class StuckInTheFirst(InlineExecutor):
    """Two workers, one of which never returns from its first unit until the time is up."""

    room = 2

    def __init__(self, at):
        super().__init__()
        self.at, self.is_stuck = at, False

    def submit(self, work, /, *args, **kwargs):
        if work is run_unit and not self.is_stuck:
            self.is_stuck = True
            return Future()
        return super().submit(work, *args, **kwargs)

    def listen(self):
        if self.is_stuck:
            self.at.now = 1_000.0


def run(out, *, executor=None, **budget):
    """Run a campaign, or continue it; return its exit code."""
    campaign_run = begin(CONFIG, out, Budget(**budget))
    return CampaignSession(campaign_run, executor or InlineExecutor(), quiet=True).run()


def left_in(out):
    """Everything that a campaign shows, except times."""
    text = (out / ".campaign" / "summary.json").read_text()
    summary = re.sub(r'"seconds": [0-9.]+|"times": {[^}]*}', "", text)
    return {file.name: file.read_bytes() for file in out.glob("*.grid")}, summary


@pytest.fixture(scope="module")
def small():
    """Units of the archive strategy that take a tenth of a second, and no waiting."""
    with pytest.MonkeyPatch.context() as patch:
        for strategy in ("archive", "native"):
            patch.setattr(
                f"fuzz.search.{strategy}.unit_size_of", lambda _: UnitSize(generation=50, proved=4)
            )
        patch.setattr("fuzz.campaign.scheduler.LISTEN", 0.0)
        yield


@pytest.fixture(scope="module")
def whole(small, tmp_path_factory):
    out = tmp_path_factory.mktemp("whole") / "out"
    assert run(out, units=UNITS) == 1
    files, summary = left_in(out)
    said = json.loads((out / ".campaign/summary.json").read_text())
    assert files and {one["strategy"] for one in said["strategies"]} == {"features", "archive"}
    assert said["archive"]["cells"]
    return files, summary


def writes_end(patch, left, ending):
    """Let ``left`` more writes succeed; the next is torn, if it is to the journal, and ends it."""
    folder, journal = fuzz.campaign.store.folder, fuzz.campaign.store.journal
    write, append = folder.write_bytes, journal.append_line

    def is_over():
        nonlocal left
        left -= 1
        return left < 0

    def write_or_end(path, data, *, force):
        if is_over():
            raise ending
        write(path, data, force=force)

    def append_or_end(file, line):
        if not is_over():
            return append(file, line)
        with file.open("ab") as stream:
            stream.write(line[: len(line) // 2])
        raise ending

    patch.setattr(folder, "write_bytes", write_or_end)
    patch.setattr(journal, "append_line", append_or_end)


def stopped_clock(patch):
    at = SimpleNamespace(now=0.0)
    patch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
    patch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=lambda: at.now))
    return at


def units_done(out):
    if not out.exists():
        return 0
    with contextlib.closing(FolderStore(out)) as store:
        return store.units_done()


def run_part(out, chance, patch):
    """Do some units, with one worker or several."""
    executor = Several(chance.random()) if chance.randrange(3) else InlineExecutor()
    run(out, units=max(chance.randint(1, UNITS), units_done(out)), executor=executor)


def kill(out, chance, patch):
    writes_end(patch, chance.randrange(40), Killed)
    with contextlib.suppress(Killed):
        run(out, units=UNITS)


def fill_the_disk(out, chance, patch):
    writes_end(patch, chance.randrange(2, 40), OutputError("unwritable", "{path}: full", path=out))
    try:
        run(out, units=UNITS)
    except OutputError as error:
        assert error.code == "broken-off"


def cut_a_unit(out, chance, patch):
    """Cut a unit short, by Ctrl-C or not; later ones lack what it would have found."""
    doomed = units_done(out) + chance.randrange(3)
    looks, by_ctrl_c = chance.randint(1, 9), chance.randrange(2) > 0

    def run_or_cut(config, unit, known, *_):
        if unit != doomed:
            return run_unit(config, unit, known)
        result = run_unit(config, unit, known, Deadline(begin=looks))
        return replace(result, interrupted=by_ctrl_c and result.cut)

    patch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=count().__next__))
    patch.setattr("fuzz.campaign.run.run_unit", run_or_cut)
    assert run(out, units=UNITS) in (1, 130)


def let_time_run_out(out, chance, patch):
    """The time is over after one more unit, before its failures are shrunk."""
    if units_done(out) == UNITS:
        return
    at = stopped_clock(patch)

    def unit_of_31_s(*given):
        result = run_unit(*given)
        at.now += 31.0
        return result

    def endless_shrinking(failure, *_, **__):
        at.now = 1_000.0
        return Shrinking(failure, complete=False)

    patch.setattr("fuzz.campaign.run.run_unit", unit_of_31_s)
    patch.setattr("fuzz.campaign.run.shrunk_or_same", endless_shrinking)
    run(out, seconds=40.0)


def let_a_worker_hang(out, chance, patch):
    """A unit takes until the time is over, while the one after it is done."""
    if units_done(out) < UNITS - 1:
        run(out, seconds=60.0, executor=StuckInTheFirst(stopped_clock(patch)))


def damage(out, chance, patch):
    """Files of the store, and those that show failures, are lost, cut off or altered."""
    for what in ("journal.txt", "failures/*.grid", "../*.grid"):
        files = sorted((out / ".campaign").glob(what))
        for file in chance.sample(files, chance.randint(0, len(files))):
            data = bytearray(file.read_bytes())
            at = chance.randrange(len(data))
            data[at] ^= 1
            change = chance.randrange(3)
            if change:
                file.write_bytes(data[:at] if change == 1 else data)
            else:
                file.unlink()


STEPS = (run_part, kill, fill_the_disk, cut_a_unit, let_time_run_out, let_a_worker_hang, damage)


SEEDS = [*some((7, *range(7))), *(pytest.param(n, marks=pytest.mark.nightly) for n in range(8, 60))]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_campaign_ends_with_the_same_corpus_however_it_is_interrupted(seed, whole, tmp_path):
    chance, out = random.Random(seed), tmp_path / "out"
    for step in chance.choices(STEPS, k=5):
        with pytest.MonkeyPatch.context() as patch:
            step(out, chance, patch)
    assert run(out, units=UNITS) == 1
    assert left_in(out) == whole
    # The same command again does nothing.
    before = {file: file.stat().st_mtime_ns for file in out.glob("*.grid")}
    assert run(out, units=UNITS) == 1
    assert {file: file.stat().st_mtime_ns for file in out.glob("*.grid")} == before
    assert left_in(out) == whole
