"""The command find: its claims are true, equal seeds find equal worlds, options work, and Ctrl-C
loses nothing.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.command_line import worldgen
from worldgen import generate, read_world

WANTED = "turn-left=loop, turn-right=reached"
QUICK = ("--units", 2, "--seed", 1, "--workers", 1)
SKETCHES = Path(__file__).parents[2] / "corpora" / "thesis" / "sketches"
SKETCH = SKETCHES / "config-05.grid"
FIND = (sys.executable, "-c", "from worldgen.cli.main import main; main()", "find", "--outcome")

MINE = '''
import math
import os
import pathlib
import time
from sim import Command

class Straight:
    """Turns to the target and drives: fails at the first wall in between."""
    def reset(self): return ()
    def act(self, observation, memory):
        turn = (observation.target_heading - observation.heading + math.pi) % math.tau - math.pi
        return Command(observation.top_speed, turn / observation.time_step), memory

class Forgets:
    """Turns on the spot, and hides a count from the simulator: poses come back, the state does not.
    """
    def __init__(self): self.count = 0
    def reset(self):
        self.count = 0
        return ()
    def act(self, observation, memory):
        self.count += 1
        return Command(0.0, 1.0 / observation.time_step), memory

class Slow(Straight):
    """Takes a second a world; leaves a note in the 20th."""
    worlds = 0
    def reset(self):
        Slow.worlds += 1
        if Slow.worlds == 20:
            pathlib.Path("MET").touch()
        return ()
    def act(self, observation, memory):
        time.sleep(0.001)
        return super().act(observation, memory)

class Dies:
    """Takes a worker process along; only crashes in the first."""
    def reset(self): return ()
    def act(self, observation, memory):
        if os.getppid() != PARENT:
            os._exit(3)
        raise ValueError
'''


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp("find") / "w.grid"
    result = worldgen("find", "--outcome", WANTED, *QUICK, "--out", path, "--json")
    return path, result, json.loads(result.out)


@pytest.fixture
def mine(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    return f"{tmp_path}/mine.py"


def let_each_look_at_the_clock_take_a_second(monkeypatch):
    """Return the list of progress callbacks."""
    looks = []

    def tick():
        looks.append(True)
        return float(len(looks))

    clock = SimpleNamespace(time=tick, monotonic=tick)
    monkeypatch.setattr("fuzz.unit.deadline.time", clock)
    monkeypatch.setattr("fuzz.campaign.schedule.time", clock)
    return looks


def run(path, controller, steps, *options):
    """Return what ``worldgen run`` reports: verdict, and steps or period."""
    episode = json.loads(
        worldgen("run", path, "--controller", controller, "--steps", steps, *options, "--json").out
    )
    return episode["verdict"], episode["evidence"].get("period", episode["steps"])


def test_every_outcome_as_wanted_ends_with_0(found):
    assert found[1].code == 0 and found[2]["exact"] and found[2]["distance"] == 0


def test_the_outcomes_claimed_are_those_of_run(found):
    claimed = {o["controller"]: (o["verdict"], o["steps"]) for o in found[2]["outcomes"]}
    assert claimed == {
        o["controller"]: run(found[0], o["controller"], o["budget"]) for o in found[2]["outcomes"]
    }
    assert [verdict for verdict, _ in claimed.values()] == ["loop", "reached"]


def test_the_target_of_the_world_can_be_reached(found):
    assert worldgen("verify", found[0]).code == 0


def test_the_file_says_what_was_looked_for(found):
    provenance = read_world(found[0]).provenance
    assert provenance.family == "find" and provenance.seed == 1
    assert provenance.params["outcome"].startswith(
        "turn-left+motion=swept+time_step=0.015=loop, turn-right"
    )


def test_outcomes_are_told_in_the_order_in_which_they_were_given(tmp_path):
    result = worldgen(
        "find", "--outcome", "turn-random=reached", "--outcome", "turn-left=reached", *QUICK, "--out", tmp_path / "w",
    )  # fmt: skip
    assert [line.split(":")[0] for line in result.out.splitlines()[:2]] == [
        "turn-random",
        "turn-left",
    ]


@pytest.mark.nightly
@pytest.mark.parametrize("workers", [1, 2])
def test_equal_seeds_find_equal_worlds_with_any_workers(found, workers, tmp_path):
    worldgen("find", "--outcome", WANTED, *QUICK[:-1], workers, "--out", tmp_path / "again.grid")
    assert (tmp_path / "again.grid").read_bytes() == found[0].read_bytes()


@pytest.mark.nightly
def test_a_number_of_steps_is_met_exactly(tmp_path):
    result = worldgen(
        "find", "--outcome", "thesis-1=reached@3s", "--motion", "stepped", "--units", 8, "--seed", 1, "--workers", 1,
        "--out", tmp_path / "w.grid",
    )  # fmt: skip
    assert result.code == 0 and run(
        tmp_path / "w.grid", "thesis-1", 1000, "--motion", "stepped"
    ) == ("reached", 200)


@pytest.mark.gate
def test_mine_fails_and_theirs_succeeds(mine, tmp_path):
    wanted = f"{mine}:Straight=loop, turn-left=reached"
    result = worldgen("find", "--outcome", wanted, *QUICK, "--out", tmp_path / "w.grid")
    assert result.code == 0 and worldgen("verify", tmp_path / "w.grid").code == 0
    assert run(tmp_path / "w.grid", f"{mine}:Straight", 20_000)[0] == "loop"
    assert run(tmp_path / "w.grid", "turn-left", 20_000)[0] == "reached"


def test_a_loop_of_a_controller_that_hides_memory_is_not_claimed(mine, tmp_path, monkeypatch):
    let_each_look_at_the_clock_take_a_second(monkeypatch)
    result = worldgen(
        "find", "--outcome", f"{mine}:Forgets=loop", "--from", SKETCH, "--leash", 0, "--keep-target", "--budget", "2h",
        "--seed", 1, "--workers", 1, "--out", tmp_path / "w.grid",
    )  # fmt: skip
    assert result.code == 1 and "wanted loop, got stalled in 20000 steps: off by 2" in result.out


def test_a_budget_ends_the_run_of_a_slow_controller_that_is_under_way(mine, tmp_path, monkeypatch):
    let_each_look_at_the_clock_take_a_second(monkeypatch)
    result = worldgen(
        "find", "--outcome", f"{mine}:Forgets=loop", "--from", SKETCH, "--leash", 0, "--budget", "100s", "--seed", 1,
        "--workers", 1, "--out", tmp_path / "w.grid",
    )  # fmt: skip
    assert result.code == 1 and "no run ended before the search did; allow more time" in result.err


@pytest.mark.gate
def test_what_cannot_be_had_comes_as_near_as_it_does_and_ends_with_1(tmp_path):
    wanted = "thesis-1=reached@100, thesis-1=reached@200"
    result = worldgen(
        "find",
        "--outcome",
        wanted,
        "--motion",
        "stepped",
        *QUICK,
        "--out",
        tmp_path / "w.grid",
        "--json",
    )
    summary = json.loads(result.out)
    steps = summary["outcomes"][0]["steps"]
    assert result.code == 1 and not summary["exact"] and 100 <= steps <= 200
    assert summary["distance"] == pytest.approx((steps - 100) / 100 + (200 - steps) / 200)


@pytest.mark.nightly
def test_how_near_it_comes_is_printed(tmp_path):
    wanted = "turn-left=reached, turn-left=loop"
    result = worldgen(
        "find", "--outcome", wanted, "--units", 1, *QUICK[2:], "--out", tmp_path / "w.grid"
    )
    assert result.code == 1 and "as wanted" in result.out and "off by" in result.out
    assert "unit 0: off by" in result.err


@pytest.mark.gate
def test_a_leash_keeps_walls_and_target_near_where_they_were(tmp_path):
    out = tmp_path / "w.grid"
    worldgen(
        "find", "--outcome", "thesis-1=reached@2000", "--motion", "stepped", "--from", SKETCH, "--leash", 2, *QUICK,
        "--out", out,
    )  # fmt: skip
    before, after = read_world(SKETCH), read_world(out)
    assert (before.walls != after.walls).any()
    assert (
        not (after.walls & ~grown(before.walls, 2)).any()
        and not (before.walls & ~grown(after.walls, 2)).any()
    )
    assert (
        max(abs(after.target.x - before.target.x), abs(after.target.y - before.target.y))
        <= 2.5 * before.cell_size
    )


def grown(walls, cells):
    """Return the walls and every cell at most this many columns and rows away."""
    padded = np.pad(walls, cells)
    height, width = walls.shape
    shifts = range(2 * cells + 1)
    return np.any(
        [padded[dy : dy + height, dx : dx + width] for dy in shifts for dx in shifts], axis=0
    )


@pytest.mark.gate
def test_keep_target_leaves_the_target_where_it_is(tmp_path):
    options = ("--motion", "stepped", "--from", SKETCH, "--keep-target", *QUICK)
    worldgen("find", "--outcome", "thesis-1=reached@300", *options, "--out", tmp_path / "w.grid")
    found = read_world(tmp_path / "w.grid")
    assert (
        found.target == read_world(SKETCH).target
        and (found.walls != read_world(SKETCH).walls).any()
    )


def test_no_edit_leaves_the_world_as_its_family_makes_it(tmp_path):
    options = ("--family", "trap", "--set", "depth=5", "--no-edit", *QUICK)
    result = worldgen("find", "--outcome", "turn-left=loop", *options, "--out", tmp_path / "w.grid")
    found = read_world(tmp_path / "w.grid")
    again = generate("trap", seed=found.provenance.seed, **found.provenance.params)
    assert (
        result.code == 0
        and found.provenance.family == "trap"
        and found.provenance.params["depth"] == 5
    )
    assert (again.walls == found.walls).all() and (again.start, again.target) == (
        found.start,
        found.target,
    )


def test_what_is_fixed_for_one_family_leaves_the_others_alone(tmp_path):
    options = (
        "--family",
        "trap",
        "--family",
        "maze",
        "--set",
        "depth=5",
        "--no-edit",
        "--units",
        1,
        "--seed",
        1,
    )
    worldgen(
        "find",
        "--outcome",
        "turn-left=reached@9999",
        *options,
        "--workers",
        1,
        "--out",
        tmp_path / "w.grid",
    )
    assert (tmp_path / "w.grid").exists()


def test_every_world_gets_the_start_that_is_given(tmp_path):
    worldgen(
        "find",
        "--outcome",
        WANTED,
        "--start",
        "0.45,0.55,-1.5",
        *QUICK,
        "--out",
        tmp_path / "w.grid",
    )
    start = read_world(tmp_path / "w.grid").start
    assert (start.x, start.y, start.heading) == (0.45, 0.55, -1.5)


def test_an_existing_file_is_refused_before_the_search(tmp_path):
    (tmp_path / "w.grid").write_text("mine")
    result = worldgen(
        "find", "--outcome", WANTED, "--budget", "1h", "--seed", 1, "--out", tmp_path / "w.grid"
    )
    assert (
        result.code == 2
        and result.error_code == "file-exists"
        and (tmp_path / "w.grid").read_text() == "mine"
    )


def test_force_overwrites(tmp_path):
    (tmp_path / "w.grid").write_text("mine")
    assert (
        worldgen("find", "--outcome", WANTED, *QUICK, "--force", "--out", tmp_path / "w.grid").code
        == 0
    )
    assert read_world(tmp_path / "w.grid").certificate is not None


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--budget", "1s", "--units", 1), "use --budget or --units"),
        (("--from", SKETCH, "--family", "trap"), "use --from or --family"),
        (("--no-edit",), "name a family with --family"),
        (("--family", "mace"), "did you mean 'maze'?"),
        (("--family", "trap", "--set", "deep=3"), "--family trap has no option 'deep'"),
        (("--family", "trap", "--set", "depth=deep"), "depth='deep' is not a whole number"),
        (("--family", "trap", "--set", "depth=-4"), "depth=-4"),
        (("--from", "absent.grid"), "absent.grid"),
        (("--start", "1,2"), "is not X,Y,HEADING"),
        (("--start", "99,99,0"), "start"),
        (("--motion", "flying"), "no motion model is called 'flying'"),
        (("--time-step", "0"), "time_step=0 s is outside"),
    ],
)
def test_bad_options_are_one_line_and_code_2(args, message, tmp_path):
    result = worldgen(
        "find", "--outcome", "turn-left=loop", *args, "--seed", 1, "--out", tmp_path / "w.grid"
    )
    assert result.code == 2 and message in result.err and "Traceback" not in result.err
    assert not (tmp_path / "w.grid").exists()


@pytest.mark.nightly
def test_a_worker_that_dies_is_one_line_and_code_2(tmp_path):
    (tmp_path / "mine.py").write_text(MINE.replace("PARENT", str(os.getpid())))
    wanted = f"{tmp_path}/mine.py:Dies=reached"
    ended = subprocess.run(
        [*FIND, wanted, "--units", "1", "--workers", "2", "--out", tmp_path / "w.grid"],
        check=False, capture_output=True, text=True, timeout=180,
    )  # fmt: skip
    assert (
        ended.returncode == 2
        and "a worker process died" in ended.stderr
        and "Traceback" not in ended.stderr
    )


def interrupted(process):
    """Send Ctrl-C to every process, as a terminal does.

    Return the output, once all have ended.
    """
    os.killpg(process.pid, signal.SIGINT)
    try:
        out, err = process.communicate(timeout=180)
        assert ended(process.pid)
    finally:
        process.kill()
    assert process.returncode == 130 and "Traceback" not in err
    return out


def started(*args):
    return subprocess.Popen(
        [*FIND, *map(str, args)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def ended(group):
    """Return whether every process of a group ends within a minute."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.nightly
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_writes_the_nearest_until_then_and_leaves_no_process(workers, tmp_path):
    wanted, path = "thesis-1=reached@331, thesis-2=reached@9388", tmp_path / "w.grid"
    process = started(
        wanted,
        "--motion",
        "stepped",
        "--budget",
        "10m",
        "--seed",
        1,
        "--workers",
        workers,
        "--out",
        path,
    )
    assert "off by" in process.stderr.readline()
    assert f"wrote {path}" in interrupted(process)
    assert worldgen("verify", path).code == 0


@pytest.mark.nightly
def test_ctrl_c_in_the_first_unit_keeps_what_that_unit_had(tmp_path):
    met = tmp_path / "met"
    (tmp_path / "mine.py").write_text(MINE.replace("MET", str(met)))
    wanted = f"{tmp_path}/mine.py:Slow=reached@9999"
    process = started(
        wanted, "--budget", "10m", "--seed", 1, "--workers", 1, "--out", tmp_path / "w.grid"
    )
    deadline = time.monotonic() + 120
    while not met.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert "worlds in 1 unit; wrote" in interrupted(process)
    assert worldgen("verify", tmp_path / "w.grid").code == 0


STUCK = """
import os, signal
from itertools import count
from sim import Command

EPISODES = count()

class Stuck:
    stuck = False

    def reset(self):
        if next(EPISODES) == 20:
            self.stuck = True
            os.kill(os.getpid(), signal.SIGINT)
        return ()

    def act(self, observation, memory):
        while self.stuck:
            pass
        return Command(0.0, 0.0), memory
"""


@pytest.mark.skipif(os.name == "nt", reason="sends itself SIGINT")
def test_ctrl_c_in_a_unit_that_does_not_end_keeps_what_it_had(tmp_path, monkeypatch):
    monkeypatch.setattr("fuzz.campaign.executors.local.TO_HAND_IN", 0.0)
    (tmp_path / "mine.py").write_text(STUCK)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        result = worldgen(
            "find", "--outcome", f"{tmp_path}/mine.py:Stuck=reached@9999", "--units", 2,
            "--seed", 1, "--workers", 1, "--out", tmp_path / "w.grid",
        )  # fmt: skip
    finally:
        signal.signal(signal.SIGINT, before)
    assert result.code == 130 and "in 1 unit; wrote" in result.out
    assert worldgen("verify", tmp_path / "w.grid").code == 0


def test_a_budget_of_time_ends_a_unit_that_takes_longer(mine, tmp_path, monkeypatch):
    looks = let_each_look_at_the_clock_take_a_second(monkeypatch)
    result = worldgen(
        "find", "--outcome", f"{mine}:Forgets=reached", "--budget", "20s", "--seed", 1, "--workers", 1,
        "--out", tmp_path / "w.grid",
    )  # fmt: skip
    assert result.code == 1 and 20 < len(looks) < 40
